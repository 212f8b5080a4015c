"""YAML against a dataclass: what is wrong with it, and where, in one line.

Drake's `yaml_load_typed` does the loading; its messages name neither the key's path
nor what would be valid, so the data is looked through before.
"""

import dataclasses as dc
import typing
from collections.abc import Hashable
from typing import Any

import yaml
from pydrake.common.yaml import yaml_load_typed

from drake_mobman.parameters import ParameterError, checked

TAG = "_tag"
"""Key under which Drake's YAML functions keep a mapping's `!Tag`."""


class _Loader(yaml.SafeLoader):
    """YAML with tags kept as `_tag`, and with no key given twice."""

    def construct_mapping(self, node: Any, deep: bool = False) -> dict[Hashable, Any]:
        keys = [key.value for key, _ in node.value]
        for key in keys:
            if keys.count(key) > 1:
                raise yaml.constructor.ConstructorError(
                    None, None, f"the key {key!r} is given twice", node.start_mark
                )
        return super().construct_mapping(node, deep)

    def construct_tagged(self, name: str, node: Any) -> Any:
        tag = f"!{name}"
        if isinstance(node, yaml.ScalarNode) and node.value == "":
            return {TAG: tag}  # A tag by itself: all defaults.
        return self.construct_mapping(node, deep=True) | {TAG: tag}


_Loader.add_multi_constructor("!", _Loader.construct_tagged)


