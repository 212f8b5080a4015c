"""The operator's console: a live simulation, driven and watched in a browser."""
