"""What a robot's file leaves out, derived from its model: one file an idea.

Each function returns a value and where it comes from.
"""

from drake_mobman.robots.derive.derived import Derived

__all__ = ["Derived"]
