"""A real browser without a window, driven by its DevTools protocol over a websocket.

Chromium is no library: it comes from the system (`apt install chromium`; `.ci/run` does that), or
from where FLOORNAV_CHROMIUM says.
"""

from __future__ import annotations

import base64
import json
import os
import shutil
import subprocess
import time
import urllib.request
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from websockets.sync.client import connect

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
EVENTUALLY_S = 60.0
_OPTIONS = (
    "--headless=new", "--remote-debugging-port=0", "--no-first-run", "--no-default-browser-check",
    "--disable-gpu", "--disable-extensions", "--disable-dev-shm-usage",
    "--disable-background-networking", "--hide-scrollbars", "--mute-audio", "--no-sandbox",
)  # fmt: skip


def find_chromium() -> str | None:
    """Return the browser's path, None where there is none."""
    named = os.environ.get("FLOORNAV_CHROMIUM")
    return shutil.which(named) if named else next(filter(None, map(shutil.which, NAMES)), None)


class Chromium:
    """One browser with one page.

    Args:
        program: Its path.
        folder: For its profile; of this browser alone.
        size: Of the page, px.
    """

    def __init__(self, program: str, folder: Path, size: tuple[int, int] = (1280, 800)) -> None:
        """Start it and take hold of its first page."""
        # The wheels' libraries are not for it.
        env = {k: v for k, v in os.environ.items() if k != "LD_LIBRARY_PATH"}
        window = f"--window-size={size[0]},{size[1]}"
        self._log = (folder / "chromium.log").open("wb")
        self.process = subprocess.Popen(
            [program, *_OPTIONS, window, f"--user-data-dir={folder / 'profile'}", "about:blank"],
            env={**env, "HOME": str(folder)}, stdin=subprocess.DEVNULL, stdout=self._log,
            stderr=self._log,
        )  # fmt: skip
        self._num = 0
        self.errors: list[str] = []
        self._open = ExitStack()
        try:
            self._socket = self._open.enter_context(
                connect(self._page_url(folder), max_size=None, compression=None)
            )
            for domain in ("Page", "Runtime", "Log"):
                self.call(f"{domain}.enable")
            self.call("Emulation.setDeviceMetricsOverride", width=size[0], height=size[1],
                      deviceScaleFactor=1, mobile=False)  # fmt: skip
        except BaseException:
            self.close()
            raise

    def call(self, method: str, **params: Any) -> dict[str, Any]:
        """Return what the browser answers; what its page complains of goes to `errors`."""
        self._num += 1
        self._socket.send(json.dumps({"id": self._num, "method": method, "params": params}))
        while True:
            message = json.loads(self._socket.recv(EVENTUALLY_S))
            if message.get("id") == self._num:
                assert "error" not in message, f"{method}: {message['error']}"
                result: dict[str, Any] = message["result"]
                return result
            self._note(message)

    def open(self, url: str) -> None:
        """Go to a page."""
        self.call("Page.navigate", url=url)

    def value(self, expression: str) -> Any:
        """Return what JavaScript gives, as JSON has it."""
        found = self.call(
            "Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True
        )
        assert "exceptionDetails" not in found, found["exceptionDetails"]
        return found["result"].get("value")

    def wait_for(self, expression: str, timeout: float = EVENTUALLY_S) -> Any:
        """Return the first value of JavaScript that counts as true."""
        end = time.monotonic() + timeout
        while True:
            # A page that is not there yet knows no names.
            found = self.value(f"(() => {{ try {{ return {expression}; }} catch {{ }} }})()")
            if found:
                return found
            assert time.monotonic() < end, f"not so within {timeout} s: {expression}"
            time.sleep(0.05)

    def mouse(self, kind: str, x: float, y: float, button: str = "left") -> None:
        """Do what a mouse does: `mousePressed`, `mouseMoved` or `mouseReleased`."""
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button=button, clickCount=1,
                  buttons=0 if kind == "mouseReleased" else 1)  # fmt: skip

    def drag(self, x: float, y: float, to_x: float, to_y: float) -> None:
        """Press, move and release; a click where both ends are one."""
        self.mouse("mousePressed", x, y)
        if (x, y) != (to_x, to_y):
            self.mouse("mouseMoved", to_x, to_y)
        self.mouse("mouseReleased", to_x, to_y)

    def screenshot(self) -> bytes:
        """Return what is seen, as a PNG."""
        return base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])

    def close(self) -> None:
        """End it."""
        self._open.close()
        self.process.terminate()
        try:
            self.process.wait(EVENTUALLY_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait(EVENTUALLY_S)
        self._log.close()

    def _page_url(self, folder: Path) -> str:
        """Return where its first page is spoken to, once it says so."""
        port_file, end = folder / "profile" / "DevToolsActivePort", time.monotonic() + EVENTUALLY_S
        while not (port_file.exists() and "\n" in port_file.read_text()):
            log = (folder / "chromium.log").read_text(errors="replace")
            assert self.process.poll() is None, f"chromium ended:\n{log}"
            assert time.monotonic() < end, f"chromium gave no port:\n{log}"
            time.sleep(0.05)
        port = port_file.read_text().split("\n")[0]
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/json/list", timeout=30) as answer:
            pages = [p for p in json.load(answer) if p["type"] == "page"]
        url: str = pages[0]["webSocketDebuggerUrl"]
        return url

    def _note(self, message: dict[str, Any]) -> None:
        params = message.get("params", {})
        if message.get("method") == "Runtime.exceptionThrown":
            self.errors.append(str(params["exceptionDetails"]))
        if message.get("method") == "Log.entryAdded" and params["entry"]["level"] == "error":
            self.errors.append(f"{params['entry']['text']} {params['entry'].get('url', '')}")
