"""Addresses to serve at."""

import pytest

from drake_mobman.console.addresses import free_address, listening, token_for


def test_free_address_is_of_this_machine_alone_and_can_be_served_at():
    host, port = free_address()
    assert host.startswith("127.")
    with listening(host, port) as listener:
        assert listener.getsockname()[:2] == (host, port)
        assert token_for(listener) is None


def test_port_in_use_is_refused():
    with listening(port=0) as taken:
        port = taken.getsockname()[1]
        for other in (free_address, lambda port: listening(port=port)):
            with pytest.raises(OSError, match="in use"):
                other(port)
