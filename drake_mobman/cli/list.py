"""`mobman list`: the scenarios that come with the package."""

from drake_mobman.cli.loading import load
from drake_mobman.cli.messages import say
from drake_mobman.scenario_files import scenario_names


def list_() -> None:
    """Lists the scenarios, one line each."""
    names = scenario_names()
    width = max(map(len, names))
    for name in names:
        scenario = load(name, [])
        say(f"{name:{width}}  {scenario.description}")
