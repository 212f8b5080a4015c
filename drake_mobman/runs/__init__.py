"""Runs: scenarios, simulation, the run folder, metrics and figures."""
