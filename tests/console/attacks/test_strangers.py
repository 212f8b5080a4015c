"""Strangers at the door: other sites' pages in the operator's browser, and guessers."""

import contextlib
import threading
import time

import pytest

from drake_mobman.console.auth import AuthMiddleware

pytestmark = pytest.mark.realtime

SOCKETS = [
    *("/drive", "/view/"),
    "/_nicegui_ws/socket.io/?EIO=4&transport=websocket&client_id=c&tab_id=t"
    "&document_id=d&next_message_id=0",
]

ELSEWHERE = {
    "Sec_Fetch_Site": "cross-site",
    "Sec_Fetch_Mode": "no-cors",
    "Sec_Fetch_Dest": "image",
    "Referer": "http://evil.example/",
}
"""What a browser says of a request that another site's page makes for a picture."""

LINK = ELSEWHERE | {"Sec_Fetch_Mode": "navigate", "Sec_Fetch_Dest": "document"}
"""The same where a person follows a link."""

HOSTS = [
    *("evil.example", "evil.example:{port}", "localhost.evil.example:{port}"),
    *("127.0.0.1.evil.example", "127.0.0.1@evil.example", "evil.example@127.0.0.1"),
    *("evil.example#127.0.0.1", "evil.example/127.0.0.1", "evil.example\\@127.0.0.1"),
    *("0.0.0.0:{port}", "192.168.1.5:{port}", "[::]:{port}", "[::ffff:8.8.8.8]"),
    *("127.0.0.1:{port}:80", "127.0.0.1:x", ""),
]
"""What a name that leads here, or one who means no good, says that this server is."""

ORIGINS = [
    *("http://evil.example", "http://127.0.0.1:{other}", "http://localhost:{other}"),
    *(
        "null",
        "",
        "http://127.0.0.1",
        "file://",
        "http://127.0.0.1:{port}.evil.example",
    ),
    *("http://evil.example@127.0.0.1:{port}", "http://[", None),
]

PATHS = [
    *("/../etc/passwd", "/static/../../etc/passwd", "/static/..%2f..%2fetc/passwd"),
    *("/static/%2e%2e/%2e%2e/auth.py", "/static//etc/passwd", "/static/....//auth.py"),
    *("/static/..%5c..%5cauth.py", "/static/%00", "/static/console.js%00.css"),
    *("/view/../../etc/passwd", "/view/..%2f..%2fetc%2fpasswd", "/view//evil.example/"),
    *("/view/http://evil.example/", "/view/@evil.example/", "/view/%2f%2fevil.example"),
    *("/view/%0d%0aX-Evil:%201", "/%0d%0aSet-Cookie:%20evil=1", "/%1b%5b31m"),
    *("//evil.example/", "http://evil.example/", "/_nicegui/../../etc/passwd"),
    *("/openapi.json", "/static/%ff%fe"),
]


@pytest.mark.parametrize("path", ["/", *SOCKETS])
def test_name_that_leads_here_is_not_this_server(drive, path):
    assert len(HOSTS) == 16
    for host in HOSTS:
        host = host.format(port=drive.port)  # noqa: PLW2901
        upgrade = {
            "Host": host,
            "Origin": f"http://{host}",
            "Connection": "Upgrade",
            "Upgrade": "websocket",
            "Sec_WebSocket_Version": "13",
            "Sec_WebSocket_Key": "dGhlIHNhbXBsZSBub25jZQ==",
        }
        asked = {"Host": host} if path == "/" else upgrade
        assert drive.ask(path, **asked).status in {400, 403}, host


@pytest.mark.parametrize("path", SOCKETS)
def test_socket_is_opened_from_no_other_origin(drive, path):
    for origin in ORIGINS:
        if origin:
            origin = origin.format(port=drive.port, other=drive.port + 1)  # noqa: PLW2901
        assert drive.refuses(path, origin=origin), origin
    with drive.connect(path):
        pass


