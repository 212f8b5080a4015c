"""The robot at fidelity `kinematic`: it moves exactly as commanded, by Euler steps."""

import dataclasses as dc
from typing import Any, ClassVar

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem

from drake_mobman import signals
from drake_mobman.arm.end_effector_sensor import EndEffectorSensor
from drake_mobman.base.unicycle import unicycle_rates
from drake_mobman.blocks import scalar_block, tickets
from drake_mobman.parameters import checked_period
from drake_mobman.robot_model import BASE_JOINTS, RobotDescription, RobotSetup
from drake_mobman.scalars import Matrix, Vector


@dc.dataclass
class Kinematic:
    """The robot moves exactly as commanded, by Euler steps of the control period."""

    has_masses: ClassVar[bool] = False

    def build(self, setup: RobotSetup, start: list[float]) -> Diagram:
        """Returns the robot as a diagram."""
        return make_kinematic_robot(setup, start)

    def plant(self, _robot: RobotDescription) -> None:
        """Returns None: there is no plant."""

    def check_period(self, period: float) -> None:
        """Accepts any control period [s]."""

    def aligned_with(self, period: float) -> "tuple[float, Kinematic]":
        """Returns period and fidelity unchanged."""
        return period, self


@scalar_block
class KinematicRobot(LeafSystem):
    """A unicycle with an arm on it, integrated by explicit Euler.

    .. pydrake_system::

        name: KinematicRobot
        input_ports: [base_command_smoothed, arm_velocity_command]
        output_ports: [base_pose, base_velocity, arm_position, arm_velocity]

    Args:
        start: positions at the start (3 + n,): x, y [m] and theta [rad] of the base,
            and the joint angles of the arm [rad].
        period: of a step [s].

    Raises:
        ParameterError: where `period` is not valid.
        RuntimeError: in a run, where a command is not finite; the state stays finite.
    """

    def __init__(self, start: Vector, period: float) -> None:
        start = np.array(start, dtype=float)
        self.period = checked_period(period)
        n = len(start) - BASE_JOINTS
        self.base_command = self.DeclareVectorInputPort(
            signals.BASE_COMMAND_SMOOTHED, 2
        )
        self.rates = self.DeclareVectorInputPort(signals.ARM_VELOCITY_COMMAND, n)
        self.DeclareDiscreteState(np.array([self.scalar(x) for x in start]))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._step)
        state = {self.all_state_ticket()}
        base, rates = tickets(self, self.base_command), tickets(self, self.rates)
        for name, size, calc, needs in (
            (signals.BASE_POSE, 3, self._calc_base_pose, state),
            (signals.BASE_VELOCITY, 3, self._calc_base_velocity, state | base),
            (signals.ARM_POSITION, n, self._calc_arm_position, state),
            (signals.ARM_VELOCITY, n, self._calc_arm_velocity, rates),
        ):
            self.DeclareVectorOutputPort(name, size, calc, prerequisites_of_calc=needs)

    def _q(self, context: Any) -> Matrix:
        """Returns the positions (3 + n,)."""
        return context.get_discrete_state_vector().CopyToVector()

    def _q_and_base_rates(self, context: Any) -> tuple[Matrix, Matrix]:
        """Returns all positions (3 + n,), and the base's rates (3,) in W."""
        q = self._q(context)
        v_b, omega_b = self.base_command.Eval(context)
        return q, np.array(unicycle_rates(q[2], v_b, omega_b))

    def _step(self, context: Any, state: Any) -> None:
        q, base_rates = self._q_and_base_rates(context)
        v = np.concatenate([base_rates, self.rates.Eval(context)])
        if self.scalar is float and not np.isfinite(v).all():
            raise RuntimeError(
                f"the robot is commanded velocities that are not finite: {v.tolist()}"
            )
        state.get_mutable_vector().SetFromVector(q + self.period * v)

    def _calc_base_pose(self, context: Any, output: Any) -> None:
        output.SetFromVector(self._q(context)[:BASE_JOINTS])

    def _calc_base_velocity(self, context: Any, output: Any) -> None:
        q, (x, y, theta) = self._q_and_base_rates(context)
        ahead_x, ahead_y, _ = unicycle_rates(q[2], 1.0, 0.0)
        forward = ahead_x * x + ahead_y * y
        sideways = ahead_x * y - ahead_y * x
        output.SetFromVector(np.array([forward, sideways, theta]))

    def _calc_arm_position(self, context: Any, output: Any) -> None:
        output.SetFromVector(self._q(context)[BASE_JOINTS:])

    def _calc_arm_velocity(self, context: Any, output: Any) -> None:
        output.SetFromVector(self.rates.Eval(context))


KinematicRobot_ = KinematicRobot.template


def make_kinematic_robot(setup: RobotSetup, start: list[float]) -> Diagram:
    """Returns the robot as a diagram.

    .. pydrake_system::

        name: robot
        input_ports: [base_command_smoothed, arm_velocity_command]
        output_ports: [base_pose, base_velocity, arm_position, arm_velocity,
                       ee_cylindrical, p_BT]

    Args:
        setup: of the robot.
        start: positions (3 + n,) of base and arm.

    Raises:
        ParameterError: where the period is not valid.
    """
    builder = DiagramBuilder()
    body, sensor = (
        builder.AddNamedSystem(name, setup.maybe_compiled(block))
        for name, block in (
            ("kinematic", KinematicRobot(start, setup.period)),
            ("sensor", EndEffectorSensor(setup.arm)),
        )
    )
    position = body.GetOutputPort(signals.ARM_POSITION)
    builder.Connect(position, sensor.GetInputPort(signals.ARM_POSITION))
    for system in (body, sensor):
        for i in range(system.num_output_ports()):
            port = system.get_output_port(i)
            builder.ExportOutput(port, port.get_name())
    for name in (signals.BASE_COMMAND_SMOOTHED, signals.ARM_VELOCITY_COMMAND):
        builder.ExportInput(body.GetInputPort(name), name)
    diagram = builder.Build()
    diagram.set_name("robot")
    return diagram
