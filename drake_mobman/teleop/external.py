"""A program commands the end effector, from outside the diagram."""

import dataclasses as dc
from typing import Any, ClassVar

from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import PassThrough

from drake_mobman import signals


@dc.dataclass
class External:
    """The diagram's input port `ee_command` is left to a program."""

    fed: ClassVar[bool] = True
    finite: ClassVar[bool] = False

    def build(self, _period: float) -> Any:
        """Returns the block, which passes on what it is given."""
        builder = DiagramBuilder()
        given = builder.AddSystem(PassThrough(3))
        builder.ExportInput(given.get_input_port(), signals.EE_COMMAND)
        builder.ExportOutput(given.get_output_port(), signals.EE_COMMAND)
        return builder.Build()
