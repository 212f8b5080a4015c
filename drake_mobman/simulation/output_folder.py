"""A folder that we write to: each file whole or not there, and nobody else's touched.

Files are made in a hidden draft in the folder, and moved to their places once they are
complete, together with a manifest that says which files are ours. So folders are never
moved: one may stand in it, it may be a mount point or a link, or another's parent. Who
is killed between two moves leaves the rest in the draft, for the next one to go on.
"""

import fcntl
import os
import shutil
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Self

from drake_mobman.files import FolderError, refusal, resolved
from drake_mobman.simulation.manifest import (
    DRAFT,
    MANIFEST,
    hash_of,
    is_ours,
    not_ours,
    read_manifest,
    write_manifest,
)

__all__ = [
    "FolderError",
    "OutputFolder",
    "check_folder",
    "check_is_ours",
    "refusal",
    "resolved",
]


class OutputFolder:
    """A folder that is written to while entered, by nobody else meanwhile.

    Args:
        path: of the folder, to be made, or ours to replace.
        kind: patterns of the names that may be replaced; None to go on with a folder
            that is ours, whatever else has come into it.

    Raises:
        FolderError: on entering, if the folder cannot be made or locked, or holds what
            is not ours.
    """

    def __init__(self, path: Path, kind: Sequence[str] | None) -> None:
        self.path = resolved(path)
        self.keeps_draft = False  # Whether the draft stays, on leaving.
        self._given = path
        self._kind = kind
        self._made: list[Path] = []
        self._lock = -1

    def __enter__(self) -> Self:
        try:
            self._open()
        except BaseException as error:
            self._close()
            if isinstance(error, OSError) and not isinstance(error, FolderError):
                why = error.strerror or str(error)
                raise FolderError(refusal(self._given, why)) from None
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._close()

    @property
    def draft(self) -> Path:
        """Returns the folder for what is not complete."""
        return self.path / DRAFT

    def file(self, name: str) -> Path:
        """Returns where to write a file until it is published under its name."""
        file = self.draft / name
        file.parent.mkdir(parents=True, exist_ok=True)
        return file

    def put(self, name: str, content: bytes) -> None:
        """Writes a file whole, and publishes it.

        Raises:
            OSError: where it cannot be written; then what was there is as it was.
        """
        file = self.file(name)
        try:
            file.write_bytes(content)
            self.publish([name])
        except OSError:
            file.unlink(missing_ok=True)
            raise

    def publish(self, names: Sequence[str], *, anew: bool = False) -> None:
        """Moves files of the draft to their places; they are ours from then on.

        Args:
            names: of the files.
            anew: whether what we wrote before is removed, but for what was changed.

        Raises:
            FolderError: if there is something in a file's place that is not ours; then
                nothing is moved.
            OSError: where it cannot be written.
        """
        made = {name: hash_of(self.draft / name) for name in names}
        before = read_manifest(self.path)
        for name in made:
            self._check_place(name, before.get(name))
        # From here on it is decided, and the next one would complete it.
        write_manifest(self.draft, made if anew else before | made)
        self._complete()

    def adopt(self, name: str) -> None:
        """Takes a file that was written in its place as ours, from now on unchanged."""
        written = read_manifest(self.path)
        write_manifest(self.path, written | {name: hash_of(self.path / name)})

    def clear(self) -> None:
        """Removes all that is ours and unchanged; the folder too, if that was all."""
        self.draft.mkdir(exist_ok=True)
        write_manifest(self.draft, {})
        self._complete()
        _remove_empty(self.draft, self.path)
        (self.path / MANIFEST).unlink()
        self._made = [self.path, *self._made]

    def move_aside(self) -> None:
        """Goes on in a new folder beside this one, and takes the draft along.

        Raises:
            OSError: where there can be none.
        """
        n = 2
        while os.path.lexists(beside := self.path.with_name(f"{self.path.name}-{n}")):
            n += 1
        beside.mkdir()
        self.draft.replace(beside / DRAFT)
        self._unlock()
        self.path = self._given = beside
        self._lock = _locked(beside)

    # How it is done.

    def _open(self) -> None:
        parents = [*reversed(self.path.parents), self.path]
        for folder in parents:
            if not folder.exists():
                with suppress(FileExistsError):
                    folder.mkdir()
                    self._made.insert(0, folder)
            if not folder.is_dir():
                what = "it" if folder == self.path else f"{folder}"
                raise FolderError(refusal(self._given, f"{what} is a file"))
        self._lock = _locked(self.path)
        if self._lock == _TAKEN:
            self._made = []
            why = "another run is being written there"
            raise FolderError(refusal(self._given, why))
        if self._kind is not None:
            check_is_ours(self._given, self._kind)
        if os.path.lexists(self.draft / MANIFEST):
            self._complete()
        shutil.rmtree(self.draft, ignore_errors=True)
        self.draft.mkdir()  # So it is known before the work whether one can.

    def _close(self) -> None:
        if not self.keeps_draft and self._lock >= 0:
            shutil.rmtree(self.draft, ignore_errors=True)
        with suppress(OSError):
            for folder in self._made:
                folder.rmdir()
        self._unlock()

    def _unlock(self) -> None:
        if self._lock >= 0:
            os.close(self._lock)
        self._lock = -1

    def _complete(self) -> None:
        """Makes the folder what the draft's manifest says."""
        before, after = read_manifest(self.path), read_manifest(self.draft)
        for name, digest in after.items():
            if (self.draft / name).exists():
                self._check_place(name, before.get(name), digest)
                (self.path / name).parent.mkdir(parents=True, exist_ok=True)
                (self.draft / name).replace(self.path / name)
        for name in before.keys() - after.keys():
            old = self.path / name
            if is_ours(old, [before[name]]):
                old.unlink()
                _remove_empty(old.parent, self.path)
        (self.draft / MANIFEST).replace(self.path / MANIFEST)
        for name in after:
            _remove_empty((self.draft / name).parent, self.path)

    def _check_place(self, name: str, *digests: str | None) -> None:
        """Raises `FolderError` unless a file may be put under a name."""
        for parent in list(Path(name).parents)[:-1]:
            place = self.path / parent
            if os.path.lexists(place) and (place.is_symlink() or not place.is_dir()):
                why = f"it holds {parent}, which was put there meanwhile"
                raise FolderError(refusal(self._given, why))
        if os.path.lexists(self.path / name) and not is_ours(self.path / name, digests):
            why = f"it holds {name}, which was put there or changed meanwhile"
            raise FolderError(refusal(self._given, why))


