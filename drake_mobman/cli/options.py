"""Arguments and options that several commands take."""

from typing import Annotated

import typer

from drake_mobman.scenario_files import scenario_names

_SCENARIO = "Name of a scenario (`mobman list` shows them), or path of its file."


def completed_scenarios(incomplete: str) -> list[str]:
    """Returns the names of scenarios that begin so, for the shell's completion."""
    return [name for name in scenario_names() if name.startswith(incomplete)]


Scenarios = Annotated[
    list[str],
    typer.Argument(
        metavar="SCENARIO", help=_SCENARIO, autocompletion=completed_scenarios
    ),
]
MaybeScenarios = Annotated[
    list[str],
    typer.Argument(
        metavar="[SCENARIO]...",
        help=_SCENARIO,
        autocompletion=completed_scenarios,
        show_default=False,
    ),
]
Scenario = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO", help=_SCENARIO, autocompletion=completed_scenarios
    ),
]
Overrides = Annotated[
    list[str],
    typer.Option(
        "--set",
        metavar="KEY.PATH=VALUE",
        help="Change a value of the scenario, as in duration=5; may be repeated.",
    ),
]
