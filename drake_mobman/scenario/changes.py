"""A scenario as a short file: what it changes of what its robot brings."""

import dataclasses as dc
from typing import Any

from drake_mobman.robot_model import RobotDescription
from drake_mobman.scenario.scenario import Scenario
from drake_mobman.schema import NOT_IN_YAML, TAG, dump_yaml, plain


def dump_changes(scenario: Scenario, robot: RobotDescription | None = None) -> str:
    """Returns a scenario as YAML, without what it has by itself for this robot.

    Args:
        scenario: to write.
        robot: the same, as the file is to name it.
    """
    kind: Any = type(scenario)
    changed = _changes(scenario, kind(robot=scenario.robot), kind)
    types = {field.name: field.type for field in dc.fields(kind)}
    changed["robot"] = plain(robot or scenario.robot, types["robot"])
    return dump_yaml({TAG: f"!{kind.__name__}"} | changed, short=True)


def _changes(obj: Any, brought: Any, schema: Any) -> dict[str, Any]:
    """Returns a dataclass as YAML data, without the fields that another has too."""
    data: dict[str, Any] = plain(obj, schema)
    if type(obj) is not type(brought):
        brought = type(obj)()
    changed = {key: data[key] for key in data if key == TAG}
    for field in dc.fields(obj):
        mine, other = (getattr(x, field.name) for x in (obj, brought))
        if field.metadata == NOT_IN_YAML or mine == other:
            continue
        if dc.is_dataclass(mine):
            changed[field.name] = _changes(mine, other, field.type)
        elif isinstance(mine, list):
            changed[field.name] = [_without_zeros(x) for x in data[field.name]]
        else:
            changed[field.name] = mine
    return changed


def _without_zeros(item: Any) -> Any:
    """Returns an item of a list; of a union's member, what is not zero."""
    if not (isinstance(item, dict) and TAG in item):
        return item
    return {key: x for key, x in item.items() if x != 0}
