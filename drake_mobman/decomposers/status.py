"""Why a decomposer cannot move the end effector as commanded."""

import enum


class DecomposerStatus(enum.IntFlag):
    """Why the end effector is slower than commanded; the sum is `decomposer_status`."""

    OK = 0
    BASE_RATE = 1
    """The base would drive or turn faster than its limits."""
    JOINT_RATE = 2
    """A joint would turn faster than its limit."""
    JOINT_LIMIT = 4
    """A joint would approach the end of its range too fast to brake."""
    WORKSPACE = 8
    """The end effector would pass the workspace limits, as the base lags behind."""
    SINGULAR = 16
    """The end effector is at the shoulder's axis, where no joint rates are enough."""
    UNSOLVED = 32
    """The optimiser found no solution: base and arm are braked to rest."""
    BASE_HELD = 64
    """The base would push a joint past its limit: it is slowed down or stopped."""
