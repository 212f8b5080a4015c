"""Parts of vectors, picked by one block: each block costs time at each step."""

from collections.abc import Mapping, Sequence

from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.primitives import Selector, SelectorParams

Places = Sequence[tuple[int, int]]
"""Elements: the index of an input, and the place in it."""


def of_first(places: Sequence[int]) -> list[tuple[int, int]]:
    """Returns elements of the first input."""
    return [(0, place) for place in places]


def selection(sizes: Sequence[int], parts: Mapping[str, Places]) -> SelectorParams:
    """Returns what a `Selector` picks.

    Args:
        sizes: of its inputs.
        parts: elements of each output, by its name.
    """
    of = SelectorParams
    inputs = [
        of.InputPortParams(name=f"u{i}", size=size) for i, size in enumerate(sizes)
    ]
    outputs = [
        of.OutputPortParams(
            name=name,
            selections=[
                of.OutputSelection(input_port_index=i, input_offset=place)
                for i, place in places
            ],
        )
        for name, places in parts.items()
    ]
    return SelectorParams(inputs=inputs, outputs=outputs)


def picked(
    builder: DiagramBuilder, ports: Sequence[OutputPort], parts: Mapping[str, Places]
) -> dict[str, OutputPort]:
    """Returns parts of some vectors, each with elements of any of them, by name.

    Args:
        builder: to add to.
        ports: the vectors.
        parts: elements of each part, by its name.
    """
    selector = builder.AddSystem(Selector(selection([p.size() for p in ports], parts)))
    for i, port in enumerate(ports):
        builder.Connect(port, selector.get_input_port(i))
    return {name: selector.GetOutputPort(name) for name in parts}
