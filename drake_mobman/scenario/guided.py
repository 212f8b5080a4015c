"""Guidance by hand: a person pulls the arm, and the base follows."""

import dataclasses as dc
import math
from typing import Any

from drake_mobman.base import BaseController
from drake_mobman.base.smoother import Smoother
from drake_mobman.base.unsmoothed import Unsmoothed
from drake_mobman.guidance.guiding_hand import Hand, peak_speed
from drake_mobman.guidance.planned import Planned
from drake_mobman.parameters import SPEED, ParameterError
from drake_mobman.robot_model import RobotDescription, RobotSetup
from drake_mobman.robots import Fidelity, Robot
from drake_mobman.robots.franka_tiago import FrankaTiago
from drake_mobman.robots.servo import Servo
from drake_mobman.scenario.fit import below, keyed
from drake_mobman.scenario.scenario import OF_ROBOT, Scenario
from drake_mobman.teleop.choice import Transition
from drake_mobman.teleop.drag import Drag
from drake_mobman.teleop.gate import Gate
from drake_mobman.teleop.guard import Guard
from drake_mobman.teleop.live import Operator
from drake_mobman.teleop.recorded import Recording

_LEAST_MASS = 1.2
"""Largest product of the hand's damping and the period [kg]: three times the smallest
apparent mass of the tool in any posture. Above it, hand and tool oscillate."""

_LEAST_DRAGGED = 0.45
"""The same [kg] for any point of the arm that is dragged."""

_GRASP = 0.05
"""Largest distance between hand and tool at the start [m]."""


@dc.dataclass
class Guided(Scenario):
    """A hand pulls the free arm by its tool, and the base follows."""

    fidelity: Fidelity = dc.field(default_factory=Servo)  # One with forces.
    robot: Robot = dc.field(default_factory=FrankaTiago)  # The robot, and its lengths.
    # What moves the hand: its path, a live operator or a recording.
    source: Planned | Operator | Recording = dc.field(default_factory=Planned)
    guard: Guard = OF_ROBOT  # Limits of an operator's command for the hand.
    gate: Gate = dc.field(default_factory=Gate)  # When an operator's command counts.
    hand: Hand = OF_ROBOT  # Its path, and how it pulls.
    drag: Drag = dc.field(default_factory=Drag)  # How an operator drags the arm.
    field: BaseController = OF_ROBOT  # Drives the base.
    # Base controllers that a live operator may choose instead, while driving.
    alternatives: list[BaseController] = dc.field(default_factory=list)
    # From one base controller to another.
    transition: Transition = dc.field(default_factory=Transition)

    @classmethod
    def robot_defaults(cls, robot: RobotDescription) -> dict[type, Any]:
        """Returns the robot's defaults for such a scenario, by their class."""
        defaults = super().robot_defaults(robot)
        defaults.pop(Unsmoothed, None)  # The field jumps where its zones meet.
        return {Smoother: Smoother()} | defaults

    @property
    def controllers(self) -> list[BaseController]:
        """Returns all base controllers: the field, then its alternatives."""
        return [self.field, *self.alternatives]

    @property
    def base_controller(self) -> BaseController:
        """Returns the base controller."""
        return self.field

    def check(self) -> None:
        """Raises `ParameterError` unless it can be run."""
        if not hasattr(self.fidelity, "build_guided"):
            name = f"!{type(self.fidelity).__name__}"
            valid = "must be !Servo or !Wheels, as a hand pulls with a force"
            raise ParameterError("fidelity", name, valid)
        super().check()

    def check_fit(self, setup: RobotSetup) -> None:
        """Raises `ParameterError` where hand or path do not fit the robot."""
        self._check_hand()
        self._check_path(setup)

    def build_all(self, setup: RobotSetup) -> None:
        """Builds each block once, to check its parameters.

        Raises:
            ParameterError: names the parameter that a block cannot work with.
        """
        for key, params in keyed("field", self.controllers):
            with below(key):
                params.build(setup)
        self.smoother.build(setup)
        self.build_robot(setup)

    def build_robot(self, setup: RobotSetup) -> Any:
        """Returns the robot as a diagram, at the start, its arm free."""
        fidelity: Any = self.fidelity
        return fidelity.build_guided(setup, self.start_position(setup))

    def bare_plant(self) -> Any:
        """Returns the simulated plant alone."""
        fidelity: Any = self.fidelity
        return fidelity.guided_plant(self.robot)

    def _check_hand(self) -> None:
        """Raises `ParameterError` where the hand is too fast for base or period."""
        for name, mass in (("hand", _LEAST_MASS), ("drag", _LEAST_DRAGGED)):
            damping, most = getattr(self, name).damping, mass / self.period
            if damping > most:
                valid = f"must be at most {most:g} at a period of {self.period:g} s"
                raise ParameterError(f"{name}.damping", damping, valid)
        speed = peak_speed(self.hand)
        base = self.smoother.limits()
        fastest = SPEED.high if base.follows_at_once else base.max_speed
        if speed > fastest:
            valid = f"out of reach; the base follows at most {fastest:g} m/s"
            raise ParameterError("hand.path", f"{speed:.3g} m/s", valid)

    def _check_path(self, setup: RobotSetup) -> None:
        """Raises `ParameterError` where the arm cannot follow the hand's path."""
        model = setup.model
        q = self.start_position(setup)
        model.set_state(q, [0.0] * len(q))
        x, y, z = model.p_W("tool")
        first = self.hand.path[0]
        gap = math.dist((x, y, z), (first.x, first.y, first.z))
        if gap > _GRASP:
            x, y, z = (round(float(each), 4) + 0.0 for each in (x, y, z))  # No -0.
            at_tool = f"x = {x:.4f}, y = {y:.4f}, z = {z:.4f}"
            valid = f"must be where the tool starts, {at_tool}, within {_GRASP:g} m"
            given = {"x": first.x, "y": first.y, "z": first.z}
            raise ParameterError("hand.path[0]", given, valid)
        # The end effector's orientation changes little, so T keeps its height above it.
        reach = setup.reach
        above = model.p_W("tee")[2] - z
        low, high = reach.l_0 - reach.r_f - above, reach.l_0 + reach.r_f - above
        for i, point in enumerate(self.hand.path):
            if not low <= point.z <= high:
                valid = f"out of reach; must be within [{low:.4g}, {high:.4g}] m"
                raise ParameterError(f"hand.path[{i}].z", point.z, valid)
