"""The files of a controller, written to a folder together."""

from collections.abc import Mapping
from pathlib import Path

from drake_mobman.simulation.output_folder import OutputFolder

LAW = ("*.c", "*.h", "Makefile")
"""Patterns of the files that may be replaced."""


def write_law(files: Mapping[str, bytes], path: Path) -> None:
    """Writes all files of a controller, or none.

    Args:
        files: contents by name.
        path: of the folder, new or of an earlier export.

    Raises:
        OSError: where it cannot be written; then the folder is unchanged.
    """
    with OutputFolder(path, LAW) as folder:
        for name, content in files.items():
            folder.file(name).write_bytes(content)
        folder.publish([*files], anew=True)
