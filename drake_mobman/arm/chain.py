"""The kinematics of a serial arm as a plain law, with its numbers from a plant.

The plant is asked once. Then pose and Jacobian are sums and products that float,
AutoDiffXd and Expression all pass through, without the plant.
"""

import dataclasses as dc
from typing import Any, NamedTuple

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix, cos, sin

from drake_mobman.frames import frame
from drake_mobman.scalars import Scalar, Vector
from drake_mobman.tracing import all_named, named

_ROUNDING = 1e-15
"""How far a number may be from 0, 1 or -1 and still counts as that [m] or [1]."""

_TURNS = "revolute"
_SLIDES = "prismatic"

Row = list[Scalar]
"""A vector (3,) in B's axes."""

Axes = tuple[Row, Row, Row]
"""The x, y and z axes of a frame, each in B's axes."""

Weights = tuple[tuple[int, float], ...]
"""The coordinates of a vector that are not zero, each with its index."""


class Fixed(NamedTuple):
    """A fixed pose of one frame in another."""

    axes: tuple[Weights, Weights, Weights]  # x, y and z axis.
    p: Weights  # Origin [m].


@dc.dataclass(frozen=True)
class ChainJoint:
    """A joint that turns about the z axis of its frame, or slides along it."""

    name: str
    index: int  # Of its position in q.
    slides: bool  # Else it turns.
    lower: float  # Its smallest position [rad] or [m].
    upper: float  # And its largest.
    X: Fixed  # Its frame, where it is at zero, in the frame of the joint before, or B.


class Pose(NamedTuple):
    """Where a frame is in B."""

    axes: Axes
    p: Row  # Origin [m].

    @property
    def R(self) -> list[Row]:
        """Returns the rows of its rotation matrix (3, 3)."""
        return [list(row) for row in zip(*self.axes, strict=True)]


class Placed(NamedTuple):
    """Where all of a chain is, at some joint positions."""

    joints: list[Pose]  # Frames of the joints, from B outward.
    X_BE: Pose
    p_BT: Row  # [m].


@dc.dataclass(frozen=True)
class Chain:
    """A serial arm from B to its end effector E, with T on the way."""

    joints: tuple[ChainJoint, ...]  # From B outward.
    X_E: Fixed  # Of E in the frame of the last joint.
    X_T: Fixed  # Of T in the frame of the joint before it.
    to_tee: int  # Joints before T.

    @property
    def num_joints(self) -> int:
        """Returns n."""
        return len(self.joints)

    @property
    def lower(self) -> list[float]:
        """Returns the smallest joint positions (n,) [rad] or [m]."""
        return [j.lower for j in sorted(self.joints, key=lambda j: j.index)]

    @property
    def upper(self) -> list[float]:
        """Returns the largest joint positions (n,) [rad] or [m]."""
        return [j.upper for j in sorted(self.joints, key=lambda j: j.index)]

    def with_tool_turned(self, R_EF: Any) -> "Chain":
        """Returns the chain with E's axes turned by a rotation matrix (3, 3)."""
        axes = np.zeros((3, 3))
        for column, weights in zip(axes, self.X_E.axes, strict=True):
            for i, weight in weights:
                column[i] = weight
        x, y, z = (_weights(column) for column in (axes.T @ R_EF).T)
        return dc.replace(self, X_E=Fixed((x, y, z), self.X_E.p))

    def at(self, q: Vector) -> Placed:
        """Returns where the chain is at joint positions `q` (n,) [rad] or [m]."""
        pose, poses = _ORIGIN, []
        for joint in self.joints:
            pose = _moved(_placed(pose, joint.X), joint, q[joint.index])
            poses.append(pose)
        before_tee = poses[self.to_tee - 1] if self.to_tee else _ORIGIN
        return Placed(poses, _placed(pose, self.X_E), _point(before_tee, self.X_T.p))

    def J_V_BE(self, at: Placed) -> list[Row]:
        """Returns the Jacobian (6, n) of E's velocity, rotational rows first."""
        columns: list[Row] = [[]] * self.num_joints
        for joint, (axes, p) in zip(self.joints, at.joints, strict=True):
            z = axes[2]
            columns[joint.index] = (
                [0.0, 0.0, 0.0, *z] if joint.slides else [*z, *_turned(z, p, at.X_BE.p)]
            )
        return [list(row) for row in zip(*columns, strict=True)]

    def J_v_BT(self, at: Placed) -> list[Row]:
        """Returns the Jacobian (3, n) of T's velocity."""
        columns: list[Row] = [[0.0, 0.0, 0.0]] * self.num_joints
        moving = zip(self.joints[: self.to_tee], at.joints, strict=False)
        for joint, (axes, p) in moving:
            z = axes[2]
            columns[joint.index] = z if joint.slides else _turned(z, p, at.p_BT)
        return [list(row) for row in zip(*columns, strict=True)]


