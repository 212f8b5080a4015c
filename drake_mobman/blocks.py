"""Blocks for any scalar, written once as a plain class."""

import inspect
from collections.abc import Callable, Iterable
from typing import Any, Generic, TypeVar

from pydrake.common.value import AbstractValue
from pydrake.systems.framework import LeafSystem, LeafSystem_, ValueProducer
from pydrake.systems.scalar_conversion import TemplateSystem

B = TypeVar("B")
V = TypeVar("V")

_OWN = ("__dict__", "__init__", "__weakref__")
"""What each class has for itself, and no other takes over."""


def scalar_block(definition: type[B]) -> type[B]:
    """Makes a block for float, AutoDiffXd and Expression of one for float.

    ::

        @scalar_block
        class Gain(LeafSystem):
            def __init__(self, k: float) -> None:
                self.k = k
                ...

    `__init__` declares ports and state; the `LeafSystem` is there already, so it calls
    no `super().__init__()`. What a block was built with is kept for its conversions: no
    block says how it is copied. `self.scalar` is its scalar type, and `Gain.template`
    Drake's template, with `Gain.template[AutoDiffXd]`.

    Args:
        definition: a `LeafSystem` of vector ports; or of a class like it, whose methods
            it then has, but that no `super()` leads to.

    Returns:
        The block for float, with the definition's name, signature and docstring.
    """
    name, module = definition.__name__, definition.__module__
    own = _members(definition)
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

        members = own | {
            "scalar": T,
            "_construct": _construct,
            "_construct_copy": _construct_copy,
        }
        return type(name, (LeafSystem_[T],), members)

    scope = inspect.getmodule(definition)
    template = TemplateSystem.define(f"{name}_", scope=scope)(instantiation)
    block = template[None]
    block.template = template
    block.__name__ = block.__qualname__ = name
    block.__module__ = module
    block.__signature__ = _without_self(construct)
    return block


def _members(definition: type) -> dict[str, Any]:
    """Returns what a class and those between it and `LeafSystem` define."""
    own: dict[str, Any] = {}
    for each in reversed(definition.__mro__):
        if issubclass(each, LeafSystem) and each not in LeafSystem.__mro__:
            own |= {key: x for key, x in vars(each).items() if key not in _OWN}
    return own


def _without_self(method: Callable[..., None]) -> inspect.Signature:
    signature = inspect.signature(method)
    return signature.replace(parameters=list(signature.parameters.values())[1:])


class Cached(Generic[V]):
    """A value that several outputs come of, worked out once for all of them.

    Attributes:
        ticket: for what depends on it.
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
    """Declares a value that a block keeps in its cache.

    Args:
        block: that keeps it.
        calc: returns the value, any object, in a context of the block.
        needs: tickets of what it depends on; all inputs and the state unless given.
    """
    if needs is None:
        # Not time: what depends on it is worked out twice a period.
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
