"""Poses and Jacobians of an arm, from a `MultibodyPlant` of any scalar type."""

from typing import Any

import numpy as np
from pydrake.multibody.tree import JacobianWrtVariable

from drake_mobman.frames import frame
from drake_mobman.scalars import Matrix, Vector


class PlantKinematics:
    """An arm in a plant of one scalar type, its base at rest at the origin of W.

    Args:
        plant: finalized `MultibodyPlant` with links `base` (B), `tee` (T) and `tool`
            (E), whose last positions are the arm's joint angles.
        num_joints: of the arm, n.
    """

    def __init__(self, plant: Any, num_joints: int) -> None:
        self.plant = plant
        self._context = plant.CreateDefaultContext()
        self._q = plant.GetPositions(self._context)
        self._arm = slice(len(self._q) - num_joints, None)
        self._B, self._T, self._E = (frame(plant, x) for x in ("base", "tee", "tool"))

    def set(self, q: Vector) -> None:
        """Sets the arm's joint angles (n,) [rad]."""
        self._q[self._arm] = q
        self.plant.SetPositions(self._context, self._q)

    def p_BT(self) -> Matrix:
        """Returns the position (3,) of T [m]."""
        return self._T.CalcPose(self._context, self._B).translation()

    def X_BE(self) -> Any:
        """Returns the pose of E, a `RigidTransform`."""
        return self._E.CalcPose(self._context, self._B)

    def J_v_BT(self) -> Matrix:
        """Returns the Jacobian (3, n) of T's velocity by the joint rates."""
        return self.plant.CalcJacobianTranslationalVelocity(
            self._context,
            JacobianWrtVariable.kV,
            self._T,
            np.zeros(3),
            self._B,
            self._B,
        )[:, self._arm]

    def J_V_BE(self) -> Matrix:
        """Returns the Jacobian (6, n) by the joint rates, rotational rows first."""
        return self.plant.CalcJacobianSpatialVelocity(
            self._context,
            JacobianWrtVariable.kV,
            self._E,
            np.zeros(3),
            self._B,
            self._B,
        )[:, self._arm]
