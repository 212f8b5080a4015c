"""`log.npz` for logs of any length, in the format of `numpy.savez_compressed`."""

import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from drake_mobman.simulation.log import WINDOW, Log


def write_npz(
    file: Path,
    log: Log,
    every: int = 1,
    progress: Callable[[float], None] = lambda _: None,
) -> None:
    """Writes a log.

    Args:
        file: to be written, and replaced.
        log: to write.
        every: keeps each `every`-th sample, from the first one on.
        progress: called with how much is written [%].

    Raises:
        OSError: where it cannot be written.
    """
    rows = len(log["time"])
    step = max(WINDOW // every, 1) * every
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for i, name in enumerate(log):
            shape = (-(-rows // every), *log[name].shape[1:])
            header = {"descr": "<f8", "fortran_order": False, "shape": shape}
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array_header_1_0(member, header)
                for start in range(0, rows, step):
                    some = log[name][start : start + step : every]
                    member.write(np.ascontiguousarray(some, "<f8").tobytes())
                    progress(100 * (i + start / rows) / len(log))
