"""YAML loaded into dataclasses, with errors that name in one line what is wrong.

Drake's `yaml_load_typed` loads the data; its messages name neither the key's path nor
what would be valid, so the data is checked before. Any text results in an instance or
in a `ParameterError`.
"""

import dataclasses as dc
import re
import types
import typing
from collections.abc import Callable
from typing import Any, ClassVar

import yaml
from pydrake.common.yaml import yaml_load_typed

from drake_mobman.parameters import ParameterError, checked

TAG = "_tag"
"""Key under which Drake's YAML functions keep a mapping's `!Tag`."""

ALL = "*"
"""Key of a mapping's value for all keys that it does not have."""

NOT_IN_YAML = {"yaml": False}
"""Metadata of a field that is not in files."""

_WIDTH = 88
"""Of lines [characters]."""

_DEEPEST = 40
"""Largest depth of nested YAML; a scenario has six levels."""


def _whole(text: str) -> int | float:
    # Python refuses to read integers of thousands of digits.
    return int(text) if len(text) < 20 else float(text)


_PLAIN: dict[str, tuple[str, Callable[[str], Any]]] = {
    "null": ("(~|null|Null|NULL)?", lambda _: None),
    "bool": ("true|True|TRUE|false|False|FALSE", lambda text: text.lower() == "true"),
    "int": ("[-+]?[0-9]+", _whole),
    "float": (
        # With `nan` and `inf` as Python writes them.
        r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?"
        r"|[-+]?\.?(inf|Inf|INF)|\.?(nan|NaN|NAN)",
        lambda text: float(re.sub(r"\.(?=[in])", "", text.lower())),
    ),
}
"""Values other than text, by tag: their form in YAML 1.2, and a function to read them.

PyYAML reads YAML 1.1, where `on` is true, 1:30 is 90, and 2026-02-30 a wrong date.
"""


class _Loader(yaml.SafeLoader):
    """YAML with tags kept as `_tag`; a key given twice is an error."""

    yaml_constructors: ClassVar[dict[Any, Any]] = {}
    yaml_multi_constructors: ClassVar[dict[Any, Any]] = {}
    yaml_implicit_resolvers: dict[Any, Any] = {}  # noqa: RUF012 - as PyYAML has it.

    depth = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        # Each level needs some of Python's stack.
        self.depth += 1
        if self.depth > _DEEPEST:
            mark = typing.cast(Any, self).peek_event().start_mark
            raise yaml.composer.ComposerError(None, None, "nested too deeply", mark)
        node = super().compose_node(parent, index)
        self.depth -= 1
        return node

    def construct_mapping(self, node: Any, deep: bool = True) -> dict[Any, Any]:
        if not isinstance(node, yaml.MappingNode):
            raise _wrong(node, "expected a mapping")
        data: dict[Any, Any] = {}
        for key, value in node.value:
            if not isinstance(key, yaml.ScalarNode):
                raise _wrong(key, "a key must be text")
            if key.value in data:
                raise _wrong(key, f"the key {key.value!r} is given twice")
            data[key.value] = self.construct_object(value, deep=deep)
        return data

    def construct_text(self, node: Any) -> str:
        return str(self.construct_scalar(node))

    def construct_list(self, node: Any) -> list[Any]:
        return self.construct_sequence(node, deep=True)

    def construct_tagged(self, name: str, node: Any) -> Any:
        tag = f"!{name}"
        if isinstance(node, yaml.ScalarNode) and node.value == "":
            return {TAG: tag}  # A tag alone: all defaults.
        if not isinstance(node, yaml.MappingNode):
            raise _wrong(node, f"{tag} goes before a mapping, as in {tag} {{}}")
        return self.construct_mapping(node) | {TAG: tag}

    def construct_unknown(self, node: Any) -> Any:
        raise _wrong(node, f"there is no tag {node.tag}")


def _wrong(node: Any, problem: str) -> yaml.constructor.ConstructorError:
    return yaml.constructor.ConstructorError(None, None, problem, node.start_mark)


class _Dumper(yaml.SafeDumper):
    """YAML with `_tag` written as a tag, and keys in their order."""

    def represent_tagged(self, data: dict[str, Any]) -> Any:
        rest = {key: value for key, value in data.items() if key != TAG}
        tag = data.get(TAG, "tag:yaml.org,2002:map")
        return self.represent_mapping(tag, rest.items())


