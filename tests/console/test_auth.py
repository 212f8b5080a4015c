"""Who is let in: by token, by host and by origin."""

import asyncio

import pytest

from drake_mobman.console.addresses import is_loopback
from drake_mobman.console.auth import COOKIE, AuthMiddleware

OWN = "127.0.0.1:8080"


async def inside(scope, _receive, send):
    """An app that greets whoever gets in."""
    if scope["type"] == "websocket":
        await send({"type": "websocket.accept"})
    else:
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": b"in"})


def asked(app, kind="http", query="", host=OWN, client="192.168.1.9", **headers):
    """Returns the app's answer: a status, or whether a socket opens; and headers."""
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

    asyncio.run(app(scope, receive, send))
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
    app = AuthMiddleware(inside)
    assert asked(app, "websocket", origin=f"http://{OWN}")[0]
    for origin in ("http://evil.example", "http://127.0.0.1:9999", "null", ""):
        assert not asked(app, "websocket", origin=origin)[0]
    assert not asked(app, "websocket")[0]
    assert asked(app, origin="http://evil.example")[0] == 403
    assert asked(app)[0] == 200


def test_name_that_leads_here_is_not_this_server():
    app = AuthMiddleware(inside)
    assert asked(app, host="evil.example")[0] == 403
    assert asked(app, host="")[0] == 403
    for host in ("localhost:9999", "[::1]:8080", "127.0.0.1"):
        assert asked(app, host=host)[0] == 200


@pytest.mark.parametrize("token", [None, "secret"])
@pytest.mark.parametrize("kind", ["http", "websocket"])
def test_host_or_origin_that_is_none_is_refused_as_a_wrong_one(kind, token):
    app, known = AuthMiddleware(inside, token), {}
    if token:
        shown = asked(app, query="token=secret")[1]
        known = {"cookie": shown["set-cookie"].partition(";")[0]}
    for wrong in ({"host": "["}, {"origin": "http://["}, {"origin": "http://[v]/"}):
        assert asked(app, kind, **known, **wrong)[0] in {403, False}


def test_beyond_this_machine_a_token_is_asked_for_and_remembered():
    app = AuthMiddleware(inside, "secret", 8080)
    there = {"host": "192.168.1.5:8080"}
    assert asked(app, **there)[0] == 403
    for wrong in ("wrong", "", "s%C3%A9cret", "secret2"):
        assert asked(app, query=f"token={wrong}", **there)[0] == 403
        assert asked(app, cookie=f"{COOKIE}_8080={wrong}", **there)[0] == 403
    status, headers = asked(app, query="token=secret", **there)
    assert (status, headers["location"]) == (303, "/")
    cookie = headers["set-cookie"].lower()
    assert "httponly" in cookie
    # One who follows a link from another site is remembered, too.
    assert "samesite=lax" in cookie
    known = there | {"cookie": headers["set-cookie"].partition(";")[0]}
    own = {"origin": "http://192.168.1.5:8080"}
    assert asked(app, **known)[0] == 200
    assert asked(app, "websocket", **known, **own)[0]
    assert not asked(app, "websocket", **there, **own)[0]
    # Neither does the token alone let in a socket: only the page is opened by it.
    assert not asked(app, "websocket", query="token=secret", **there, **own)[0]
    assert not asked(app, "websocket", **known, origin="http://evil.example")[0]
    # What servers at other ports are told is worth nothing to them.
    assert "secret" not in known["cookie"]
    assert asked(app, **known, client="192.168.1.66")[0] == 403
    assert asked(AuthMiddleware(inside, "secret", 8081), **known)[0] == 403


def test_pages_are_shown_in_no_other_sites_frame_and_load_nothing_from_elsewhere():
    policy = asked(AuthMiddleware(inside))[1]["content-security-policy"]
    assert "frame-ancestors 'self'" in policy
    assert policy.startswith("default-src 'self'")
