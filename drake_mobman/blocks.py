"""Blocks for any scalar type, each written once as a plain class."""

import inspect
from collections.abc import Callable, Iterable
from typing import Any, Generic, TypeVar

from pydrake.common.value import AbstractValue
from pydrake.systems.framework import LeafSystem, LeafSystem_, ValueProducer
from pydrake.systems.scalar_conversion import TemplateSystem

B = TypeVar("B")
V = TypeVar("V")

_OWN = ("__dict__", "__init__", "__weakref__")
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
    not call `super().__init__()`. The arguments of `__init__` are stored, and a
    conversion to another scalar type calls it again with them. `self.scalar` is the
    scalar type of a block, and `Gain.template` is Drake's template:
    `Gain.template[AutoDiffXd]` is a class.

    There may be a class between the block and `LeafSystem`. The block gets its methods,
    but `super()` does not find them: call them by the class's name, as in
    `Base.__init__(self, ...)`.

    Args:
        definition: a `LeafSystem` with vector ports. Where it works for some scalar
            types only, its attribute `scalars` lists them, float first.

    Returns:
        The block for float, with the definition's name, signature and docstring. If it
        inherits `__init__`, the docstring of that class is added.
    """
    name = definition.__name__
    own = _members(definition) | {"__doc__": _documentation(definition)}
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
    define = TemplateSystem.define(f"{name}_", T_list=own.get("scalars"), scope=scope)
    template = define(instantiation)
    block = template[None]
    block.template = template
    block.__name__ = block.__qualname__ = name
    block.__module__ = definition.__module__
    block.__signature__ = _without_self(construct)
    return block


def _members(definition: type) -> dict[str, Any]:
    """Returns the members that a class, and its bases up to `LeafSystem`, define."""
    own: dict[str, Any] = {}
    for each in reversed(definition.__mro__):
        if issubclass(each, LeafSystem) and each not in LeafSystem.__mro__:
            own |= {key: x for key, x in vars(each).items() if key not in _OWN}
    return own


def _documentation(definition: type) -> str:
    """Returns a class's docstring, with that of the class that has its `__init__`."""
    own = inspect.cleandoc(definition.__doc__ or "")
    owner = next(each for each in definition.__mro__ if "__init__" in vars(each))
    if owner is definition:
        return own
    _, _, rest = inspect.cleandoc(owner.__doc__ or "").partition("\n\n")
    rest = rest.replace(f"name: {owner.__name__}", f"name: {definition.__name__}")
    return f"{own}\n\n{rest}"


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
