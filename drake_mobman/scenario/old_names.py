"""Scenarios of earlier versions, with old names, still load."""

import warnings
from collections.abc import Callable
from typing import Any

from drake_mobman.parameters import ParameterError
from drake_mobman.schema import TAG

Data = dict[str, Any]


def _change(data: Data) -> Data:
    return {("transition" if k == "change" else k): x for k, x in data.items()}


def _enabled(data: Data) -> Data:
    smoother = dict(data["smoother"])
    enabled = smoother.pop("enabled")
    if not isinstance(enabled, bool):
        raise ParameterError("smoother.enabled", enabled, "must be true, false")
    if enabled:
        return data | {"smoother": smoother | {TAG: "!Smoother"}}
    kept = {k: x for k, x in smoother.items() if k in {"max_speed", "max_yaw_rate"}}
    return data | {"smoother": kept | {TAG: "!Unsmoothed"}}


def _projection(data: Data) -> Data:
    projection = data["projection"]
    data = {key: x for key, x in data.items() if key != "projection"}

    def projected(decomposer: Any) -> Any:
        given = {TAG: decomposer} if isinstance(decomposer, str) else decomposer
        name = str(given.get(TAG, "") if isinstance(given, dict) else "")
        if name.lstrip("!").lower() not in {"blending", "switching"}:
            return decomposer
        return {"projection": projection} | given

    if "decomposer" in data:
        data["decomposer"] = projected(data["decomposer"])
    if isinstance(data.get("alternatives"), list):
        data["alternatives"] = [projected(each) for each in data["alternatives"]]
    return data


OLD_NAMES: dict[str, tuple[str, Callable[[Data], Data]]] = {
    "change": ("transition", _change),
    "projection": ("decomposer.projection", _projection),
    "smoother.enabled": ("smoother: !Smoother or !Unsmoothed", _enabled),
}
"""By the old key: its new name, and a function that converts the data."""


def with_new_names(data: Any, where: str) -> Any:
    """Returns a scenario's YAML data with old names replaced, and warns of each.

    Args:
        data: of a whole scenario; it need not be valid.
        where: the file, for the warning.

    Raises:
        ParameterError: where the value of an old name is not valid.
    """
    for old, (new, renamed) in OLD_NAMES.items():
        if _holds(data, old):
            warnings.warn(
                f"{where}: {old} is an old name; now it is {new}",
                FutureWarning,
                stacklevel=2,
            )
            data = renamed(data)
    return data


def _holds(data: Any, path: str) -> bool:
    for key in path.split("."):
        if not isinstance(data, dict) or key not in data:
            return False
        data = data[key]
    return True
