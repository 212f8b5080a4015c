"""Where the bodies of a plant are, and how they move, from a state of it."""

from typing import Any

from pydrake.multibody.tree import BodyIndex

from drake_mobman.frames import frame


class PlantMotion:
    """The motion of a finalized `MultibodyPlant`; it is not simulated.

    Attributes:
        plant: of a robot.
    """

    def __init__(self, plant: Any) -> None:
        self.plant = plant
        self._context = plant.CreateDefaultContext()

    def set_state(self, q: Any, v: Any) -> None:
        """Sets positions and velocities of the plant."""
        self.plant.SetPositions(self._context, q)
        self.plant.SetVelocities(self._context, v)

    def p_W(self, link: str) -> Any:
        """Returns the position (3,) of a link's origin in W [m]."""
        return frame(self.plant, link).CalcPoseInWorld(self._context).translation()

    def v_W(self, link: str) -> Any:
        """Returns the velocity (3,) of a link's origin in W [m/s]."""
        found = frame(self.plant, link)
        return found.CalcSpatialVelocityInWorld(self._context).translational()

    def motion_W(self, body: Any, state: Any) -> tuple[Any, Any]:
        """Returns position [m] and velocity [m/s] (3,) in W of a body's origin.

        Faster than `p_W` and `v_W` after `set_state`.

        Args:
            body: of the plant.
            state: positions of the plant, then velocities.
        """
        X_WB, V_WB = self._motion(body, state)
        return X_WB.translation(), V_WB.translational()

    def point_W(self, body: int, p_BQ: Any, state: Any) -> tuple[Any, Any]:
        """Returns position [m] and velocity [m/s] (3,) in W of a point Q of a body B.

        Args:
            body: index of B in the plant.
            p_BQ: position of Q in B (3,) [m].
            state: positions of the plant, then velocities.
        """
        X_WB, V_WB = self._motion(self.plant.get_body(BodyIndex(body)), state)
        V_WQ = V_WB.Shift(X_WB.rotation() @ p_BQ)
        return X_WB @ p_BQ, V_WQ.translational()

    def _motion(self, body: Any, state: Any) -> tuple[Any, Any]:
        """Returns pose and spatial velocity in W of a body."""
        self.plant.SetPositionsAndVelocities(self._context, state)
        return (
            self.plant.EvalBodyPoseInWorld(self._context, body),
            self.plant.EvalBodySpatialVelocityInWorld(self._context, body),
        )
