"""Which page operates: one drives, the others watch, and any may stop the robot."""

import time
from collections.abc import Callable
from pathlib import Path

from drake_mobman.console.latency import LatencyBound
from drake_mobman.console.messages import ButtonPress, MessageRateLimit, parse_message
from drake_mobman.console.session import LiveSession
from drake_mobman.terminal import visible

IDLE_TIMEOUT = 2.0
"""After this time without input, another page may take the stick without asking [s]."""

MAX_PRESS_LATENCY = 1.0
"""Largest latency of a button press [s]; a later one has no effect."""


class Page:
    """A page that is open somewhere.

    Args:
        clock: monotonic wall clock [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.rate_limit = MessageRateLimit(clock)
        self.latency = LatencyBound(clock)
        self.notice = ""  # Shown on the page, in one line.


class OperatorArbiter:
    """Receives the messages of all pages, and passes the operator's on to the session.

    The first page operates. A page that opens later watches until it takes the stick,
    which the operator has to hand over, or has not used for a while. At each change of
    operator the robot stops, and must be armed again. All calls come from one thread.

    Args:
        session: that is driven.
        new_folder: returns the folder for the next recording.
        clock: monotonic wall clock [s].
    """

    def __init__(
        self,
        session: LiveSession,
        new_folder: Callable[[], Path],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._session = session
        self._new_folder = new_folder
        self._clock = clock
        self._last_input = clock()
        self._largest = session.scenario.guard.largest
        self.pages: list[Page] = []
        self.operator: Page | None = None
        self.handover_requested = False  # Whether another page wants the stick.

    def join(self) -> Page:
        """Returns a page that has just been opened."""
        page = Page(self._clock)
        if not self.pages:
            self._set_operator(page)
        self.pages.append(page)
        return page

    def leave(self, page: Page) -> None:
        """Removes a page that was closed; if it was the operator's, the robot stops."""
        self.pages.remove(page)
        if page is self.operator:
            self._set_operator(None)

    def role(self, page: Page) -> str:
        """Returns who drives, as the page sees it: "you", "another" or "nobody"."""
        if self.operator is None:
            return "nobody"
        return "you" if page is self.operator else "another"

    def receive(self, page: Page, message: str | bytes) -> None:
        """Takes in a page's message; one that the page may not send changes nothing.

        Raises:
            MessageError: where no page of ours sends such a message, or so many.
        """
        page.rate_limit.count()
        parsed = parse_message(message, self._largest, self._session.draggable)
        latency = page.latency.of(parsed.sent, parsed.offset)
        if isinstance(parsed.content, ButtonPress):
            self._handle(page, parsed.content, latency)
        elif page is self.operator:
            self._last_input = self._clock()
            self._session.send(parsed.content, latency)

    def _handle(self, page: Page, press: ButtonPress, latency: float) -> None:
        page.notice = ""
        operates = page is self.operator
        if press.action == "stop":  # However late.
            self._session.stop("the operator" if operates else "a viewer")
        elif latency > MAX_PRESS_LATENCY:
            page.notice = "that arrived too late; press again"
        elif press.action == "take":
            self._take_stick(page)
        elif not operates:
            page.notice = "only the operator may do that"
        else:
            self._operate(page, press)

    def _take_stick(self, page: Page) -> None:
        idle = self._clock() - self._last_input > IDLE_TIMEOUT
        if page is self.operator:
            return
        if self.operator is None or idle:
            self._set_operator(page)
        else:
            self.handover_requested = True
            page.notice = "another page drives; it was asked to hand over"

    def _operate(self, page: Page, press: ButtonPress) -> None:
        """Does what only the operator may do."""
        try:
            match press.action:
                case "hand_over":
                    self._set_operator(None)
                case "reset":
                    self._session.reset()
                case "record":
                    self._session.record(self._new_folder())
                case "end_record":
                    self._session.record(None)
                case "choose":
                    self._session.choose(press.choice)
                case other:
                    raise AssertionError(f"nothing is done for {other!r}")
        except (OSError, ValueError) as error:
            page.notice = visible(" ".join(str(error).split()))

    def _set_operator(self, page: Page | None) -> None:
        """Makes a page the operator, or none; the robot stops."""
        self.operator = page
        self.handover_requested = False
        for other in self.pages:
            other.notice = ""
        self._last_input = self._clock()
        self._session.release()