def test_no_page_of_ours_is_shown_or_read_or_posted_to_by_another(drive):
    page = drive.ask("/")
    assert page.status == 200
    assert "frame-ancestors 'self'" in page.headers["content-security-policy"]
    assert page.headers["cross-origin-resource-policy"] == "same-origin"
    assert page.headers["cross-origin-opener-policy"] == "same-origin"
    assert page.headers["x-content-type-options"] == "nosniff"
    assert "access-control-allow-origin" not in page.headers
    for path in ("/", "/drive", "/view/", "/_nicegui_ws/socket.io/?EIO=4"):
        for method in ("POST", "PUT", "DELETE", "OPTIONS", "TRACE", "CONNECT"):
            assert drive.ask(path, method).status in {400, 403, 405}, (method, path)
        assert drive.ask(path, Origin="http://evil.example").status == 403


def test_what_another_site_makes_the_browser_ask_for_is_refused(drive):
    for dest in ("image", "script", "style", "iframe", "object", "embed", "empty"):
        for site in ("cross-site", "same-site"):
            asked = ELSEWHERE | {"Sec_Fetch_Site": site, "Sec_Fetch_Dest": dest}
            for mode in ("no-cors", "cors", "navigate"):
                for path in ("/", "/static/console.js", "/view/", "/nothing"):
                    answer = drive.ask(path, **asked | {"Sec_Fetch_Mode": mode})
                    assert answer.status == 403, (asked, path)
    # A link to the page may be followed, and what it loads is its own.
    assert drive.ask("/", **LINK).status == 200
    assert drive.ask("/static/console.js", **LINK).status == 403
    assert (
        drive.ask("/", Sec_Fetch_Site="none", Sec_Fetch_Mode="navigate").status == 200
    )
    assert drive.ask("/static/keys.js", Sec_Fetch_Site="same-origin").status == 200


