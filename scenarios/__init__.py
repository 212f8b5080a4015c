"""Scenarios that `mobman list` knows: a YAML file each."""
