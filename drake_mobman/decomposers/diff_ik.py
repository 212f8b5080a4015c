"""Base and arm commanded together by Drake's differential inverse kinematics.

maximize    100 alpha - |P (u - N^+ K (q_nominal - q))|^2
subject to  J u = alpha V,  0 <= alpha <= 1,
            q_min <= q + N u dt <= q_max,  u_min <= u <= u_max,

u = [v_b, omega_b, q_dot_arm], P a basis of J's null space: the end effector keeps its
direction and is as fast as the limits allow, and the null space brings the arm back to
its posture. N(q) maps u to the rates of x, y, theta and the joints: with it, the base
rolls and does not slide. It is Drake's `DoDifferentialInverseKinematics`, in the frame
B: the pose of the base makes no difference.
"""

import dataclasses as dc
import math
from typing import Any

import numpy as np
from pydrake.multibody.inverse_kinematics import (
    DifferentialInverseKinematicsParameters,
    DoDifferentialInverseKinematics,
)
from pydrake.multibody.tree import JacobianWrtVariable
from pydrake.solvers import OsqpSolver

from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.arm.limits import JointLimits, braking_rate
from drake_mobman.arm.orientation import orientation_error, rotation_about_z
from drake_mobman.decomposers.optimization import BASE_RATES, OptimizationDecomposer
from drake_mobman.frames import frame
from drake_mobman.parameters import (
    ACCELERATION,
    GAIN,
    PAUSE,
    SPEED,
    YAW_ACCELERATION,
    YAW_RATE,
    Range,
    checked,
    within,
)
from drake_mobman.robot_model import BASE_JOINTS, RobotSetup
from drake_mobman.robot_model.base_limits import check_base
from drake_mobman.scalars import larger, smaller

_LEVEL_JOINTS = 6
"""Joints needed to place the end effector and keep it level; with fewer, it moves in
the plane."""

_UNITS = (0.2, 0.1)
"""Units of all rates in Drake's program [m/s] and [rad/s], tried in this order.

In units of 1, alpha dominates the cost: OSQP takes five times as long, and finds no
solution of many programs that have one. In either of these units it fails on one in a
hundred, but not on the same ones. Smaller units would make the end effector slower.
"""


@dc.dataclass
class DiffIk:
    """Limits of the base, and how the arm comes back to its posture."""

    max_speed: float = 0.5  # Of the base, forward and back [m/s].
    max_yaw_rate: float = 1.0  # Of the base [rad/s].
    max_acceleration: float = 1.0  # Of the base [m/s^2].
    max_yaw_acceleration: float = 2.0  # Of the base [rad/s^2].
    # It also moves the base while the end effector is at rest.
    centering: float = 1.0  # K: joint rates per distance from the posture [1/s].
    level_gain: float = 1.0  # Turning rate per orientation error [1/s].
    # By default as long as the base needs at its largest acceleration.
    stop_time: float = 0.5  # Time to stop from the largest rates, if unsolved [s].
    tolerance: float = 1e-8  # Of the solver, absolute and relative.

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, SPEED, "max_speed")
        within(self, YAW_RATE, "max_yaw_rate")
        within(self, ACCELERATION, "max_acceleration")
        within(self, YAW_ACCELERATION, "max_yaw_acceleration")
        within(self, GAIN, "centering", "level_gain")
        within(self, PAUSE, "stop_time")
        within(self, Range(1e-12, 0.01), "tolerance")

    def build(self, setup: RobotSetup) -> "DiffIkDecomposer":
        """Returns the block for a robot.

        Raises:
            ParameterError: where a limit is above what the base can do.
        """
        check_base(self, setup.model.base_limits)
        return DiffIkDecomposer(self, setup)


# The law.


def nonholonomic_map(theta: float, num_joints: int) -> Any:
    """Returns N(q) (3 + n, 2 + n), which maps u to the rates of all positions.

    x' = v_b cos(theta), y' = v_b sin(theta), theta' = omega_b; joint rates unchanged.

    Args:
        theta: heading of the base [rad].
        num_joints: of the arm, n.
    """
    N = np.eye(
        BASE_JOINTS + num_joints, BASE_RATES + num_joints, BASE_RATES - BASE_JOINTS
    )
    N[:BASE_JOINTS] = 0.0
    N[0, 0], N[1, 0], N[2, 1] = math.cos(theta), math.sin(theta), 1.0
    return N


