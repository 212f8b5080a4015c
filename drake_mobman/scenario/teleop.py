"""Tele-operation: the end effector is commanded."""

import dataclasses as dc
from typing import Any

from drake_mobman.arm.closed_form_inverse import INVERSES
from drake_mobman.base import BaseController
from drake_mobman.decomposers import Decomposer
from drake_mobman.decomposers.field import build_decomposer
from drake_mobman.parameters import one_of
from drake_mobman.robot_model import RobotSetup
from drake_mobman.scenario.fit import below, keyed
from drake_mobman.scenario.scenario import OF_ROBOT, Scenario
from drake_mobman.teleop import Source
from drake_mobman.teleop.choice import Transition
from drake_mobman.teleop.gate import Gate
from drake_mobman.teleop.guard import Guard
from drake_mobman.teleop.scripted import Script


@dc.dataclass
class Teleop(Scenario):
    """The end effector is commanded; a decomposer splits that between base and arm."""

    source: Source = dc.field(default_factory=Script)  # Who commands.
    guard: Guard = OF_ROBOT  # What it lets through.
    gate: Gate = dc.field(default_factory=Gate)  # Of a live or recorded operator.
    decomposer: Decomposer = OF_ROBOT  # Who moves, base or arm.
    # What a live operator may choose instead, while driving.
    alternatives: list[Decomposer] = dc.field(default_factory=list)
    # From one of them to the next.
    transition: Transition = dc.field(default_factory=Transition)
    inverse: str = "positions"  # Of an arm with closed form: "positions" or "rates".

    @property
    def controllers(self) -> list[Decomposer]:
        """Returns what may drive: the decomposer, then its alternatives."""
        return [self.decomposer, *self.alternatives]

    @property
    def base_controller(self) -> BaseController | None:
        """Returns the base controller that drives, if one does."""
        drives = self.decomposer
        return drives if isinstance(drives, BaseController) else None

    def setup(self) -> RobotSetup:
        """Returns the robot as blocks are built for it; its model is parsed anew."""
        return dc.replace(super().setup(), inverse=self.inverse)

    def check(self) -> None:
        """Raises `ParameterError` unless it can be run."""
        one_of(self, "inverse", INVERSES)
        super().check()

    def build_all(self, setup: RobotSetup) -> None:
        """Builds each block that a parameter goes into, to see that it can be built.

        Raises:
            ParameterError: names the parameter that a block cannot work with.
        """
        for key, params in keyed("decomposer", self.controllers):
            with below(key):
                build_decomposer(params, setup)
        self.smoother.build(setup)
        self.robot.arm_inverse(setup)
        self.build_robot(setup)

    def build_robot(self, setup: RobotSetup) -> Any:
        """Returns the robot as a diagram, at the start."""
        return self.fidelity.build(setup, self.start_position(setup))

    def bare_plant(self) -> Any:
        """Returns the plant that is stepped, by itself; None where there is none."""
        return self.fidelity.plant(self.robot)
