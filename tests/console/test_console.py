"""The console without a browser: who is let in, who drives, and what may be said."""

import asyncio
import importlib.util
import json
import math
import socket
import types

import pytest
from typer.testing import CliRunner

from drake_mobman.cli.app import app
from drake_mobman.console.auth import COOKIE, AuthMiddleware, is_loopback
from drake_mobman.console.mailbox import OperatorInput
from drake_mobman.console.messages import (
    BURST,
    LARGEST,
    RATE,
    Ask,
    MessageError,
    Rate,
    parsed,
)
from drake_mobman.console.operator_arbiter import LATE, SILENT, OperatorArbiter
from drake_mobman.console.plain import FIRST, NEXT, KeyHold
from drake_mobman.console.session import Snapshot
from drake_mobman.console.state import state
from drake_mobman.teleop.drag import NOTHING
from drake_mobman.teleop.guard import Guard
from drake_mobman.teleop.recorded import COMMANDS

FULL = (0.4, 0.3, 0.2)
"""The largest command: m/s, rad/s, m/s."""


def words(**changes):
    """Returns an operator's message."""
    said = {
        "sequence": 7,
        "v_c": 0.5,
        "omega_c": -1.0,
        "v_z": 0.0,
        "dead_man": True,
        "sent": 12.5,
        "ahead": 87.5,
    }
    return json.dumps(said | changes)


