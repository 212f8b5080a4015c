"""The command line, `mobman`."""
