"""Files that others wrote, read so that nothing but a file is waited for."""

import os
import stat
from pathlib import Path


def read_file(path: Path, most: int) -> bytes:
    """Returns what is in a file of at most so many bytes.

    A pipe or a device is not opened for long: it might never end, or never begin.

    Raises:
        FileNotFoundError: where there is none.
        OSError: where it cannot be read, is no file, or is longer.
    """
    handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
    with os.fdopen(handle, "rb") as file:
        told = os.fstat(handle)
        if stat.S_ISDIR(told.st_mode):
            raise IsADirectoryError(None, "it is a folder")
        if not stat.S_ISREG(told.st_mode):
            raise OSError(None, "it is no file")
        # One more, in case it grows.
        data = file.read(most + 1)
    if len(data) > most:
        raise OSError(None, f"it has more than {most} bytes")
    return data
