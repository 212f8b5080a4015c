"""Addresses and ports to serve at, and who can reach them."""

import ipaddress
import secrets
import socket
from typing import NamedTuple

from drake_mobman.meshcat import random_loopback_host

_LOWEST_PORT = 1024
"""Lowest port that Meshcat takes."""


class Address(NamedTuple):
    """Where a panel is served."""

    host: str
    port: int


def is_loopback(host: str) -> bool:
    """Returns whether a name or address can be reached from this machine alone."""
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return host.lower() == "localhost"


def listening(host: str = "127.0.0.1", port: int = 8080) -> socket.socket:
    """Returns a socket to serve at.

    Args:
        host: name or address of this machine.
        port: port to listen at; 0 picks a free one.

    Raises:
        OSError: where it is not available.
    """
    found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
    family, _, _, _, address = found[0]
    listener = socket.socket(family, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
        listener.listen()  # Two programs may bind, but only one may listen.
    except OSError:
        listener.close()
        raise
    return listener


def free_address(port: int | None = None) -> Address:
    """Returns where a panel may be served, to this machine alone.

    Args:
        port: port at 127.0.0.1; 0 or None picks a free one, at a random loopback host.

    Raises:
        OSError: where the port is not available.
    """
    if port and port < _LOWEST_PORT:
        raise OSError(0, f"it must be {_LOWEST_PORT} or above")
    host = "127.0.0.1" if port else random_loopback_host()
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        probe.bind((host, port or 0))
        return Address(*probe.getsockname())


def token_for(listener: socket.socket) -> str | None:
    """Returns a new token, if other machines can reach a socket."""
    host = listener.getsockname()[0]
    return None if is_loopback(host) else secrets.token_urlsafe(16)


def own_address(family: int) -> str:
    """Returns this machine's address in its network, or its name if it has none.

    Phones often cannot resolve the name.
    """
    # Addresses that are reserved for documentation.
    outside = "2001:db8::1" if family == socket.AF_INET6 else "203.0.113.1"
    with socket.socket(family, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect((outside, 9))  # UDP: nothing is sent.
        except OSError:
            return socket.gethostname()
        address: str = probe.getsockname()[0]
    return address
