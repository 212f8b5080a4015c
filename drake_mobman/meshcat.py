"""Meshcat that nobody, or only this machine, can reach.

Meshcat has no login: any web site that is open in a browser of this machine can connect
to its port, press its buttons, or end it with a frame that it cannot read.
"""

import logging
import os
import secrets
import socket
import stat

from pydrake.geometry import Meshcat, MeshcatParams


def random_loopback_host() -> str:
    """Returns an address of this machine that no web page finds by trying.

    A random one in 127/8, or 127.0.0.1 where the system has no other.
    """
    host = ".".join(["127", *(str(1 + secrets.randbelow(254)) for _ in range(3))])
    with socket.socket() as probe:
        try:
            probe.bind((host, 0))
        except OSError:
            return "127.0.0.1"
    return host


def local_meshcat(host: str, port: int = 0) -> Meshcat:
    """Returns a Meshcat that is served to this machine alone, and prints nothing.

    Args:
        host: a loopback address.
        port: port to serve at; 0 picks a free one.

    Raises:
        RuntimeError: where the port is not available.
    """
    logging.getLogger("drake").setLevel(logging.WARNING)
    return Meshcat(MeshcatParams(host=host, port=port, show_stats_plot=False))


def offline_meshcat() -> Meshcat:
    """Returns a Meshcat without a server, whose drawing can be saved as a page.

    Meshcat always opens a port. It is closed here before anyone could find it.

    Raises:
        RuntimeError: where there is no such port, or it cannot be closed.
    """
    meshcat = local_meshcat(random_loopback_host())
    files = map(int, os.listdir("/dev/fd"))
    listeners = [number for number in files if _listens(number, meshcat.port())]
    for number in listeners:
        # The number stays in use until Meshcat closes it, or it would close another
        # file that has got the same number.
        with open(os.devnull, "rb") as nothing:
            os.dup2(nothing.fileno(), number, inheritable=False)
    if not listeners:
        raise RuntimeError("Meshcat's port cannot be closed")
    return meshcat


def _listens(number: int, port: int) -> bool:
    """Returns whether an open file of ours is a socket that listens at a port."""
    try:
        if not stat.S_ISSOCK(os.fstat(number).st_mode):
            return False
    except OSError:
        return False  # It was closed in the meantime.
    with socket.socket(fileno=os.dup(number)) as listener:
        if listener.family not in {socket.AF_INET, socket.AF_INET6}:
            return False
        listens = listener.getsockopt(socket.SOL_SOCKET, socket.SO_ACCEPTCONN)
        return bool(listens) and listener.getsockname()[1] == port
