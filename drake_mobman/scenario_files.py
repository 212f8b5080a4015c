"""The scenarios that come with the package: their files, found without Drake."""

from importlib import resources
from pathlib import Path


def scenario_paths() -> dict[str, Path]:
    """Returns the files of the scenarios that come with the package, by name."""
    folder = Path(str(resources.files("drake_mobman.scenarios")))
    return {path.stem: path for path in sorted(folder.glob("*.yaml"))}


def scenario_names() -> list[str]:
    """Returns the names of the scenarios that come with the package, in order."""
    return list(scenario_paths())