@pytest.mark.parametrize("asked", [ELSEWHERE, LINK], ids=["pictures", "links"])
def test_hundreds_of_requests_of_another_site_are_refused_at_once(
    drive, operator, asked
):
    drive.ask("/", **asked)
    before, answers = drive.memory, []

    def attack(ended):
        while time.monotonic() < ended:
            began = time.monotonic()
            answer = drive.ask(f"/?{began}", **asked)
            answers.append((answer.status, time.monotonic() - began))
            time.sleep(0.05)

    with operator.drives_on():
        # As many at once as a browser has connections to a host.
        ended = time.monotonic() + 3.0
        threads = [threading.Thread(target=attack, args=[ended]) for _ in range(6)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert len(answers) > 112
    refused = [status for status, _ in answers if status in {403, 429}]
    assert len(refused) > 0.8 * len(answers)
    assert drive.memory < before + 15.0


def test_no_path_leads_out_or_is_said_in_the_terminal(drive):
    assert len(PATHS) == 23
    for path in PATHS:
        answer = drive.ask(path)
        assert answer.status in {307, 400, 403, 404}, path
        assert answer.status != 307 or answer.headers["location"].startswith(
            f"http://{drive.own}/"
        )
        assert not {"x-evil", "set-cookie"} & answer.headers.keys()
        assert b"root:" not in answer.body
        assert b"hmac" not in answer.body
    assert drive.errors == b""


def test_control_characters_never_reach_the_terminal(drive):
    for character in ("%1b%5b31m", "%07", "%9b31m", "%c2%9b31m", "%e2%80%ae", "%7f"):
        for path in ("/{}", "/static/{}", "/_nicegui/{}", "/view/{}", "/?x={}"):
            drive.ask(path.format(character))
        drive.ask("/", Host=f"{character}.example")
        drive.ask("/", "GET\x1b")
        drive.says(b"\x1b[31m\r\n\r\n")
        drive.refuses(f"/{character}")
    assert drive.errors == b""


# --- The token -----------------------------------------------------------------------


def cookie_of(answer):
    """Returns what a browser says again of the cookie that it was given."""
    return answer.headers["set-cookie"].partition(";")[0]


def test_token_is_not_told(afar):
    shown = afar.ask(f"/?token={afar.token}")
    assert (shown.status, shown.headers["location"]) == (303, "/")
    known = {"Cookie": cookie_of(shown)}
    page = afar.ask("/", **known)
    assert page.status == 200
    # Not by a link that is followed from it, nor by the cookie, which servers at other
    # ports of this machine are told as well.
    assert page.headers["referrer-policy"] == "no-referrer"
    assert shown.headers["referrer-policy"] == "no-referrer"
    for told in (page.body.decode(), str(page.headers), str(shown.headers)):
        assert afar.token not in told
    assert afar.token.encode() not in afar.errors
    # Each time it leaves the address bar, also with what else is said there.
    for asked in ("/?token={}", "/?x=1&token={}", "/static/keys.js?token={}"):
        answer = afar.ask(asked.format(afar.token), **known)
        assert (answer.status, answer.headers["location"]) == (303, "/")
    assert afar.ask("/?token=wrong", **known).headers["location"] == "/"


@pytest.mark.parametrize(
    "path", ["//evil.example/", "/\\evil.example/", "//evil.example/%2f..", "///x"]
)
def test_who_shows_the_token_stays_here(afar, path):
    answer = afar.ask(f"{path}?token={afar.token}")
    assert answer.status in {303, 400, 404}
    assert answer.headers.get("location", "/") == "/"


def test_cookie_is_of_one_port_and_of_one_address(afar):
    cookie = cookie_of(afar.ask(f"/?token={afar.token}"))
    name, _, value = cookie.partition("=")
    assert str(afar.port) in name
    # One of another session beside it, before or after, evicts nothing.
    for both in (f"mobman_token_1=x; {cookie}", f"{cookie}; mobman_token=x"):
        assert afar.ask("/", Cookie=both).status == 200
    for wrong in (f"mobman_token={value}", f"{name}={afar.token}", f"{name}="):
        assert afar.ask("/", Cookie=wrong).status == 403


def test_token_is_asked_for_everywhere(afar):
    cookie = cookie_of(afar.ask(f"/?token={afar.token}"))
    for path in SOCKETS:
        assert afar.refuses(path)
        assert afar.refuses(path, additional_headers={"Cookie": "mobman_token=x"})
        joint = "&" if "?" in path else "?"
        assert afar.refuses(f"{path}{joint}token={afar.token}")
        with afar.connect(path, additional_headers={"Cookie": cookie}):
            pass
    for path in ("/", "/static/keys.js", "/view/", "/favicon.ico", "/_nicegui_ws/"):
        assert afar.ask(path).status == 403


def test_wrong_tokens_get_slow_and_who_knows_it_is_not_kept_waiting(afar):
    answers = []

    def guess(ended):
        while time.monotonic() < ended:
            with contextlib.suppress(OSError):
                asked = f"/?token=guess{len(answers)}"
                answers.append(afar.ask(asked, timeout=ended + 0.5 - time.monotonic()))

    ended = time.monotonic() + 3.0
    threads = [threading.Thread(target=guess, args=[ended]) for _ in range(20)]
    for thread in threads:
        thread.start()
    time.sleep(1.5)
    began = time.monotonic()
    cookie = cookie_of(afar.ask(f"/?token={afar.token}"))
    assert afar.ask("/static/keys.js", Cookie=cookie).status == 200
    assert time.monotonic() - began < 1.0
    for thread in threads:
        thread.join()
    answered = [answer.status for answer in answers if answer.status]
    assert set(answered) <= {403}
    # Some at once, as a person errs; then one a second.
    assert len(answered) < 15


def test_wrong_token_takes_as_long_whatever_of_it_is_right():
    token = "x" * 2_000_000  # So long that even copying it would show.
    door = AuthMiddleware(None, token)

    def takes(guess):
        began = time.perf_counter()
        assert not door.is_token(guess)
        return time.perf_counter() - began

    guesses = ["y" + token[1:], token[:-1] + "y"]
    first, last = map(min, zip(*(map(takes, guesses) for _ in range(30)), strict=True))
    # Where they are compared up to the first difference, it is a thousandth.
    assert first > 0.2 * last
