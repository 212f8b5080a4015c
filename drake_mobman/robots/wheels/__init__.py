"""Fidelity `wheels`: the robot rolls on a floor, by friction alone."""

from drake_mobman.robots.wheels.wheels import Wheels

__all__ = ["Wheels"]
