"""The scenarios and robots that come with the package: their files, without Drake."""

from importlib import resources
from pathlib import Path

ROBOT = ".robot.yaml"
"""How the name of a robot file ends."""


def scenario_paths() -> dict[str, Path]:
    """Returns the files of the scenarios that come with the package, by name."""
    return {path.stem: path for path in sorted(_folder().glob("*.yaml"))}


def scenario_names() -> list[str]:
    """Returns the names of the scenarios that come with the package, in order."""
    return list(scenario_paths())


def robot_paths() -> dict[str, Path]:
    """Returns the robot files that come with the package, by the robot's name."""
    paths = sorted((_folder() / "robots").glob(f"*{ROBOT}"))
    return {path.name.removesuffix(ROBOT): path for path in paths}


def robot_names() -> list[str]:
    """Returns the names of the robots that come with the package, in order."""
    return list(robot_paths())


def about(path: Path) -> str:
    """Returns what the comment at the top of a robot file says; empty without one."""
    first, _, _ = path.read_text("utf-8").partition("\n")
    return first.removeprefix("#").strip() if first.startswith("#") else ""


def models_folder() -> Path:
    """Returns the folder of the robots' own models, `package://drake_mobman`."""
    return _folder() / "robots"


def _folder() -> Path:
    return Path(str(resources.files("drake_mobman.scenarios")))
