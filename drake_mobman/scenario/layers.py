"""The layer below a scenario's file: what its robot brings along."""

import dataclasses as dc
import typing
from collections.abc import Mapping
from typing import Any

from drake_mobman.scenario.schema import TAG, plain


def with_defaults(data: Any, schema: Any, own: Mapping[type, Any]) -> Any:
    """Returns YAML data with what it leaves out of parameters that are known.

    Wherever the schema has them, in a union or a list too.

    Args:
        data: conformed to the schema.
        schema: of the data.
        own: parameters by their class.
    """
    members = typing.get_args(schema)
    if typing.get_origin(schema) is list:
        return [with_defaults(item, members[0], own) for item in data]
    if members:
        (schema,) = (x for x in members if data[TAG] == f"!{x.__name__}")
    if not dc.is_dataclass(schema):
        return data
    kind: Any = schema
    types = {TAG: str} | {field.name: field.type for field in dc.fields(schema)}
    given = {key: with_defaults(x, types[key], own) for key, x in data.items()}
    known = plain(own[kind], kind) if kind in own else {}
    return known | given
