"""The process that completes recordings: one, and each is answered for."""

import os
import signal
import time
from contextlib import suppress
from pathlib import Path

from drake_mobman.console.post_processor import PostProcessor

PATIENCE = 60.0
"""Of a test that waits for what is to happen at once [s]."""


def finished(processor):
    """Waits until it has answered for all folders; returns those that failed."""
    end = time.monotonic() + PATIENCE
    while processor.busy:
        assert time.monotonic() < end
        time.sleep(0.01)
        processor.poll()
    return processor.failed


def children():
    """Returns the processes that this one has started and that run."""
    found = set()
    for task in Path("/proc/self/task").glob("*/children"):
        with suppress(OSError):  # A thread that has ended meanwhile.
            found |= set(map(int, task.read_text().split()))
    return found


def test_process_that_is_killed_fails_what_it_was_given_and_another_takes_over(
    tmp_path,
):
    processor, before = PostProcessor(), children()
    for name in ("one", "two"):
        processor.submit(tmp_path / name, 1.0, "")
    (pid,) = children() - before
    os.kill(pid, signal.SIGKILL)
    assert finished(processor) == [
        f"{tmp_path}/{name}: recorded, but not completed: its process ended with "
        "status -9"
        for name in ("one", "two")
    ]
    processor.submit(tmp_path / "\udcff\n{}", 1.0, "")
    last = finished(processor)[-1]
    assert last.startswith(f"{tmp_path}/\udcff\n{{}}: recorded, but not completed: ")
    assert "FileNotFoundError" in last
    end = time.monotonic() + PATIENCE
    while children() - before:  # Nobody waits for more.
        assert time.monotonic() < end
        time.sleep(0.01)


def test_process_that_cannot_be_had_is_reported(tmp_path, monkeypatch):
    def none_left(*_args, **_options):
        raise OSError(24, "Too many open files")

    monkeypatch.setattr("subprocess.Popen", none_left)
    processor = PostProcessor()
    processor.submit(tmp_path, 1.0, "")
    (line,) = finished(processor)
    assert line.endswith("not completed: [Errno 24] Too many open files")
