"""Scenarios and robots that come with the package: files, found without Drake."""

from importlib import resources
from pathlib import Path


def scenario_paths() -> dict[str, Path]:
    """Returns the files of the scenarios that come with the package, by name."""
    folder = Path(str(resources.files("drake_mobman.scenarios")))
    return {path.stem: path for path in sorted(folder.glob("*.yaml"))}


def scenario_names() -> list[str]:
    """Returns the names of the scenarios that come with the package, in order."""
    return list(scenario_paths())


def robot_paths() -> dict[str, Path]:
    """Returns the robot files that come with the package, by name."""
    folder = Path(str(resources.files("drake_mobman.scenarios"))) / "robots"
    found = sorted(folder.glob("*.robot.yaml"))
    return {path.name.removesuffix(".robot.yaml"): path for path in found}
