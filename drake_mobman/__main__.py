"""The command `mobman`, from its first import to its last word."""

import os
import signal
import sys
from contextlib import suppress
from typing import NoReturn

from drake_mobman.exit_status import BAD_INPUT, DIED, INTERRUPTED
from drake_mobman.output import Output, text_on


def main() -> None:
    """Runs the command line; says so where it was interrupted, or not listened to."""
    signal.signal(signal.SIGINT, interrupt)
    try:
        run()
    except KeyboardInterrupt:
        say("interrupted")
        sys.exit(INTERRUPTED)


def interrupt(*_: object) -> NoReturn:
    """Ends what Ctrl-C is to end: at once, while there is nothing that could be lost.

    Drake's modules, interrupted while they are loaded, take that for their own error,
    or go on. The diagrams are loaded after all of them, and before anything is run.
    """
    if hasattr(sys.modules.get("drake_mobman.diagrams"), "make_diagram"):
        raise KeyboardInterrupt
    with suppress(OSError):
        os.write(2, b"mobman: interrupted\n")
    os._exit(INTERRUPTED)


def run() -> None:
    """Runs the command line on outputs that may go away."""
    if sys.stderr is not None:
        sys.stderr = text_on(Output(2, "w", closefd=False), sys.stderr)
    if sys.stdout is None:
        # The next file to be opened would get what Drake's solvers have to say.
        say("the standard output is closed; must be open, if only to /dev/null")
        sys.exit(BAD_INPUT)
    output = Output(1, "w", closefd=False)
    sys.stdout = text_on(output, sys.stdout)
    try:
        os.getcwd()  # Drake wants to know, whatever it is asked for.
    except OSError as error:
        say(f"the working folder is gone: {error.strerror}")
        sys.exit(BAD_INPUT)

    from drake_mobman.cli.app import app  # noqa: PLC0415 - After all there is to set up.

    try:
        app(prog_name="mobman")
    except SystemExit as end:
        sys.stdout.flush()
        if output.lost:
            say(f"the standard output was not taken: {output.lost}")
            sys.exit(end.code or DIED)
        raise


def say(message: str) -> None:
    """Prints one line to the standard error, without what is yet to be imported."""
    if sys.stderr is not None:
        sys.stderr.write(f"mobman: {message}\n")


if __name__ == "__main__":
    main()
