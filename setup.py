"""Finds the packages; all else about the build is in `pyproject.toml`."""

from setuptools import find_packages, setup

# These two stand at the top of the tree, and install inside the package.
BESIDE = ["drake_mobman.diagrams", "drake_mobman.scenarios"]

setup(packages=[*find_packages(include=["drake_mobman*"]), *BESIDE])
