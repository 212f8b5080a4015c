"""The gate: only an armed operator's fresh, finite commands in range get past it."""

import dataclasses as dc
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from drake_mobman.console.latency import LatencyBound
from drake_mobman.console.mailbox import Mailbox, OperatorInput
from drake_mobman.parameters import ParameterError
from drake_mobman.teleop.drag import NOTHING, Drag, Draggable, Dragged
from drake_mobman.teleop.gate import (
    Arming,
    CommandGate,
    Gate,
    GateState,
    GateStatus,
    input_status,
    next_state,
)
from drake_mobman.teleop.guard import Guard, braked
from drake_mobman.teleop.live import NOBODY, LiveSource, OperatorSample

PERIOD = 1 / 16
"""A power of two, as are the times below: sums of them carry no rounding."""

GUARD = Guard(max_v_c=0.4, max_omega_c=0.5, max_v_z=0.2, stop_time=0.25)
GATE = Gate(fresh=0.25, neutral=0.05)
ARM = Draggable(frozenset({4, 5}), Drag(max_distance=2.0, max_offset=0.5))
LARGEST = np.array(GUARD.largest)
STOP_PERIODS = round(GUARD.stop_time / PERIOD)

REST = OperatorSample(age=0.0)
HELD = OperatorSample(0.3, -0.4, 0.1, dead_man=1.0, age=0.0)
PULL = Dragged(4, 0.3, 0.0, -0.4, 0.0, 1.2, 1.6)  # At the borders, both of them.

LATCHED, READY, ARMED = Arming
OK = GateStatus.OK


@pytest.fixture(scope="module")
def passed(fed, step):
    """A function that returns what the gate puts out for samples, one a period."""

    def outputs_over_time(samples):
        block = CommandGate(GATE, GUARD, PERIOD, ARM)
        context = fed(block, operator_input=NOBODY)
        out, why = [], []
        for said in samples:
            block.get_input_port().FixValue(context, np.array(said))
            out.append(tuple(block.GetOutputPort("ee_command").Eval(context)))
            why.append(int(block.GetOutputPort("gate_status").Eval(context)[0]))
            step(block, context)
        return out, why

    return outputs_over_time


# --- The law, by hand ---------------------------------------------------------------


@pytest.mark.parametrize(
    ("said", "why"),
    [
        (HELD, OK),
        (HELD._replace(v_c=0.4, omega_c=-0.5, v_z=0.2), OK),
        (HELD._replace(age=0.25), OK),
        (HELD._replace(v_c=math.nextafter(0.4, 1)), OK),  # It is rounding.
        (HELD._replace(v_c=0.4 * (1 + 2e-9)), GateStatus.OVER_RANGE),
        (HELD._replace(v_z=-1e300), GateStatus.OVER_RANGE),
        (HELD._replace(omega_c=math.nan), GateStatus.NOT_FINITE),
        (HELD._replace(v_z=-math.inf), GateStatus.NOT_FINITE),
        (HELD._replace(age=math.nextafter(0.25, 1)), GateStatus.STALE),
        (HELD._replace(age=math.inf), GateStatus.GONE),
        (HELD._replace(age=math.nan), GateStatus.STALE),
        (HELD._replace(age=-0.1), GateStatus.STALE),
        (HELD._replace(dead_man=0.0), GateStatus.RELEASED),
        (HELD._replace(dead_man=math.nan), GateStatus.RELEASED),
        (HELD._replace(stop=1.0), GateStatus.STOPPED),
        (HELD._replace(stop=math.nan), GateStatus.STOPPED),
        # Of several reasons, the gravest.
        (HELD._replace(stop=1.0, age=9.0, v_c=math.nan), GateStatus.STOPPED),
        (HELD._replace(age=9.0, v_c=math.nan, dead_man=0.0), GateStatus.STALE),
        (HELD._replace(v_c=math.nan, omega_c=9.0), GateStatus.NOT_FINITE),
        (HELD._replace(v_c=9.0, dead_man=0.0), GateStatus.OVER_RANGE),
        (NOBODY, GateStatus.GONE),
    ],
)
def test_gravest_reason_is_told(said, why):
    assert input_status(said, GATE, GUARD) == why


def dragging(said=HELD, **changes):
    return said._replace(**PULL._replace(**changes)._asdict())


