"""Serves the page and one websocket a browser, on loopback, in a thread of its own.

What is sent goes by slots: of each slot a browser gets the newest (see `outbox`).
"""

from __future__ import annotations

import asyncio
import logging
import socket
import threading
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from http import HTTPStatus
from importlib import resources
from typing import NamedTuple

from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from floornav_common.live_view.commands import goal_of
from floornav_common.live_view.encoding import text_message
from floornav_common.live_view.origins import refusal
from floornav_common.live_view.outbox import Outbox
from floornav_common.se2 import SE2

HOST = "127.0.0.1"
MAX_BROWSERS = 16
_MAX_BYTES = 4096  # of what a browser sends
_MAX_GOALS = 16
_CLOSING_S = 5.0
_TYPES = {"html": "text/html", "js": "text/javascript", "css": "text/css"}
_PAGE = {"/": "index.html", "/live_view.js": "live_view.js", "/live_view.css": "live_view.css"}
_HEADERS = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    # No other page may put this one in a frame and have its user click a goal.
    "X-Frame-Options": "DENY",
    "Content-Security-Policy": "default-src 'self'; img-src 'self' blob: data:; "
    "frame-ancestors 'none'",
}  # fmt: skip


class GoalAsked(NamedTuple):
    """A goal that a browser asked for.

    Attributes:
        browser: Number of the browser, to answer it.
        pose: The goal in the map frame.
    """

    browser: int
    pose: SE2


@dataclass
class _Browser:
    socket: ServerConnection
    outbox: Outbox = field(default_factory=Outbox)
    has_mail: asyncio.Event = field(default_factory=asyncio.Event)

    def put(self, slot: str, message: str | bytes) -> None:
        self.outbox.put(slot, message)
        self.has_mail.set()


class LiveViewServer:
    """The page, its websockets, and the goals asked for. Methods may be called from any thread.

    Args:
        port: On loopback; 0 for any free one.

    Attributes:
        url: Address of the page.
        num_ever: Browsers that have come so far; who sends begins anew for each.

    Raises:
        OSError: If the port is taken.
    """

    def __init__(self, port: int) -> None:
        """Take the port and begin to serve."""
        folder = resources.files("floornav_common") / "live_view" / "page"
        self._pages = {path: (folder / name).read_bytes() for path, name in _PAGE.items()}
        self._browsers: dict[int, _Browser] = {}
        self._goals: deque[GoalAsked] = deque(maxlen=_MAX_GOALS)
        self.num_ever = self._num_refused = 0
        self._listener = socket.create_server((HOST, port))
        self.url = f"http://{HOST}:{self._listener.getsockname()[1]}/"
        self._loop = asyncio.new_event_loop()
        self._end = asyncio.Event()
        self._thread = threading.Thread(target=self._run, name="live_view", daemon=True)
        self._thread.start()

    @property
    def num_browsers(self) -> int:
        """How many browsers look now."""
        return len(self._browsers)

    @property
    def counts(self) -> dict[str, int]:
        """Browsers now and ever, requests refused, messages that newer ones replaced."""
        dropped = sum(b.outbox.num_dropped for b in list(self._browsers.values()))
        return {
            "browsers": self.num_browsers, "browsers so far": self.num_ever,
            "requests refused": self._num_refused, "replaced by newer": dropped,
        }  # fmt: skip

    def send(self, messages: Mapping[str, str | bytes]) -> None:
        """Send to all browsers, by slot."""
        self._call(self._send_all, dict(messages))

    def answer(self, browser: int, message: str) -> None:
        """Send to one browser, if it is still there."""
        self._call(self._send_one, browser, message)

    def take_goals(self) -> list[GoalAsked]:
        """Return the goals asked for since the last call, the oldest first."""
        return [self._goals.popleft() for _ in range(len(self._goals))]

    def close(self) -> None:
        """Tell the browsers good-bye and free the port."""
        self._call(self._end.set)
        self._thread.join(_CLOSING_S)

    def _call(self, function: object, *args: object) -> None:
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(function, *args)  # type: ignore[arg-type]

    def _send_all(self, messages: dict[str, str | bytes]) -> None:
        for browser in self._browsers.values():
            for slot, message in messages.items():
                browser.put(slot, message)

    def _send_one(self, number: int, message: str) -> None:
        if number in self._browsers:
            self._browsers[number].put("answer", message)

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_until_complete(self._serve())
        finally:
            self._loop.close()

    async def _serve(self) -> None:
        async with serve(
            self._talk, sock=self._listener, process_request=self._respond, compression=None,
            max_size=_MAX_BYTES, logger=_quiet_logger(),
        ):  # fmt: skip
            await self._end.wait()

    def _respond(self, connection: ServerConnection, request: Request) -> Response | None:
        """Answer a request; None lets a websocket through."""
        hosts, origins = (request.headers.get_all(name) for name in ("Host", "Origin"))
        why = refusal(hosts[0] if len(hosts) == 1 else None, ", ".join(origins) or None)
        path = request.path.partition("?")[0]
        if why:
            self._num_refused += 1
            return connection.respond(HTTPStatus.FORBIDDEN, f"{why}\n")
        if path == "/ws" and len(self._browsers) < MAX_BROWSERS:
            return None
        if path == "/ws":
            text = f"{MAX_BROWSERS} browsers look already\n"
            return connection.respond(HTTPStatus.SERVICE_UNAVAILABLE, text)
        if path not in _PAGE:
            return connection.respond(HTTPStatus.NOT_FOUND, "no such page\n")
        body = self._pages[path]
        kind = _TYPES[_PAGE[path].rpartition(".")[2]]
        headers = Headers(_HEADERS)
        headers["Content-Type"] = f"{kind}; charset=utf-8"
        headers["Content-Length"] = str(len(body))
        headers["Connection"] = "close"
        return Response(HTTPStatus.OK, "OK", headers, body)

    async def _talk(self, connection: ServerConnection) -> None:
        """Serve one browser until it leaves."""
        browser = _Browser(connection)
        self.num_ever += 1
        number = self.num_ever
        self._browsers[number] = browser
        sending = asyncio.create_task(_post(browser))
        try:
            async for text in connection:
                self._listen(number, browser, text)
        except ConnectionClosed:
            pass  # it went without a word
        finally:
            sending.cancel()
            del self._browsers[number]

    def _listen(self, number: int, browser: _Browser, text: str | bytes) -> None:
        try:
            self._goals.append(GoalAsked(number, goal_of(text)))
        except ValueError as error:
            browser.put("answer", text_message("answer", ok=False, text=str(error)))


async def _post(browser: _Browser) -> None:
    """Send what waits; while the browser takes no more, the outbox keeps the newest."""
    try:
        while True:
            await browser.has_mail.wait()
            browser.has_mail.clear()
            while (outgoing := browser.outbox.take()) is not None:
                await browser.socket.send(outgoing.message)
    except ConnectionClosed:
        pass  # the one who listens to it ends the talk


def _quiet_logger() -> logging.Logger:
    """Return a logger that says nothing of browsers that open a connection and never ask."""
    logger = logging.getLogger("floornav_common.live_view")
    logger.setLevel(logging.ERROR)
    logger.addFilter(lambda record: not record.getMessage().startswith("opening handshake"))
    return logger
