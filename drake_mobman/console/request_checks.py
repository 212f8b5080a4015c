"""Checks of a request's headers and path, before anyone is authenticated.

Any web site that is open in the same browser may send requests to this server. But
`Origin` and `Sec-Fetch-Site` show where a request comes from, and `Host` shows whether
a site reaches the server by a name of its own.
"""

import re
from typing import NamedTuple
from urllib.parse import urlsplit

from starlette.requests import HTTPConnection
from starlette.types import Scope

from drake_mobman.console.addresses import is_loopback

_PATHS = re.compile(
    r"(?!.*(\.\.|//))/"
    r"(drive|favicon\.ico|(static|view|_nicegui_ws)/[\w./-]*|_nicegui/[\w./@-]*)?",
    re.ASCII,
)
"""All paths that exist: plain names, which lead nowhere else and may be printed."""

_HOST = re.compile(r"(?P<name>[\w.-]*|\[[\w:.]*\])(:\d+)?", re.ASCII)

_OWN_SITE = {"same-origin", "none"}
"""`Sec-Fetch-Site` of requests from our own pages, or from the address bar."""


class Refusal(NamedTuple):
    """An answer to a request that is refused."""

    status: int
    reason: str


def check_host(request: HTTPConnection, local_only: bool) -> Refusal | None:
    """Returns why a request is refused for the name that it has for this server.

    Args:
        request: from a browser, or anyone else.
        local_only: whether this server is for this machine alone.
    """
    host = _HOST.fullmatch(request.headers.get("host", ""))
    if not host:
        return Refusal(403, "the Host header is not valid")
    if local_only and not is_loopback(host["name"]):
        return Refusal(403, "this server is for its own machine only")
    return None


def check_origin(request: HTTPConnection) -> Refusal | None:
    """Returns why a request is refused for where it comes from."""
    origin = request.headers.get("origin")
    if origin is None and request.scope["type"] == "websocket":
        # Browsers always send where a socket is opened from.
        return Refusal(403, "there is no Origin header")
    try:
        site = urlsplit(origin or "")
    except ValueError:
        return Refusal(403, "the Origin header is not valid")
    ours = site.scheme in {"http", "https"} and site.netloc == request.headers["host"]
    if origin is not None and not ours:
        return Refusal(403, "the Origin header names another site")
    own_site = request.headers.get("sec-fetch-site", "none") in _OWN_SITE
    if not own_site and not _is_link(request):
        return Refusal(403, "another site sent the request")
    return None


def _is_link(request: HTTPConnection) -> bool:
    """Returns whether a person has followed a link to the page."""
    how = [request.headers.get(f"sec-fetch-{name}") for name in ("mode", "dest")]
    return request.scope["path"] == "/" and how == ["navigate", "document"]


def check_path(scope: Scope) -> Refusal | None:
    """Returns why a request is refused for its method or path."""
    if scope["type"] == "http" and scope["method"] not in {"GET", "HEAD"}:
        return Refusal(405, "only GET and HEAD are allowed")
    if not _PATHS.fullmatch(scope["path"]):
        return Refusal(404, "there is no such page")
    return None