@pytest.mark.parametrize(
    ("said", "why"),
    [
        (dragging(), OK),
        (dragging(body=5), OK),
        (dragging(body=3), GateStatus.OVER_RANGE),
        (dragging(body=4.5), GateStatus.OVER_RANGE),
        (dragging(body=-4), GateStatus.OVER_RANGE),
        # Nothing is dragged, but somewhere.
        (dragging(body=0), GateStatus.OVER_RANGE),
        (dragging(q_y=0.01), GateStatus.OVER_RANGE),
        (dragging(to_x=-0.1), GateStatus.OVER_RANGE),
        (dragging(to_z=1e300), GateStatus.OVER_RANGE),
        (dragging(body=math.nan), GateStatus.NOT_FINITE),
        (dragging(q_z=math.inf), GateStatus.NOT_FINITE),
        (dragging(to_y=math.nan), GateStatus.NOT_FINITE),
        # Of several reasons, the gravest, whichever of command and drag it is.
        (dragging(HELD._replace(v_c=math.nan), body=3), GateStatus.NOT_FINITE),
        (dragging(HELD._replace(v_c=9.0), to_y=math.nan), GateStatus.NOT_FINITE),
        (dragging(HELD._replace(v_c=9.0)), GateStatus.OVER_RANGE),
        (dragging(HELD._replace(age=0.3), body=3), GateStatus.STALE),
        (dragging(REST), GateStatus.RELEASED),
    ],
)
def test_drag_passes_as_a_command_does(said, why):
    assert input_status(said, GATE, GUARD, ARM) == why


def test_nothing_may_be_dragged_unless_it_is_named():
    assert input_status(dragging(), GATE, GUARD) == GateStatus.OVER_RANGE
    assert input_status(HELD, GATE, GUARD) == OK


def test_who_drags_is_not_neutral():
    last = GateState(LATCHED, GateStatus.STALE)
    assert next_state(last, dragging(REST), GATE, GUARD, ARM) == last
    assert next_state(last, REST, GATE, GUARD, ARM).arming == READY


def test_drag_passes_bit_for_bit_and_is_let_go_at_once(fed, outputs, step):
    block = CommandGate(GATE, GUARD, PERIOD, ARM)
    context = fed(block, operator_input=REST)
    step(block, context)
    drags = []
    for said in (dragging(), dragging(q_x=0.1), dragging(body=9), dragging()):
        block.get_input_port().FixValue(context, np.array(said))
        drags.append(tuple(outputs(block, context)["drag"]))
        step(block, context)
    assert drags == [PULL, PULL._replace(q_x=0.1), NOTHING, NOTHING]


@pytest.mark.parametrize("key", [field.name for field in dc.fields(Drag)])
@pytest.mark.parametrize("value", [0.0, -1.0, math.inf, math.nan])
def test_drag_without_bounds_is_refused(key, value):
    arm = Draggable(frozenset({4}), Drag(**{key: value}))
    with pytest.raises(ParameterError, match=f"^{key}: "):
        CommandGate(GATE, GUARD, PERIOD, arm)


PUSHED = REST._replace(v_c=0.1)  # The stick is not neutral, the dead-man is let go.
NEARLY = REST._replace(v_c=0.02, omega_c=-0.025, v_z=0.01)  # The border of neutral.
NAN = HELD._replace(v_c=math.nan)
STALE = HELD._replace(age=0.3)
STOP = HELD._replace(stop=1.0)


