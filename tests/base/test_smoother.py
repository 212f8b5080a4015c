import dataclasses as dc
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.autodiffutils import InitializeAutoDiff
from pydrake.symbolic import Expression, MakeVectorVariable

from drake_mobman.base.smoother import CommandSmoother, Smoother, smoothed
from drake_mobman.base.unsmoothed import Unsmoothed
from drake_mobman.parameters import ParameterError

ROUNDING = 1e-12
"""Of a few operations on numbers of about one."""

PERIOD = 0.01
"""Of the control loop [s]."""


class Loop:
    """A smoother in its own context, told one command a period."""

    def __init__(self, params):
        self.block = CommandSmoother(params, PERIOD)
        self.context = self.block.CreateDefaultContext()

    def sent(self, raw):
        """What is sent at `raw`, without a step."""
        self.block.get_input_port().FixValue(self.context, raw)
        return self.block.get_output_port().Eval(self.context)

    def step(self, raw):
        sent = self.sent(raw)
        updated = self.block.EvalUniquePeriodicDiscreteUpdate(self.context)
        self.context.SetDiscreteState(updated)
        return sent


anything = st.one_of(
    st.sampled_from([0.0, math.inf, -math.inf, 1e308, -1e308]),
    st.floats(-2.0, 2.0),
    st.floats(allow_nan=False),
)
segments = st.lists(
    st.tuples(anything, anything, st.integers(1, 80)), min_size=1, max_size=6
)
"""Commands v, omega, each held for some periods; a dropped one is 0."""

smoothers = st.builds(
    Smoother,
    smoothing=st.floats(0.01, 1.0),
    max_speed=st.floats(0.05, 2.0),
    max_acceleration=st.floats(0.1, 10.0),
    max_yaw_rate=st.floats(0.05, 4.0),
    max_yaw_acceleration=st.floats(0.1, 20.0),
)


@given(params=smoothers, held=segments)
def test_what_is_sent_never_exceeds_speed_or_acceleration(params, held):
    limits = np.array([params.max_speed, params.max_yaw_rate])
    steps = PERIOD * np.array([params.max_acceleration, params.max_yaw_acceleration])
    loop, last = Loop(params), np.zeros(2)
    for v, omega, periods in held:
        for _ in range(periods):
            sent = loop.step([v, omega])
            assert (np.abs(sent) <= limits).all()
            assert (np.abs(sent - last) <= steps + ROUNDING).all()
            last = sent


@given(params=smoothers, held=segments)
def test_what_is_sent_never_passes_the_command(params, held):
    loop, last = Loop(params), np.zeros(2)
    for v, omega, periods in held:
        given = np.array([v, omega])
        raw = np.where(np.isfinite(given), given, 0.0)  # The rest is a stop.
        for _ in range(periods):
            sent = loop.step(given)
            low, high = np.minimum(last, raw), np.maximum(last, raw)
            assert (low - ROUNDING <= sent).all()
            assert (sent <= high + ROUNDING).all()
            last = sent


def test_steps_are_as_worked_out_by_hand():
    # A fifth of what is missing: 0.02 m/s is over the limit of 0.01 m/s a period,
    # 0.016 rad/s is below that of 0.02 rad/s.
    loop = Loop(Smoother())
    assert loop.step([0.1, 0.08]) == pytest.approx([0.01, 0.016])
    assert loop.step([0.1, 0.08]) == pytest.approx([0.02, 0.0288])
    # Over the limit of speed, too, only by as much as acceleration lets through.
    assert loop.step([9.0, -9.0]) == pytest.approx([0.03, 0.0088])


def braked(smoothing, speed, step, seconds):
    """Speeds sent from full speed on, while the command is 0."""
    speeds = [speed]
    for _ in range(math.floor(seconds / PERIOD)):
        speeds.append(smoothed(speeds[-1], 0.0, smoothing, step, speed))
    return np.array(speeds)


shares = st.floats(0.05, 1.0)
speeds_at_full = st.floats(0.05, 2.0)
brakings = st.floats(0.1, 10.0)


@given(smoothing=shares, speed=speeds_at_full, braking=brakings)
def test_it_stops_from_full_speed_within_v_over_a_and_a_period(
    smoothing, speed, braking
):
    seconds = speed / braking + PERIOD * (1 + ROUNDING)
    assert braked(smoothing, speed, braking * PERIOD, seconds)[-1] == 0.0