def _read_by(pattern: re.Pattern[str], value: Callable[[str], Any]) -> Any:
    """Returns a constructor of plain values, which may have an explicit tag."""

    def construct(loader: _Loader, node: Any) -> Any:
        text = loader.construct_scalar(node)
        if not pattern.match(text):
            name = node.tag.rpartition(":")[2]
            raise _wrong(node, f"{text!r} is not a valid !!{name}")
        return value(text)

    return construct


for _name, (_form, _value) in _PLAIN.items():
    _tag, _pattern = f"tag:yaml.org,2002:{_name}", re.compile(rf"(?:{_form})\Z")
    _Loader.add_implicit_resolver(_tag, _pattern, None)
    _Loader.add_constructor(_tag, _read_by(_pattern, _value))
    # Text that looks like one of these is quoted.
    _Dumper.add_implicit_resolver(_tag, _pattern, None)
_Loader.add_constructor("tag:yaml.org,2002:str", _Loader.construct_text)
_Loader.add_constructor("tag:yaml.org,2002:seq", _Loader.construct_list)
_Loader.add_constructor("tag:yaml.org,2002:map", _Loader.construct_mapping)
_Loader.add_constructor(None, _Loader.construct_unknown)
_Loader.add_multi_constructor("!", _Loader.construct_tagged)
_Dumper.add_representer(dict, _Dumper.represent_tagged)


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
    except (yaml.YAMLError, ValueError, ArithmeticError) as error:
        # The latter two come from escapes and `%YAML` with too large a number.
        first = str(error).splitlines()[0]
        raise ParameterError("text", first, "must be YAML") from None


def dump_yaml(data: Any, short: bool = False) -> str:
    """Returns data, with tags as `_tag`, as YAML text: the inverse of `load_yaml`.

    Args:
        data: to write.
        short: whether what holds no other mapping or list is written on one line.
    """
    style: dict[str, Any] = {}
    if short:
        style = {"default_flow_style": None, "width": _WIDTH}
    return yaml.dump(data, Dumper=_Dumper, **style)


def dump_typed(obj: Any) -> str:
    """Returns a dataclass as YAML: every field, a tag at every union and at the top."""
    keys = {
        key: x for key, x in plain(obj, type(obj)).items() if key in _keys(type(obj))
    }
    return dump_yaml({TAG: f"!{type(obj).__name__}"} | keys)


def plain(obj: Any, schema: Any) -> Any:
    """Returns an instance of `schema` as YAML data, with `_tag` at every union."""
    if typing.get_origin(schema) is list:
        return [plain(item, typing.get_args(schema)[0]) for item in obj]
    if isinstance(obj, dict):
        return dict(obj)
    if not dc.is_dataclass(obj):
        return obj
    tag = {TAG: f"!{type(obj).__name__}"} if members_of(schema) else {}
    return tag | {f.name: plain(getattr(obj, f.name), f.type) for f in dc.fields(obj)}


def given(schema: Any) -> Any:
    """Returns a schema without its `None`, which stands for what is not given."""
    some = [each for each in _alternatives(schema) if each is not types.NoneType]
    return some[0] if len(some) == 1 else schema


def members_of(schema: Any) -> tuple[Any, ...]:
    """Returns the dataclasses of a union, of which a tag selects one; else nothing."""
    return _alternatives(given(schema))


def _alternatives(schema: Any) -> tuple[Any, ...]:
    is_union = typing.get_origin(schema) in {types.UnionType, typing.Union}
    return typing.get_args(schema) if is_union else ()


def with_override(data: Any, path: str, value: Any) -> Any:
    """Returns a copy of the mapping `data` with `value` set at a dotted `path`.

    Raises:
        ParameterError: where the path goes through a value that is not a mapping.
    """
    *parents, last = keys = path.split(".")
    if not all(keys):
        raise ParameterError(path, value, "must be at keys joined by dots")
    # The whole is put below a key, so that all levels are treated alike.
    top = holder = {"": data}
    for key in ("", *parents):
        child = holder.get(key)
        if isinstance(child, str):
            child = {TAG: child}  # A union's member by its bare name.
        if not isinstance(child, dict | None):
            valid = "must lead through mappings; set the whole value"
            raise ParameterError(path, child, valid)
        holder[key] = holder = dict(child or {})
    holder[last] = value
    return top[""]


