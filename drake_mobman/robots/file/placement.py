"""Where B and T are in a model: what has to be known before a robot is put together."""

import dataclasses as dc
from typing import Any

import numpy as np
from pydrake.math import RigidTransform

from drake_mobman.parameters import ParameterError
from drake_mobman.robots.file.contents import RobotFile
from drake_mobman.robots.file.layout import Layout
from drake_mobman.robots.file.loose import Loose


@dc.dataclass(frozen=True)
class Placement:
    """Where B and T are in a model."""

    X_FB: RigidTransform  # Pose of B in the frame F of the base.
    tee: str  # Link or frame that T is fixed to.
    X_T: RigidTransform  # Pose of T in that.


def place(contents: RobotFile, model: Loose, layout: Layout) -> Placement:
    """Returns where B and T are.

    Raises:
        ParameterError: where it cannot be told from the model.
    """
    X_FB = RigidTransform()
    if layout.wheels:
        middle = (_middle(model, layout, each) for each in (layout.left, layout.right))
        x, y, z = np.mean(list(middle), axis=0)
        if contents.base.wheel_radius is None:
            raise ParameterError("base.wheel_radius", None, "must be given")
        X_FB = RigidTransform([x, y, z - contents.base.wheel_radius])
    return Placement(X_FB, contents.arm.tee or layout.tool, RigidTransform())


def _middle(model: Loose, layout: Layout, joints: list[str]) -> Any:
    F, all_joints = model.parsed.frames[layout.base], model.parsed.joints
    poses = [all_joints[n].frame_on_child().CalcPose(model.context, F) for n in joints]
    return np.mean([X.translation() for X in poses], axis=0)
