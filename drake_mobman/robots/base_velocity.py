"""The base's true velocity, in its own axes."""

from pydrake.symbolic import MakeVectorVariable, cos, sin
from pydrake.systems.primitives import SymbolicVectorSystem


def base_velocity() -> SymbolicVectorSystem:
    """Returns `base_velocity` from theta and the rates of x, y and theta in W."""
    motion = MakeVectorVariable(4, "u")
    theta, x, y, omega = motion
    c, s = cos(theta), sin(theta)
    velocity = [c * x + s * y, c * y - s * x, omega]
    return SymbolicVectorSystem(input=motion, output=velocity)
