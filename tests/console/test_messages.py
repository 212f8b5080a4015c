"""Messages of pages: what is taken in, and what is refused."""

import json

import pytest

from drake_mobman.console.mailbox import OperatorInput
from drake_mobman.console.messages import (
    BURST,
    MAX_SIZE,
    RATE,
    ButtonPress,
    MessageError,
    MessageRateLimit,
    parse_message,
)
from drake_mobman.teleop.drag import NOTHING

FULL = (0.4, 0.3, 0.2)
"""The largest command: m/s, rad/s, m/s."""


def input_message(**changes):
    """Returns a page's message with an operator's input."""
    values = {
        "sequence": 7,
        "v_c": 0.5,
        "omega_c": -1.0,
        "v_z": 0.0,
        "dead_man": True,
        "sent": 12.5,
        "ahead": 87.5,
    }
    return json.dumps(values | changes)


def test_input_is_taken_as_shares_of_the_largest_command():
    assert parse_message(input_message(), FULL).content == OperatorInput(
        7, 0.2, -0.3, 0.0, True
    )
    assert parse_message(input_message(v_c=1, dead_man=False), FULL).content.v_c == 0.4


def test_command_out_of_range_or_not_finite_is_left_to_the_gate_which_says_so():
    assert parse_message(input_message(v_c=3), FULL).content.v_c == pytest.approx(1.2)
    huge = input_message().replace("0.5", "1e999")
    assert parse_message(huge, FULL).content.v_c == float("inf")
    assert parse_message(input_message(v_c=10**400), FULL).content.v_c == float("inf")


LINKS = {"link3": 10, "link4": 11}
DRAG = {"body": "link4", "point": [0.1, 0, -0.2], "to": [1, 2.25, 0.5]}


def test_drag_is_taken_by_the_name_of_the_body():
    dragged = parse_message(input_message(drag=DRAG), FULL, LINKS).content.dragged
    assert dragged == (11, 0.1, 0.0, -0.2, 1.0, 2.25, 0.5)
    assert (
        parse_message(input_message(drag=None), FULL, LINKS).content.dragged == NOTHING
    )
    huge = input_message(drag=DRAG).replace("2.25", "1e999")
    assert parse_message(huge, FULL, LINKS).content.dragged.to_y == float("inf")


@pytest.mark.parametrize(
    "drag",
    [
        7,
        [],
        {},
        DRAG | {"body": "base"},
        DRAG | {"body": 11},
        DRAG | {"body": ["link4"]},
        DRAG | {"point": [0.1, 0.0]},
        DRAG | {"point": [0.1, 0.0, "0"]},
        DRAG | {"to": [1, 2, None]},
        DRAG | {"to": {"x": 1}},
        DRAG | {"force": [0, 0, 100]},
    ],
)
def test_drag_that_no_page_of_ours_sends_is_refused(drag):
    with pytest.raises(MessageError, match=r"not a (drag|number)"):
        parse_message(input_message(drag=drag), FULL, LINKS)


def test_nothing_is_dragged_where_nothing_may_be():
    with pytest.raises(MessageError, match="not a drag"):
        parse_message(input_message(drag=DRAG), FULL)


@pytest.mark.parametrize(
    "message",
    [
        "",
        "hello",
        "[]",
        "7",
        "null",
        "{}",
        "[" * 500,
        b"{}",
        input_message(v_c="0.5"),
        input_message(v_c=None),
        input_message(v_c=True),
        input_message(v_c=float("nan")),
        input_message(sent=float("inf")),
        input_message(sent=10**400),
        input_message(sent=None),
        input_message(ahead="1"),
        input_message(ahead=-(10**400)),
        '{"ask": "stop"}',
        '{"ask": "stop", "sent": "now"}',
        input_message(sequence=1.0),
        input_message(sequence=-1),
        input_message(sequence=2**60),
        input_message(dead_man=1),
        input_message(extra=0),
        input_message().replace('"v_c": 0.5, ', ""),
        '{"sent": 1, "ask": "fly"}',
        '{"sent": 1, "ask": ["stop"]}',
        '{"sent": 1, "ask": {}}',
        '{"sent": 1, "ask": "choose", "choice": 3}',
        '{"sent": 1, "ask": "record", "folder": "/etc"}',
    ],
)
def test_message_that_no_page_of_ours_sends_is_refused(message):
    with pytest.raises(MessageError) as refused:
        parse_message(message, FULL)
    assert refused.value.code == MessageError.NOT_OURS


def test_times_come_along():
    assert parse_message(input_message(), FULL)[1:] == (12.5, 87.5)
    assert parse_message(input_message(ahead=None), FULL)[1:] == (12.5, None)


def test_message_that_is_too_long_is_refused_unread():
    for message in (" " * (MAX_SIZE + 1), "é" * MAX_SIZE):
        with pytest.raises(MessageError) as refused:
            parse_message(message, FULL)
        assert refused.value.code == MessageError.TOO_BIG


def test_buttons_ask():
    assert parse_message('{"sent": 1.5, "ask": "stop"}', FULL).content == ButtonPress(
        "stop"
    )
    assert parse_message(
        '{"sent": 1.5, "ask": "choose", "choice": "exact"}', FULL
    ).content == ButtonPress("choose", "exact")


def test_messages_are_counted(clock):
    limit = MessageRateLimit(clock)
    for _ in range(int(BURST)):
        limit.count()
    with pytest.raises(MessageError, match="too many"):
        limit.count()
    clock.now += 2.0
    for _ in range(830):  # 83 a second, as ours sends at most.
        clock.now += 1 / 83
        limit.count()
    assert RATE > 83