@pytest.mark.parametrize(
    ("last", "said", "expected"),
    [
        # A press arms only where rest was seen the period before.
        ((LATCHED, GateStatus.NOT_ARMED), HELD, (LATCHED, GateStatus.NOT_ARMED)),
        ((LATCHED, GateStatus.NOT_ARMED), REST, (READY, GateStatus.NOT_ARMED)),
        ((LATCHED, GateStatus.STALE), NEARLY, (READY, GateStatus.STALE)),
        ((LATCHED, GateStatus.STALE), PUSHED, (LATCHED, GateStatus.STALE)),
        ((LATCHED, GateStatus.STALE), NOBODY, (LATCHED, GateStatus.STALE)),
        ((READY, GateStatus.STALE), HELD, (ARMED, OK)),
        ((READY, GateStatus.STALE), REST, (READY, GateStatus.STALE)),
        # It lapses as soon as the stick is pushed, or nobody is there any more.
        ((READY, GateStatus.RELEASED), PUSHED, (LATCHED, GateStatus.RELEASED)),
        ((READY, GateStatus.RELEASED), NOBODY, (LATCHED, GateStatus.RELEASED)),
        # A press that does not arm says why.
        ((READY, GateStatus.RELEASED), NAN, (LATCHED, GateStatus.NOT_FINITE)),
        ((READY, GateStatus.RELEASED), STALE, (LATCHED, GateStatus.STALE)),
        # Armed, it stays so until the first reason not to be, and keeps that.
        ((ARMED, OK), HELD, (ARMED, OK)),
        ((ARMED, OK), HELD._replace(v_c=0.0), (ARMED, OK)),
        ((ARMED, OK), REST, (LATCHED, GateStatus.RELEASED)),
        ((ARMED, OK), NAN, (LATCHED, GateStatus.NOT_FINITE)),
        ((ARMED, OK), STALE, (LATCHED, GateStatus.STALE)),
        ((ARMED, OK), STOP, (LATCHED, GateStatus.STOPPED)),
        ((LATCHED, GateStatus.NOT_FINITE), STALE, (LATCHED, GateStatus.NOT_FINITE)),
        ((LATCHED, GateStatus.NOT_FINITE), HELD, (LATCHED, GateStatus.NOT_FINITE)),
        # But a stop is told in any case.
        ((LATCHED, GateStatus.RELEASED), STOP, (LATCHED, GateStatus.STOPPED)),
        (
            (READY, GateStatus.RELEASED),
            REST._replace(stop=1.0),
            (LATCHED, GateStatus.STOPPED),
        ),
    ],
)
def test_state_goes_on_as_worked_out_by_hand(last, said, expected):
    assert next_state(GateState(*last), said, GATE, GUARD) == expected


def test_it_passes_brakes_and_latches_as_worked_out_by_hand(passed):
    # The largest, 0.4, goes to rest in four periods, by 0.1 each; 0.5 by 0.125.
    samples = [HELD, REST, HELD, HELD, STALE, HELD, HELD, HELD, REST, HELD]
    out, why = passed(samples)
    rest, going = (0.0, 0.0, 0.0), (0.3, -0.4, 0.1)
    np.testing.assert_allclose(
        out,
        [
            rest,
            rest,
            going,
            going,
            (0.2, -0.275, 0.05),
            (0.1, -0.15, 0.0),
            (0.0, -0.025, 0.0),
            rest,
            rest,
            going,
        ],
        rtol=0,
        atol=1e-15,
    )
    unarmed, stale = GateStatus.NOT_ARMED, GateStatus.STALE
    assert why == [unarmed, unarmed, OK, OK, *[stale] * 5, OK]


def test_what_is_out_of_the_gate_is_the_command_bit_for_bit(passed):
    odd = HELD._replace(v_c=0.1 + 0.2, omega_c=-5e-324, v_z=-0.0)
    out, _ = passed([REST, odd])
    assert np.array(out[-1]).tobytes() == np.array(odd.command).tobytes()


def test_guards_own_status_tells_of_the_command_as_it_comes(fed, outputs):
    block = CommandGate(GATE, GUARD, PERIOD)
    for said, why in ((HELD, 0), (NAN, 1), (HELD._replace(v_c=9.0), 2)):
        out = outputs(block, fed(block, operator_input=said))
        assert out["guard_status"] == [why]
        assert out["gate_status"] == [GateStatus.NOT_ARMED]


# --- Whatever the link does ----------------------------------------------------------

COMPONENTS = st.one_of(
    st.sampled_from([0.0, 0.2, -0.2, 0.01, math.nan, math.inf, -math.inf, 1e308]),
    st.floats(-0.6, 0.6),
)


DRAGS = st.one_of(
    st.just(NOTHING),
    st.sampled_from(
        [
            PULL,
            PULL._replace(body=3),
            PULL._replace(to_x=math.nan),
            PULL._replace(q_y=-math.inf),
            PULL._replace(to_z=3.0),
        ]
    ),
    st.builds(Dragged, st.sampled_from([4.0, 5.0]), *[st.floats(-0.6, 0.6)] * 6),
)


