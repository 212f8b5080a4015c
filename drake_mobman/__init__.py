"""Steer the end effector of a mobile manipulator; its base follows, as Drake blocks.

::

    import drake_mobman as mm

    run = mm.simulate("kwon_spatial", decomposer=mm.Blending(alpha=10))
    run["ee_command"], run.time, run.metrics()

All names of `__all__` are here. Each is imported when it is first used, so that
importing the package imports neither Drake nor numpy.
"""

from typing import TYPE_CHECKING

from drake_mobman.lazy import lazy_getattr

__version__ = "0.1.0"

if TYPE_CHECKING:  # `lazy_getattr` reads these lines too.
    from drake_mobman.analysis.metrics import metrics
    from drake_mobman.arm.closed_form_inverse import ClosedFormInverse
    from drake_mobman.arm.damped_inverse import DampedInverse
    from drake_mobman.arm.end_effector_sensor import EndEffectorSensor
    from drake_mobman.arm.inverse import ArmInverse
    from drake_mobman.arm.limits import JointLimits
    from drake_mobman.arm.oriented_inverse import OrientedInverse
    from drake_mobman.base.jerk_limited import JerkLimited, JerkLimiter
    from drake_mobman.base.smoother import CommandSmoother, Smoother
    from drake_mobman.base.unsmoothed import CommandPassThrough, Unsmoothed
    from drake_mobman.base.velocity_field import VelocityField, VelocityFieldController
    from drake_mobman.blocks import scalar_block
    from drake_mobman.decomposers.blending import Blending, BlendingDecomposer
    from drake_mobman.decomposers.decomposer import (
        CompensatedDecomposer,
        ShareDecomposer,
        declare_decomposer_ports,
    )
    from drake_mobman.decomposers.diff_ik import DiffIk, DiffIkDecomposer
    from drake_mobman.decomposers.exact import Exact, ExactDecomposer
    from drake_mobman.decomposers.field import FieldDecomposer
    from drake_mobman.decomposers.optimization import OptimizationDecomposer
    from drake_mobman.decomposers.projection import Projection
    from drake_mobman.decomposers.qp import Qp, QpDecomposer
    from drake_mobman.decomposers.switching import Switching, SwitchingDecomposer
    from drake_mobman.diagrams import make_diagram
    from drake_mobman.engines.drake import Drake
    from drake_mobman.engines.mujoco.params import Mujoco
    from drake_mobman.estimation.base_estimator import BaseEstimator
    from drake_mobman.estimation.gyro import Gyro
    from drake_mobman.estimation.measured import Measured
    from drake_mobman.estimation.odometry import Odometry
    from drake_mobman.estimation.sent import Sent
    from drake_mobman.figures import draw_figures
    from drake_mobman.guidance.applied_force import PointForce
    from drake_mobman.guidance.guiding_hand import (
        GraspForce,
        GuidingHand,
        Hand,
        Release,
        Waypoint,
    )
    from drake_mobman.guidance.planned import Planned
    from drake_mobman.guidance.tool_sensor import ToolSensor
    from drake_mobman.notebook import simulate
    from drake_mobman.parameters import ParameterError
    from drake_mobman.robot_model import (
        BaseLimits,
        Reach,
        RobotSetup,
        WorkspaceLimits,
    )
    from drake_mobman.robots.defaults import Start
    from drake_mobman.robots.file import File
    from drake_mobman.robots.franka_tiago import FrankaTiago
    from drake_mobman.robots.kinematic import Kinematic, KinematicRobot
    from drake_mobman.robots.planar import Planar
    from drake_mobman.robots.servo import Servo
    from drake_mobman.robots.spatial import Spatial
    from drake_mobman.robots.wheels import Wheels
    from drake_mobman.robots.wheels.drive import Drive
    from drake_mobman.robots.wheels.floor import Bump, Floor, Patch
    from drake_mobman.robots.wheels.sensors import Sensors
    from drake_mobman.scenario import Guided, ScenarioError, Teleop, load_scenario
    from drake_mobman.scenario_files import scenario_names
    from drake_mobman.teleop.choice import ControllerSelector, CrossFade, Transition
    from drake_mobman.teleop.drag import Drag
    from drake_mobman.teleop.external import External
    from drake_mobman.teleop.gate import CommandGate, Gate
    from drake_mobman.teleop.guard import CommandGuard, Guard
    from drake_mobman.teleop.led_hand import LedHand, SteeredGrasp
    from drake_mobman.teleop.live import LiveSource, Operator
    from drake_mobman.teleop.recorded import RecordedSource, Recording
    from drake_mobman.teleop.scripted import Held, Script, ScriptedSource, Smooth
    from drake_mobman.teleop.stop_ramp import StopRamp
else:
    __getattr__ = lazy_getattr(
        __name__, ("arm", "base", "decomposers", "guidance", "robots", "teleop")
    )

__all__ = [
    "ArmInverse",
    "BaseEstimator",
    "BaseLimits",
    "Blending",
    "BlendingDecomposer",
    "Bump",
    "ClosedFormInverse",
    "CommandGate",
    "CommandGuard",
    "CommandPassThrough",
    "CommandSmoother",
    "CompensatedDecomposer",
    "ControllerSelector",
    "CrossFade",
    "DampedInverse",
    "DiffIk",
    "DiffIkDecomposer",
    "Drag",
    "Drake",
    "Drive",
    "EndEffectorSensor",
    "Exact",
    "ExactDecomposer",
    "External",
    "FieldDecomposer",
    "File",
    "Floor",
    "FrankaTiago",
    "Gate",
    "GraspForce",
    "Guard",
    "Guided",
    "GuidingHand",
    "Gyro",
    "Hand",
    "Held",
    "JerkLimited",
    "JerkLimiter",
    "JointLimits",
    "Kinematic",
    "KinematicRobot",
    "LedHand",
    "LiveSource",
    "Measured",
    "Mujoco",
    "Odometry",
    "Operator",
    "OptimizationDecomposer",
    "OrientedInverse",
    "ParameterError",
    "Patch",
    "Planar",
    "Planned",
    "PointForce",
    "Projection",
    "Qp",
    "QpDecomposer",
    "Reach",
    "RecordedSource",
    "Recording",
    "Release",
    "RobotSetup",
    "ScenarioError",
    "Script",
    "ScriptedSource",
    "Sensors",
    "Sent",
    "Servo",
    "ShareDecomposer",
    "Smooth",
    "Smoother",
    "Spatial",
    "Start",
    "SteeredGrasp",
    "StopRamp",
    "Switching",
    "SwitchingDecomposer",
    "Teleop",
    "ToolSensor",
    "Transition",
    "Unsmoothed",
    "VelocityField",
    "VelocityFieldController",
    "Waypoint",
    "Wheels",
    "WorkspaceLimits",
    "__version__",
    "declare_decomposer_ports",
    "draw_figures",
    "load_scenario",
    "make_diagram",
    "metrics",
    "scalar_block",
    "scenario_names",
    "simulate",
]


def __dir__() -> list[str]:
    """Returns what there is, used already or not."""
    return sorted({*globals(), *__all__})
