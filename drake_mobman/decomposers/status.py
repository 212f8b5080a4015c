"""What keeps a decomposer from giving the hand all that it is commanded."""

import enum


class DecomposerStatus(enum.IntFlag):
    """Why the hand is slower than commanded; the sum is `decomposer_status`."""

    OK = 0
    BASE_RATE = 1
    """The base would go or turn faster than it may."""
    JOINT_RATE = 2
    """A joint would turn faster than it can."""
    JOINT_LIMIT = 4
    """A joint would near the end of its range faster than can be braked."""
    WORKSPACE = 8
    """The hand would leave the workspace, as the base does not keep up yet."""
    SINGULAR = 16
    """No rates of the joints make what is left: the hand is at the shoulder's axis."""
    UNSOLVED = 32
    """The optimiser found nothing: base and arm are braked to rest."""
    BASE_HELD = 64
    """The base would push a joint against its end: it goes slower, or not at all."""