class Link(RuleBasedStateMachine):
    """An operator at one end of a link that does its worst, the gate at the other."""

    @initialize()
    def start(self):
        self.now = 0.0
        self.inbox = Mailbox(max_latency=GATE.fresh, clock=lambda: self.now)
        self.lateness = LatencyBound(clock=lambda: self.now)
        # The operator's clock is ahead by an hour; this is what he knows of it.
        self.ahead = None
        self.block = CommandGate(GATE, GUARD, PERIOD, ARM)
        self.context = self.block.CreateDefaultContext()
        self.block.get_input_port().FixValue(self.context, np.array(NOBODY))
        self.sequence = 0
        self.last = None  # Message that counts.
        self.handed_over = False
        self.under_way = []  # Messages sent, and not delivered yet.
        self.sent = {}  # When, by command; a NaN is itself only by identity.
        self.said = []  # Samples at each tick.
        self.out = [(0.0, 0.0, 0.0)]  # What passed at each tick, from before the first.
        self.drags = []  # The same of drags.
        self.why = []

    def send(self, command, dead_man, dragged=NOTHING):
        self.sequence += 1
        self.sent[self.sequence] = self.now
        message = OperatorInput(self.sequence, *command, dead_man, dragged)
        self.under_way.append((message, self.now + 3600.0, self.ahead))

    def deliver(self, index=-1):
        message, *times = self.under_way.pop(index)
        if self.inbox.put(message, self.lateness.of(*times)):
            # Never an old word after a newer one, nor a late one.
            assert self.last is None or message.sequence > self.last.sequence
            self.last = message

    def tick(self):
        said = self.inbox.sample()
        port = self.block.get_input_port()
        port.FixValue(self.context, np.array(said))
        self.said.append(said)
        get = self.block.GetOutputPort
        self.out.append(tuple(get("ee_command").Eval(self.context)))
        self.drags.append(tuple(get("drag").Eval(self.context)))
        self.why.append(GateStatus(int(get("gate_status").Eval(self.context)[0])))
        after = self.block.EvalUniquePeriodicDiscreteUpdate(self.context)
        self.context.SetDiscreteState(after.value().copy())
        self.check_last_tick()
        if self.handed_over:
            assert self.why[-1] != OK
            self.handed_over = False
        self.now += PERIOD

    @rule(
        command=st.tuples(COMPONENTS, COMPONENTS, COMPONENTS),
        dead_man=st.booleans(),
        dragged=DRAGS,
        ticks=st.integers(0, 3),
    )
    def say(self, command, dead_man, dragged, ticks):
        self.send(command, dead_man, dragged)
        self.deliver()
        self.wait(ticks)

    @rule(delay=st.sampled_from([0.0, 1 / 16, 0.5, 2.0]))
    def hear(self, delay):
        self.ahead = (self.now - delay) - (self.now + 3600.0)

    @rule(command=st.tuples(COMPONENTS, COMPONENTS, COMPONENTS), dead=st.booleans())
    def say_into_a_slow_link(self, command, dead):
        self.send(command, dead)

    @rule(data=st.data())
    def deliver_late_or_out_of_order(self, data):
        if self.under_way:
            self.deliver(data.draw(st.integers(0, len(self.under_way) - 1)))

    @rule(data=st.data())
    def drop(self, data):
        if self.under_way:
            self.under_way.pop(data.draw(st.integers(0, len(self.under_way) - 1)))

    @rule(ticks=st.integers(1, 8))
    def wait(self, ticks):
        for _ in range(ticks):
            self.tick()

    @rule()
    def anyone_stops(self):
        self.inbox.stop()
        self.tick()
        assert self.why[-1] == GateStatus.STOPPED

    @rule()
    def hand_over(self):
        self.inbox.clear()
        # Another page, which has a link of its own.
        self.sequence, self.last, self.ahead = 0, None, None
        self.lateness = LatencyBound(clock=lambda: self.now)
        self.under_way.clear()
        self.handed_over = True

    @rule(
        command=st.tuples(st.floats(-0.4, 0.4), st.floats(-0.5, 0.5)),
        dragged=st.sampled_from([NOTHING, PULL]),
    )
    def let_go_and_press(self, command, dragged):
        self.hear(0.0)
        for dead_man in (False, True):
            command_now = (*(c * dead_man for c in command), 0.0)
            self.send(command_now, dead_man, dragged if dead_man else NOTHING)
            self.deliver()
            self.wait(2)
        assert self.why[-1] == OK
        assert self.out[-1] == (*command, 0.0)

    def check_last_tick(self):
        before, now = self.out[-2:]
        passes = self.armed()
        assert (self.why[-1] == OK) == passes
        if not passes:
            assert now == tuple(braked(before, GUARD, PERIOD))
            assert self.drags[-1] == NOTHING
            return
        # No command that is not armed, fresh, finite and in range ever passes.
        command = self.last.v_c, self.last.omega_c, self.last.v_z
        assert self.last.dead_man
        assert now == command
        assert np.isfinite(command).all()
        assert (np.abs(command) <= LARGEST).all()
        assert self.drags[-1] == self.last.dragged
        assert self.drags[-1] == NOTHING or self.may_be_dragged(self.last.dragged)
        assert self.now - self.sent[self.last.sequence] <= GATE.fresh

    def armed(self):
        """Returns whether a rest, then a press, and nothing wrong since, was said."""
        k = len(self.said) - 1
        while k >= 0 and self.is_good(self.said[k]):
            k -= 1
        # Before the good ones there must have been a rest.
        return 0 <= k < len(self.said) - 1 and self.is_rest(self.said[k])

    @staticmethod
    def may_be_dragged(dragged):
        return bool(
            dragged.body in (4, 5)
            and np.isfinite(dragged).all()
            and np.linalg.norm(dragged.p_BQ) <= 0.5
            and np.linalg.norm(dragged.to) <= 2.0
        )

    @classmethod
    def is_good(cls, said):
        return bool(
            said.dead_man == 1
            and said.stop == 0
            and said.age <= 0.25
            and (said.dragged == NOTHING or cls.may_be_dragged(said.dragged))
            and np.isfinite(said.command).all()
            and (np.abs(said.command) <= LARGEST).all()
        )

    @staticmethod
    def is_rest(said):
        return bool(
            said.dead_man == 0
            and said.stop == 0
            and said.age <= 0.25
            and said.dragged == NOTHING
            and (np.abs(said.command) <= 0.05 * LARGEST).all()
        )

    @invariant()
    def is_at_rest_a_stop_time_after_the_last_command_passed(self):
        stopped = STOP_PERIODS + 1  # One more takes what rounding leaves.
        if len(self.why) >= stopped and OK not in self.why[-stopped:]:
            assert self.out[-1] == (0.0, 0.0, 0.0)


