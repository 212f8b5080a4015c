"""The console's page, laid out by NiceGUI.

The scripts in `static/` find the elements by their class: they send what is done to
them to the session, and show its state.
"""

import json
from collections.abc import Iterator
from contextlib import contextmanager

from nicegui import ui
from nicegui.elements.mixins.text_element import TextElement

from drake_mobman.console.plots import SPAN, plots
from drake_mobman.console.session import LiveSession
from drake_mobman.console.view import CAN_DRAG
from drake_mobman.terminal import visible

_HEAD = '<link rel="stylesheet" href="/static/console.css">'
_BODY = '<script type="module" src="/static/console.js"></script>'


def add_page(name: str, session: LiveSession) -> None:
    """Adds the page of a session at `/`."""

    @ui.page("/")
    def page() -> None:
        ui.add_head_html(_HEAD)
        ui.add_body_html(_BODY)
        with _block("console"):
            _bar(name)
            with _block("stage"):
                with _block("first"):
                    _view()
                    _controls(session)
                _plots(session)


@contextmanager
def _block(class_: str, tag: str = "div", **attributes: str) -> Iterator[ui.element]:
    """Opens an element that others are put in."""
    with _element(class_, tag, **attributes) as element:
        yield element


def _element(class_: str, tag: str = "div", **attributes: str) -> ui.element:
    element = ui.element(tag).classes(class_)
    element.props.update({key.replace("_", "-"): x for key, x in attributes.items()})
    return element


def _text(class_: str, text: str = "", tag: str = "div", **attributes: str) -> None:
    """Adds plain text, never markup: names come from files and the command line."""
    with _block(class_, tag, **attributes):
        TextElement(tag="span", text=visible(text))


def _markup(class_: str, html: str) -> None:
    """Adds our own text, with HTML tags in it."""
    with _block(class_):
        ui.html(html, sanitize=False, tag="span")


def _button(text: str, action: str, title: str, **attributes: str) -> None:
    """Adds a button that sends an action; see `messages.ACTIONS`."""
    _text(
        f"button {action}", text, "button", data_ask=action, title=title, **attributes
    )


def _bar(name: str) -> None:
    """Adds the bar on top: the status, and STOP."""
    with _block("bar"):
        with _block("says"):
            _text("status", "connecting ...", role="status")
            with _block("facts"):
                _text("fact name", name)
                _text("fact role")
                _text("fact time")
                _text("fact ratio", title="Simulated over wall time")
                _text("fact recording")
            _text("notice")
        _button("STOP", "stop", "Stops the robot, whoever drives (Escape)")


def _view() -> None:
    with _block("view"):
        _element("scene", "iframe", src="/view/", title="The robot in 3D")
        _element("still", role="status")  # Why the picture is frozen, if it is.


def _controls(session: LiveSession) -> None:
    with _block("controls"):
        with _block("sticks"):
            _stick("pad", "reach out", "turn")
            _stick("lever", "up", "down")
        with _block("settings"):
            _button("Take the stick", "take", "Drive from this page")
            _button("Hand over", "hand_over", "Let another page drive")
            _button("Reset", "reset", "Start over")
            _button("Record", "record", "Start over and record")
            _button("End recording", "end_record", "End the recording and keep it")
        # No drop-down list: while it is open it takes the keys, and their release.
        with _block("choices"):
            title = "Drive with this controller"
            for choice in session.choices:
                _button(choice, "choose", title, data_choice=choice)
        drags = session.draggable and CAN_DRAG
        _markup("help", _HELP + (_DRAG_HELP if drags else ""))


_HELP = (
    "Hold the pad or the lever to drive, release it to stop. "
    '<span class="keys">Keys: hold <b>Space</b>, steer by arrows or <b>WASD</b>, up and'
    " down by <b>R</b> <b>F</b>, slowly with <b>Shift</b>; <b>Esc</b> stops. "
    "Gamepad: hold a trigger.</span>"
)

_DRAG_HELP = (
    '<span class="keys"> In the picture, <b>Ctrl</b> + drag pulls the arm.</span>'
)


def _stick(name: str, *labels: str) -> None:
    with _block(f"stick {name}", aria_label=" and ".join(labels)):
        _element("knob")


def _plots(session: LiveSession) -> None:
    with _block("plots"):
        for plot in plots(session.scenario, session.signals):
            keys = json.dumps(list(plot.series.values()))
            chart = ui.echart(plot.options()).classes("plot")
            chart.props.update({"data-keys": keys, "data-span": str(SPAN)})
