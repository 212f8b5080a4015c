"""What Drake complains about while it reads a model, collected."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager


class _Collector(logging.Handler):
    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.messages: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.messages.append(record.getMessage())


@contextmanager
def collected_complaints() -> Iterator[list[str]]:
    """Keeps Drake's log inside the `with` statement quiet; yields its warnings."""
    log, collector = logging.getLogger("drake"), _Collector()
    before = log.handlers[:], log.propagate, log.level
    log.handlers[:], log.propagate = [collector], False
    log.setLevel(logging.WARNING)
    try:
        yield collector.messages
    finally:
        log.handlers[:], log.propagate = before[:2]
        log.setLevel(before[2])
