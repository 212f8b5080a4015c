"""Base and arm told at once by an optimiser, and stopped where it finds nothing."""

import abc
from typing import Any

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import LeafSystem, ValueProducer

from drake_mobman.decomposers.arm_compensation import LEAST_REACH, base_induced_rates
from drake_mobman.decomposers.decomposer import declare_decomposer_ports
from drake_mobman.decomposers.status import DecomposerStatus
from drake_mobman.parameters import checked_period
from drake_mobman.scalars import larger, nearer_to_rest

BASE_RATES = 2
"""v_b [m/s] and omega_b [rad/s] stand first among the rates that are solved for."""

_LARGEST = 1e3
"""No command, reach or angle of a robot is larger [m], [rad], [m/s] or [rad/s]. Much
larger ones overflow in squares, and OSQP prints what it thinks of them."""


def braking_factor(rates: Any, largest: Any, share: float) -> float:
    """Returns the factor in [0, 1] that takes `rates` one period nearer to rest.

    They keep their direction by it. The largest come to rest in 1 / share periods,
    others sooner.

    Args:
        rates: of the period before (k,).
        largest: of each (k,).
        share: of the largest, taken away in a period.
    """
    speed = float(np.max(np.abs(rates) / largest))
    return nearer_to_rest(speed, share) / speed if speed > 0 else 0.0


class OptimizationDecomposer(LeafSystem):
    """Splits the command by the rates that an optimiser finds for base and joints.

    .. pydrake_system::

        name: OptimizationDecomposer
        input_ports:
        - ee_command
        - workspace
        - arm_position
        - base_command_smoothed
        output_ports:
        - base_command
        - base_contribution
        - arm_command
        - decomposer_status

    It solves once a period. Where nothing is found, or an input is no number or an
    absurd one, what was last put out is braked to rest in its direction, within
    `stop_time`, and the status says so for as long as there is no solution. The state
    is what was last put out: rates (k,), then `base_contribution` and `arm_command`.

    Args:
        joints: of the arm, n.
        p_BS: shoulder in B (3,) [m].
        largest: rates (k,) of base and joints [m/s] and [rad/s].
        stop_time: to bring these to rest [s].
        period: control period [s].
    """

    def __init__(
        self, joints: int, p_BS: Any, largest: Any, stop_time: float, period: float
    ) -> None:
        super().__init__()
        self.p_BS, self.largest = p_BS, largest
        self.period = checked_period(period)
        self._stop_share = period / max(stop_time, period)
        self._parts = np.cumsum([len(largest), 2])
        declare_decomposer_ports(
            self,
            joints,
            self._calc_base,
            self._calc_share,
            self._calc_arm,
            self._calc_status,
        )
        size = self._parts[-1] + 3
        self.DeclareDiscreteState(size)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._keep)
        self.solved = self.DeclareCacheEntry(
            "put out, and status",
            ValueProducer(
                allocate=lambda: AbstractValue.Make(()), calc=self._calc_solved
            ),
            {
                self.input_port_ticket(port.get_index())
                for port in (self.command, self.workspace, self.arm_position)
            }
            | {self.xd_ticket()},
        )

    @abc.abstractmethod
    def rates(
        self, command: Any, workspace: Any, q: Any, last: Any
    ) -> tuple[Any, Any] | None:
        """Returns the rates (k,) and the hand's velocity by the arm, or None.

        Args:
            command: `ee_command`, finite as all else.
            workspace: l [m], psi [rad], z [m].
            q: joint angles (n,) [rad].
            last: rates (k,) that were last put out.

        Returns:
            Rates of base [m/s], [rad/s] and joints [rad/s]; and how these joints' rates
            move the hand on the base: along the reach, across it, up (3,) [m/s]. None
            where there is no solution or none was found.
        """

    def _calc_solved(self, context: Any, value: Any) -> None:
        command, workspace, q = (
            port.Eval(context)
            for port in (self.command, self.workspace, self.arm_position)
        )
        state = context.get_discrete_state_vector().value()
        last = state[: self._parts[0]]
        found = None
        if np.abs(np.concatenate([command, workspace, q])).max() <= _LARGEST:
            found = self.rates(command, workspace, q, last)
        if found is None:
            factor = braking_factor(last, self.largest, self._stop_share)
            value.set_value((factor * state, DecomposerStatus.UNSOLVED))
            return
        rates, (along, across, up) = found
        share = base_induced_rates(workspace, rates[0], rates[1], self.p_BS)
        turning = across / larger(workspace[0], LEAST_REACH)
        put_out = np.concatenate([rates, share, (along, turning, up)])
        value.set_value((put_out, DecomposerStatus.OK))

    def _calc_base(self, context: Any, output: Any) -> None:
        output.SetFromVector(self.solved.Eval(context)[0][:BASE_RATES])

    def _calc_share(self, context: Any, output: Any) -> None:
        put_out = self.solved.Eval(context)[0]
        output.SetFromVector(put_out[self._parts[0] : self._parts[1]])

    def _calc_arm(self, context: Any, output: Any) -> None:
        output.SetFromVector(self.solved.Eval(context)[0][self._parts[1] :])

    def _calc_status(self, context: Any, output: Any) -> None:
        output.SetAtIndex(0, float(self.solved.Eval(context)[1]))

    def _keep(self, context: Any, state: Any) -> None:
        state.get_mutable_vector().SetFromVector(self.solved.Eval(context)[0])