def load_yaml(text: str) -> Any:
    """Returns the data in `text`, with tags as `_tag`.

    Raises:
        ParameterError: where it is not YAML; the key is the place, `line L, column C`.
    """
    try:
        return yaml.load(text, Loader=_Loader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        at = f"line {mark.line + 1}, column {mark.column + 1}" if mark else "text"
        raise ParameterError(at, error.problem, "must be YAML") from None
    except yaml.YAMLError as error:
        first = str(error).splitlines()[0]
        raise ParameterError("text", first, "must be YAML") from None


class _Dumper(yaml.SafeDumper):
    """YAML with `_tag` written as a tag, and keys in the order they stand in."""

    def represent_tagged(self, data: dict[str, Any]) -> Any:
        rest = {key: value for key, value in data.items() if key != TAG}
        tag = data.get(TAG, "tag:yaml.org,2002:map")
        return self.represent_mapping(tag, rest.items())


_Dumper.add_representer(dict, _Dumper.represent_tagged)


def dump_yaml(data: Any) -> str:
    """Returns data with tags as `_tag`, the counterpart of `load_yaml`, as text."""
    return yaml.dump(data, Dumper=_Dumper)


def dump_typed(obj: Any) -> str:
    """Returns a dataclass as YAML: every field, a tag at every union and at the top."""
    return dump_yaml({TAG: f"!{type(obj).__name__}"} | plain(obj, type(obj)))


def plain(obj: Any, schema: Any) -> Any:
    """Returns an instance of `schema` as YAML data, with `_tag` at every union."""
    members = typing.get_args(schema)
    if typing.get_origin(schema) is list:
        return [plain(item, members[0]) for item in obj]
    if not dc.is_dataclass(obj):
        return obj
    tag = {TAG: f"!{type(obj).__name__}"} if members else {}
    return tag | {f.name: plain(getattr(obj, f.name), f.type) for f in dc.fields(obj)}


def with_override(data: Any, path: str, value: Any) -> Any:
    """Returns a copy of the mapping `data` with `value` put at a dotted `path`.

    Raises:
        ParameterError: where the path leads into something that is not a mapping.
    """
    key, _, rest = path.partition(".")
    if isinstance(data, str):
        data = {TAG: data}  # A union's member by its bare name, about to get fields.
    if not isinstance(data, dict | None):
        raise ParameterError(path, data, "must lead through mappings; set the whole")
    data = dict(data or {})
    data[key] = with_override(data.get(key), rest, value) if rest else value
    return data


def load_typed(schema: Any, data: Any) -> Any:
    """Returns an instance of `schema` made from YAML data, checked.

    The schema is a dataclass, or a union of dataclasses of which a tag at the top names
    one, by default the first. Below, a member of a union is named by its tag,
    `!Switching`, or by its bare name in any case, `switching`.

    Raises:
        ParameterError: names the key, its value and what is valid.
    """
    if members := typing.get_args(schema):
        data = {} if data is None else data
        data = _conformed_union(data, members, "", members[0])
        tag = data.pop(TAG).lstrip("!")
        (schema,) = (member for member in members if member.__name__ == tag)
    else:
        data = _conformed(data, schema, "")
    if hasattr(schema, "completed"):
        data = schema.completed(data)  # What it leaves out is not for itself to say.
    return checked(yaml_load_typed(schema=schema, data=dump_yaml(data)))


def _conformed(data: Any, schema: Any, path: str, default: Any = None) -> Any:
    """Returns `data` as `yaml_load_typed` takes it, or raises `ParameterError`.

    A mapping for a union that has no tag is one for the class of the field's `default`.
    """
    members = typing.get_args(schema)
    if typing.get_origin(schema) is list:
        if not isinstance(data, list):
            raise ParameterError(path, data, "must be a list")
        item = members[0]
        return [_conformed(x, item, f"{path}[{i}]") for i, x in enumerate(data)]
    if members:
        untagged = members[0] if default is None else type(default)
        return _conformed_union(data, members, path, untagged)
    if dc.is_dataclass(schema):
        return _conformed_mapping(data, schema, path)
    return _conformed_scalar(data, schema, path)


def _conformed_union(
    data: Any, members: tuple[Any, ...], path: str, untagged: Any
) -> Any:
    by_name = {member.__name__.lower(): member for member in members}
    if isinstance(data, str) and path:
        data = {TAG: data}
    if not isinstance(data, dict):
        valid = _tags(members) if path else _keys(untagged)
        raise ParameterError(path or "the whole", data, valid)
    name = data.get(TAG, untagged.__name__)
    member = by_name.get(str(name).lstrip("!").lower())
    if member is None:
        raise ParameterError(path or "the tag at the top", name, _tags(members))
    rest = {key: value for key, value in data.items() if key != TAG}
    return _conformed_mapping(rest, member, path) | {TAG: f"!{member.__name__}"}


def _tags(members: tuple[Any, ...]) -> str:
    return "must be one of " + ", ".join(f"!{member.__name__}" for member in members)


def _keys(schema: Any) -> str:
    names = ", ".join(field.name for field in dc.fields(schema))
    return f"must be a mapping with keys of {names}"


def _conformed_mapping(data: Any, schema: Any, path: str) -> dict[str, Any]:
    fields = {field.name: field.type for field in dc.fields(schema)}
    if not isinstance(data, dict):
        raise ParameterError(path or "the whole", data, _keys(schema))
    where = f"{path}." if path else ""
    for key, value in data.items():
        if key not in fields:
            valid = ", ".join(fields) or "none at all"
            raise ParameterError(f"{where}{key}", value, f"valid keys are: {valid}")
    defaults = schema()
    return {
        key: _conformed(value, fields[key], f"{where}{key}", getattr(defaults, key))
        for key, value in data.items()
    }


def _conformed_scalar(data: Any, schema: Any, path: str) -> Any:
    names = {float: "a number", int: "a whole number", str: "text", bool: "true, false"}
    wrong = ParameterError(path, data, f"must be {names[schema]}")
    if schema is bool or isinstance(data, bool):
        if schema is bool and isinstance(data, bool):
            return data
        raise wrong
    if schema is str:
        if isinstance(data, str):
            return data
        raise wrong
    if not isinstance(data, int | float | str):
        raise wrong
    try:
        number = float(data)  # Also "1e-3", which YAML takes for text.
    except (ValueError, OverflowError):
        raise wrong from None
    if schema is int and not number.is_integer():
        raise wrong
    return schema(number)
