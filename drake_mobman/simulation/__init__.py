"""Simulation of a scenario: its log, and its run folder."""