def check_folder(path: Path, kind: Sequence[str]) -> None:
    """Finds out, before the work, whether a folder can be written to.

    Leaves nothing behind.

    Args:
        path: of the folder, to be made, or ours to replace.
        kind: patterns of the names that may be replaced.

    Raises:
        FolderError: as `OutputFolder`.
    """
    with OutputFolder(path, kind):
        pass


def check_is_ours(path: Path, kind: Sequence[str]) -> None:
    """Raises `FolderError` if a folder holds what is not ours to replace."""
    folder = resolved(path)
    written = [read_manifest(folder), read_manifest(folder / DRAFT)]
    for what in not_ours(folder, written, kind):
        raise FolderError(refusal(path, f"it holds {what}"))


_TAKEN = -2


def _locked(folder: Path) -> int:
    """Returns a descriptor of a folder that nobody else has, or `_TAKEN`.

    The lock ends with the process. Where the file system has none, we go without.
    """
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(descriptor)
        return _TAKEN
    except OSError:
        pass
    # Whoever had it may have removed the folder meanwhile.
    if not os.path.lexists(folder) or not os.path.samestat(
        os.fstat(descriptor), os.stat(folder)
    ):
        os.close(descriptor)
        return _TAKEN
    return descriptor


def _remove_empty(folder: Path, top: Path) -> None:
    """Removes a folder and those that it is in, below `top`, while they are empty."""
    with suppress(OSError):
        while folder != top:
            folder.rmdir()
            folder = folder.parent
