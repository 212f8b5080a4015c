"""A posture for an arm: level, ahead, far from its limits and well-conditioned.

By nonlinear programs from several starts, which are the same each time; the best
solution is taken.
"""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from pydrake.multibody.inverse_kinematics import InverseKinematics
from pydrake.multibody.tree import JacobianWrtVariable
from pydrake.solvers import SnoptSolver

from drake_mobman.frames import frame
from drake_mobman.robot_model.model import BASE_JOINTS, moving_joints
from drake_mobman.robots.derive.derived import Derived
from drake_mobman.robots.derive.ranges import arm_ranges
from drake_mobman.scalars import Matrix

_STARTS = 16
"""Random joint angles to start from, for each direction of the tool."""

_MARGIN = 0.05
"""Share of a joint's range that stays free at each end."""

_NEAR, _FAR = 0.65, 0.75
"""Least and largest distance of T from the shoulder, as shares of the arm's reach."""

_LOW, _HIGH = -0.6, 0.3
"""Least and largest height of T above the shoulder, as shares of the same."""

_HANGING = 0.3
"""What a posture counts whose elbow is below both the shoulder and the wrist, where
the base is; of one whose elbow is not."""

_SLIGHTLY = 0.02
"""How far below still counts as level with it [m]."""

_FLOOR = 0.1
"""Least height of the end effector above the floor [m]."""

_EXACT = 1e-9
"""How far a direction may be off [rad]; SNOPT meets it to about 1e-6."""


class Tool(NamedTuple):
    """A direction that the tool may point in."""

    name: str
    ahead: tuple[float, float, float]  # In B's axes.


TOOLS = Tool("ahead", (1.0, 0.0, 0.0)), Tool("down", (0.0, 0.0, -1.0))
"""What counts as level: the tool's axis is horizontal, or it is vertical."""


TILTED = "tool in any direction"
"""Source of a posture in which the tool is not level."""


class _Found(NamedTuple):
    """A posture that a program has found."""

    score: float
    q: Matrix  # (n,) [rad], [m].
    how: str


def posture(
    plant: Any, p_BS: Matrix, r_f: float, length: float, *, level: bool
) -> Derived[Matrix]:
    """Returns joint positions (n,) for the arm to start from and to return to.

    Args:
        plant: finalized, with frames `base`, `tee` and `tool`.
        p_BS: of the shoulder (3,) [m].
        r_f: largest distance of T from it [m].
        length: weight of turning E against moving it [m].
        level: whether E is to be level.

    Returns:
        The posture; its source says where the end effector cannot be level.
    """
    search = _Search(plant, p_BS, r_f, length if level else None)
    levels = TOOLS if level else ()
    found = [each for tool in levels for each in search.postures(tool)]
    if not found:
        found = [*search.postures(None)]
    if not found:
        return Derived(
            search.ranges.middle, "middle of the joints' ranges, as no other fits"
        )
    best = max(found, key=lambda each: each.score)
    return Derived(best.q, best.how)


