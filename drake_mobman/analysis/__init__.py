"""Analysis of runs: motion, metrics, and comparisons."""
