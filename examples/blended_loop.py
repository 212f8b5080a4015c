"""The blended loop that both examples take apart: BlendingDecomposer to robot and back.

Wired as `make_teleop_diagram` wires it, without source and guard: these take floats
only, and all else here takes `AutoDiffXd`.
"""

from drake_mobman.diagrams.wiring import build_and_export, connect_by_name, outputs
from drake_mobman.robots.robot import make_robot
from pydrake.systems.framework import Diagram, DiagramBuilder

from drake_mobman import signals
from drake_mobman.arm.closed_form_inverse import ClosedFormInverse
from drake_mobman.base.smoother import CommandSmoother, Smoother
from drake_mobman.decomposers.blending import Blending, BlendingDecomposer
from drake_mobman.robot_model import RobotModel
from drake_mobman.robots.planar import Planar

PERIOD = 0.01
"""h [s]: of control, and the robot's Euler step."""


def make_blended_loop(blending: Blending, smoother: Smoother, l: float) -> Diagram:
    """Returns the loop on the planar robot, with the hand `l` [m] straight ahead.

    Its input port is `ee_command`, its output ports are the signals. The discrete
    state is the command last sent, v [m/s] and omega [rad/s]; and x, y [m], theta
    [rad] of the base, then shoulder and elbow [rad].
    """
    planar = Planar()
    arm = planar.arm()
    builder = DiagramBuilder()
    blocks = {
        "decomposer": BlendingDecomposer(blending),
        "smoother": CommandSmoother(smoother, PERIOD),
        "arm": ClosedFormInverse(arm, RobotModel(planar).limits, PERIOD),
        "robot": make_robot(planar, [0, 0, 0, *arm.inverse((l, 0, 0))], PERIOD),
    }
    systems = [builder.AddNamedSystem(*block) for block in blocks.items()]
    ports = outputs(systems)
    connect_by_name(builder, ports, systems, left_open=[signals.EE_COMMAND])
    command = systems[0].GetInputPort(signals.EE_COMMAND)
    builder.ExportInput(command, signals.EE_COMMAND)
    return build_and_export(builder, "blended loop", ports, PERIOD, logged=False)
