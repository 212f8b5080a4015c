"""The command `mobman`: its process, before and after what a command does."""

import os
import signal
import sys
from contextlib import suppress
from typing import NoReturn

from drake_mobman.exit_status import BAD_INPUT, DIED, INTERRUPTED
from drake_mobman.output import Output, text_on


def main() -> None:
    """Runs the command line; prints a line if it was interrupted."""
    signal.signal(signal.SIGINT, interrupt)
    try:
        run()
    except KeyboardInterrupt:
        say("interrupted")
        sys.exit(INTERRUPTED)


def interrupt(*_: object) -> NoReturn:
    """Ends the process on Ctrl-C: at once, while nothing could be lost.

    Drake's modules, interrupted while they are imported, raise an error of their own or
    go on. The diagrams are imported after all of them, before anything is run.
    """
    if hasattr(sys.modules.get("drake_mobman.diagrams"), "make_diagram"):
        raise KeyboardInterrupt
    with suppress(OSError):
        os.write(2, b"mobman: interrupted\n")
    os._exit(INTERRUPTED)


def run() -> None:
    """Runs the command line on outputs that may fail."""
    if sys.stderr is not None:
        sys.stderr = text_on(Output(2, "w", closefd=False), sys.stderr)
    if sys.stdout is None:
        # The next file to be opened would get what Drake's solvers print.
        say("the standard output is closed; must be open, if only to /dev/null")
        sys.exit(BAD_INPUT)
    output = Output(1, "w", closefd=False)
    sys.stdout = text_on(output, sys.stdout)
    try:
        os.getcwd()  # Drake needs one, whatever it does.
    except OSError as error:
        say(f"the working folder is gone: {error.strerror}")
        sys.exit(BAD_INPUT)

    from drake_mobman.cli.app import app  # noqa: PLC0415 - After the outputs are set up.

    try:
        app(prog_name="mobman")
    except SystemExit as end:
        sys.stdout.flush()
        if output.error:
            say(f"cannot write to the standard output: {output.error}")
            sys.exit(end.code or DIED)
        raise


def say(message: str) -> None:
    """Prints one line to the standard error, with nothing imported for it."""
    if sys.stderr is not None:
        sys.stderr.write(f"mobman: {message}\n")


if __name__ == "__main__":
    main()
