"""A number of a robot that its file leaves out, and where it comes from."""

from typing import Generic, NamedTuple, TypeVar

T = TypeVar("T")


class Derived(NamedTuple, Generic[T]):
    """What was derived of a robot."""

    value: T
    source: str  # In a few words, for `mobman robot check`.
