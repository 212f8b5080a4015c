"""What every source of commands has, so that one swaps for another."""

from typing import Any, ClassVar, Protocol


class SourceParams(Protocol):
    """Parameters of a source.

    Its block puts out `ee_command`; or `operator_input`, where an operator is to arm
    the robot first. Inputs of the block become inputs of the diagram.
    """

    fed: ClassVar[bool]  # Whether a program feeds it while it runs.
    finite: ClassVar[bool]  # Whether all that it puts out is finite for sure.

    def build(self, period: float) -> Any:
        """Returns the block, for a control period [s]."""
