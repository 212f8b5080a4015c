"""The base: what drives it, and how its commands are smoothed and limited."""

from drake_mobman.base.smoother import Smoother
from drake_mobman.base.unsmoothed import Unsmoothed
from drake_mobman.base.velocity_field import VelocityField

BaseController = VelocityField
"""Whatever tells the base what to do by where the end effector is.

Each is a dataclass with `build(setup)`, its block, and `command(p_BT, reach, joint)`,
its law; see `VelocityField`. Another one is one more member: `VelocityField | Mine`.
"""

Smoothing = Smoother | Unsmoothed
"""Whatever stands between a base command and the base."""

__all__ = ["BaseController", "Smoother", "Smoothing", "Unsmoothed", "VelocityField"]
