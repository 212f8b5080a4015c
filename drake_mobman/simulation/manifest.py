"""The files that we wrote to a folder, with their hashes, as `sha256sum -c` reads them.

A file is ours to replace or remove if it is in this list and unchanged.
"""

import hashlib
import os
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path, PurePosixPath

MANIFEST = "manifest.sha256"
"""The list's name in its folder."""

DRAFT = ".draft"
"""A hidden folder in that folder, for files that are not complete yet."""

Manifest = dict[str, str]
"""Hashes by file names: paths relative to the folder, with slashes."""

_LINE = re.compile(r"([0-9a-f]{64})  (.+)")


def hash_of(file: Path) -> str:
    """Returns a file's SHA-256 in hex."""
    with file.open("rb") as opened:
        return hashlib.file_digest(opened, "sha256").hexdigest()


def read_manifest(folder: Path) -> Manifest:
    """Returns a folder's list; empty where there is none, or it is not a list."""
    try:
        text = (folder / MANIFEST).read_text("utf-8")
    except (FileNotFoundError, NotADirectoryError, IsADirectoryError, ValueError):
        return {}
    lines = [_LINE.fullmatch(line) for line in text.splitlines()]
    return {line[2]: line[1] for line in lines if line}


def write_manifest(folder: Path, written: Manifest) -> None:
    """Writes a folder's list, whole or not at all."""
    text = "".join(f"{digest}  {name}\n" for name, digest in sorted(written.items()))
    draft = folder / f"{MANIFEST}.part"
    draft.write_text(text, "utf-8")
    draft.replace(folder / MANIFEST)


def is_ours(file: Path, digests: Iterable[str | None]) -> bool:
    """Returns whether a file has one of some hashes, and is not a link."""
    return file.is_file() and not file.is_symlink() and hash_of(file) in digests


def not_ours(
    folder: Path, written: Sequence[Manifest], kind: Sequence[str]
) -> Iterator[str]:
    """Yields the files in a folder that we may not replace, each with the reason.

    Args:
        folder: an existing one.
        written: lists of the files that are ours, if unchanged.
        kind: patterns of the names that may be replaced.
    """
    names = {name for manifest in written for name in manifest}
    inner = {str(parent) for name in names for parent in PurePosixPath(name).parents}

    def look(at: Path) -> Iterator[str]:
        for entry in sorted(os.scandir(at), key=lambda entry: entry.name):
            path = Path(entry.path)
            name = path.relative_to(folder).as_posix()
            if name == DRAFT and entry.is_dir(follow_symlinks=False):
                continue
            if name == MANIFEST and entry.is_file(follow_symlinks=False):
                continue
            if name in inner and entry.is_dir(follow_symlinks=False):
                yield from look(path)
            elif name not in names:
                known = any(PurePosixPath(name).match(pattern) for pattern in kind)
                yield f"{name}, " + (
                    f"but no {MANIFEST} that shows who wrote it"
                    if known and not names
                    else "which would be lost"
                )
            elif not is_ours(path, [manifest.get(name) for manifest in written]):
                yield f"{name}, which was changed since we wrote it"
            elif not any(PurePosixPath(name).match(pattern) for pattern in kind):
                yield f"{name}, which would be lost"

    return look(folder)
