"""A live operator: what is said at the edge, taken in at the control ticks."""

import dataclasses as dc
import math
from typing import Any, ClassVar, NamedTuple

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_mobman import signals
from drake_mobman.parameters import checked_period
from drake_mobman.teleop.drag import Dragged


class OperatorSample(NamedTuple):
    """The signal `operator_input`, component by component.

    Flags count as set or not on the safe side: a `dead_man` is held if above one half,
    a `stop` is asked for unless it is 0, and neither is told by a NaN.
    """

    v_c: float = 0.0  # [m/s].
    omega_c: float = 0.0  # [rad/s].
    v_z: float = 0.0  # [m/s].
    dead_man: float = 0.0  # 1 while held.
    age: float = math.inf  # Since the operator said so [s].
    stop: float = 0.0  # 1 when anyone asks for a stop.
    choice: float = 0.0  # Index of the decomposer, or field, that is to drive.
    # As in `Dragged`.
    body: float = 0.0
    q_x: float = 0.0
    q_y: float = 0.0
    q_z: float = 0.0
    to_x: float = 0.0
    to_y: float = 0.0
    to_z: float = 0.0

    @property
    def command(self) -> tuple[float, float, float]:
        """Returns the `ee_command` that is asked for."""
        return self.v_c, self.omega_c, self.v_z

    @property
    def dragged(self) -> Dragged:
        """Returns which point is to be dragged, and whereto."""
        return Dragged(*self[-len(Dragged._fields) :])


NOBODY = OperatorSample()
"""What is taken in while no operator has said a word."""

SIZE = len(NOBODY)
"""Of the signal `operator_input`."""


@dc.dataclass
class Operator:
    """An operator at the diagram's input port `operator_input`; nobody, if not fed."""

    fed: ClassVar[bool] = True
    finite: ClassVar[bool] = False

    def build(self, period: float) -> Any:
        """Returns the block, for a control period [s]."""
        return LiveSource(period)


class LiveSource(LeafSystem):
    """Takes in what the operator says at each control tick, and holds it.

    .. pydrake_system::

        name: LiveSource
        input_ports:
        - operator_input
        output_ports:
        - operator_input

    What comes out after a tick is the state alone, whoever feeds the input and however
    long after the tick: so the log of it is all that a replay needs. An input that is
    not fed is an operator who is not there.

    Args:
        period: control period [s].

    Raises:
        ParameterError: where the period is not valid.
    """

    def __init__(self, period: float) -> None:
        super().__init__()
        checked_period(period)
        self.said = self.DeclareVectorInputPort(signals.OPERATOR_INPUT, SIZE)
        state = self.DeclareDiscreteState(np.array(NOBODY))
        self.DeclareStateOutputPort(signals.OPERATOR_INPUT, state)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._take_in)

    def _take_in(self, context: Any, state: Any) -> None:
        heard = self.said.HasValue(context)
        said = self.said.Eval(context) if heard else np.array(NOBODY)
        state.get_mutable_vector().SetFromVector(said)
