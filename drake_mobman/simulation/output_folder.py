"""A folder to write to: each file is whole or missing, and files of others are kept.

Files are made in a hidden draft folder inside, and moved to their places once they are
complete, together with a manifest that lists which files are ours. The folder itself is
never moved: it may be a mount point, a link, or a working folder in use. If a process
is killed between two moves, the rest stays in the draft; the next process finishes.
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
    """A folder to write to, locked inside a `with` statement.

    Args:
        path: of the folder, new or of an earlier run.
        kind: patterns of the names that may be replaced; None to continue with a folder
            of ours, even if it now holds other files.

    Raises:
        FolderError: on entering, if the folder cannot be made or locked, or holds files
            that are not ours.
    """

    def __init__(self, path: Path, kind: Sequence[str] | None) -> None:
        self.path = resolved(path)
        self.keeps_draft = False  # Whether the draft stays at the end.
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
        """Returns the folder for files that are not complete."""
        return self.path / DRAFT

    def file(self, name: str) -> Path:
        """Returns where to write a file until it is published."""
        file = self.draft / name
        file.parent.mkdir(parents=True, exist_ok=True)
        return file

    def put(self, name: str, content: bytes) -> None:
        """Writes a file and publishes it.

        Raises:
            OSError: where it cannot be written; then the old file is unchanged.
        """
        file = self.file(name)
        try:
            file.write_bytes(content)
            self.publish([name])
        except OSError:
            file.unlink(missing_ok=True)
            raise

    def publish(self, names: Sequence[str], *, anew: bool = False) -> None:
        """Moves files of the draft to their places, and lists them as ours.

        Args:
            names: of the files.
            anew: whether to remove other files that we wrote before, if unchanged.

        Raises:
            FolderError: if a file that is not ours is in the way; then nothing is
                moved.
            OSError: where it cannot be written.
        """
        made = {name: hash_of(self.draft / name) for name in names}
        before = read_manifest(self.path)
        for name in made:
            self._check_place(name, before.get(name))
        # From here on, the next process would finish if this one is killed.
        write_manifest(self.draft, made if anew else before | made)
        self._complete()

    def adopt(self, name: str) -> None:
        """Lists a file as ours that was written without a draft."""
        written = read_manifest(self.path)
        write_manifest(self.path, written | {name: hash_of(self.path / name)})

    def clear(self) -> None:
        """Removes our unchanged files, and the folder if it is empty then."""
        self.draft.mkdir(exist_ok=True)
        write_manifest(self.draft, {})
        self._complete()
        _remove_empty(self.draft, self.path)
        (self.path / MANIFEST).unlink()
        self._made = [self.path, *self._made]

    def move_aside(self) -> None:
        """Continues in a new folder beside this one, and moves the draft there.

        Raises:
            OSError: where it cannot be made.
        """
        n = 2
        while os.path.lexists(beside := self.path.with_name(f"{self.path.name}-{n}")):
            n += 1
        beside.mkdir()
        self.draft.replace(beside / DRAFT)
        self._unlock()
        self.path = self._given = beside
        self._lock = _locked(beside)

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
        self.draft.mkdir()  # Fails before the work if it is not allowed.

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
        """Makes the folder match the draft's manifest."""
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
    """Checks that a folder can be written to; leaves no files behind.

    Args:
        path: of the folder, new or of an earlier run.
        kind: patterns of the names that may be replaced.

    Raises:
        FolderError: as `OutputFolder`.
    """
    with OutputFolder(path, kind):
        pass


def check_is_ours(path: Path, kind: Sequence[str]) -> None:
    """Raises `FolderError` if a folder holds files that are not ours to replace."""
    folder = resolved(path)
    written = [read_manifest(folder), read_manifest(folder / DRAFT)]
    for what in not_ours(folder, written, kind):
        raise FolderError(refusal(path, f"it holds {what}"))


_TAKEN = -2


def _locked(folder: Path) -> int:
    """Returns a descriptor of a folder, locked for us alone, or `_TAKEN`.

    The lock ends with the process. A file system without locks is used without.
    """
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(descriptor)
        return _TAKEN
    except OSError:
        pass
    # The process that held the lock may have removed the folder.
    if not os.path.lexists(folder) or not os.path.samestat(
        os.fstat(descriptor), os.stat(folder)
    ):
        os.close(descriptor)
        return _TAKEN
    return descriptor


def _remove_empty(folder: Path, top: Path) -> None:
    """Removes an empty folder, and its parents below `top` while they are empty."""
    with suppress(OSError):
        while folder != top:
            folder.rmdir()
            folder = folder.parent
