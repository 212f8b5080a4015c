"""Whose word counts: one page operates, the others watch, and any may stop."""

import time
from collections.abc import Callable
from pathlib import Path

from drake_mobman.console.lateness import Lateness
from drake_mobman.console.messages import Ask, Rate, parsed
from drake_mobman.console.session import LiveSession
from drake_mobman.terminal import visible

SILENT = 2.0
"""After what silence another page may take the stick without being given it [s]."""


LATE = 1.0
"""How late a button may be that was pressed [s]; what comes later is not done."""


class Page:
    """A page that is open somewhere.

    Args:
        clock: the wall's [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.rate = Rate(clock)
        self.lateness = Lateness(clock)
        self.notice = ""  # What it is to be told, in one line.


class OperatorArbiter:
    """Hears all pages, and passes on to the session what counts.

    A page that comes alone operates; one that comes to others watches until it takes
    the stick, which the operator has to hand over, or has not used for a while. With
    each change the robot stops, and is to be armed again. All calls come from one
    thread.

    Args:
        session: that is driven.
        new_folder: where the next recording goes.
        clock: the wall's [s].
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
        self._heard = clock()  # When the operator was.
        self._largest = session.scenario.guard.largest
        self.pages: list[Page] = []
        self.operator: Page | None = None
        self.asked = False  # Whether another page wants the stick.

    def join(self) -> Page:
        """Returns a page that has just been opened."""
        page = Page(self._clock)
        if not self.pages:
            self._seat(page)
        self.pages.append(page)
        return page

    def leave(self, page: Page) -> None:
        """Forgets a page that is gone; if it drove, the robot stops."""
        self.pages.remove(page)
        if page is self.operator:
            self._seat(None)

    def role(self, page: Page) -> str:
        """Returns who drives, as the page sees it: "you", "another" or "nobody"."""
        if self.operator is None:
            return "nobody"
        return "you" if page is self.operator else "another"

    def hear(self, page: Page, message: str | bytes) -> None:
        """Takes in what a page says; what is not for it to say changes nothing.

        Raises:
            MessageError: where no page of ours says such a thing, or so much.
        """
        page.rate.count()
        said, sent, ahead = parsed(message, self._largest, self._session.draggable)
        late = page.lateness.of(sent, ahead)
        if isinstance(said, Ask):
            self._answer(page, said, late)
        elif page is self.operator:
            self._heard = self._clock()
            self._session.tell(said, late)

    def _answer(self, page: Page, ask: Ask, late: float) -> None:
        page.notice = ""
        operates = page is self.operator
        if ask.what == "stop":  # However late.
            self._session.stop("the operator" if operates else "a viewer")
        elif late > LATE:
            page.notice = "that came too late; press again"
        elif ask.what == "take":
            self._take(page)
        elif not operates:
            page.notice = "only who drives may do that"
        else:
            self._obey(page, ask)

    def _take(self, page: Page) -> None:
        silent = self._clock() - self._heard > SILENT
        if page is self.operator:
            return
        if self.operator is None or silent:
            self._seat(page)
        else:
            self.asked = True
            page.notice = "another page drives; it has been asked to hand over"

    def _obey(self, page: Page, ask: Ask) -> None:
        try:
            match ask.what:
                case "hand_over":
                    self._seat(None)
                case "reset":
                    self._session.reset()
                case "record":
                    self._session.record(self._new_folder())
                case "end_record":
                    self._session.record(None)
                case "choose":
                    self._session.choose(ask.choice)
        except (OSError, ValueError) as error:
            page.notice = visible(" ".join(str(error).split()))

    def _seat(self, page: Page | None) -> None:
        """Makes a page the operator, or none; the robot stops."""
        self.operator = page
        self.asked = False
        for other in self.pages:
            other.notice = ""
        self._heard = self._clock()
        self._session.hand_over()
