"""A hand leads robots that no one here wrote, and feels little of their weight."""

import pytest

from drake_mobman.analysis.metrics import metrics
from drake_mobman.parameters import checked
from drake_mobman.robots.file import File
from drake_mobman.scenario.fitted import fitted_guided
from drake_mobman.scenario_files import robot_paths
from drake_mobman.simulation.simulate import simulate


@pytest.mark.parametrize(
    "robot",
    [
        "so101",  # So light that a hand may be neither stiff nor soft.
        "tiago_dual",  # Its shoulder is on the left, its first joint ends soon.
        "tiago_pro",  # Its shoulder is ahead and on the left, its first axis oblique.
        "pr2",  # Its hand is far below the shoulder.
    ],
)
def test_a_hand_leads_a_robot_lightly_and_the_tool_stays_in_it(robot):
    run = simulate(checked(fitted_guided(File(str(robot_paths()[robot])))))
    found = metrics(run)
    assert not run.died
    assert found["hand_force_max"] < 20.0  # [N].
    assert found["hand_error_max"] < 0.025  # [m].
    assert found["base_jerk_rms"] < 5.0  # [m/s^3]: the zones do not meet.
