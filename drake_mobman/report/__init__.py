"""Reports of runs in folders: log, metrics, pictures."""
