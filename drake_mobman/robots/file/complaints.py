"""What Drake complains about of a model, in one line."""

from collections.abc import Sequence

_SHOWN = 3
"""Links in a line."""


def summary(complaints: Sequence[str]) -> str:
    """Returns one line on all of Drake's complaints.

    Args:
        complaints: of Drake, those on a link with `link NAME: ` before them.
    """
    inertias = [each for each in complaints if "inertia" in each]
    others = [each for each in complaints if each not in inertias]
    lines = []
    if inertias:
        places = [each.partition(": ")[0].removeprefix("link ") for each in inertias]
        links = list(dict.fromkeys(places))
        names = ", ".join(links[:_SHOWN]) + (", ..." if len(links) > _SHOWN else "")
        lines.append(f"Drake replaces unphysical inertias, those of {names}")
    if others:
        count = f", and {len(others) - 1} more" if len(others) > 1 else ""
        lines.append(f"Drake says of {others[0]}{count}")
    return "; ".join(lines)
