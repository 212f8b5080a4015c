"""Anyone's robot, described by a file: read, checked, and put together in a plant."""

from drake_mobman.robots.file.file import File

__all__ = ["File"]
