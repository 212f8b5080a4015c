"""The operator's console: a live session, and what is shown of it."""