TestLink = Link.TestCase
TestLink.settings = settings(max_examples=200, stateful_step_count=40)


@given(
    said=st.lists(
        st.builds(OperatorSample, *[st.floats(allow_nan=True)] * len(NOBODY)),
        max_size=20,
    )
)
def test_whatever_comes_what_passes_is_finite_and_in_range(passed, said):
    out, _ = passed([REST, HELD, *said])
    assert np.isfinite(out).all()
    assert (np.abs(out) <= LARGEST).all()


# --- The blocks ----------------------------------------------------------------------


def test_ports_are_those_of_the_contract():
    block = CommandGate(Gate(), Guard(), PERIOD)
    assert block.num_input_ports() == 1
    assert block.GetInputPort("operator_input").size() == 14
    sizes = {"ee_command": 3, "guard_status": 1, "gate_status": 1, "gate_arming": 1}
    assert block.num_output_ports() == len(sizes)
    for name, size in sizes.items():
        assert block.GetOutputPort(name).size() == size
    block = CommandGate(Gate(), Guard(), PERIOD, ARM)
    assert block.num_output_ports() == len(sizes) + 1
    assert block.GetOutputPort("drag").size() == 7


def test_two_contexts_do_not_disturb_each_other(fed, outputs, step):
    block = CommandGate(GATE, GUARD, PERIOD)
    first, second = (fed(block, operator_input=REST) for _ in range(2))
    step(block, first)
    for context in (first, second):
        block.get_input_port().FixValue(context, np.array(HELD))
    assert outputs(block, first)["gate_status"] == [OK]
    assert outputs(block, second)["gate_status"] == [GateStatus.NOT_ARMED]


@pytest.mark.parametrize(
    ("key", "value"),
    [("fresh", 0.0), ("fresh", math.inf), ("neutral", -0.1), ("neutral", 1.0)],
)
def test_parameters_that_guard_nothing_are_refused(key, value):
    with pytest.raises(ParameterError, match=f"^{key}: "):
        CommandGate(Gate(**{key: value}), GUARD, PERIOD)


def test_a_source_that_is_not_fed_is_an_operator_who_is_not_there(fed, outputs, step):
    block = LiveSource(PERIOD)
    context = block.CreateDefaultContext()
    assert tuple(outputs(block, context)["operator_input"]) == NOBODY
    step(block, context)
    assert tuple(outputs(block, context)["operator_input"]) == NOBODY
    context = fed(block, operator_input=HELD)
    step(block, context)
    assert tuple(outputs(block, context)["operator_input"]) == HELD


# --- The edge ------------------------------------------------------------------------


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


