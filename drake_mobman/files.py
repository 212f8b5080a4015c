"""Files: read without waiting for a pipe or device, written whole or not at all."""

import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class FolderError(OSError):
    """A folder that cannot be written to; the message is one line."""


def read_file(path: Path, most: int) -> bytes:
    """Returns the content of a file of at most `most` bytes.

    A pipe or a device is refused: it may never end, or never begin.

    Raises:
        FileNotFoundError: where there is no file.
        OSError: where it cannot be read, is not a file, or is longer.
    """
    handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
    with os.fdopen(handle, "rb") as file:
        status = os.fstat(handle)
        if stat.S_ISDIR(status.st_mode):
            raise IsADirectoryError(None, "it is a folder")
        if not stat.S_ISREG(status.st_mode):
            raise OSError(None, "it is not a file")
        # One byte more, in case it grows.
        data = file.read(most + 1)
    if len(data) > most:
        raise OSError(None, f"it has more than {most} bytes")
    return data


@contextmanager
def new_file(file: Path) -> Iterator[Path]:
    """Yields a file to write to, which replaces `file` at the end.

    Raises:
        FolderError: if `file` cannot be made.
    """
    target = resolved(file)
    draft = target.with_name(f".{secrets.token_hex(8)}.part")
    try:
        if target.is_dir():
            raise FolderError(f"{file}: cannot be written, it is a folder")
        target.parent.mkdir(parents=True, exist_ok=True)
        draft.touch(exist_ok=False)
    except FolderError:
        raise
    except OSError as error:
        raise FolderError(f"{file}: cannot be written, {error.strerror}") from None
    try:
        yield draft
        draft.replace(target)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise


def resolved(path: Path) -> Path:
    """Returns an absolute path without links.

    Raises:
        FolderError: where there is no such path, or a link is broken.
    """
    try:
        for at in (path, *path.parents):
            if at.is_symlink() and not at.exists():
                why = f"{at} is a broken link"
                raise FolderError(refusal(path, why))
        return path.resolve()
    except FolderError:
        raise
    except (OSError, RuntimeError, ValueError) as error:
        why = getattr(error, "strerror", None) or str(error)
        raise FolderError(refusal(path, why)) from None


def refusal(path: Path, why: str) -> str:
    """Returns the line of an error: why a folder cannot be written to."""
    return f"{path}: cannot be written, {why}; must be new, or of an earlier run"
