"""Steer the hand of a mobile manipulator and the wheels follow, as Drake blocks.

Importing this package imports nothing of Drake, so that `mobman --help` is quick;
take blocks from the modules that hold them.
"""

__version__ = "0.1.0"
