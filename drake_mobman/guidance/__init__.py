"""Guidance by hand: a person moves the robot by pulling at its tool."""
