"""A robot on wheels that tests command by hand."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from drake_mobman.robot_model import RobotSetup
from drake_mobman.robots.franka_tiago import POSTURE, FrankaTiago
from drake_mobman.robots.wheels import Wheels

PERIOD = 0.01

START = [0.4, -0.3, 0.5, *POSTURE]
"""Neither x nor y is ahead."""


class Bench:
    """A robot on wheels that a test commands by hand."""

    def __init__(self, wheels=None, start=START, *, free_arm=False, robot=None):
        wheels = wheels or Wheels()
        make = wheels.build_guided if free_arm else wheels.build
        self.diagram = make(RobotSetup.of(robot or FrankaTiago(), PERIOD), start)
        self.simulator = Simulator(self.diagram)
        self.context = self.simulator.get_mutable_context()
        self.plant = self.diagram.GetSubsystemByName("plant")
        self.ticks = 0
        self.command("base_command_smoothed", [0.0, 0.0])
        if not free_arm:
            self.command("arm_velocity_command", np.zeros(7))

    @property
    def plant_context(self):
        return self.plant.GetMyContextFromRoot(self.context)

    def command(self, port, value):
        self.diagram.GetInputPort(port).FixValue(self.context, value)

    def advance(self, ticks=1):
        """Takes some control periods, to just before the next tick."""
        self.ticks += ticks
        self.simulator.AdvanceTo(self.ticks * PERIOD - 1e-4)

    def read(self, port):
        return self.diagram.GetOutputPort(port).Eval(self.context).copy()

    def ramp(self, v, omega, seconds=0.5, hold=0.5):
        """Drives up to a velocity and on."""
        ticks = round(seconds / PERIOD)
        for k in range(ticks):
            share = (k + 1) / ticks
            self.command("base_command_smoothed", [v * share, omega * share])
            self.advance()
        self.advance(round(hold / PERIOD))


@pytest.fixture(scope="session")
def bench():
    """Makes a robot on wheels to command."""
    return Bench
