"""Names that would be markup, or would be obeyed by a terminal: they are text."""

import json
import logging
import re
import shutil
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest
from playwright.sync_api import sync_playwright
from typer.testing import CliRunner

from drake_mobman.cli.app import app
from drake_mobman.terminal import OneLine, visible

pytestmark = pytest.mark.realtime

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")

in_a_browser = pytest.mark.skipif(not CHROMIUM, reason="there is no Chromium")

FLAGS = [
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update"),
    *("--disable-sync", "--use-gl=angle", "--use-angle=swiftshader"),
    "--enable-unsafe-swiftshader",
]

SCRIPT = "window.parent.ran=1"

NAMES = [
    f"x<img src=x onerror={SCRIPT}>",
    f"<script>{SCRIPT}<&lt;script>",
    f"'\"><svg onload={SCRIPT}>",
    f"{{{{ constructor.constructor('{SCRIPT}')() }}}}",
    "$&\\u003cb\\u003e `${1}` %3Cb%3E",
]

EVIL = "\x1b[31m\x1b]0;owned\x07\x9b31m\r\x7f\u202e\u2066"


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("kwon_1, größer → 3", "kwon_1, größer → 3"),
        ("\x1b[31m", "\\x1b[31m"),
        ("a\r\nb\tc\x07", "a\\r\\nb\\tc\\x07"),
        ("\x9b31m\x7f", "\\x9b31m\\x7f"),
        ("\u202eabc\u2066\u200f", "\\u202eabc\\u2066\\u200f"),
        ("\udcff\u2028", "\\udcff\\u2028"),
        ("[bold]<b>", "[bold]<b>"),
    ],
)
def test_text_is_shown_with_nothing_in_it_that_a_terminal_obeys(text, shown):
    assert visible(text) == shown


def test_every_control_character_is_made_visible():
    for code in [*range(0x20), *range(0x7F, 0xA0), 0x202E, 0x2066, 0xD800, 0xFEFF]:
        assert visible(chr(code)).isascii(), hex(code)
        assert visible(chr(code)).isprintable(), hex(code)


def test_log_is_told_in_single_lines():
    try:
        raise ValueError(f"{EVIL}\nof two lines")
    except ValueError as error:
        info = (ValueError, error, error.__traceback__)
    record = logging.LogRecord("x", 40, "x", 1, "failed: %s", (EVIL,), info)
    line = OneLine().format(record)
    assert line.startswith("mobman: failed: \\x1b[31m")
    assert "ValueError: \\x1b[31m" in line
    assert line.isprintable()


def written(folder, name):
    """Returns a scenario's file of such a name."""
    path = folder / f"{name}.yaml"
    path.write_text("duration: 0.1\n")
    return path


@pytest.mark.parametrize(
    "arguments",
    [
        ("drive", "{folder}/none{evil}", "--port", "0"),
        ("drive", "kwon_1", "--set", "{evil}=1", "--port", "0"),
        ("drive", "kwon_1", "--set", "start.{evil}=1", "--port", "0"),
        ("drive", "kwon_1", "--record", "/dev/null/{evil}", "--port", "0"),
        ("drive", "kwon_1", "--host", "{evil}", "--port", "0"),
        ("run", "{file}", "--out", "{folder}/out{evil}", "--no-figures"),
        ("graph", "{file}", "--out", "{folder}/{evil}.png"),
    ],
)
def test_control_characters_in_names_never_reach_the_terminal(tmp_path, arguments):
    given = {"evil": EVIL, "folder": tmp_path, "file": written(tmp_path, f"x{EVIL}")}
    result = CliRunner().invoke(app, [one.format(**given) for one in arguments])
    shown = result.stdout + result.stderr
    # A long name is told by its ends.
    assert "\\x1b[31m" in shown or "\\u202e" in shown
    for character in set(EVIL) - set("[31m]0;owned"):
        assert character not in shown, repr(character)


# --- In the page ---------------------------------------------------------------------


@pytest.fixture(scope="module")
def browser():
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield browser
        browser.close()


@pytest.mark.browser
@in_a_browser
def test_names_are_text_in_the_page_and_in_the_terminal(
    mobman_drive, tmp_path, browser
):
    # As long as a file's name may be.
    files = [written(tmp_path, "".join(part)) for part in (NAMES[:3], NAMES[3:])]
    for file, record in zip(files, (f"s{NAMES[0]}{EVIL}", f"s{NAMES[2]}"), strict=True):
        look_at(mobman_drive, tmp_path, browser, file, tmp_path / record)