def load_typed(schema: Any, data: Any) -> Any:
    """Returns an instance of `schema` made from YAML data, checked.

    The schema is a dataclass, or a union of dataclasses: a tag at the top selects one,
    by default the first. Below, a tag, `!Switching`, or a name in upper or lower case,
    `switching`, selects the member of a union.

    Raises:
        ParameterError: names the key, its value and what is valid.
    """
    if members := members_of(schema):
        data = {} if data is None else data
        data = _conformed_union(data, members, "", members[0])
        tag = data.pop(TAG).lstrip("!")
        (schema,) = (member for member in members if member.__name__ == tag)
    else:
        data = _conformed(data, schema, "")
    if hasattr(schema, "completed"):
        data = schema.completed(data)  # With defaults that depend on other keys.
    return checked(yaml_load_typed(schema=schema, data=dump_yaml(data)))


def _conformed(data: Any, schema: Any, path: str, default: Any = None) -> Any:
    """Returns `data` in the form for `yaml_load_typed`, or raises `ParameterError`.

    A mapping without a tag, for a union, is one for the class of the field's `default`.
    """
    if data is None and schema != given(schema):
        return None
    schema = given(schema)
    if typing.get_origin(schema) is list:
        if not isinstance(data, list):
            raise ParameterError(path, data, "must be a list")
        item = typing.get_args(schema)[0]
        return [_conformed(x, item, f"{path}[{i}]") for i, x in enumerate(data)]
    if typing.get_origin(schema) is dict:
        return _conformed_table(data, typing.get_args(schema)[1], path)
    if members := members_of(schema):
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
        valid = _tags(members) if path else _mapping(untagged)
        raise ParameterError(path or "the whole", data, valid)
    name = data.get(TAG, untagged.__name__)
    member = by_name.get(str(name).lstrip("!").lower())
    if member is None:
        raise ParameterError(path or "the tag at the top", name, _tags(members))
    rest = {key: value for key, value in data.items() if key != TAG}
    return _conformed_mapping(rest, member, path) | {TAG: f"!{member.__name__}"}


def _tags(members: tuple[Any, ...]) -> str:
    return "must be one of " + ", ".join(f"!{member.__name__}" for member in members)


def _keys(schema: Any) -> dict[str, Any]:
    """Returns the keys that a file may hold, with their types."""
    fields = [field for field in dc.fields(schema) if field.metadata != NOT_IN_YAML]
    return {field.name: field.type for field in fields}


def _mapping(schema: Any) -> str:
    return f"must be a mapping with keys of {', '.join(_keys(schema))}"


def _conformed_mapping(data: Any, schema: Any, path: str) -> dict[str, Any]:
    fields = _keys(schema)
    if not isinstance(data, dict):
        raise ParameterError(path or "the whole", data, _mapping(schema))
    where = f"{path}." if path else ""
    for key, value in data.items():
        if key not in fields:
            valid = ", ".join(fields) or "none at all"
            raise ParameterError(f"{where}{key}", value, f"valid keys are: {valid}")
    defaults = _defaults(data, schema, fields)
    return {
        key: _conformed(value, fields[key], f"{where}{key}", getattr(defaults, key))
        for key, value in data.items()
    }


def _defaults(data: dict[str, Any], schema: Any, fields: dict[str, Any]) -> Any:
    """Returns an instance of all defaults; some may depend on a key in the data."""
    defaults, key = schema(), getattr(schema, "decided_by", None)
    if key is None or key not in data:
        return defaults
    given = _conformed(data[key], fields[key], key, getattr(defaults, key))
    loaded = yaml_load_typed(schema=schema, data=dump_yaml({key: given}))
    return schema(**{key: getattr(loaded, key)})


def _conformed_table(data: Any, value: Any, path: str) -> dict[str, Any]:
    """Returns a mapping with keys of any name; a number is one for all of them."""
    if isinstance(data, int | float) and not isinstance(data, bool):
        data = {ALL: data}
    if not isinstance(data, dict) or TAG in data:
        raise ParameterError(path, data, "must be a mapping, without a tag")
    return {key: _conformed(x, value, f"{path}.{key}") for key, x in data.items()}


def _conformed_scalar(data: Any, schema: Any, path: str) -> Any:
    names = {
        float: "a number",
        int: "a whole number",
        str: "a line of text",
        bool: "true, false",
    }
    wrong = ParameterError(path, data, f"must be {names[schema]}")
    if schema is bool or isinstance(data, bool):
        if schema is bool and isinstance(data, bool):
            return data
        raise wrong
    if schema is str:
        # It is printed, drawn, and written to other files.
        if isinstance(data, str) and data.rstrip("\n").isprintable():
            return data.rstrip("\n")
        raise wrong
    if not isinstance(data, int | float):
        raise wrong
    try:
        number = float(data)
    except OverflowError:
        raise wrong from None
    if schema is int and not number.is_integer():
        raise wrong
    return schema(number)
