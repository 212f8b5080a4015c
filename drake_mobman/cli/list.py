"""`mobman list`: the scenarios and robots that come with the package."""

from drake_mobman.cli.loading import load
from drake_mobman.cli.messages import say
from drake_mobman.scenario_files import about, robot_paths, scenario_names


def list_() -> None:
    """Lists the scenarios, then the robots, one line each."""
    robots = robot_paths()
    width = max(map(len, [*scenario_names(), *robots]))
    for name in scenario_names():
        scenario = load(name, [])
        say(f"{name:{width}}  {scenario.description}")
    say("")
    say("Robots, for `robot: !File {path: NAME}` and for `mobman robot`:")
    for name, path in robots.items():
        say(f"{name:{width}}  {about(path)}")
