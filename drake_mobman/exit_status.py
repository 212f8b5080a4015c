"""The exit statuses of `mobman`, but for those of signals, which a shell numbers."""

BAD_INPUT = 2
DIED = 1
"""Also where something could not be done, or written."""

INTERRUPTED = 130
"""As a shell reports Ctrl-C."""
