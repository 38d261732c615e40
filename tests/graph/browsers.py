"""A stand-in for the live view's page: a websocket that keeps the newest of each kind."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from floornav_common.live_view.encoding import split_message

EVENTUALLY_S = 60.0
_LOOK_S = 0.02


class Looker:
    """One who looks.

    Args:
        url: Of the page.
        origin: As a browser's page names itself; None as a program.

    Attributes:
        heard: The newest message of each kind: its JSON and what lies behind it.
        counts: How many of each kind came.
    """

    def __init__(self, url: str, origin: str | None = None) -> None:
        """Connect."""
        self.heard: dict[str, tuple[dict[str, Any], bytes]] = {}
        self.counts: dict[str, int] = {}
        self._open = ExitStack()
        address = url.replace("http", "ws") + "ws"
        self.socket: ClientConnection = self._open.enter_context(
            connect(address, origin=origin, max_size=None, compression=None)  # type: ignore[arg-type]
        )

    def close(self) -> None:
        """Leave."""
        self._open.close()

    def read(self, wait_s: float = _LOOK_S) -> bool:
        """Take what has come; whether anything had."""
        try:
            message = self.socket.recv(wait_s)
        except (TimeoutError, ConnectionClosed):
            return False
        text_only = isinstance(message, str)
        head, payload = (json.loads(message), b"") if text_only else split_message(message)
        self.heard[head["kind"]] = head, payload
        self.counts[head["kind"]] = self.counts.get(head["kind"], 0) + 1
        return True

    def until(self, is_so: Callable[[], Any], meanwhile: Callable[[], None] = lambda: None) -> None:
        """Read until something is so; fails with the kinds that came."""
        end = time.monotonic() + EVENTUALLY_S
        while not is_so():
            assert time.monotonic() < end, f"not so; heard: {self.counts}"
            meanwhile()
            while self.read(0.01):
                pass

    def values(self, kind: str) -> dict[str, Any]:
        """Return the newest JSON of a kind, empty before the first."""
        return self.heard[kind][0] if kind in self.heard else {}

    def say(self, text: str | bytes) -> None:
        """Send."""
        self.socket.send(text)
