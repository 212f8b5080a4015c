"""How the base is about to move: what is measured, and the change that is sent.

Our own law. What was measured at this tick is what the commands before it made; those
sent since then change it. So with m measured and y what the drive's model makes of the
commands, `latency` periods ago, the base's velocity over the tick to come is
(mean of the model over the tick) + m - y. With a drive that does at once as it is sent,
that is m + (sent_k - sent_{k-1}).
"""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_mobman import signals
from drake_mobman.blocks import scalar_block, tickets
from drake_mobman.estimation.drive_model import DriveModel
from drake_mobman.parameters import checked, checked_period
from drake_mobman.scalars import Scalar, Vector, all_finite, where


def base_estimate(
    model: DriveModel, state: Vector, sent: Vector, measured: Vector | None
) -> list[Scalar]:
    """Returns the `base_estimate` (3,): v, v_y [m/s], omega [rad/s].

    A measurement that is not finite is left out, whole.

    Args:
        model: of the drive.
        state: of the model.
        sent: `base_command_smoothed` (2,).
        measured: v, v_y [m/s] and omega [rad/s] (3,), or None.
    """
    v, omega = model.mean(state, sent)
    if measured is None:
        return [v, 0.0 * v, omega]
    was, turned = model.before(state)
    finite = all_finite(measured)
    beside = [measured[0] - was, measured[1], measured[2] - turned]
    return [
        where(finite > 0, x + by, x)
        for x, by in zip((v, 0.0 * v, omega), beside, strict=True)
    ]


def periods_apart(
    last: Scalar, params: Any, model: DriveModel, state: Vector, measured: Vector
) -> Scalar:
    """Returns for how many periods the base has not moved as it was sent.

    Args:
        last: the number a period ago.
        params: `apart` [m/s] and `turning_apart` [rad/s] bound the difference.
        model: of the drive.
        state: of the model.
        measured: v, v_y [m/s] and omega [rad/s] (3,).
    """
    was, turned = model.before(state)
    near: Scalar = all_finite(measured)
    for difference, most in (
        (measured[0] - was, params.apart),
        (measured[1], params.apart),
        (measured[2] - turned, params.turning_apart),
    ):
        near = where(abs(difference) <= most, near, 0.0)
    return where(near > 0, 0.0, last + 1.0)


@scalar_block
class BaseEstimator(LeafSystem):
    """Tells how the base is about to move, for the arm that makes up for it.

    .. pydrake_system::

        name: BaseEstimator
        input_ports:
        - base_command_smoothed
        - (the signals that `params` measures)
        output_ports:
        - base_estimate
        - base_astray (where anything is measured)

    The state is that of the drive's model, and for how many periods the base has not
    moved as it was sent. `base_astray` does not depend on the inputs: so what stops the
    robot by it is in no algebraic loop.

    Args:
        params: what is measured, and how the drive is modelled.
        period: control period [s].

    Raises:
        ParameterError: where a parameter is not valid.
    """

    def __init__(self, params: Any, period: float) -> None:
        self.params, self.period = checked(params), checked_period(period)
        params.check_period(period)
        self.model: DriveModel = params.model(period)
        self.sent = self.DeclareVectorInputPort(signals.BASE_COMMAND_SMOOTHED, 2)
        self.sensors = [
            self.DeclareVectorInputPort(name, size)
            for name, size in params.measures.items()
        ]
        needs = tickets(self, self.sent, *self.sensors) | {self.xd_ticket()}
        self.DeclareVectorOutputPort(
            signals.BASE_ESTIMATE, 3, self._calc, prerequisites_of_calc=needs
        )
        size = self.model.size
        if self.sensors:
            size += 1
            self.DeclareVectorOutputPort(
                signals.BASE_ASTRAY,
                1,
                self._calc_astray,
                prerequisites_of_calc={self.xd_ticket()},
            )
        self.DeclareDiscreteState(size)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._keep)

    def _state(self, context: Any) -> list[Scalar]:
        state = context.get_discrete_state_vector()
        return [state.GetAtIndex(i) for i in range(state.size())]

    def _measured(self, context: Any) -> Vector | None:
        if not self.sensors:
            return None
        return self.params.measured(*(p.Eval(context).tolist() for p in self.sensors))

    def _calc(self, context: Any, output: Any) -> None:
        state = self._state(context)[: self.model.size]
        sent = self.sent.Eval(context).tolist()
        estimate = base_estimate(self.model, state, sent, self._measured(context))
        output.SetFromVector(np.array(estimate))

    def _calc_astray(self, context: Any, output: Any) -> None:
        most = self.params.patience / self.period
        for_long = self._state(context)[-1] > most + 1e-6
        output.SetFromVector(np.array([where(for_long, self.scalar(1.0), 0.0)]))

    def _keep(self, context: Any, state: Any) -> None:
        now = self._state(context)
        model, apart = now[: self.model.size], now[self.model.size :]
        after = self.model.next(model, self.sent.Eval(context).tolist())
        measured = self._measured(context)
        if measured is not None:
            after.append(
                periods_apart(apart[0], self.params, self.model, model, measured)
            )
        state.get_mutable_vector().SetFromVector(np.array(after))


BaseEstimator_ = BaseEstimator.template
