"""What pages say that no page of ours would, and who says it."""

import contextlib
import json
import re
import time
from urllib.parse import urlencode

import pytest
from websockets.exceptions import ConnectionClosed

pytestmark = pytest.mark.realtime

ARMED = 2


def words(**changes):
    """Returns an operator's message."""
    said = {"sequence": 1, "v_c": 0.5, "omega_c": 0.0, "v_z": 0.0, "dead_man": True}
    return json.dumps(said | {"sent": 12.5, "ahead": 87.5} | changes)


MALFORMED = [
    *(
        "",
        " ",
        "hello",
        "{",
        "[]",
        "7",
        "null",
        '"x"',
        "{}",
        "\0",
        "[" * 400,
        "{" * 400,
    ),
    *('{"a":' * 80, "[[" * 100 + "]]" * 100, "NaN", "\ufeff{}", "{'a': 1}"),
    *(b"{}", b"\x00\xff", words().encode()),
    *('{"ask": "stop"}', '{"sent": 1, "ask": "fly"}', '{"sent": 1, "ask": ["stop"]}'),
    '{"sent": 1, "ask": "record", "folder": "/etc"}',
    words()[:-1] + ', "v_c": 0.1}',  # A key twice: who is to say which counts?
    '{"sent": 1, "ask": "stop", "ask": "reset"}',
]

NO_NUMBERS = ["NaN", "Infinity", "-Infinity", "true", '"0.5"', "null", "[0.5]", "{}"]


@pytest.mark.parametrize("message", MALFORMED)
def test_what_no_page_of_ours_says_closes_the_socket(drive, message):
    assert drive.closes(message) == 1008


def test_what_is_no_text_closes_the_socket(drive):
    # By WebSocket's own rules, before it is a message of ours.
    with drive.connect() as page:
        page.recv(timeout=10)
        page.socket.sendall(bytes([0x81, 0x84, 0, 0, 0, 0]) + b"\xff\xfe\xc3\x28")
        assert drive.closed(page) == 1007


@pytest.mark.parametrize("size", [513, 65_000, 1_000_000])
@pytest.mark.parametrize("kind", [str, bytes])
def test_message_that_is_too_long_closes_the_socket(drive, size, kind):
    message = " " * size
    code = drive.closes(message if kind is str else message.encode())
    assert code == (1008 if kind is bytes and size == 513 else 1009)


@pytest.mark.parametrize("size", [0, 1, 1000])
def test_message_without_an_end_closes_the_socket(drive, size):
    mask, began = bytes(4), time.monotonic()
    head = bytes([0x80 | size]) if size < 126 else b"\xfe" + size.to_bytes(2)
    rest = head + mask + b"x" * size
    with drive.connect() as page:
        with contextlib.suppress(OSError):
            page.socket.sendall(b"\x01" + rest)
            while time.monotonic() < began + 10.0:
                page.socket.sendall((b"\x00" + rest) * 200)
        assert drive.closed(page)
    assert time.monotonic() < began + 10.0


@pytest.mark.parametrize("value", NO_NUMBERS)
def test_what_is_no_number_never_is_a_command(drive, operator, value):
    operator.moves()
    operator.send(words(sequence=2**52).replace('"v_c": 0.5', f'"v_c": {value}'))
    operator.until(lambda _: operator.closed, "it is closed")
    assert operator.closed == 1008
    drive.rests()


@pytest.mark.parametrize(
    ("value", "why"),
    [
        (1e999, "not finite"),
        (-1e999, "not finite"),
        (1e308, "out of range"),
        (-1.5, "out of range"),
        (10**300, "out of range"),
    ],
)
def test_number_that_is_out_of_range_never_is_a_command(operator, value, why):
    said = json.dumps(value).replace("Infinity", "1e999")
    seen, ended = set(), time.monotonic() + 20.0
    while not any(why in text for text in seen):  # A busy machine may be late for it.
        assert time.monotonic() < ended, seen
        operator.holds = True
        operator.drives()
        operator.holds = None  # Says no more of itself.
        for _ in range(8):
            operator.sequence += 1
            now = {"sequence": operator.sequence, "sent": time.monotonic()}
            message = words(**now, ahead=0.0)
            operator.send(message.replace('"v_c": 0.5', f'"v_c": {said}'))
            seen.add(operator.state["text"])
            time.sleep(1 / 30)
    operator.rests()


