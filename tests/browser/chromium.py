"""Headless Chromium over its debugging pipe (file descriptors 3 and 4): enough of the DevTools protocol for a test."""

from __future__ import annotations

import atexit
import base64
import json
import os
import select
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import TracebackType
from typing import Any

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update", "--disable-dev-shm-usage",
    "--remote-debugging-pipe",
)  # fmt: skip
ANSWER_WITHIN = 60.0  # s; a browser that hangs fails the test instead of blocking it


def find_chromium() -> str | None:
    """Path of a Chromium, or None."""
    return next((found for name in NAMES if (found := shutil.which(name))), None)


class Chromium:
    """A process of Chromium, in which any number of pages is opened, each with a profile of its own."""

    def __init__(self, program: str) -> None:
        self._profile = tempfile.mkdtemp(prefix="dvp-chromium-")
        to_browser, self._out = os.pipe()
        self._in, from_browser = os.pipe()
        self._id = 0
        self._buffer = b""
        self._listening: dict[str | None, Browser] = {}
        # The shell moves the two pipe ends to descriptors 3 and 4, wherever they are here.
        command = ["bash", "-c", f'exec "$0" "$@" 3<&{to_browser} 4>&{from_browser}', program, *FLAGS]
        command += [f"--user-data-dir={self._profile}", "about:blank"]
        self._process = subprocess.Popen(
            command, pass_fds=(to_browser, from_browser), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        os.close(to_browser)
        os.close(from_browser)

    def close(self) -> None:
        self._process.kill()
        self._process.wait()
        os.close(self._out)
        os.close(self._in)
        shutil.rmtree(self._profile, ignore_errors=True)

    def listen(self, session: str, page: Browser | None) -> None:
        """What happens in a session is told to its page, to nobody for None."""
        if page is None:
            self._listening.pop(session, None)
        else:
            self._listening[session] = page

    def call(self, method: str, session: str | None = None, **parameters: Any) -> dict[str, Any]:
        """Send a command and wait for its answer; what happens meanwhile is noted by the page it happens in."""
        self._id += 1
        message: dict[str, Any] = {"id": self._id, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._receive()
            if answer.get("id") == self._id:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return dict(answer["result"])
            page = self._listening.get(answer.get("sessionId"))
            if page is not None:
                page.note(answer)

    def _receive(self) -> dict[str, Any]:
        while b"\0" not in self._buffer:
            ready, _, _ = select.select([self._in], [], [], ANSWER_WITHIN)
            chunk = os.read(self._in, 1 << 20) if ready else b""
            if not chunk:
                raise RuntimeError("chromium does not answer")
            self._buffer += chunk
        message, self._buffer = self._buffer.split(b"\0", 1)
        return dict(json.loads(message))


@cache
def chromium(program: str) -> Chromium:
    """The one of this process: a start and its first page take as long as three more pages."""
    found = Chromium(program)
    atexit.register(found.close)
    return found


class Browser:
    """One page with a profile of its own. `problems`: console errors, exceptions, failed or foreign requests."""

    def __init__(self, program: str, width: int = 1280, height: int = 900) -> None:
        self.problems: list[str] = []
        self.requests: list[str] = []
        self._chromium = chromium(program)
        self._context = self._chromium.call("Target.createBrowserContext")["browserContextId"]
        size = {"width": width, "height": height}
        page = self._chromium.call("Target.createTarget", url="about:blank", browserContextId=self._context, **size)
        attached = self._chromium.call("Target.attachToTarget", targetId=page["targetId"], flatten=True)
        self._session = attached["sessionId"]
        self._chromium.listen(self._session, self)
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def __enter__(self) -> Browser:
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self._chromium.listen(self._session, None)
        self._chromium.call("Target.disposeBrowserContext", browserContextId=self._context)

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send a command of the page and wait for its answer; what happens meanwhile is noted."""
        return self._chromium.call(method, self._session, **parameters)

    def open(self, path: Path, ready: str) -> None:
        """Load a local file and wait until the expression `ready` holds."""
        self.call("Page.navigate", url=path.resolve().as_uri())
        waiting = (
            f"new Promise((done) => {{ const look = () => ({ready}) ? done(true) : setTimeout(look, 20); look(); }})"
        )
        self.evaluate(waiting)

    def evaluate(self, expression: str) -> Any:
        """Value of a JavaScript expression in the page; promises are awaited."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(answer["exceptionDetails"].get("exception", {}).get("description", expression))
        return answer["result"].get("value")

    def click(self, x: float, y: float) -> None:
        for kind in ("mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def set_colours(self, scheme: str) -> None:
        """`scheme`: "light" or "dark", as a reader's system would say."""
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])

    def screenshot(self, path: Path, *, whole: bool = False) -> None:
        image = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(image["data"]))

    def note(self, message: dict[str, Any]) -> None:
        """An event of the page."""
        method, details = message.get("method"), message.get("params", {})
        if method == "Runtime.exceptionThrown":
            self.problems.append(str(details["exceptionDetails"].get("exception", {}).get("description")))
        elif method == "Runtime.consoleAPICalled" and details["type"] in ("error", "warning", "assert"):
            self.problems.append(" ".join(str(entry.get("value", "")) for entry in details["args"]))
        elif method == "Log.entryAdded" and details["entry"]["level"] in ("error", "warning"):
            self.problems.append(details["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            self.requests.append(details["request"]["url"])


@contextmanager
def opened(page: Path, ready: str) -> Iterator[Browser]:
    """A browser that shows `page`, once the JavaScript expression `ready` is true. Skips where there is no Chromium."""
    program = find_chromium()
    if program is None:
        pytest.skip("no Chromium on PATH")
    with Browser(program) as browser:
        browser.open(page, ready)
        yield browser