class _Search:
    """Looks for postures of one arm."""

    def __init__(
        self, plant: Any, p_BS: Matrix, r_f: float, length: float | None
    ) -> None:
        self.plant, self.context = plant, plant.CreateDefaultContext()
        self.p_BS, self.r_f, self.length = p_BS, r_f, length
        self.B, self.T, self.E = (frame(plant, x) for x in ("base", "tee", "tool"))
        self.ranges = arm_ranges(plant)
        self.n = len(self.ranges.low)
        moving = moving_joints(plant)[BASE_JOINTS:]
        self.last = moving[-1]
        turning = [x for x in moving if x.type_name() == "revolute"]
        self.links = [x.frame_on_child() for x in turning[1:]]

    def postures(self, tool: Tool | None) -> Iterator[_Found]:
        """Yields postures with the tool in a direction, or in any."""
        rng = np.random.default_rng(1)
        low, high, _ = self.ranges
        for start in rng.uniform(low, high, (_STARTS, self.n)):
            q = self._solve(tool, start)
            if q is not None:
                how = f"tool {tool.name}" if tool else TILTED
                yield _Found(self._score(q), q, f"optimised, {how}")

    def _solve(self, tool: Tool | None, start: Matrix) -> Matrix | None:
        """Returns a posture from a start; None where the program finds none."""
        ik = InverseKinematics(self.plant, self.context, with_joint_limits=False)
        q, program = ik.q(), ik.prog()
        still = np.zeros(BASE_JOINTS)
        program.AddBoundingBoxConstraint(still, still, q[:BASE_JOINTS])
        low, high, ended = self.ranges
        spare, arm = _MARGIN * (high - low) * ended, q[BASE_JOINTS:]
        program.AddBoundingBoxConstraint(low + spare, high - spare, arm)
        weight = np.where(ended, (high - low) ** -2.0, 0.0)
        program.AddQuadraticErrorCost(np.diag(weight), self.ranges.middle, arm)
        self._place(ik)
        if tool:
            self._point(ik, tool)
        guess = np.append(still, start)
        result = SnoptSolver().Solve(program, guess, None)
        return result.GetSolution(arm) if result.is_success() else None

    def _place(self, ik: Any) -> None:
        """Keeps E straight ahead of S, and T in the middle of the arm's reach."""
        (x, y, z), far = self.p_BS, 2 * self.r_f + 1.0
        low, high = [x, y, _FLOOR], [x + far, y, z + far]
        ik.AddPositionConstraint(self.E, np.zeros(3), self.B, low, high)
        low, high = (
            [x, y - far, z + _LOW * self.r_f],
            [x + far, y + far, z + _HIGH * self.r_f],
        )
        ik.AddPositionConstraint(self.T, np.zeros(3), self.B, low, high)
        least, most = _NEAR * self.r_f, _FAR * self.r_f
        ik.AddPointToPointDistanceConstraint(
            self.B, self.p_BS, self.T, np.zeros(3), least, most
        )

    def _point(self, ik: Any, tool: Tool) -> None:
        """Lets the tool's axis point in a direction."""
        axis, right = self._tool_axis(), math.pi / 2
        for across in np.eye(3)[np.array(tool.ahead) == 0]:
            ik.AddAngleBetweenVectorsConstraint(
                self.B, across, self.E, axis, right - _EXACT, right + _EXACT
            )
        ik.AddAngleBetweenVectorsConstraint(
            self.B, np.array(tool.ahead), self.E, axis, 0.0, right / 2
        )

    def _tool_axis(self) -> Matrix:
        """Returns the axis in E's axes that the tool points along.

        That of the last joint, on the side of the tool that is away from the wrist.
        """
        X_EL = self.last.frame_on_child().CalcPose(self.context, self.E)
        axis = np.asarray(X_EL.rotation() @ self.last.revolute_axis())
        to_wrist = self.T.CalcPose(self.context, self.E).translation()
        return -axis if axis @ to_wrist > 0 else axis

    def _score(self, q: Matrix) -> float:
        """Returns how good a posture is: conditioning times distance from limits."""
        plant = self.plant
        plant.SetPositions(self.context, np.append(np.zeros(BASE_JOINTS), q))
        J = plant.CalcJacobianSpatialVelocity(
            self.context,
            JacobianWrtVariable.kV,
            self.E,
            np.zeros(3),
            self.B,
            self.B,
        )[:, BASE_JOINTS:]
        rows = J[3:]
        if self.length is not None:
            J[:3] *= self.length
            rows = J
        smallest = float(np.linalg.svd(rows, compute_uv=False)[-1])
        return smallest * self.ranges.margin(q) * (_HANGING if self._hangs() else 1.0)

    def _hangs(self) -> bool:
        """Returns whether the elbow is below both S and T."""
        B, context = self.B, self.context
        T, *links = (
            x.CalcPose(context, B).translation()[2] for x in (self.T, *self.links)
        )
        return bool(min(links) < min(self.p_BS[2], T) - _SLIGHTLY)