@pytest.mark.parametrize(
    "changes",
    [
        {"__proto__": {"v_c": 1}},
        {"constructor": 1},
        {"toString": 1},
        {"dead_man": 1},
        {"dead_man": "true"},
        {"sequence": -1},
        {"sequence": 1.5},
        {"sequence": 2**60},
        {"sent": None},
        {"drag": {"body": "link1", "point": [0, 0, 0], "to": [0, 0, 0]}},
    ],
)
def test_what_no_input_has_closes_the_socket(drive, changes):
    assert drive.closes(words(**changes)) == 1008


@pytest.mark.parametrize(
    "lies",
    [
        {"sequence": 3},
        {"sent": -1000.0},
        {"sent": 1e9, "ahead": 0.0},
        {"ahead": 1000.0},
    ],
    ids=str,
)
def test_what_is_replayed_or_of_a_wrong_clock_does_not_drive(drive, operator_of, lies):
    with operator_of(drive) as operator:
        operator.drives()
        operator.holds = None
        ended = time.monotonic() + 1.5
        while time.monotonic() < ended:
            now = {"sent": lies["sent"] + time.monotonic()} if "sent" in lies else {}
            fresh = {"ahead": -now["sent"]} if lies.get("ahead") == 0.0 else {}
            operator.state["arming"] = ARMED  # Whatever it is told.
            operator.holds = True
            operator.say(**lies | now | fresh)
            operator.holds = None
            time.sleep(1 / 30)
        operator.rests()
        assert "no recent input" in operator.state["text"]


# --- Who says it ---------------------------------------------------------------------


def pressed(what, **more):
    return json.dumps({"ask": what, "sent": time.monotonic(), "ahead": 0.0} | more)


def test_who_watches_changes_nothing(drive, operator):
    operator.drives()
    choice = operator.state["choice"]
    with drive.connect() as page, operator.drives_on():
        for what in ("reset", "record", "end_record", "hand_over"):
            page.send(pressed(what))
        page.send(pressed("choose", choice="exact"))
        for k in range(20):
            page.send(words(sequence=k + 10**6, sent=time.monotonic(), ahead=0.0))
        time.sleep(1.0)
    assert operator.state["choice"] == choice
    assert operator.state["role"] == "you"
    assert operator.state["recording"] == ""
    assert operator.state["time"] > 1.0


def test_forty_changes_of_hands_leave_one_operator_and_the_robot_at_rest(drive):
    def roles():
        now = time.monotonic() + 0.1  # By then, what was pressed is done.
        states = [told_after(page, now) for page in pages]
        return [state["role"] for state in states], states[0]

    with drive.connect() as one, drive.connect() as two, drive.connect() as three:
        pages = [one, two, three]
        for turn in range(40):
            for page in pages:  # All at once, whoever has it.
                page.send(pressed("take"))
            pages[turn % 3].send(pressed("hand_over"))
            seen, state = roles()
            assert seen.count("you") <= 1
            assert state["arming"] != ARMED
        until_one_drives = time.monotonic() + 10.0
        while roles()[0].count("you") != 1:
            assert time.monotonic() < until_one_drives
            for page in pages:
                page.send(pressed("take"))


def told_after(page, moment):
    """Returns what a page is told after some moment."""
    for _ in range(400):
        state = json.loads(page.recv(timeout=10))
        if state["clock"] > moment:
            return state
    raise AssertionError("it is not told")


def test_silent_operator_keeps_nobody_from_the_stick(drive):
    with drive.connect() as silent, drive.connect() as other:
        states = []

        def role(page):
            states.append(json.loads(page.recv(timeout=10)))
            return states[-1]["role"]

        assert role(silent) == "you"
        other.send(pressed("take"))
        assert role(other) == "another"
        ended = time.monotonic() + 10.0
        while role(other) != "you":
            assert time.monotonic() < ended
            other.send(pressed("take"))
            time.sleep(0.1)
        assert states[-1]["arming"] != ARMED


