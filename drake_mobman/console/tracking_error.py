"""How far the end effector is from its command, while a session runs."""

import math

import numpy as np

from drake_mobman import signals
from drake_mobman.analysis.motion import ee_motion
from drake_mobman.robot_model import RobotModel
from drake_mobman.scenario import AnyScenario
from drake_mobman.simulation.log import Log
from drake_mobman.simulation.simulate import Run


def tracking_error(scenario: AnyScenario, model: RobotModel, log: Log) -> float:
    """Returns the end effector's error at a log's last sample, as in the metrics.

    That is the error of its velocity in the plane [m/s]. Where a hand pulls the tool,
    it is the distance between the two [m], and NaN while the hand drags something else.

    Args:
        scenario: of the session.
        model: of its robot.
        log: of two samples, as with masses the command of the one before counts; of
            one, at the start alone.
    """
    if signals.HAND_POSITION in log:
        if log[signals.DRAG][-1].any():
            return math.nan
        gap = log[signals.HAND_POSITION][-1] - log[signals.TOOL_POSITION][-1]
    else:
        gap = ee_motion(Run(scenario, log, 0.0, np.zeros(0)), model).error[-1]
    return float(np.linalg.norm(gap))