def rates_within_reach(
    last: Any, q: Any, largest: Any, accelerations: Any, limits: JointLimits, dt: float
) -> tuple[Any, Any]:
    """Returns the smallest and the largest rates (2 + n,) after rates `last`.

    They are within the largest rates, and can be reached by the accelerations. A joint
    approaches its limit no faster than it can brake; else Drake's limit on positions
    would leave no rate at all after some time.

    Args:
        last: rates of the period before, each within `largest` (2 + n,).
        q: joint angles (n,) [rad].
        largest: rates of base and joints (2 + n,).
        accelerations: of these (2 + n,); may be infinite.
        limits: of the joints.
        dt: for which the rates are held [s].
    """
    lowest, highest = -largest, largest.copy()
    joints = zip(q, limits.lower, limits.upper, accelerations[BASE_RATES:], strict=True)
    for i, (angle, low, high, most) in enumerate(joints, start=BASE_RATES):
        # As slow as needed, but no slower than the acceleration allows.
        towards_high = larger(braking_rate(high - angle, most, dt), last[i] - most * dt)
        towards_low = larger(braking_rate(angle - low, most, dt), -last[i] - most * dt)
        highest[i] = smaller(highest[i], towards_high)
        lowest[i] = larger(lowest[i], -towards_low)
    step = accelerations * dt
    return np.maximum(lowest, last - step), np.minimum(highest, last + step)


class EndEffectorModel:
    """The end effector's motion by u in B, from the robot's `MultibodyPlant`.

    Each call overwrites its context: do not share one object between threads.
    """

    def __init__(self, plant: Any, num_joints: int) -> None:
        """Takes a finalized plant of x, y, theta and the arm's joints."""
        self._plant = plant
        self._context = plant.CreateDefaultContext()
        self._q = np.zeros(BASE_JOINTS + num_joints)
        self._B, self._E = frame(plant, "base"), frame(plant, "tool")
        self._N = nonholonomic_map(0.0, num_joints)

    def pose_and_jacobian(self, q: Any) -> tuple[Any, Any]:
        """Returns R_BE (3, 3) and the Jacobian (6, 2 + n) of V_WE in B by u.

        The base is at W's origin, so W's axes are B's.

        Args:
            q: joint angles (n,) [rad].
        """
        self._q[BASE_JOINTS:] = q
        self._plant.SetPositions(self._context, self._q)
        W = self._plant.world_frame()
        J = self._plant.CalcJacobianSpatialVelocity(
            self._context, JacobianWrtVariable.kQDot, self._E, np.zeros(3), W, W
        )
        R_BE = self._E.CalcPose(self._context, self._B).rotation().matrix()
        return R_BE, J @ self._N


# The block.