def test_age_is_counted_from_when_it_was_said_not_from_when_it_came(clock):
    inbox = Mailbox(max_latency=0.25, clock=clock)
    clock.now = 0.5
    inbox.put(OperatorInput(2, v_c=0.1), 0.2)  # Said at 0.3.
    clock.now = 0.625
    assert inbox.sample().age == pytest.approx(0.325)


def test_what_comes_late_or_out_of_order_or_twice_is_dropped(clock):
    inbox = Mailbox(max_latency=0.25, clock=clock)
    assert inbox.put(OperatorInput(5, v_c=0.1))
    assert not inbox.put(OperatorInput(5, v_c=0.2))
    assert not inbox.put(OperatorInput(4, v_c=0.2))
    for lateness in (0.26, math.inf, math.nan):
        assert not inbox.put(OperatorInput(6, v_c=0.2), lateness)
    clock.now = 600.0
    assert inbox.sample().v_c == 0.1
    assert inbox.sample().age == 600.0
    assert inbox.put(OperatorInput(8, v_c=0.3), 0.25)
    assert inbox.sample().v_c == 0.3


@given(
    up=st.lists(st.floats(0, 5), min_size=1, max_size=20),
    down=st.floats(0, 5),
    ahead=st.floats(-1e6, 1e6),
    rate=st.floats(1 - 1e-4, 1 + 1e-4),
)
def test_no_message_is_later_than_it_is_said_to_be(up, down, ahead, rate):
    # However slow the link is from the first message on, and whatever the page's clock.
    clock = Clock()
    lateness = LatencyBound(clock)
    theirs = lambda time: (time - ahead) * rate  # noqa: E731
    for k, delay in enumerate(up):
        told = 10.0 * k
        heard = told + down
        sent = heard + 0.02
        clock.now = sent + delay
        late = lateness.of(theirs(sent), told - theirs(heard))
        assert delay - 1e-3 <= late <= delay + down + 0.02


def test_quick_link_is_not_held_to_be_late_for_a_hitch(clock):
    lateness = LatencyBound(clock)
    assert lateness.of(50.0, -50.0) == 0.0
    clock.now = 1.0
    # The page was busy, and heard only an old word of ours since.
    assert lateness.of(51.0, -50.8) == pytest.approx(0.0, abs=2e-3)


@pytest.mark.parametrize("rate", [1 - 1e-4, 1 + 1e-4])
def test_clocks_that_drift_apart_make_nothing_late(clock, rate):
    lateness = LatencyBound(clock)
    for k in range(36_000):  # An hour.
        clock.now = k / 10
        assert lateness.of(k / 10 * rate, k / 10 - k / 10 * rate) < 1e-3


def test_page_whose_clock_stood_still_is_believed_again_when_it_has_heard(clock):
    lateness = LatencyBound(clock)
    assert lateness.of(50.0, -50.0) == 0.0
    clock.now = 600.0  # Its device slept, and so did its clock.
    assert lateness.of(50.1, -50.0) > 599.0  # From before that, as far as one knows.
    clock.now = 600.1
    assert lateness.of(50.2, 549.9) == pytest.approx(0.0, abs=1e-9)


def test_page_whose_clock_was_set_is_not_believed_until_it_has_heard(clock):
    lateness = LatencyBound(clock)
    assert lateness.of(50.0, None) == math.inf
    assert lateness.of(50.0, -50.0) == 0.0
    clock.now = 0.1
    # What it says seems to come before it was sent.
    assert lateness.of(99.0, -50.0) == math.inf
    assert lateness.of(99.0, None) == math.inf
    assert lateness.of(99.0, -98.9) == pytest.approx(0.0, abs=1e-9)


def test_stop_is_told_once_and_an_operator_forgotten_is_nobody(clock):
    inbox = Mailbox(clock=clock)
    inbox.choose(2)
    inbox.put(OperatorInput(9, v_c=0.1, dead_man=True))
    inbox.stop()
    assert inbox.sample() == OperatorSample(0.1, dead_man=1, age=0, stop=1, choice=2)
    assert inbox.sample().stop == 0
    inbox.clear()
    assert inbox.sample() == NOBODY._replace(choice=2)
    assert inbox.put(OperatorInput(1))  # Another counts from where he likes.


def test_a_change_of_operators_shows_however_quick_it_is(clock):
    inbox = Mailbox(clock=clock)
    inbox.put(OperatorInput(9, dead_man=True))
    inbox.clear()
    inbox.put(OperatorInput(1, dead_man=True))
    assert inbox.sample() == NOBODY
    assert inbox.sample().dead_man == 1
