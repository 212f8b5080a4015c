"""Base and arm commanded together by a quadratic program (Kwon et al., eq. 17).

minimize    1/2 |J u - v_ref|^2 + lambda |u|^2
subject to  q + u dt <= q_max,

u = [v_b, omega_b, theta_dot_1, ...]: the base's velocities and the rates of the joints
that place the end effector. The paper compares its own law with this one, and does not
define J, v_ref and the bound. Here:

- The rows of J and v_ref = [v_c, l omega_c, v_z] are velocities of the end effector in
  W [m/s]: along the reach, across it, and up where the arm can. The paper writes
  omega_c; that row times l means the same motion, has the unit of the other rows, so
  that lambda weighs all alike, and stays finite where l = 0.
- q_max = 0.01 cannot be a bound on the base's position. It bounds a step,
  |u dt| <= q_max: 1 m/s and 1 rad/s at a period of 10 ms. Joints also keep to their
  ranges and rates, which is the bound as printed.
"""

import dataclasses as dc
import functools
import math
from typing import Any, NamedTuple

import numpy as np
from pydrake.solvers import MathematicalProgram, OsqpSolver, SolverOptions

from drake_mobman.arm import two_link
from drake_mobman.arm.kinematics import ArmKinematics
from drake_mobman.arm.limits import JointLimits
from drake_mobman.arm.planar import PlanarArm
from drake_mobman.arm.spatial import SpatialArm
from drake_mobman.decomposers.optimization import BASE_RATES, OptimizationDecomposer
from drake_mobman.parameters import (
    PAUSE,
    ParameterError,
    Range,
    checked,
    checked_period,
    within,
)
from drake_mobman.robot_model import RobotSetup


