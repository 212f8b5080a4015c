"""Scenarios: their parameters, and loading them from files."""

from drake_mobman.scenario.guided import Guided
from drake_mobman.scenario.load import AnyScenario, ScenarioError, load_scenario
from drake_mobman.scenario.scenario import Scenario
from drake_mobman.scenario.teleop import Teleop
from drake_mobman.scenario_files import scenario_paths

__all__ = [
    "AnyScenario",
    "Guided",
    "Scenario",
    "ScenarioError",
    "Teleop",
    "load_scenario",
    "scenario_paths",
]
