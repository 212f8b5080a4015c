"""Where commands come from, and the guard that lets them in."""
