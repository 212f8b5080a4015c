"""Blocks for any scalar type, each written once as a plain class."""

import inspect
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Generic, TypeVar

from pydrake.common.value import AbstractValue
from pydrake.systems.framework import LeafSystem, LeafSystem_, ValueProducer
from pydrake.systems.scalar_conversion import TemplateSystem

B = TypeVar("B")
V = TypeVar("V")

_NOT_COPIED = ("__dict__", "__init__", "__weakref__")
"""Members of a class that are not copied to another class."""


def scalar_block(definition: type[B]) -> type[B]:
    """Turns a block for float into one for float, AutoDiffXd and Expression.

    ::

        @scalar_block
        class Gain(LeafSystem):
            def __init__(self, k: float) -> None:
                self.k = k
                ...

    `__init__` declares ports and state; the `LeafSystem` is initialized before, so do
    not call `super().__init__()`. Its arguments are stored for conversions to another
    scalar type. `self.scalar` is the block's scalar type, and `Gain.template` is
    Drake's template: `Gain.template[AutoDiffXd]` is a class.

    With another class between the block and `LeafSystem`, call that class's methods by
    its name, as in `Base.__init__(self, ...)`: `super()` does not find them.

    Args:
        definition: a `LeafSystem` with vector ports. Where it works for some scalar
            types only, its attribute `scalars` lists them, float first.

    Returns:
        The block for float, with the definition's name, signature and docstring; the
        docstring of the class with its `__init__` is added where that is another.
    """
    name = definition.__name__
    defined = _members(definition) | {"__doc__": _documentation(definition)}
    construct: Callable[..., None] = definition.__init__

    def instantiation(T: Any) -> type:
        def _construct(
            self: Any, *args: Any, converter: Any = None, **kwargs: Any
        ) -> None:
            LeafSystem_[T].__init__(self, converter=converter)
            self.built_with = args, kwargs
            construct(self, *args, **kwargs)

        def _construct_copy(self: Any, other: Any, converter: Any = None) -> None:
            args, kwargs = other.built_with
            _construct(self, *args, converter=converter, **kwargs)

        members = defined | {
            "scalar": T,
            "_construct": _construct,
            "_construct_copy": _construct_copy,
        }
        return type(name, (LeafSystem_[T],), members)

    scope = inspect.getmodule(definition)
    define = TemplateSystem.define(
        f"{name}_", T_list=defined.get("scalars"), scope=scope
    )
    template = define(instantiation)
    block = _with_short_stack(lambda: template[None])
    block.template = template
    block.__signature__ = _without_self(construct)
    return _named_as(block, definition)


def _named_as(block: Any, definition: type) -> Any:
    """Returns a class with a definition's name and module."""
    block.__name__ = block.__qualname__ = definition.__name__
    block.__module__ = definition.__module__
    return block


def _with_short_stack(call: Callable[[], V]) -> V:
    """Returns what a call returns, made where few others are under way.

    Drake looks at the whole stack, twice a block, for who defines it. While modules
    import each other that takes 20 ms, half of what it takes to import the package.
    """
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(call).result()


def _members(definition: type) -> dict[str, Any]:
    """Returns the members that a class, and its bases up to `LeafSystem`, define."""
    members: dict[str, Any] = {}
    for each in reversed(definition.__mro__):
        if issubclass(each, LeafSystem) and each not in LeafSystem.__mro__:
            members |= {k: x for k, x in vars(each).items() if k not in _NOT_COPIED}
    return members


def _documentation(definition: type) -> str:
    """Returns a class's docstring, with that of the class that has its `__init__`."""
    text = inspect.cleandoc(definition.__doc__ or "")
    owner = next(each for each in definition.__mro__ if "__init__" in vars(each))
    if owner is definition:
        return text
    _, _, details = inspect.cleandoc(owner.__doc__ or "").partition("\n\n")
    name = definition.__name__
    return f"{text}\n\n{details.replace(f'name: {owner.__name__}', f'name: {name}')}"


def _without_self(method: Callable[..., None]) -> inspect.Signature:
    """Returns a method's signature without `self`."""
    signature = inspect.signature(method)
    return signature.replace(parameters=list(signature.parameters.values())[1:])


class Cached(Generic[V]):
    """A value that several outputs need, computed once for all of them.

    Attributes:
        ticket: dependency ticket of the value, for `prerequisites_of_calc`.
    """

    def __init__(self, entry: Any) -> None:
        self._entry = entry
        self.ticket = entry.ticket()

    def __call__(self, context: Any) -> V:
        """Returns the value in a context of the block."""
        value: V = self._entry.Eval(context)
        return value


def cached(
    block: Any, calc: Callable[[Any], V], needs: Iterable[Any] | None = None
) -> Cached[V]:
    """Declares a value in a block's cache.

    Args:
        block: whose cache it is.
        calc: returns the value, any object, for a context of the block.
        needs: tickets of what the value depends on; by default, all inputs and the
            discrete state.
    """
    if needs is None:
        # Without time: what depends on time is computed twice a period.
        needs = block.all_input_ports_ticket(), block.xd_ticket()
    entry = block.DeclareCacheEntry(
        calc.__name__,
        ValueProducer(
            allocate=lambda: AbstractValue.Make(()),
            calc=lambda context, value: value.set_value(calc(context)),
        ),
        set(needs),
    )
    return Cached(entry)


def tickets(block: Any, *ports: Any) -> set[Any]:
    """Returns the tickets of some of a block's input ports."""
    return {block.input_port_ticket(port.get_index()) for port in ports}
