"""The robot at fidelity `wheels`: it rolls on a floor, by friction alone."""

import dataclasses as dc
from typing import Any, ClassVar

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder

from drake_mobman.engines.drake import Drake
from drake_mobman.parameters import OFFSET, ParameterError, Range, checked, within
from drake_mobman.robot_model import RobotDescription, RobotSetup
from drake_mobman.robot_model.rolling import RollingBase
from drake_mobman.robot_model.tipping import SupportPolygon
from drake_mobman.robots.wheels.drive import Drive
from drake_mobman.robots.wheels.floor import GRAVITY, Floor
from drake_mobman.robots.wheels.plant import rolling_plant
from drake_mobman.robots.wheels.robot import make_rolling_robot
from drake_mobman.robots.wheels.sensors import Sensors
from drake_mobman.robots.wheels.settle import standing
from drake_mobman.robots.wheels.support import support_polygon
from drake_mobman.robots.wheels.tip_limits import Footing, check_upright
from drake_mobman.ticks import aligned, whole_steps


@dc.dataclass
class Wheels:
    """Driven wheels and casters on a floor; nothing holds the base but the tyres.

    Gravity is on. The arm's servos carry its weight, and are otherwise those of
    `Servo`. A wheel's torque is its gain times the error of its rate, up to the joint's
    effort limit. The controller knows nothing of the faults of floor, drive and
    sensors.
    """

    step: float = 0.002  # Of the plant [s].
    stiffness: float = 1e7  # Of a tyre [N/m]: a softer one rolls short.
    dissipation: float = 500.0  # Of tyres and casters, by Hunt and Crossley [s/m].
    arm_gain: float = 1e4  # Of the arm's joints, where they are driven [N m s].
    joint_damping: float = 1.0  # Of the arm's joints, where they are free [N m s].
    # At 0, a free arm that is released stays in its posture; else it goes to the start.
    joint_stiffness: float = 0.0  # Of the free joints, towards the start [N m/rad].
    # Limits of base and reach that bring the zero-moment point nearer than this to the
    # edge of what the robot stands on are refused [m].
    tip_margin: float = 0.01
    floor: Floor = dc.field(default_factory=Floor)  # What it rolls on.
    drive: Drive = dc.field(default_factory=Drive)  # Of the wheels.
    sensors: Sensors = dc.field(default_factory=Sensors)  # Of the base's motion.
    has_masses: ClassVar[bool] = True

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, Range(1e-5, 0.02, "s"), "step")
        within(self, Range(1e4, 1e8, "N/m"), "stiffness")
        within(self, Range(0.0, 1e4, "s/m"), "dissipation")
        within(self, Range(0.01, 1e8, "N m s"), "arm_gain")
        within(self, Range(0.0, 1e4, "N m s"), "joint_damping")
        within(self, Range(0.0, 1e5, "N m/rad"), "joint_stiffness")
        within(self, OFFSET, "tip_margin")

    def build(self, setup: RobotSetup, start: list[float]) -> Diagram:
        """Returns the robot as a diagram, its arm driven."""
        return self._build(setup, start, free_arm=False)

    def build_guided(self, setup: RobotSetup, start: list[float]) -> Diagram:
        """Returns the robot as a diagram, its arm free to be pulled by hand."""
        return self._build(setup, start, free_arm=True)

    def _build(
        self, setup: RobotSetup, start: list[float], *, free_arm: bool
    ) -> Diagram:
        checked(self).check_period(setup.period)
        made = rolling_plant(setup.robot, self, free_arm=free_arm)
        ideal = dc.replace(self, drive=self.drive.ideal(), sensors=Sensors())

        def unsettled(q: np.ndarray) -> Diagram:
            again = rolling_plant(setup.robot, ideal, free_arm=False)
            return make_rolling_robot(setup, ideal, again, q, free_arm=False)

        q = standing(made, start, self.floor, setup.engine, unsettled)
        return make_rolling_robot(setup, self, made, q, free_arm=free_arm)

    def believed(self, base: RollingBase) -> RollingBase:
        """Returns the base as the controller knows it."""
        return dc.replace(base, track=base.track / self.drive.track)

    def plant(self, robot: RobotDescription) -> Any:
        """Returns the simulated plant alone, its arm driven."""
        return rolling_plant(robot, self, free_arm=False).plant

    def guided_plant(self, robot: RobotDescription) -> Any:
        """Returns the simulated plant alone, its arm free."""
        return rolling_plant(robot, self, free_arm=True).plant

    def alone(self, robot: RobotDescription, *, free_arm: bool) -> Diagram:
        """Returns plant and floor alone, in a diagram: together, they can be stepped.

        Args:
            robot: its parameters.
            free_arm: whether the arm is free, else driven.
        """
        made = rolling_plant(robot, self, free_arm=free_arm)
        builder = DiagramBuilder()
        Drake().add_to(builder, made.plant, made.scene_graph)
        return builder.Build()

    def check_upright(self, setup: RobotSetup, z: float) -> None:
        """Raises `ParameterError` where its limits let the robot tip over.

        Args:
            setup: of the robot, with its limits.
            z: height of the end effector above the shoulder [m].
        """
        made = rolling_plant(setup.robot, self, free_arm=False)
        plant, wheels = made.plant, {*made.wheel_q}
        mass = plant.CalcTotalMass(plant.CreateDefaultContext())
        thrust = sum(
            plant.get_joint_actuator(i).effort_limit()
            for i in plant.GetJointActuatorIndices()
            if plant.get_joint_actuator(i).joint().position_start() in wheels
        )
        grip = min(
            thrust / made.base.wheel_radius / mass, self.floor.friction * GRAVITY
        )
        footing = Footing(
            support_polygon(made), self.floor.gravity_W(), grip, self.tip_margin
        )
        check_upright(setup, z, footing)

    def support(self, robot: RobotDescription) -> SupportPolygon:
        """Returns the polygon on which a robot stands."""
        return support_polygon(rolling_plant(robot, self, free_arm=False))

    def check_period(self, period: float) -> None:
        """Raises `ParameterError` unless step, delay and latency fit the period [s]."""
        if not whole_steps(period, self.step):
            valid = f"must divide the control period of {period:g} s"
            raise ParameterError("step", self.step, valid)
        for key, check, unit in (
            ("drive", self.drive.check_step, self.step),
            ("sensors", self.sensors.check_period, period),
        ):
            try:
                check(unit)
            except ParameterError as error:
                raise error.below(key) from None

    def aligned_with(self, period: float) -> tuple[float, "Wheels"]:
        """Returns a period that is an exact multiple of the step, and this fidelity.

        Period and step differ from the given ones in the last bits at most.
        """
        period, step = aligned(period, self.step)
        return period, dc.replace(self, step=step)
