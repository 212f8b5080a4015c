"""Meshcat, seen by nobody, or by who was told where it is.

Meshcat asks nobody who they are: any web site that is open in a browser of this machine
may look into its port, press its buttons, or end it by a frame that it cannot read.
"""

import logging
import os
import secrets
import socket
import stat

from pydrake.geometry import Meshcat, MeshcatParams


def unguessed_host() -> str:
    """Returns an address of this machine that no web page comes upon by trying.

    One in 127/8 that is drawn by lot, or 127.0.0.1 where the system has no other.
    """
    host = ".".join(["127", *(str(1 + secrets.randbelow(254)) for _ in range(3))])
    with socket.socket() as probe:
        try:
            probe.bind((host, 0))
        except OSError:
            return "127.0.0.1"
    return host


def local_meshcat(host: str, port: int = 0) -> Meshcat:
    """Returns a Meshcat that is served to this machine alone, without a word of it.

    Args:
        host: a loopback address.
        port: 0 for any that is free.

    Raises:
        RuntimeError: where the port cannot be had.
    """
    logging.getLogger("drake").setLevel(logging.WARNING)
    return Meshcat(MeshcatParams(host=host, port=port, show_stats_plot=False))


def sealed_meshcat() -> Meshcat:
    """Returns a Meshcat that nobody can reach: it draws, and tells what it has drawn.

    It cannot be made without a port. That is closed before it could be found.

    Raises:
        RuntimeError: where there is no such port, or it cannot be closed.
    """
    meshcat = local_meshcat(unguessed_host())
    files = map(int, os.listdir("/dev/fd"))
    doors = [number for number in files if _listens(number, meshcat.port())]
    for number in doors:
        # The number stays in use until Meshcat closes it, or it would close the file
        # of somebody else.
        with open(os.devnull, "rb") as nothing:
            os.dup2(nothing.fileno(), number, inheritable=False)
    if not doors:
        raise RuntimeError("Meshcat's port cannot be closed")
    return meshcat


def _listens(number: int, port: int) -> bool:
    """Returns whether an open file of ours is a socket that listens at a port."""
    try:
        if not stat.S_ISSOCK(os.fstat(number).st_mode):
            return False
    except OSError:
        return False  # It has been closed meanwhile.
    with socket.socket(fileno=os.dup(number)) as place:
        if place.family not in {socket.AF_INET, socket.AF_INET6}:
            return False
        listens = place.getsockopt(socket.SOL_SOCKET, socket.SO_ACCEPTCONN)
        return bool(listens) and place.getsockname()[1] == port