def chain_of(plant: Any) -> Chain:
    """Returns the arm of a finalized plant with frames `base`, `tee` and `tool`.

    q are the positions of the joints between B and E, in the plant's order.

    Raises:
        ValueError: where a joint between them neither turns nor slides, or where T
            moves against the arm.
    """
    B, T, E = (frame(plant, name) for name in ("base", "tee", "tool"))
    joints = joints_between(plant, B.body(), E.body())
    to_tee = joints_between(plant, B.body(), T.body())
    if to_tee != joints[: len(to_tee)]:
        raise ValueError("T is not between base and end effector")
    order = sorted(joint.position_start() for joint in joints)
    context = plant.CreateDefaultContext()
    before, aligned, found, ends = B, RigidTransform(), [], [(B, RigidTransform())]
    for joint in joints:
        axis, slides = _axis(joint)
        X = joint.frame_on_parent().CalcPose(context, before)
        along = RigidTransform(RotationMatrix.MakeFromOneVector(axis, 2), np.zeros(3))
        index = order.index(joint.position_start())
        X_joint = _fixed(aligned.inverse() @ X @ along)
        (lower,), (upper,) = (
            joint.position_lower_limits(),
            joint.position_upper_limits(),
        )
        found.append(
            ChainJoint(joint.name(), index, slides, float(lower), float(upper), X_joint)
        )
        before, aligned = joint.frame_on_child(), along
        ends.append((before, aligned))

    def end(of: Any, after: int) -> Fixed:
        before, aligned = ends[after]
        return _fixed(aligned.inverse() @ of.CalcPose(context, before))

    tee = len(to_tee)
    return Chain(tuple(found), end(E, len(joints)), end(T, tee), tee)


def joints_between(plant: Any, base: Any, body: Any) -> list[Any]:
    """Returns the movable joints of a finalized plant from one body out to another.

    Raises:
        ValueError: where the second does not move with the first.
    """
    inboard = {}
    for joint in map(plant.get_joint, plant.GetJointIndices()):
        inboard[joint.child_body().index()] = joint
    fixed = {each.index() for each in plant.GetBodiesWeldedTo(base)}
    joints: list[Any] = []
    while body.index() not in fixed:
        joint = inboard.get(body.index())
        if joint is None:
            raise ValueError("the end effector is not on the base")
        if joint.num_positions():
            joints.append(joint)
        body = joint.parent_body()
    return joints[::-1]


def _axis(joint: Any) -> tuple[Any, bool]:
    """Returns a joint's axis (3,), and whether it slides along it."""
    kind = joint.type_name()
    if kind == _TURNS:
        return joint.revolute_axis(), False
    if kind == _SLIDES:
        return joint.translation_axis(), True
    raise ValueError(
        f"joint '{joint.name()}' is {kind}; one of an arm must turn or slide"
    )


def _fixed(X: Any) -> Fixed:
    """Returns a pose without what is only rounding."""
    x, y, z = (_weights(axis) for axis in X.rotation().matrix().T)
    return Fixed((x, y, z), _weights(X.translation()))


def _weights(vector: Any) -> Weights:
    near = [float(round(x)) if abs(x - round(x)) < _ROUNDING else x for x in vector]
    return tuple((i, float(x)) for i, x in enumerate(near) if x)


# The law.

_ORIGIN = Pose(([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]), [0.0, 0.0, 0.0])


def _placed(pose: Pose, X: Fixed) -> Pose:
    """Returns a frame at `X` in the frame at `pose`."""
    x, y, z = X.axes
    axes = pose.axes
    return Pose((_sum(x, axes), _sum(y, axes), _sum(z, axes)), _point(pose, X.p))


def _point(pose: Pose, p: Weights) -> Row:
    """Returns a point at `p` in the frame at `pose`."""
    if not p:
        return pose.p
    return all_named([a + b for a, b in zip(pose.p, _sum(p, pose.axes), strict=True)])


def _sum(weights: Weights, axes: Axes) -> Row:
    """Returns the vector with these coordinates in some axes."""
    (i, w), *others = weights
    if not others:
        return axes[i] if w == 1 else [w * a for a in axes[i]]
    if len(others) == 1:
        ((j, v),) = others
        return all_named([w * a + v * b for a, b in zip(axes[i], axes[j], strict=True)])
    x, y, z = (weight for _, weight in weights)
    return all_named([x * a + y * b + z * c for a, b, c in zip(*axes, strict=True)])


def _moved(pose: Pose, joint: ChainJoint, by: Scalar) -> Pose:
    """Returns the frame of a joint that has turned, or slid, `by` [rad] or [m]."""
    (x, y, z), p = pose
    if joint.slides:
        return Pose(
            pose.axes, all_named([a + by * b for a, b in zip(p, z, strict=True)])
        )
    c, s = named(cos(by)), named(sin(by))
    turned_x = [a * c + b * s for a, b in zip(x, y, strict=True)]
    turned_y = [b * c - a * s for a, b in zip(x, y, strict=True)]
    return Pose((all_named(turned_x), all_named(turned_y), z), p)


def _turned(z: Row, about: Row, p: Row) -> Row:
    """Returns the velocity of a point `p` turned by 1 rad/s about an axis `z`."""
    x, y, h = (a - b for a, b in zip(p, about, strict=True))
    return all_named([z[1] * h - z[2] * y, z[2] * x - z[0] * h, z[0] * y - z[1] * x])