class Clock:
    """A wall clock that goes when it is told to."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


# --- What may be said ----------------------------------------------------------------


def test_input_is_taken_as_shares_of_the_largest_command():
    assert parsed(words(), FULL).said == OperatorInput(7, 0.2, -0.3, 0.0, True)
    assert parsed(words(v_c=1, dead_man=False), FULL).said.v_c == 0.4


def test_command_out_of_range_or_not_finite_is_left_to_the_gate_which_says_so():
    assert parsed(words(v_c=3), FULL).said.v_c == pytest.approx(1.2)
    huge = words().replace("0.5", "1e999")
    assert parsed(huge, FULL).said.v_c == float("inf")
    assert parsed(words(v_c=10**400), FULL).said.v_c == float("inf")


LINKS = {"link3": 10, "link4": 11}
DRAG = {"body": "link4", "point": [0.1, 0, -0.2], "to": [1, 2.25, 0.5]}


def test_drag_is_taken_by_the_name_of_the_body():
    said = parsed(words(drag=DRAG), FULL, LINKS).said
    assert said.dragged == (11, 0.1, 0.0, -0.2, 1.0, 2.25, 0.5)
    assert parsed(words(drag=None), FULL, LINKS).said.dragged == NOTHING
    huge = words(drag=DRAG).replace("2.25", "1e999")
    assert parsed(huge, FULL, LINKS).said.dragged.to_y == float("inf")


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
        parsed(words(drag=drag), FULL, LINKS)


def test_nothing_is_dragged_where_nothing_may_be():
    with pytest.raises(MessageError, match="not a drag"):
        parsed(words(drag=DRAG), FULL)


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
        words(v_c="0.5"),
        words(v_c=None),
        words(v_c=True),
        words(v_c=float("nan")),
        words(sent=float("inf")),
        words(sent=10**400),
        words(sent=None),
        words(ahead="1"),
        words(ahead=-(10**400)),
        '{"ask": "stop"}',
        '{"ask": "stop", "sent": "now"}',
        words(sequence=1.0),
        words(sequence=-1),
        words(sequence=2**60),
        words(dead_man=1),
        words(extra=0),
        words().replace('"v_c": 0.5, ', ""),
        '{"sent": 1, "ask": "fly"}',
        '{"sent": 1, "ask": ["stop"]}',
        '{"sent": 1, "ask": {}}',
        '{"sent": 1, "ask": "choose", "choice": 3}',
        '{"sent": 1, "ask": "record", "folder": "/etc"}',
    ],
)
def test_message_that_no_page_of_ours_sends_is_refused(message):
    with pytest.raises(MessageError) as refused:
        parsed(message, FULL)
    assert refused.value.code == MessageError.NOT_OURS


def test_times_come_along():
    assert parsed(words(), FULL)[1:] == (12.5, 87.5)
    assert parsed(words(ahead=None), FULL)[1:] == (12.5, None)


def test_message_that_is_too_long_is_refused_unread():
    for message in (" " * (LARGEST + 1), "é" * LARGEST):
        with pytest.raises(MessageError) as refused:
            parsed(message, FULL)
        assert refused.value.code == MessageError.TOO_BIG


def test_buttons_ask():
    assert parsed('{"sent": 1.5, "ask": "stop"}', FULL).said == Ask("stop")
    assert parsed(
        '{"sent": 1.5, "ask": "choose", "choice": "exact"}', FULL
    ).said == Ask("choose", "exact")


def test_messages_are_counted():
    clock = Clock()
    rate = Rate(clock)
    for _ in range(int(BURST)):
        rate.count()
    with pytest.raises(MessageError, match="too many"):
        rate.count()
    clock.now += 2.0
    for _ in range(830):  # 83 a second, as ours sends at most.
        clock.now += 1 / 83
        rate.count()
    assert RATE > 83


# --- Who drives ----------------------------------------------------------------------


class Session:
    """Stands for a session, and remembers what it is told."""

    def __init__(self):
        self.scenario = types.SimpleNamespace(guard=Guard())
        self.draggable = {"link3": 10}
        self.told = []

    def tell(self, said, lateness):
        self.told.append((said, lateness))

    def choose(self, name):
        if name != "exact":
            raise ValueError(f"no choice {name!r}")
        self.told.append(("choose", name))

    def __getattr__(self, name):
        return lambda *arguments: self.told.append((name, *arguments))


@pytest.fixture
def session():
    return Session()


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def desk(session, clock):
    return OperatorArbiter(session, lambda: "folder", clock)


def asks(desk, page, what, **more):
    times = {"sent": 0.0, "ahead": desk._clock()}  # A page that has just been opened.
    desk.hear(page, json.dumps({"ask": what} | times | more))


def test_first_page_drives_and_others_watch(desk, session):
    first, second = desk.join(), desk.join()
    assert (desk.role(first), desk.role(second)) == ("you", "another")
    session.told.clear()
    desk.hear(second, words())
    assert session.told == []
    desk.hear(first, words())
    assert session.told == [(OperatorInput(7, 0.2, -0.4, 0.0, True), 0.0)]


def test_anyone_may_stop(desk, session):
    first, second = desk.join(), desk.join()
    asks(desk, second, "stop")
    asks(desk, first, "stop")
    assert session.told[-2:] == [("stop", "a viewer"), ("stop", "the operator")]


def test_who_watches_may_do_nothing_else(desk, session):
    desk.join()
    second = desk.join()
    session.told.clear()
    for what in ("hand_over", "reset", "record", "end_record", "choose"):
        asks(desk, second, what, choice="exact")
        assert second.notice == "only who drives may do that"
    assert session.told == []


def test_stick_is_handed_over_and_the_robot_stops_each_time(desk, session):
    first, second = desk.join(), desk.join()
    session.told.clear()
    asks(desk, second, "take")
    assert desk.role(second) == "another"
    assert "asked to hand over" in second.notice
    assert desk.asked
    asks(desk, first, "hand_over")
    assert session.told == [("hand_over",)]
    assert {desk.role(first), desk.role(second)} == {"nobody"}
    asks(desk, second, "take")
    assert session.told == [("hand_over",)] * 2
    assert (desk.role(first), desk.role(second)) == ("another", "you")
    assert not desk.asked
    assert second.notice == ""


def test_what_was_pressed_long_ago_is_not_done_but_for_a_stop(desk, session, clock):
    page = desk.join()
    session.told.clear()
    asks(desk, page, "reset")
    assert session.told.pop() == ("reset",)
    clock.now += LATE + 0.1  # A link that was dead delivers what it kept.
    for what in ("reset", "record", "hand_over"):
        asks(desk, page, what, ahead=100.0)
        assert page.notice == "that came too late; press again"
    assert session.told == []
    asks(desk, page, "stop", ahead=100.0)
    assert session.told == [("stop", "the operator")]


def test_how_late_the_operator_is_comes_along(desk, session, clock):
    page = desk.join()
    session.told.clear()
    desk.hear(page, words(ahead=None))  # Nobody knows: it has heard nothing yet.
    clock.now += 1.0
    desk.hear(page, words())
    (_, unknown), (_, late) = session.told
    assert unknown == math.inf
    assert late == pytest.approx(1.0, abs=0.01)


def test_stick_that_nobody_has_used_for_a_while_may_be_taken(desk, clock):
    first, second = desk.join(), desk.join()
    clock.now += SILENT - 0.1
    desk.hear(first, words())
    clock.now += SILENT - 0.1
    asks(desk, second, "take")
    assert desk.role(first) == "you"
    clock.now += 0.2
    asks(desk, second, "take")
    assert desk.role(second) == "you"


def test_robot_stops_when_the_operator_leaves_and_nobody_takes_his_place_unasked(
    desk, session
):
    first, second = desk.join(), desk.join()
    session.told.clear()
    desk.leave(second)
    assert session.told == []
    second = desk.join()
    desk.leave(first)
    assert session.told == [("hand_over",)]
    assert desk.role(second) == "nobody"
    assert desk.role(desk.join()) == "nobody"


def test_operator_chooses_resets_and_records(desk, session):
    page = desk.join()
    session.told.clear()
    asks(desk, page, "choose", choice="exact")
    asks(desk, page, "reset")
    asks(desk, page, "record")
    asks(desk, page, "end_record")
    assert session.told == [
        ("choose", "exact"),
        ("reset",),
        ("record", "folder"),
        ("record", None),
    ]
    asks(desk, page, "choose", choice="magic")
    assert page.notice == "no choice 'magic'"


def test_flood_is_refused_even_of_words_that_count_for_nothing(desk):
    desk.join()
    viewer = desk.join()
    for _ in range(int(BURST)):
        desk.hear(viewer, words())
    with pytest.raises(MessageError, match="too many"):
        desk.hear(viewer, words())


# --- Who is let in -------------------------------------------------------------------


OWN = "127.0.0.1:8080"


async def inside(scope, _receive, send):
    """An app that greets whoever gets in."""
    if scope["type"] == "websocket":
        await send({"type": "websocket.accept"})
    else:
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": b"in"})


def asked(door, kind="http", query="", host=OWN, client="192.168.1.9", **headers):
    """Returns the door's answer: a status, or whether a socket opens; and headers."""
    path, headers = "/", {"host": host} | headers
    scope = {
        "type": kind,
        "method": "GET",
        "client": (client, 50_000),
        "path": path,
        "query_string": query.encode(),
        "headers": [(name.encode(), x.encode()) for name, x in headers.items()],
    }
    answers = []

    async def send(message):
        answers.append(message)

    async def receive():  # Whoever asks says no more, and waits.
        await asyncio.Event().wait()

    asyncio.run(door(scope, receive, send))
    first = answers[0]
    answered = {k.decode(): v.decode() for k, v in first.get("headers", [])}
    if kind == "websocket":
        return first["type"] == "websocket.accept", answered
    return first["status"], answered


