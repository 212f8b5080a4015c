"""What a run shows: motion, metrics, and runs side by side."""
