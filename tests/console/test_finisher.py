"""The process that completes recordings: one, and each is answered for."""

import os
import signal
import time
from contextlib import suppress
from pathlib import Path

from drake_mobman.console.finisher import Finisher

PATIENCE = 60.0
"""Of a test that waits for what is to happen at once [s]."""


def heard(finisher):
    """Waits until it has been told of all folders; returns those that failed."""
    end = time.monotonic() + PATIENCE
    while finisher.works:
        assert time.monotonic() < end
        time.sleep(0.01)
        finisher.hear()
    return finisher.failed


def children():
    """Returns the processes that this one has started and that run."""
    found = set()
    for task in Path("/proc/self/task").glob("*/children"):
        with suppress(OSError):  # A thread that has ended meanwhile.
            found |= set(map(int, task.read_text().split()))
    return found


def test_finisher_that_is_killed_fails_what_it_was_given_and_another_takes_over(
    tmp_path,
):
    finisher, before = Finisher(), children()
    for name in ("one", "two"):
        finisher.give(tmp_path / name, 1.0, "")
    (pid,) = children() - before
    os.kill(pid, signal.SIGKILL)
    assert heard(finisher) == [
        f"{tmp_path}/{name}: recorded, but not completed: its process ended with "
        "status -9"
        for name in ("one", "two")
    ]
    finisher.give(tmp_path / "\udcff\n{}", 1.0, "")
    last = heard(finisher)[-1]
    assert last.startswith(f"{tmp_path}/\udcff\n{{}}: recorded, but not completed: ")
    assert "FileNotFoundError" in last
    end = time.monotonic() + PATIENCE
    while children() - before:  # Nobody waits for more.
        assert time.monotonic() < end
        time.sleep(0.01)


def test_process_that_cannot_be_had_is_told_of(tmp_path, monkeypatch):
    def none_left(*_args, **_options):
        raise OSError(24, "Too many open files")

    monkeypatch.setattr("subprocess.Popen", none_left)
    finisher = Finisher()
    finisher.give(tmp_path, 1.0, "")
    (line,) = heard(finisher)
    assert line.endswith("not completed: [Errno 24] Too many open files")
