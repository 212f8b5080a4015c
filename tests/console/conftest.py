"""What tests of the console share."""

import pytest


class Clock:
    """A wall clock that moves only when a test sets it."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()
