"""Which page drives, and what the others may do."""

import json
import math
import types

import pytest

from drake_mobman.console.mailbox import OperatorInput
from drake_mobman.console.messages import ACTIONS, BURST, MessageError
from drake_mobman.console.operator_arbiter import (
    IDLE_TIMEOUT,
    MAX_PRESS_LATENCY,
    OperatorArbiter,
)
from drake_mobman.teleop.guard import Guard


def push(ahead=87.5):
    """Returns a page's message: its stick is pushed, its dead-man held."""
    command = {"v_c": 0.5, "omega_c": -1.0, "v_z": 0.0, "dead_man": True}
    return json.dumps(command | {"sequence": 7, "sent": 12.5, "ahead": ahead})


class Session:
    """Stands for a session, and remembers all calls."""

    def __init__(self):
        self.scenario = types.SimpleNamespace(guard=Guard())
        self.draggable = {"link3": 10}
        self.calls = []

    def send(self, operator_input, latency):
        self.calls.append((operator_input, latency))

    def choose(self, name):
        if name != "exact":
            raise ValueError(f"no choice {name!r}")
        self.calls.append(("choose", name))

    def __getattr__(self, name):
        return lambda *arguments: self.calls.append((name, *arguments))


@pytest.fixture
def session():
    return Session()


@pytest.fixture
def arbiter(session, clock):
    return OperatorArbiter(session, lambda: "folder", clock)


def asks(arbiter, page, what, **more):
    times = {
        "sent": 0.0,
        "ahead": arbiter._clock(),
    }  # A page that has just been opened.
    arbiter.receive(page, json.dumps({"ask": what} | times | more))


def test_first_page_drives_and_others_watch(arbiter, session):
    first, second = arbiter.join(), arbiter.join()
    assert (arbiter.role(first), arbiter.role(second)) == ("you", "another")
    session.calls.clear()
    arbiter.receive(second, push())
    assert session.calls == []
    arbiter.receive(first, push())
    assert session.calls == [(OperatorInput(7, 0.2, -0.4, 0.0, True), 0.0)]


def test_anyone_may_stop(arbiter, session):
    first, second = arbiter.join(), arbiter.join()
    asks(arbiter, second, "stop")
    asks(arbiter, first, "stop")
    assert session.calls[-2:] == [("stop", "a viewer"), ("stop", "the operator")]


def test_who_watches_may_do_nothing_else(arbiter, session):
    arbiter.join()
    second = arbiter.join()
    session.calls.clear()
    for what in ("hand_over", "reset", "record", "end_record", "choose"):
        asks(arbiter, second, what, choice="exact")
        assert second.notice == "only the operator may do that"
    assert session.calls == []


def test_stick_is_handed_over_and_the_robot_stops_each_time(arbiter, session):
    first, second = arbiter.join(), arbiter.join()
    session.calls.clear()
    asks(arbiter, second, "take")
    assert arbiter.role(second) == "another"
    assert "asked to hand over" in second.notice
    assert arbiter.handover_requested
    asks(arbiter, first, "hand_over")
    assert session.calls == [("release",)]
    assert {arbiter.role(first), arbiter.role(second)} == {"nobody"}
    asks(arbiter, second, "take")
    assert session.calls == [("release",)] * 2
    assert (arbiter.role(first), arbiter.role(second)) == ("another", "you")
    assert not arbiter.handover_requested
    assert second.notice == ""


def test_what_was_pressed_long_ago_is_not_done_but_for_a_stop(arbiter, session, clock):
    page = arbiter.join()
    session.calls.clear()
    asks(arbiter, page, "reset")
    assert session.calls.pop() == ("reset",)
    clock.now += MAX_PRESS_LATENCY + 0.1  # A link that was dead delivers what it kept.
    for what in ("reset", "record", "hand_over"):
        asks(arbiter, page, what, ahead=100.0)
        assert page.notice == "that arrived too late; press again"
    assert session.calls == []
    asks(arbiter, page, "stop", ahead=100.0)
    assert session.calls == [("stop", "the operator")]


def test_how_late_the_operator_is_comes_along(arbiter, session, clock):
    page = arbiter.join()
    session.calls.clear()
    arbiter.receive(page, push(ahead=None))  # Nobody knows: it has heard nothing yet.
    clock.now += 1.0
    arbiter.receive(page, push())
    (_, unknown), (_, late) = session.calls
    assert unknown == math.inf
    assert late == pytest.approx(1.0, abs=0.01)


def test_stick_that_nobody_has_used_for_a_while_may_be_taken(arbiter, clock):
    first, second = arbiter.join(), arbiter.join()
    clock.now += IDLE_TIMEOUT - 0.1
    arbiter.receive(first, push())
    clock.now += IDLE_TIMEOUT - 0.1
    asks(arbiter, second, "take")
    assert arbiter.role(first) == "you"
    clock.now += 0.2
    asks(arbiter, second, "take")
    assert arbiter.role(second) == "you"


def test_robot_stops_when_the_operator_leaves_and_nobody_takes_his_place_unasked(
    arbiter, session
):
    first, second = arbiter.join(), arbiter.join()
    session.calls.clear()
    arbiter.leave(second)
    assert session.calls == []
    second = arbiter.join()
    arbiter.leave(first)
    assert session.calls == [("release",)]
    assert arbiter.role(second) == "nobody"
    assert arbiter.role(arbiter.join()) == "nobody"


def test_operator_chooses_resets_and_records(arbiter, session):
    page = arbiter.join()
    session.calls.clear()
    asks(arbiter, page, "choose", choice="exact")
    asks(arbiter, page, "reset")
    asks(arbiter, page, "record")
    asks(arbiter, page, "end_record")
    assert session.calls == [
        ("choose", "exact"),
        ("reset",),
        ("record", "folder"),
        ("record", None),
    ]
    asks(arbiter, page, "choose", choice="magic")
    assert page.notice == "no choice 'magic'"


def test_flood_is_refused_even_of_messages_that_count_for_nothing(arbiter):
    arbiter.join()
    viewer = arbiter.join()
    for _ in range(int(BURST)):
        arbiter.receive(viewer, push())
    with pytest.raises(MessageError, match="too many"):
        arbiter.receive(viewer, push())


@pytest.mark.parametrize("action", ACTIONS)
def test_operator_may_press_every_button_of_the_page(arbiter, session, action):
    page = arbiter.join()
    session.calls.clear()
    asks(arbiter, page, action, choice="exact")
    assert (len(session.calls) == 1) == (action != "take")  # Who drives need not take.
