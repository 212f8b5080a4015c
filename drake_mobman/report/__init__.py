"""All that is made of a run: log, metrics, pictures."""
