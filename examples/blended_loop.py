"""The blended loop that both examples take apart: BlendingDecomposer to robot and back.

Wired as `make_teleop_diagram` wires it, without source and guard: these take floats
only, and all else here takes `AutoDiffXd`.
"""

from drake_mobman.diagrams.wiring import build_and_export, connect_by_name, outputs
from pydrake.systems.framework import Diagram, DiagramBuilder

import drake_mobman as mm
from drake_mobman import signals
from drake_mobman.base import Smoothing

PERIOD = 0.01
"""h [s]: of control, and the robot's Euler step."""


def make_blended_loop(blending: mm.Blending, smoothing: Smoothing, l: float) -> Diagram:
    """Returns the loop on the planar robot, its end effector `l` [m] straight ahead.

    Its input port is `ee_command`, its output ports are the signals. The discrete
    state is the command last sent, v [m/s] and omega [rad/s]; and x, y [m], theta
    [rad] of the base, then shoulder and elbow [rad].
    """
    setup = mm.RobotSetup.of(mm.Planar(), PERIOD)
    start = [0.0, 0.0, 0.0, *setup.arm.inverse((l, 0.0, 0.0))]
    builder = DiagramBuilder()
    blocks = {
        "decomposer": blending.build(setup),
        "smoother": smoothing.build(setup),
        "estimator": mm.Sent().build(PERIOD),
        "arm": mm.ClosedFormInverse(setup.arm, setup.joint_limits, PERIOD),
        "robot": mm.Kinematic().build(setup, start),
    }
    systems = [builder.AddNamedSystem(*block) for block in blocks.items()]
    ports = outputs(systems)
    connect_by_name(builder, ports, systems, left_open=[signals.EE_COMMAND])
    command = systems[0].GetInputPort(signals.EE_COMMAND)
    builder.ExportInput(command, signals.EE_COMMAND)
    return build_and_export(builder, "blended loop", ports, PERIOD, logged=False)