@pytest.mark.parametrize(
    ("host", "loopback"),
    [
        ("127.0.0.1", True),
        ("127.8.8.8", True),
        ("localhost", True),
        ("::1", True),
        ("0.0.0.0", False),
        ("::", False),
        ("192.168.1.5", False),
        ("localhost.evil.example", False),
    ],
)
def test_only_this_machine_is_loopback(host, loopback):
    assert is_loopback(host) == loopback


def test_other_sites_pages_open_no_socket():
    door = AuthMiddleware(inside)
    assert asked(door, "websocket", origin=f"http://{OWN}")[0]
    for origin in ("http://evil.example", "http://127.0.0.1:9999", "null", ""):
        assert not asked(door, "websocket", origin=origin)[0]
    assert not asked(door, "websocket")[0]
    assert asked(door, origin="http://evil.example")[0] == 403
    assert asked(door)[0] == 200


def test_name_that_leads_here_is_not_this_server():
    door = AuthMiddleware(inside)
    assert asked(door, host="evil.example")[0] == 403
    assert asked(door, host="")[0] == 403
    for host in ("localhost:9999", "[::1]:8080", "127.0.0.1"):
        assert asked(door, host=host)[0] == 200


@pytest.mark.parametrize("token", [None, "secret"])
@pytest.mark.parametrize("kind", ["http", "websocket"])
def test_host_or_origin_that_is_none_is_refused_as_a_wrong_one(kind, token):
    door, known = AuthMiddleware(inside, token), {}
    if token:
        shown = asked(door, query="token=secret")[1]
        known = {"cookie": shown["set-cookie"].partition(";")[0]}
    for wrong in ({"host": "["}, {"origin": "http://["}, {"origin": "http://[v]/"}):
        assert asked(door, kind, **known, **wrong)[0] in {403, False}


