"""Robots: a URDF each, and a diagram at each fidelity.

A dataclass imported here is available in scenarios and on the command line.
"""

from typing import TYPE_CHECKING

from drake_mobman.kinds import unions_of
from drake_mobman.robot_model import RobotDescription
from drake_mobman.robots.fidelity import FidelityParams
from drake_mobman.robots.file import File
from drake_mobman.robots.franka_tiago import FrankaTiago
from drake_mobman.robots.kinematic import Kinematic
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.servo import Servo
from drake_mobman.robots.spatial import Spatial
from drake_mobman.robots.wheels import Wheels

if TYPE_CHECKING:
    Robot = RobotDescription
    Fidelity = FidelityParams
else:
    Robot, Fidelity = unions_of(globals(), RobotDescription, FidelityParams)
