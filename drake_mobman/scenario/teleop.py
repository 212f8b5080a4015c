"""Teleoperation: the end effector is commanded."""

import dataclasses as dc
from typing import Any

from drake_mobman.arm.closed_form_inverse import INVERSES
from drake_mobman.base import BaseController
from drake_mobman.decomposers import Decomposer
from drake_mobman.decomposers.field import build_decomposer
from drake_mobman.estimation import Estimate
from drake_mobman.estimation.sent import Sent
from drake_mobman.parameters import ParameterError, one_of
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
    """A command for the end effector is split between base and arm."""

    source: Source = dc.field(default_factory=Script)  # Where commands come from.
    guard: Guard = OF_ROBOT  # Limits of the command.
    gate: Gate = dc.field(default_factory=Gate)  # When an operator's command counts.
    decomposer: Decomposer = OF_ROBOT  # Splits the command between base and arm.
    # Decomposers that a live operator may choose instead, while driving.
    alternatives: list[Decomposer] = dc.field(default_factory=list)
    # From one decomposer to another.
    transition: Transition = dc.field(default_factory=Transition)
    # Of the base's motion, which the arm makes up for.
    estimate: Estimate = dc.field(default_factory=Sent)
    inverse: str = "positions"  # An arm in closed form inverts "positions" or "rates".

    @property
    def controllers(self) -> list[Decomposer]:
        """Returns all decomposers: the scenario's, then its alternatives."""
        return [self.decomposer, *self.alternatives]

    @property
    def base_controller(self) -> BaseController | None:
        """Returns the decomposer if it is a base controller."""
        params = self.decomposer
        return params if isinstance(params, BaseController) else None

    def setup(self) -> RobotSetup:
        """Returns the robot's setup; each call parses the model again."""
        return dc.replace(super().setup(), inverse=self.inverse)

    def check(self) -> None:
        """Raises `ParameterError` unless it can be run."""
        one_of(self, "inverse", INVERSES)
        super().check()

    def build_all(self, setup: RobotSetup) -> None:
        """Builds each block once, to check its parameters.

        Raises:
            ParameterError: names the parameter that a block cannot work with.
        """
        for key, params in keyed("decomposer", self.controllers):
            with below(key):
                build_decomposer(params, setup)
        self.smoother.build(setup)
        self.robot.arm_inverse(setup)
        with below("estimate"):
            self.estimate.build(setup.period)
        robot = self.build_robot(setup)
        for name in self.estimate.measures:
            if not robot.HasOutputPort(name):
                tag, at = (
                    f"!{type(x).__name__}" for x in (self.estimate, self.fidelity)
                )
                valid = f"needs {name}, which fidelity {at} does not measure"
                raise ParameterError("estimate", tag, f"{valid}; !Sent needs nothing")

    def build_robot(self, setup: RobotSetup) -> Any:
        """Returns the robot as a diagram, at the start."""
        return self.fidelity.build(setup, self.start_position(setup))

    def bare_plant(self) -> Any:
        """Returns the simulated plant alone; None where there is none."""
        return self.fidelity.plant(self.robot)