class DiffIkDecomposer(OptimizationDecomposer):
    """Splits the command by Drake's program; ports as every `OptimizationDecomposer`.

    For every robot. The end effector moves in the plane; where the arm has six joints
    or more, in space: then it is kept level, as at the posture, and turns with the
    reach. The posture is the arm's own; an arm in closed form has the end effector at
    half the reach straight ahead.

    A jump of the command can be more than the accelerations allow, as the end effector
    keeps its direction: then there is no solution until braking has made the rates
    small enough.

    Args:
        params: limits of the base and gains; the joints' limits are the model's.
        setup: of the robot.

    Raises:
        ParameterError: where a parameter is not valid.
    """

    def __init__(self, params: DiffIk, setup: RobotSetup) -> None:
        checked(params)
        limits, arm, period = setup.joint_limits, setup.arm, setup.period
        largest = np.array([params.max_speed, params.max_yaw_rate, *limits.velocity])
        super().__init__(arm.num_joints, arm.p_BS, largest, params.stop_time, period)
        self.params, self.limits = params, limits
        self.accelerations = np.array(
            [
                params.max_acceleration,
                params.max_yaw_acceleration,
                *limits.acceleration,
            ]
        )
        if isinstance(arm, JacobianArm):
            posture = arm.posture
        else:
            posture = np.array(arm.inverse((0.5 * setup.reach.r_f, 0.0, 0.0)))
        self.end_effector = EndEffectorModel(setup.model.plant, arm.num_joints)
        R_BE, _ = self.end_effector.pose_and_jacobian(posture)
        self._R_level = rotation_about_z(-arm.ee_cylindrical(posture)[1]) @ R_BE
        # Rotation and translation; or translation in the plane.
        self._rows = slice(0, 6) if arm.num_joints >= _LEVEL_JOINTS else slice(3, 5)
        self._N = np.asfortranarray(nonholonomic_map(0.0, arm.num_joints))
        self._N_plus = np.asfortranarray(self._N.T)  # Its columns are orthonormal.
        self._parameters = [
            _parameters(params, posture, limits, period, unit) for unit in _UNITS
        ]

    def rates(self, command: Any, at: Any, q: Any, last: Any) -> tuple[Any, Any] | None:
        """Returns Drake's solution and the velocity on the base, or None."""
        V, J = self.task(command, at, q)
        # A value that is not finite would end the process.
        if not np.isfinite(V).all():
            return None
        # Drake's own limit on accelerations has the size of the positions, not of u. As
        # limits on rates it is the same.
        lowest, highest = rates_within_reach(
            last, q, self.largest, self.accelerations, self.limits, self.period
        )
        positions = np.concatenate([np.zeros(BASE_JOINTS), q])
        rows_of_J = np.asfortranarray(J[self._rows])
        for unit, parameters in zip(_UNITS, self._parameters, strict=True):
            parameters.set_joint_velocity_limits((lowest / unit, highest / unit))
            found = DoDifferentialInverseKinematics(
                positions,
                last / unit,
                V[self._rows] / unit,
                rows_of_J,
                parameters,
                self._N,
                self._N_plus,
            ).joint_velocities
            if found is not None:
                u = unit * found
                by_arm = J[3:, BASE_RATES:] @ u[BASE_RATES:]
                return u, rotation_about_z(-at[1]) @ by_arm
        return None

    def task(self, command: Any, at: Any, q: Any) -> tuple[Any, Any]:
        """Returns the desired V_WE (6,), and its Jacobian by u (6, 2 + n).

        Both in B's axes, rotational rows first. The desired V_WE also turns the end
        effector back to level.
        """
        l, psi, _ = at
        v_c, omega_c, v_z = command
        R_BE, J = self.end_effector.pose_and_jacobian(q)
        R_reach = rotation_about_z(psi)
        w = self.params.level_gain * orientation_error(R_BE, R_reach @ self._R_level)
        w[2] += omega_c
        return np.concatenate([w, R_reach @ (v_c, l * omega_c, v_z)]), J


def _parameters(
    params: DiffIk, posture: Any, limits: JointLimits, period: float, unit: float
) -> DifferentialInverseKinematicsParameters:
    """Returns Drake's parameters in a unit of rates, without the limits on rates."""
    n = len(posture)
    made = DifferentialInverseKinematicsParameters(BASE_JOINTS + n, BASE_RATES + n)
    made.set_time_step(unit * period)
    anywhere = np.full(BASE_JOINTS, math.inf)
    made.set_joint_position_limits(
        (
            np.concatenate([-anywhere, limits.lower]),
            np.concatenate([anywhere, limits.upper]),
        )
    )
    nowhere = np.zeros(BASE_JOINTS)
    made.set_nominal_joint_position(np.concatenate([nowhere, posture]))
    gains = np.concatenate([nowhere, np.full(n, params.centering / unit)])
    made.set_joint_centering_gain(np.asfortranarray(np.diag(gains)))
    options = made.get_mutable_solver_options()
    for name, value in (
        ("eps_abs", params.tolerance),
        ("eps_rel", params.tolerance),
        ("polishing", 0),  # Polishing prints a line where no limit is active.
    ):
        options.SetOption(OsqpSolver.id(), name, value)
    return made