def test_a_command_that_is_nearly_zero_is_filtered_as_any_other():
    # Stops alone go past the filter; the tail of 0.05 * 0.8^k [m/s] is eq. 7's.
    assert smoothed(0.04, 1e-9, 0.2, 0.01, 0.5) == pytest.approx(0.032)
    assert smoothed(0.04, 0.0, 0.2, 0.01, 0.5) == pytest.approx(0.03)


@given(params=smoothers, bad=st.sampled_from([math.nan, -math.nan]))
def test_what_is_not_a_number_is_a_stop(params, bad):
    loop, other = Loop(params), Loop(params)
    for k in range(60):
        raw = bad if 20 <= k < 40 else 0.3
        stopped = 0.0 if 20 <= k < 40 else 0.3
        assert (loop.step([raw, raw]) == other.step([stopped, stopped])).all()


def test_command_passes_as_it_is_where_smoothing_is_off():
    block = Unsmoothed().build(None)
    context = block.CreateDefaultContext()
    assert context.num_total_states() == 0
    for raw, passed in (([9.0, -9.0], [9.0, -9.0]), ([math.nan, math.inf], [0, 0])):
        block.get_input_port().FixValue(context, raw)
        assert (block.get_output_port().Eval(context) == passed).all()


def test_ports_have_the_names_and_sizes_of_the_contract():
    block = CommandSmoother(Smoother(), PERIOD)
    raw, sent = block.get_input_port(), block.get_output_port()
    assert (raw.get_name(), raw.size()) == ("base_command", 2)
    assert (sent.get_name(), sent.size()) == ("base_command_smoothed", 2)


def test_two_contexts_do_not_disturb_each_other():
    block, alone = Loop(Smoother()), Loop(Smoother())
    other = block.block.CreateDefaultContext()
    for k in range(20):
        block.context, other = other, block.context
        block.step([-0.3, 0.1 * k])
        block.context, other = other, block.context
        assert (block.step([0.5, -1.0]) == alone.step([0.5, -1.0])).all()


STATES = [([0.1, 0.2], [0.12, 0.15]), ([0.1, 0.2], [0.5, -1.0]), ([0.5, 1.0], [9, 9])]
"""Last sent and raw: within all limits, at those of acceleration, at those of speed."""


@pytest.mark.parametrize(("last", "raw"), STATES)
def test_derivatives_are_those_of_finite_differences(last, raw):
    loop = Loop(Smoother())
    x = np.array([*last, *raw])

    def sent(x):
        loop.context.SetDiscreteState(x[:2])
        return loop.sent(x[2:])

    block = loop.block.ToAutoDiffXd()
    context = block.CreateDefaultContext()
    duals = InitializeAutoDiff(x)[:, 0]
    context.SetDiscreteState(duals[:2])
    block.get_input_port().FixValue(context, duals[2:])
    outputs = block.get_output_port().Eval(context)
    step = 1e-6
    for i, row in enumerate(step * np.eye(4)):
        slope = (sent(x + row) - sent(x - row)) / (2 * step)
        for y, expected in zip(outputs, slope, strict=True):
            # A constant has no derivatives at all.
            derivative = y.derivatives()[i] if y.derivatives().size else 0.0
            assert derivative == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize(("last", "raw"), STATES)
def test_expressions_say_the_same_as_numbers(last, raw):
    loop = Loop(Smoother())
    loop.context.SetDiscreteState(last)
    block = loop.block.ToSymbolic()
    context = block.CreateDefaultContext()
    u = MakeVectorVariable(2, "u")
    context.SetDiscreteState([Expression(x) for x in last])
    block.get_input_port().FixValue(context, u)
    expressions = block.get_output_port().Eval(context)
    values = [e.Evaluate(dict(zip(u, raw, strict=True))) for e in expressions]
    assert values == pytest.approx(loop.sent(raw), abs=ROUNDING)


@pytest.mark.parametrize(
    ("key", "value", "valid"),
    [
        ("smoothing", 0.0, "must be within [0.0001, 1]"),
        ("smoothing", 1.1, "must be within [0.0001, 1]"),
        ("max_speed", -0.5, "must be within [0.001, 10] m/s"),
        ("max_speed", math.inf, "must be a finite number"),
        ("max_acceleration", 0.0, "must be within [0.001, 100] m/s^2"),
        ("max_yaw_rate", 0.0, "must be within [0.001, 20] rad/s"),
        ("max_yaw_acceleration", math.nan, "must be a finite number"),
    ],
)
def test_limit_that_nothing_can_keep_is_refused(key, value, valid):
    with pytest.raises(ParameterError) as refused:
        CommandSmoother(dc.replace(Smoother(), **{key: value}), PERIOD)
    assert refused.value.key == key
    assert refused.value.value is value
    assert refused.value.valid == valid