def test_beyond_this_machine_a_token_is_asked_for_and_remembered():
    door = AuthMiddleware(inside, "secret", 8080)
    there = {"host": "192.168.1.5:8080"}
    assert asked(door, **there)[0] == 403
    for wrong in ("wrong", "", "s%C3%A9cret", "secret2"):
        assert asked(door, query=f"token={wrong}", **there)[0] == 403
        assert asked(door, cookie=f"{COOKIE}_8080={wrong}", **there)[0] == 403
    status, headers = asked(door, query="token=secret", **there)
    assert (status, headers["location"]) == (303, "/")
    cookie = headers["set-cookie"].lower()
    assert "httponly" in cookie
    # One who follows a link from another site is remembered, too.
    assert "samesite=lax" in cookie
    known = there | {"cookie": headers["set-cookie"].partition(";")[0]}
    own = {"origin": "http://192.168.1.5:8080"}
    assert asked(door, **known)[0] == 200
    assert asked(door, "websocket", **known, **own)[0]
    assert not asked(door, "websocket", **there, **own)[0]
    # Neither does the token alone let in a socket: only the page is opened by it.
    assert not asked(door, "websocket", query="token=secret", **there, **own)[0]
    assert not asked(door, "websocket", **known, origin="http://evil.example")[0]
    # What servers at other ports are told is worth nothing to them.
    assert "secret" not in known["cookie"]
    assert asked(door, **known, client="192.168.1.66")[0] == 403
    assert asked(AuthMiddleware(inside, "secret", 8081), **known)[0] == 403


def test_pages_are_shown_in_no_other_sites_frame_and_load_nothing_from_elsewhere():
    policy = asked(AuthMiddleware(inside))[1]["content-security-policy"]
    assert "frame-ancestors 'self'" in policy
    assert policy.startswith("default-src 'self'")


# --- What is shown -------------------------------------------------------------------


def test_state_is_json_whatever_the_robot_does():
    snapshot = Snapshot(
        time=1.25,
        signals={
            "ee_cylindrical": (1.0, 0.0, float("nan")),
            "base_command_smoothed": (0.2, 0.1),
            "arm_command": (0.1, 0.0, 0.0),
        },
        hand_error=float("inf"),
    )
    said = json.loads(json.dumps(state(snapshot, (0.1, 0.3, 0.5)), allow_nan=False))
    assert said["z"] is None
    assert said["error"] is None
    assert (said["base"], said["arm"]) == (0.17, 0.1)  # 0.2 - 0.1 x 0.3 m/s.
    json.dumps(state(Snapshot(), (0.1, 0.3, 0.5)), allow_nan=False)


# --- Meshcat's panel -----------------------------------------------------------------


def test_key_is_held_while_it_is_repeated(clock):
    key = KeyHold(clock)
    assert not key.is_held(0)
    assert key.is_held(1)
    clock.now += FIRST - 0.01  # The first repetition takes long.
    assert key.is_held(1)
    clock.now += 0.005
    assert key.is_held(2)
    clock.now += NEXT - 0.01
    assert key.is_held(3)
    clock.now += NEXT + 0.01
    assert not key.is_held(3)
    assert key.is_held(4)
    clock.now += FIRST + 0.01
    assert not key.is_held(4)


# --- The command line ----------------------------------------------------------------


def refused(*arguments):
    """Returns the one line by which `mobman drive` refuses."""
    result = CliRunner().invoke(app, ["drive", *map(str, arguments)])
    assert (result.exit_code, result.stdout) == (2, "")
    (line,) = result.stderr.splitlines()
    return line


def test_without_the_extra_it_says_what_to_install(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    assert "pip install 'drake_mobman[console]'" in refused("kwon_arbitrary")


def test_bad_input_is_refused_before_anything_runs(tmp_path):
    folder = tmp_path / "session"
    record = ("--record", folder, "--port", 0)
    assert "valid names are" in refused("kwon_9", *record)
    assert "must be" in refused("kwon_1", "--set", "period=0", *record)
    assert "gate.fresh" in refused("kwon_1", "--set", "gate.fresh=-1", *record)
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        line = refused("kwon_1", "--record", folder, "--port", port)
        assert f"cannot serve at 127.0.0.1, port {port}" in line
        line = refused("kwon_1", "--record", folder, "--port", port, "--plain")
        assert f"cannot serve at port {port}" in line
    assert "no.such.host" in refused("kwon_1", *record, "--host", "no.such.host")
    assert "this machine alone" in refused("kwon_1", "--plain", "--host", "0.0.0.0")
    assert not folder.exists()
    folder.mkdir()
    (folder / "thesis.tex").write_text("years of work")
    assert "thesis.tex" in refused("kwon_1", *record)
    assert len(list(folder.iterdir())) == 1


def test_recording_is_not_replaced(tmp_path):
    (tmp_path / COMMANDS).write_text("an hour of a person's work")
    line = refused("kwon_1", "--record", tmp_path, "--port", 0)
    assert line == (
        f"mobman: {tmp_path}: cannot be written, it holds a recorded session, which "
        "would be lost; must be new, or of an earlier run"
    )
    assert (tmp_path / COMMANDS).read_text() == "an hour of a person's work"
    assert len(list(tmp_path.iterdir())) == 1
