"""Who may talk to the live view: pages of its own, called by a name of this machine.

The server listens on loopback only, but any page open in a browser here could still reach it: by
opening a websocket to it (its `Origin` is another), or by a name of its own that suddenly means
127.0.0.1 (DNS rebinding: the `Host` is that name). Programs that are no browsers send no `Origin`.
"""

from __future__ import annotations

from urllib.parse import urlsplit

_NAMES = ("127.0.0.1", "localhost", "::1")


def refusal(host: str | None, origin: str | None) -> str:
    """Return why a request is refused, "" if it is not.

    Args:
        host: Its header `Host`. Only the name counts: behind `ssh -L` the port is another.
        origin: Its header `Origin`; None without one.
    """
    if host is None or _name(f"http://{host}") not in _NAMES:
        return f"Host must be one of {', '.join(_NAMES)}, got {host!r}"
    if origin is not None and origin != f"http://{host}":
        return f"Origin must be http://{host}, got {origin!r}"
    return ""


def _name(url: str) -> str | None:
    try:
        parts = urlsplit(url)
        parts.port  # noqa: B018, raises for what is none
    except ValueError:
        return None
    if parts.username is not None or parts.path or parts.query or parts.fragment:
        return None
    return parts.hostname
