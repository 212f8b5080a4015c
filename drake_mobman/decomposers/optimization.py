"""Base and arm commanded together by an optimiser; stopped where it has no solution."""

import abc
from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_mobman.blocks import cached, tickets
from drake_mobman.decomposers.arm_compensation import LEAST_REACH, base_induced_rates
from drake_mobman.decomposers.decomposer import declare_decomposer_ports
from drake_mobman.decomposers.status import DecomposerStatus
from drake_mobman.parameters import checked_period
from drake_mobman.scalars import larger, nearer_to_rest

BASE_RATES = 2
"""v_b [m/s] and omega_b [rad/s] come first among the rates that are solved for."""

_LARGEST = 1e3
"""Largest command, reach or angle that is solved for [m], [rad], [m/s] or [rad/s]. The
squares of much larger ones overflow, and OSQP prints warnings."""


def braking_factor(rates: Any, largest: Any, share: float) -> float:
    """Returns the factor in [0, 1] that brakes `rates` for one period.

    They keep their direction. The largest rates come to rest in 1 / share periods,
    smaller ones sooner.

    Args:
        rates: of the period before (k,).
        largest: of each (k,).
        share: of the largest, by which they become smaller in a period.
    """
    speed = float(np.max(np.abs(rates) / largest))
    return nearer_to_rest(speed, share) / speed if speed > 0 else 0.0


class OptimizationDecomposer(LeafSystem):
    """Splits the command by the rates that an optimiser finds for base and joints.

    .. pydrake_system::

        name: OptimizationDecomposer
        input_ports: [ee_command, ee_cylindrical, arm_position, base_command_smoothed,
                      base_estimate]
        output_ports: [base_command, base_contribution, arm_command, decomposer_status]

    It solves once a period. Where there is no solution, or an input is NaN or far too
    large, the last output is braked to rest in its direction within `stop_time`, and
    the status is `UNSOLVED` until there is a solution. The state is the last output:
    rates (k,), then `base_contribution` and `arm_command`.

    Args:
        num_joints: of the arm, n.
        p_BS: shoulder in B (3,) [m].
        largest: rates (k,) of base and joints [m/s] and [rad/s].
        stop_time: to bring these to rest [s].
        period: control period [s].
    """

    def __init__(
        self, num_joints: int, p_BS: Any, largest: Any, stop_time: float, period: float
    ) -> None:
        super().__init__()
        self.p_BS, self.largest = p_BS, largest
        self.period = checked_period(period)
        self._stop_share = period / max(stop_time, period)
        self._parts = np.cumsum([len(largest), 2])
        declare_decomposer_ports(
            self,
            num_joints,
            self._calc_base,
            self._calc_contribution,
            self._calc_arm,
            self._calc_status,
        )
        size = self._parts[-1] + 3
        self.DeclareDiscreteState(size)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._keep)
        inputs = self.command, self.ee_cylindrical, self.arm_position
        needs = tickets(self, *inputs) | {self.xd_ticket()}
        self.solved = cached(self, self._calc_solved, needs)

    @abc.abstractmethod
    def rates(self, command: Any, at: Any, q: Any, last: Any) -> tuple[Any, Any] | None:
        """Returns the rates (k,) and the end effector's velocity by the arm, or None.

        Args:
            command: `ee_command` (3,); it and all other inputs are finite.
            at: `ee_cylindrical` (3,).
            q: joint angles (n,) [rad].
            last: rates (k,) of the last output.

        Returns:
            Rates of base [m/s], [rad/s] and joints [rad/s]; and the end effector's
            velocity by the joints, with the base at rest: along the reach, across it,
            up (3,) [m/s]. None where there is no solution or none was found.
        """

    def _calc_solved(self, context: Any) -> tuple[Any, DecomposerStatus]:
        """Returns the output (k + 5,), and the status."""
        command, at, q = (
            port.Eval(context)
            for port in (self.command, self.ee_cylindrical, self.arm_position)
        )
        state = context.get_discrete_state_vector().value()
        last = state[: self._parts[0]]
        found = None
        if np.abs(np.concatenate([command, at, q])).max() <= _LARGEST:
            found = self.rates(command, at, q, last)
        if found is None:
            factor = braking_factor(last, self.largest, self._stop_share)
            return factor * state, DecomposerStatus.UNSOLVED
        rates, (along, across, up) = found
        contribution = base_induced_rates(at, rates[0], rates[1], self.p_BS)
        turning = across / larger(at[0], LEAST_REACH)
        solution = np.concatenate([rates, contribution, (along, turning, up)])
        return solution, DecomposerStatus.OK

    def _calc_base(self, context: Any, output: Any) -> None:
        output.SetFromVector(self.solved(context)[0][:BASE_RATES])

    def _calc_contribution(self, context: Any, output: Any) -> None:
        solution = self.solved(context)[0]
        output.SetFromVector(solution[self._parts[0] : self._parts[1]])

    def _calc_arm(self, context: Any, output: Any) -> None:
        output.SetFromVector(self.solved(context)[0][self._parts[1] :])

    def _calc_status(self, context: Any, output: Any) -> None:
        output.SetAtIndex(0, float(self.solved(context)[1]))

    def _keep(self, context: Any, state: Any) -> None:
        state.get_mutable_vector().SetFromVector(self.solved(context)[0])
