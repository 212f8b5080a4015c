"""The guard: it passes only commands that are finite and in range."""

import dataclasses as dc
import enum
from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_mobman import signals
from drake_mobman.blocks import scalar_block, tickets
from drake_mobman.parameters import (
    PAUSE,
    SPEED,
    YAW_RATE,
    checked,
    checked_period,
    within,
)
from drake_mobman.scalars import (
    Scalar,
    Vector,
    all_finite,
    larger,
    nearer_to_rest,
    saturated,
    where,
)


class GuardStatus(enum.IntEnum):
    """Why a command is stopped."""

    OK = 0
    NOT_FINITE = 1
    OVER_RANGE = 2
    ASTRAY = 8
    """The base has not moved as it was sent for too long."""


@dc.dataclass
class Guard:
    """What an operator's command may be (Kwon, table 1), and how it is stopped."""

    max_v_c: float = 0.4  # Largest |v_c| [m/s].
    max_omega_c: float = 0.4  # Largest |omega_c| [rad/s].
    max_v_z: float = 0.4  # Largest |v_z| [m/s].
    stop_time: float = 0.2  # Time to bring the largest command to rest [s].

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, SPEED, "max_v_c", "max_v_z")
        within(self, YAW_RATE, "max_omega_c")
        within(self, PAUSE, "stop_time")

    @property
    def largest(self) -> tuple[float, float, float]:
        """Returns the largest magnitude of each component of `ee_command`."""
        return self.max_v_c, self.max_omega_c, self.max_v_z


_ROUNDING = 1e-9
"""Share of a limit by which a command may exceed it and still passes."""


def command_status(command: Vector, guard: Guard) -> Scalar:
    """Returns why `command` (3,) may not pass, a `GuardStatus`, or OK.

    A command is over range if it is so by more than rounding: a script that ends
    exactly at the limit may be a bit or two beyond.
    """
    over = 0.0
    for c, most in zip(command, guard.largest, strict=True):
        over = where(abs(c) <= most * (1 + _ROUNDING), over, 1.0)
    in_finite = where(over > 0, float(GuardStatus.OVER_RANGE), float(GuardStatus.OK))
    return where(all_finite(command) > 0, in_finite, float(GuardStatus.NOT_FINITE))


def clamped(command: Vector, guard: Guard) -> list[Scalar]:
    """Returns a command (3,) that may pass, clamped to its range."""
    return [saturated(c, most) for c, most in zip(command, guard.largest, strict=True)]


def braked(passed: Vector, guard: Guard, period: float) -> list[Scalar]:
    """Returns the command (3,) one `period` [s] further on its way to rest.

    Args:
        passed: the command last passed (3,).
        guard: its `stop_time` brings the largest command to rest.
        period: control period [s].
    """
    if guard.stop_time <= period:
        return [0.0, 0.0, 0.0]
    share = period / guard.stop_time
    return [
        nearer_to_rest(c, most * share)
        for c, most in zip(passed, guard.largest, strict=True)
    ]


@scalar_block
class CommandGuard(LeafSystem):
    """Passes a command that is finite and in range, and brakes to rest otherwise.

    .. pydrake_system::

        name: CommandGuard
        input_ports:
        - ee_command
        - base_astray (where it is watched)
        output_ports:
        - ee_command
        - guard_status

    The state is the command last passed. A command that may not pass becomes a stop
    from there, within `stop_time`; the status gives the reason for as long as it lasts.
    A base that is astray ends all commands for good: nobody is there to look at it. The
    state then has one more number, 1 from then on.

    Args:
        params: what a command may be, and how it is stopped.
        period: control period [s].
        watched: whether an estimator tells where the base is astray.

    Raises:
        ParameterError: where a parameter is not valid.
    """

    def __init__(self, params: Guard, period: float, *, watched: bool = False) -> None:
        self.params = checked(params)
        self.period = checked_period(period)
        self.command = self.DeclareVectorInputPort(signals.EE_COMMAND, 3)
        command = needs = tickets(self, self.command)
        self.astray: Any = None
        if watched:
            self.astray = self.DeclareVectorInputPort(signals.BASE_ASTRAY, 1)
            needs = command | tickets(self, self.astray) | {self.xd_ticket()}
        self.passed = self.DeclareVectorOutputPort(
            signals.EE_COMMAND,
            3,
            self._calc_passed,
            prerequisites_of_calc=needs | {self.xd_ticket()},
        )
        self.DeclareVectorOutputPort(
            signals.GUARD_STATUS, 1, self._calc_status, prerequisites_of_calc=needs
        )
        self.DeclareDiscreteState(4 if watched else 3)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._keep_passed)

    def _calc_passed(self, context: Any, output: Any) -> None:
        command = self.command.Eval(context)
        last = context.get_discrete_state_vector()
        stop = braked([last.GetAtIndex(i) for i in range(3)], self.params, self.period)
        ok = self._status(context, command) == GuardStatus.OK
        good = clamped(command, self.params)
        passed = [where(ok, c, b) for c, b in zip(good, stop, strict=True)]
        output.SetFromVector(np.array(passed))

    def _calc_status(self, context: Any, output: Any) -> None:
        status = self._status(context, self.command.Eval(context))
        output.SetFromVector(np.array([self.scalar(1.0) * status]))

    def _status(self, context: Any, command: Vector) -> Scalar:
        status = command_status(command, self.params)
        if self.astray is None:
            return status
        return where(self._has_strayed(context) > 0, float(GuardStatus.ASTRAY), status)

    def _has_strayed(self, context: Any) -> Scalar:
        """Returns 1 where the base is astray, or has been."""
        before = context.get_discrete_state_vector().GetAtIndex(3)
        return larger(before, self.astray.Eval(context)[0])

    def _keep_passed(self, context: Any, state: Any) -> None:
        after = self.passed.Eval(context)
        if self.astray is not None:
            after = np.append(after, self._has_strayed(context))
        state.get_mutable_vector().SetFromVector(after)


CommandGuard_ = CommandGuard.template