def look_at(mobman_drive, tmp_path, browser, file, folder):
    """Drives what has such names, and looks what the page makes of them."""
    with mobman_drive(file, "--record", folder, cwd=tmp_path) as drive:
        name = visible(file.stem)
        assert drive.line.startswith(f"drive {name} at ")
        assert drive.line.strip().isprintable()
        context = browser.new_context()
        page, errors = context.new_page(), []
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.goto(drive.address)
        page.wait_for_selector("html[data-ready][data-role]")
        page.wait_for_selector("html[data-recording=on]")
        # A title has no two spaces in a row, and none at its ends.
        assert page.title() == " ".join(f"{name} · mobman drive".split())
        assert page.text_content(".fact.name") == name
        shown = f"recording to {visible(str(folder))}"
        assert page.text_content(".fact.recording") == shown
        page.wait_for_timeout(300)
        assert page.evaluate("window.ran") is None
        assert page.locator(".console img, .console svg").count() == 0
        assert errors == []
        context.close()
        assert drive.errors == b""


# --- From another site, in a browser -------------------------------------------------


ATTACK = """
<!doctype html><title>evil</title>
<script>
  const [, target, port] = /^#(.*):(.*)$/.exec(location.hash);
  const url = `http://${target}:${port}/`;
  window.seen = {};
  const note = (what, how) => (seen[what] = String(how));
  for (const mode of ["no-cors", "cors"]) {
    fetch(url, { mode, credentials: "include" })
      .then(async (got) => note(mode, `${got.type} ${(await got.text()).length}`))
      .catch((error) => note(mode, error.name));
  }
  fetch(url, { method: "POST", mode: "no-cors", body: "x" })
    .then((got) => note("post", got.type)).catch((error) => note("post", error.name));
  for (const path of ["drive", "view/"]) {
    const socket = new WebSocket(`ws://${target}:${port}/${path}`);
    socket.onopen = () => note(path, "open");
    socket.onclose = () => (seen[path] ??= "closed");
  }
  const script = document.createElement("script");
  script.src = `${url}static/show.js`;
  script.onload = () => note("script", "loaded");
  script.onerror = () => note("script", "refused");
  document.head.append(script);
  for (let i = 0; i < 300; i++) new Image().src = `${url}?${i}`;
  addEventListener("load", () => {
    const frame = document.createElement("iframe");
    frame.src = url;
    const look = () => note("frames", frame.contentWindow.length);
    frame.onload = () => setTimeout(look, 500);
    document.body.append(frame);
  });
</script>
<body></body>
"""


class Elsewhere(BaseHTTPRequestHandler):
    def do_GET(self):
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.end_headers()
        self.wfile.write(ATTACK.encode())

    def log_message(self, *_):
        pass


@pytest.fixture(scope="module")
def elsewhere():
    """The port of another site."""
    with ThreadingHTTPServer(("127.0.0.1", 0), Elsewhere) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield server.server_address[1]
        server.shutdown()


@pytest.mark.browser
@in_a_browser
@pytest.mark.parametrize("site", ["localhost", "127.0.0.1"])
def test_page_of_another_site_gets_nothing_and_holds_up_nobody(
    drive, operator, browser, elsewhere, site
):
    context = browser.new_context()
    page, answers = context.new_page(), []
    page.on("response", lambda got: answers.append((got.url, got.status)))
    with operator.drives_on():
        page.goto(f"http://{site}:{elsewhere}/#127.0.0.1:{drive.port}")
        page.wait_for_function("Object.keys(seen).length == 7", timeout=30_000)
        page.wait_for_timeout(1500)
    seen = page.evaluate("seen")
    assert seen["cors"] == "TypeError"
    assert seen["no-cors"] in {"opaque 0", "TypeError"}
    assert {seen["drive"], seen["view/"]} == {"closed"}
    assert seen["script"] == "refused"
    assert seen["frames"] == "0"  # Ours would have one inside.
    own = re.compile(rf"http://127\.0\.0\.1:{drive.port}/")
    assert {status for url, status in answers if own.match(url)} <= {403}
    context.close()


@pytest.mark.browser
@in_a_browser
def test_link_on_another_site_opens_the_page(drive, browser, elsewhere):
    context = browser.new_context()
    page = context.new_page()
    page.goto(f"http://localhost:{elsewhere}/#localhost:1")
    page.evaluate(f"location = 'http://127.0.0.1:{drive.port}/'")
    page.wait_for_selector("html[data-ready][data-role]")
    context.close()


@pytest.mark.browser
@in_a_browser
def test_gamepad_that_cannot_be_used_is_told_of(drive, browser):
    context = browser.new_context()
    page = context.new_page()
    page.goto(drive.address)
    page.wait_for_selector("html[data-ready][data-role]")
    name = f"Odd <b>Stick</b> {NAMES[0]}"
    page.evaluate(
        """(id) => {
            const odd = { connected: true, mapping: "", axes: [0, -1], id };
            odd.buttons = [{ value: 1, pressed: true }];
            window.odd = odd;
            navigator.getGamepads = () => [null, odd];
        }""",
        name,
    )
    why = f"{name} is not used: this browser does not know its axes"
    page.wait_for_function(
        "(why) => document.querySelector('.notice').textContent === why", arg=why
    )
    assert json.loads(page.evaluate("JSON.stringify(window.ran ?? null)")) is None
    page.evaluate("odd.connected = false")
    page.wait_for_function("document.querySelector('.notice').textContent === ''")
    context.close()
