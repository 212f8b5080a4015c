"""A live operator, whose input is sampled at the control ticks."""

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

    Flags are read on the safe side: `dead_man` is held if it is above one half, and
    `stop` is requested unless it is 0. So a NaN holds nothing, and stops.
    """

    v_c: float = 0.0  # [m/s].
    omega_c: float = 0.0  # [rad/s].
    v_z: float = 0.0  # [m/s].
    dead_man: float = 0.0  # 1 while held.
    age: float = math.inf  # Time since the operator sent it [s].
    stop: float = 0.0  # 1 when anyone requests a stop.
    choice: float = 0.0  # Index of the chosen controller.
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
        """Returns the `ee_command` (3,)."""
        return self.v_c, self.omega_c, self.v_z

    @property
    def dragged(self) -> Dragged:
        """Returns which point is dragged, and its target."""
        return Dragged(*self[-len(Dragged._fields) :])


NOBODY = OperatorSample()
"""The input while there is no operator."""

SIZE = len(NOBODY)
"""Of the signal `operator_input`."""


@dc.dataclass
class Operator:
    """A live operator, at the diagram's input port `operator_input`.

    While nothing is connected to the port, there is no operator.
    """

    fed: ClassVar[bool] = True
    finite: ClassVar[bool] = False

    def build(self, period: float) -> "LiveSource":
        """Returns the block, for a control period [s]."""
        return LiveSource(period)


class LiveSource(LeafSystem):
    """Samples the operator's input at each control tick, and holds it.

    .. pydrake_system::

        name: LiveSource
        input_ports:
        - operator_input
        output_ports:
        - operator_input

    The output is the state, and so does not change between two ticks: its log is all
    that a replay needs. While nothing is connected to the input, there is no operator.

    Args:
        period: control period [s].

    Raises:
        ParameterError: where the period is not valid.
    """

    def __init__(self, period: float) -> None:
        super().__init__()
        checked_period(period)
        self.input = self.DeclareVectorInputPort(signals.OPERATOR_INPUT, SIZE)
        state = self.DeclareDiscreteState(np.array(NOBODY))
        self.DeclareStateOutputPort(signals.OPERATOR_INPUT, state)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._sample)

    def _sample(self, context: Any, state: Any) -> None:
        fed = self.input.HasValue(context)
        sample = self.input.Eval(context) if fed else np.array(NOBODY)
        state.get_mutable_vector().SetFromVector(sample)
