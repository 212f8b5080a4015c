"""The command `mobman`, from its first import to its last word."""

import os
import sys

from drake_mobman.terminal import leaving_at_once, replaced


def main() -> None:
    """Runs the command line, and says so where its output was not taken."""
    with leaving_at_once():
        from drake_mobman.cli import BAD_INPUT, DIED, app, complain  # noqa: PLC0415

    if sys.stderr is not None:
        sys.stderr, _ = replaced(sys.stderr)
    if sys.stdout is None:
        # The next file that is opened would get what Drake has to say.
        complain("standard output is closed; must be open, if only to /dev/null")
        sys.exit(BAD_INPUT)
    sys.stdout, output = replaced(sys.stdout)
    try:
        os.getcwd()  # Drake asks, and takes it amiss.
    except OSError as error:
        complain(f"the working folder is gone: {error.strerror}")
        sys.exit(BAD_INPUT)
    try:
        app(prog_name="mobman")
    except SystemExit as end:
        sys.stdout.flush()
        if output.lost:
            complain(f"standard output: {output.lost}")
            sys.exit(end.code or DIED)
        raise


if __name__ == "__main__":
    main()
