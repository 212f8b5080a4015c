"""`import drake_mobman as mm`: quick, and with every block and its parameters."""

import ast
import dataclasses as dc
import importlib
import inspect
import pkgutil
import statistics
import subprocess
import sys
import time
import typing
from importlib.metadata import version
from pathlib import Path

import pytest
from pydrake.systems.framework import System

import drake_mobman as mm

OF_BLOCKS = ["arm", "base", "decomposers", "guidance", "teleop", "robots"]
"""Packages that hold blocks."""


def run_python(code):
    """Returns how long a new interpreter takes to run some code [s]."""
    start = time.perf_counter()
    subprocess.run([sys.executable, "-c", code], check=True)
    return time.perf_counter() - start


def public_blocks():
    """Yields the blocks of the package, by name."""
    for package in OF_BLOCKS:
        path = Path(mm.__file__).parent / package
        for info in pkgutil.iter_modules([str(path)]):
            name = f"drake_mobman.{package}.{info.name}"
            module = importlib.import_module(name)
            for key, value in vars(module).items():
                ours = inspect.isclass(value) and value.__module__ == name
                # The instances of templates carry odd letters in their names.
                public = key.isascii() and not key.startswith("_")
                if ours and public and issubclass(value, System):
                    yield key, value


def parameters(schema, found):
    """Returns the dataclasses that a scenario may hold, at any depth."""
    for member in typing.get_args(schema) or [schema]:
        if typing.get_args(member):
            parameters(member, found)
        elif dc.is_dataclass(member) and member not in found:
            found.add(member)
            for field in dc.fields(member):
                parameters(field.type, found)
    return found


def test_import_takes_neither_drake_nor_numpy():
    run_python(
        "import sys, drake_mobman as mm\n"
        "assert mm.__version__ and mm.scenario_names() and dir(mm)\n"
        "assert not hasattr(mm, 'nosuch')\n"
        "heavy = {'pydrake', 'numpy', 'matplotlib', 'rich'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
    )


def test_import_takes_less_than_a_tenth_of_a_second():
    pairs = [(run_python("import drake_mobman"), run_python("")) for _ in range(9)]
    ours, bare = (statistics.median(times) for times in zip(*pairs, strict=True))
    assert ours - bare < 0.1


def test_version_is_that_of_the_installed_package():
    assert mm.__version__ == version("drake_mobman")


def test_names_are_those_that_type_checkers_see():
    tree = ast.parse(Path(mm.__file__).read_text())
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    seen = [name.name for line in block.body for name in line.names]
    assert sorted([*seen, "__version__"]) == mm.__all__


@pytest.mark.parametrize("name", mm.__all__)
def test_each_name_is_there(name):
    assert getattr(mm, name) is not None
    assert name in dir(mm)


def test_every_block_is_there():
    blocks = dict(public_blocks())
    assert {"BlendingDecomposer", "GuidingHand", "KinematicRobot"} <= set(blocks)
    assert all(getattr(mm, name) is block for name, block in blocks.items())


def test_all_parameters_of_a_scenario_are_there():
    found = parameters(mm.Teleop | mm.Guided, set())
    assert {mm.Blending, mm.Smoother, mm.Script, mm.Waypoint, mm.Servo} <= found
    assert all(getattr(mm, kind.__name__) is kind for kind in found)


def test_name_that_is_mistyped_is_refused():
    with pytest.raises(AttributeError, match="no attribute 'Blendin'") as refusal:
        mm.Blendin  # noqa: B018 - looked up for its error.
    assert (refusal.value.name, refusal.value.obj) == ("Blendin", mm)


def test_modules_are_imported_as_ever():
    run_python(
        "from drake_mobman import signals\nassert signals.EE_COMMAND == 'ee_command'"
    )
