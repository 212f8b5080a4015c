"""The frames that every robot has in its plant: `base` (B), `tee` (T), `tool` (E)."""

from typing import Any

INSTANCE = "mobman"
"""Model instance of what we add to another's model, which may use the same names."""


def frame(plant: Any, name: str) -> Any:
    """Returns a frame of a robot's plant: ours, where a model has one of that name too.

    Raises:
        RuntimeError: where there is no such frame.
    """
    if plant.HasModelInstanceNamed(INSTANCE):
        ours = plant.GetModelInstanceByName(INSTANCE)
        if plant.HasFrameNamed(name, ours):
            return plant.GetFrameByName(name, ours)
    return plant.GetFrameByName(name)


def body(plant: Any, name: str) -> Any:
    """Returns the body of a frame, as `frame` finds it."""
    return frame(plant, name).body()
