"""The layer below a scenario's file: its robot's defaults."""

import dataclasses as dc
import typing
from collections.abc import Mapping
from typing import Any

from drake_mobman.schema import TAG, given, members_of, plain


def with_defaults(data: Any, schema: Any, defaults: Mapping[type, Any]) -> Any:
    """Returns YAML data with missing keys filled in from defaults.

    At every level of the schema, in unions and lists too.

    Args:
        data: that conforms to the schema.
        schema: of the data.
        defaults: parameters by their class.
    """
    if typing.get_origin(schema) is list:
        item = typing.get_args(schema)[0]
        return [with_defaults(x, item, defaults) for x in data]
    schema = schema if data is None else given(schema)
    if members := members_of(schema):
        (schema,) = (x for x in members if data[TAG] == f"!{x.__name__}")
    if not dc.is_dataclass(schema):
        return data
    kind: Any = schema
    types = {TAG: str} | {field.name: field.type for field in dc.fields(schema)}
    told = {key: with_defaults(x, types[key], defaults) for key, x in data.items()}
    missing = plain(defaults[kind], kind) if kind in defaults else {}
    return missing | told
