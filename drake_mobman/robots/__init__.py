"""Robots: a URDF each, and the robot as a diagram at each fidelity."""

from drake_mobman.robots.franka_tiago import FrankaTiago
from drake_mobman.robots.kinematic import Kinematic
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.servo import Servo
from drake_mobman.robots.spatial import Spatial

Robot = Planar | Spatial | FrankaTiago
"""Which robot. Each is a dataclass with the methods of `RobotDescription`."""

Fidelity = Kinematic | Servo
"""How the robot is simulated.

Each is a dataclass with `build(setup, start)`, the robot as a diagram; with forces, a
hand may pull its arm, and it has `build_guided(setup, start)` too.
"""

__all__ = [
    "Fidelity",
    "FrankaTiago",
    "Kinematic",
    "Planar",
    "Robot",
    "Servo",
    "Spatial",
]
