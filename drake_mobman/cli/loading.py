"""Scenarios as a command gets them: loaded and checked, or refused with one line."""

from pathlib import Path
from typing import TYPE_CHECKING

from drake_mobman.cli.messages import refuse

if TYPE_CHECKING:
    from drake_mobman.scenario import AnyScenario


def load(given: str, overrides: list[str]) -> "AnyScenario":
    """Returns a scenario, or refuses."""
    from drake_mobman.scenario import ScenarioError, load_scenario

    try:
        return load_scenario(given, overrides)
    except ScenarioError as error:
        refuse(error)


def load_runnable(given: str, overrides: list[str]) -> "AnyScenario":
    """Returns a scenario that needs no program to feed it, or refuses."""
    scenario = load(given, overrides)
    if scenario.source.fed:
        kind = type(scenario.source).__name__
        refuse(f"{given}: source: !{kind} is fed by a program, not from here")
    return scenario


def load_all(
    scenarios: list[str], overrides: list[str], out: Path, ours: tuple[str, ...]
) -> dict[str, "AnyScenario"]:
    """Returns scenarios by name, or refuses: all are checked before the first runs.

    Args:
        scenarios: names or paths.
        overrides: `key.path=value` each.
        out: where each scenario gets a folder of its own, new or with nothing in it
            but files of `ours`.
        ours: patterns of files that may be replaced.
    """
    from drake_mobman.parameters import ParameterError
    from drake_mobman.simulation.output_folder import FolderError
    from drake_mobman.simulation.run_folder import check_run_folder
    from drake_mobman.simulation.size import check_room

    loaded: dict[str, AnyScenario] = {}
    for given in scenarios:
        scenario = load_runnable(given, overrides)
        name = scenario.name
        if name in loaded:
            refuse(f"{given}: {name} is given twice; each goes to its own folder")
        try:
            check_run_folder(out / name, ours)
            check_room(scenario, out / name)
        except FolderError as error:
            refuse(error)
        except ParameterError as error:
            refuse(f"{given}: {error}")
        loaded[name] = scenario
    return loaded