# --- To NiceGUI, which has laid out the page -----------------------------------------

PAGE = {
    "client_id": "4ffc9028-6c02-479d-b6d2-5cb0f5ea5081",
    "document_id": "5ecca23b-cd9f-4f96-91e5-2d989a502160",
    "tab_id": "e3871365-d2ed-41d2-9db1-942ae8639b1d",
    "old_tab_id": "null",
    "next_message_id": "0",
    "implicit_handshake": "true",
    "EIO": "4",
    "transport": "websocket",
}


def layout(**changes):
    """Returns where NiceGUI's script in a page connects to."""
    query = {key: x for key, x in (PAGE | changes).items() if x is not None}
    return f"/_nicegui_ws/socket.io/?{urlencode(query, doseq=True)}"


TO_LAYOUT = [
    *("", "x", "9", "4", "42", "42[", "42[]", "42{}", "42[1]", '42["x"]', "2x", "6"),
    *('42["log",{}]', '42["event",{}]', '42["event",7]', '42["handshake",{}]'),
    *(
        '42["ack"]',
        '42["ack",{}]',
        '42["ack",{"client_id":{}}]',
        '42["ack",' + "[" * 900,
    ),
    *('42["javascript_response",{"request_id":1}]', "45-", "451-[", "43[]", "4399[]"),
    *('40{"a":', "40/evil,", "41/x", "b4AAAA", b"\x00\xff", b"4", "42" + "9" * 5000),
    '42["log",{"client_id":"{id}","level":"error","message":"\x1b[31mevil"}]',
    '42["log",{"client_id":"{id}","level":"__class__","message":"x"}]',
    '42["event",{"client_id":"{id}","id":0,"listener_id":"x","args":[]}]',
    '42["ack",{"client_id":"{id}","next_message_id":"x"}]',
    '42["ack",{"client_id":"{id}","next_message_id":[]}]',
    '42["handshake",{"client_id":"{id}","tab_id":{},"document_id":"x"}]',
]


@pytest.fixture(scope="module")
def client(shared):
    """What NiceGUI calls a page that is open, as whoever opens it is told."""
    return re.search(rb"'client_id': '([\w-]+)'", shared.ask("/").body)[1].decode()


def hears_out(drive, *messages, **changes):
    """Says things to NiceGUI, as a page; returns the code by which that is closed."""
    with drive.connect(layout(**changes)) as socket:
        try:
            for message in messages:
                socket.send(message)
            for _ in range(10):
                socket.recv(timeout=1.0)
        except ConnectionClosed as closed:
            return closed.rcvd and closed.rcvd.code
        except TimeoutError:
            return None
    return None


@pytest.mark.parametrize("message", TO_LAYOUT)
def test_layout_hears_nothing_but_that_its_page_is_there(drive, client, message):
    if isinstance(message, str):
        message = message.replace("{id}", client)
    for greeting in ([], ["40"]):
        assert hears_out(drive, *greeting, message, client_id=client) == 1008


def test_page_is_heard_by_its_layout(drive, client):
    ack = json.dumps({"client_id": client, "next_message_id": 0})
    assert hears_out(drive, "40", f'42["ack",{ack}]', "3", client_id=client) is None


@pytest.mark.parametrize(
    "changes",
    [
        {"client_id": None},
        {"client_id": "\x1b[31m"},
        {"tab_id": None},
        {"document_id": ["x" * 100]},
        {"next_message_id": "x"},
        {"next_message_id": None},
        {"EIO": "3"},
        {"transport": "polling"},
        {"sid": "x"},
        {"transport": None},
    ],
    ids=str,
)
def test_layout_of_nobody_is_refused(drive, changes):
    assert drive.refuses(layout(**changes))
    assert drive.ask(layout(**changes)).status == 404
