"""Parts of vectors are the elements that they name, of no more inputs than those."""

import numpy as np
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import PassThrough

from drake_mobman.parts import of_first, picked


def test_parts_hold_the_elements_they_name_in_that_order():
    builder = DiagramBuilder()
    sources = [builder.AddSystem(PassThrough(size)) for size in (4, 2)]
    for i, source in enumerate(sources):
        builder.ExportInput(source.get_input_port(), f"in{i}")
    parts = {"mixed": [(0, 3), (1, 1), (0, 0)], "first": of_first([2, 1])}
    for name, port in picked(
        builder, [source.get_output_port() for source in sources], parts
    ).items():
        builder.ExportOutput(port, name)
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    diagram.GetInputPort("in0").FixValue(context, [10.0, 11.0, 12.0, 13.0])
    # The other input has no value yet, and is not asked for.
    first = diagram.GetOutputPort("first").Eval(context)
    np.testing.assert_array_equal(first, [12.0, 11.0])
    diagram.GetInputPort("in1").FixValue(context, [20.0, 21.0])
    mixed = diagram.GetOutputPort("mixed").Eval(context)
    np.testing.assert_array_equal(mixed, [13.0, 21.0, 10.0])
    assert not diagram.HasDirectFeedthrough(1, 1)
    assert diagram.HasDirectFeedthrough(1, 0)