@dc.dataclass
class Qp:
    """The program's weights and bounds, and how it is solved (Kwon, section 5)."""

    damping: float = 0.01  # lambda: weight of motion against the error of E, in (0, 1).
    max_step: float = 0.01  # q_max: largest step in a period, of each [m] and [rad].
    # Finer than a robot needs, to compare solvers.
    tolerance: float = 2e-7  # How far each rate may be from its optimum [m/s], [rad/s].
    iterations: int = 4000  # Largest number of the solver's iterations.
    stop_time: float = 0.2  # Time to stop from the largest rates, if unsolved [s].

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range, `damping` below 1."""
        within(self, Range(1e-6, 1.0), "damping")
        within(self, Range(1e-6, 1.0, "m or rad"), "max_step")
        within(self, Range(1e-12, 0.01, "m/s or rad/s"), "tolerance")
        within(self, Range(1, 100_000), "iterations")
        within(self, PAUSE, "stop_time")
        if not self.damping < 1:
            raise ParameterError("damping", self.damping, "must be below 1")

    def build(self, setup: RobotSetup) -> "QpDecomposer":
        """Returns the block for a robot.

        Raises:
            ParameterError: where its arm has no Jacobian in closed form.
        """
        if not has_jacobian(setup.arm):
            valid = "must be another; the arm has no Jacobian in closed form"
            raise ParameterError("", "!Qp", valid)
        return QpDecomposer(self, setup.arm, setup.joint_limits, setup.period)


@functools.singledispatch
def arm_jacobian(arm: ArmKinematics, _q: Any, _at: Any) -> Any:
    """Returns the Jacobian (2 or 3, m) of the end effector's velocity on the base.

    Rows: along the reach, across it, and up [m/s]; the end effector stays level.
    Columns: the arm's first m joints [rad/s].

    Args:
        arm: has m = 2 joints that place the end effector in the plane, or 3 in space.
        _q: joint angles (n,) [rad].
        _at: `ee_cylindrical` (3,) at `_q`.

    Raises:
        ParameterError: where the arm has no Jacobian in closed form.
    """
    valid = "must have an arm with a Jacobian in closed form"
    raise ParameterError("robot", type(arm).__name__, valid)


@arm_jacobian.register
def _(arm: PlanarArm, q: Any, at: Any) -> Any:
    l, psi, _ = at
    lower_link = q[0] + q[1] - psi
    return np.array(
        [
            [0.0, -arm.lower * math.sin(lower_link)],
            [l, arm.lower * math.cos(lower_link)],
        ]
    )


@arm_jacobian.register
def _(arm: SpatialArm, q: Any, at: Any) -> Any:
    ahead, above = two_link.forward(q[1], q[2], arm.upper, arm.lower)
    lower_link = q[1] + q[2]
    return np.array(
        [
            [0.0, -above, -arm.lower * math.sin(lower_link)],
            [at[0], 0.0, 0.0],
            [0.0, ahead, arm.lower * math.cos(lower_link)],
        ]
    )


def has_jacobian(arm: ArmKinematics) -> bool:
    """Returns whether `arm_jacobian` is defined for the arm."""
    return arm_jacobian.dispatch(type(arm)) is not arm_jacobian.dispatch(object)


def base_jacobian(at: Any, p_BS: Any) -> Any:
    """Returns the end effector's Jacobian (3, 2) by v_b and omega_b, the arm at rest.

    Rows: along the reach, across it, up [m/s].

    Args:
        at: `ee_cylindrical` (3,).
        p_BS: shoulder in B (3,) [m].
    """
    l, psi, _ = at
    d, e, _ = p_BS
    c, s = math.cos(psi), math.sin(psi)
    return np.array([[c, d * s - e * c], [-s, l + d * c + e * s], [0.0, 0.0]])


class BoxQp(NamedTuple):
    """Minimize 1/2 u^T P u + q^T u, subject to lb <= u <= ub."""

    P: Any  # (k, k)
    q: Any  # (k,)
    lb: Any  # (k,)
    ub: Any  # (k,)


def tracking_qp(J: Any, v_ref: Any, bounds: tuple[Any, Any], damping: float) -> BoxQp:
    """Returns eq. 17 for an end effector whose velocity is `J u`.

    Args:
        J: Jacobian (r, k).
        v_ref: desired velocity (r,).
        bounds: smallest and largest rates, (k,) each.
        damping: lambda.
    """
    P = J.T @ J
    P.flat[:: len(P) + 1] += 2 * damping
    return BoxQp(P, -(v_ref @ J), *bounds)


def rate_bounds(
    q: Any, limits: JointLimits, params: Qp, period: float
) -> tuple[Any, Any]:
    """Returns the smallest and the largest rates (2 + m,) of base and joints.

    For a joint that is out of its range by more than a step there is no valid rate: its
    smallest rate is then above its largest.

    Args:
        q: angles (m,) of the joints that place the end effector [rad].
        limits: of the arm's joints, these first.
        params: bounds each step.
        period: for which the rates are held [s].
    """
    m = len(q)
    largest = np.full(BASE_RATES + m, params.max_step / period)
    np.minimum(largest[BASE_RATES:], limits.velocity[:m], out=largest[BASE_RATES:])
    lowest, highest = -largest, largest
    to_lower = np.subtract(limits.lower[:m], q) / period
    to_upper = np.subtract(limits.upper[:m], q) / period
    np.maximum(lowest[BASE_RATES:], to_lower, out=lowest[BASE_RATES:])
    np.minimum(highest[BASE_RATES:], to_upper, out=highest[BASE_RATES:])
    return lowest, highest


def decomposition_qp(
    arm: ArmKinematics,
    limits: JointLimits,
    params: Qp,
    period: float,
    command: Any,
    at: Any,
    q: Any,
) -> tuple[BoxQp, Any]:
    """Returns the program that splits a command, and the arm's part of its Jacobian.

    Args:
        arm: one that `arm_jacobian` is defined for.
        limits: of its joints.
        params: weights and bounds.
        period: control period [s].
        command: `ee_command`.
        at: `ee_cylindrical` (3,).
        q: joint angles (n,) [rad].
    """
    J_arm = arm_jacobian(arm, q, at)
    rows, m = J_arm.shape
    J = np.hstack([base_jacobian(at, arm.p_BS)[:rows], J_arm])
    v_c, omega_c, v_z = command
    v_ref = np.array([v_c, at[0] * omega_c, v_z])[:rows]
    bounds = rate_bounds(q[:m], limits, params, period)
    return tracking_qp(J, v_ref, bounds, params.damping), J_arm


class QpProgram:
    """A `BoxQp` of k unknowns as a Drake program that is kept, and solved by OSQP.

    The cost's curvature is 2 lambda at least. So an error of the gradient of at most
    2 lambda times the tolerance keeps the solution within the tolerance.

    Each solution overwrites its coefficients: do not share one object between threads.
    """

    def __init__(self, size: int, params: Qp) -> None:
        self._program = MathematicalProgram()
        u = self._program.NewContinuousVariables(size)
        self._cost = self._program.AddQuadraticCost(
            np.eye(size), np.zeros(size), u, is_convex=True
        ).evaluator()
        self._bounds = self._program.AddBoundingBoxConstraint(
            -np.ones(size), np.ones(size), u
        ).evaluator()
        self._solver = OsqpSolver()
        self._options = SolverOptions()
        for name, value in (
            ("eps_abs", 2 * params.damping * params.tolerance),
            ("eps_rel", 0.0),
            ("max_iter", params.iterations),
            ("polishing", 0),  # Polishing prints a line where no bound is active.
        ):
            self._options.SetOption(OsqpSolver.id(), name, value)

    def solve(self, qp: BoxQp, guess: Any = None) -> Any:
        """Returns the solution (k,), or None where there is none or none is found.

        Args:
            qp: the program.
            guess: where to start from (k,), if given.
        """
        # OSQP would print where bounds are out of order, and accept NaN.
        if not (np.isfinite(qp.P).all() and np.isfinite(qp.q).all()):
            return None
        if not (qp.lb <= qp.ub).all():
            return None
        self._cost.UpdateCoefficients(qp.P, qp.q, 0.0, is_convex=True)
        self._bounds.set_bounds(qp.lb, qp.ub)
        result = self._solver.Solve(self._program, guess, self._options)
        return result.get_x_val() if result.is_success() else None


class QpDecomposer(OptimizationDecomposer):
    """Splits the command by eq. 17; ports as every `OptimizationDecomposer`.

    The wrist's joints, which keep the end effector level, are no part of the program:
    the arm's inverse keeps to their limits.

    Args:
        params: weights and bounds.
        arm: one that `arm_jacobian` is defined for.
        limits: of all its joints.
        period: control period [s].

    Raises:
        ParameterError: where a parameter or the arm is not valid.
    """

    def __init__(
        self, params: Qp, arm: ArmKinematics, limits: JointLimits, period: float
    ) -> None:
        checked(params)
        q = np.zeros(arm.num_joints)
        m = arm_jacobian(arm, q, arm.ee_cylindrical(q)).shape[1]
        largest = np.full(BASE_RATES + m, params.max_step / checked_period(period))
        super().__init__(arm.num_joints, arm.p_BS, largest, params.stop_time, period)
        self.params, self.arm, self.limits = params, arm, limits
        self.program = QpProgram(BASE_RATES + m, params)

    def rates(self, command: Any, at: Any, q: Any, last: Any) -> tuple[Any, Any] | None:
        """Returns the optimum and the velocity on the base, or None."""
        qp, J_arm = decomposition_qp(
            self.arm, self.limits, self.params, self.period, command, at, q
        )
        u = self.program.solve(qp, last)
        if u is None:
            return None
        velocity = np.zeros(3)
        velocity[: len(J_arm)] = J_arm @ u[BASE_RATES:]
        return u, velocity
