"""A progress bar in the terminal."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from drake_mobman.cli.messages import errors


@contextmanager
def progress_bar(
    name: str, total: float, unit: str = " s"
) -> Iterator[Callable[[float], None]]:
    """Shows a bar on the standard error while its body runs, if that is a terminal.

    A terminal that has gone ends nothing.

    Args:
        name: what is shown before the bar.
        total: how much there is to do.
        unit: of `total`, with a space before it.

    Yields:
        A function that takes how much is done.
    """
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn(f"{{task.completed:.0f}} of {{task.total:.0f}}{unit}"),
        TimeRemainingColumn(),
    )
    shown = errors.is_terminal
    bar = Progress(*columns, console=errors, disable=not shown, transient=True)
    with suppress(OSError):
        bar.start()
    task = bar.add_task(name, total=total)

    def update(completed: float) -> None:
        with suppress(OSError):
            bar.update(task, completed=completed)

    try:
        yield update
    finally:
        with suppress(OSError):
            bar.stop()
