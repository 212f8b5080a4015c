"""A scenario as the files that it is loaded from again, its robot among them."""

import dataclasses as dc

from drake_mobman.robots.file import File
from drake_mobman.robots.file.kept import HASHES, KEPT, kept_files
from drake_mobman.scenario import AnyScenario
from drake_mobman.schema import dump_typed

SCENARIO = "scenario.yaml"

SCENARIO_FILES = (SCENARIO, KEPT, HASHES)
"""Names of all files that a scenario may have."""


def scenario_texts(scenario: AnyScenario) -> dict[str, str]:
    """Returns the texts of a scenario's files, by their names.

    A robot from a file is kept beside it: what is found of it through its packages or
    by absolute paths is not.
    """
    robot = scenario.robot
    if not isinstance(robot, File):
        return {SCENARIO: dump_typed(scenario)}
    kept = kept_files(robot.described())
    return {SCENARIO: dump_typed(dc.replace(scenario, robot=File(KEPT)))} | kept
