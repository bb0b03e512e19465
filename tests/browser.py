"""A headless Chromium, driven over its DevTools protocol through two pipes: no package, no port, no network."""

import base64
import contextlib
import fcntl
import json
import os
import select
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
_PATIENCE = 60.0  # s for one answer: a busy machine starts a browser slowly


def find_chromium() -> str | None:
    """The program: that of the environment variable CHROMIUM, else one of the usual names."""
    return os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)


@contextlib.contextmanager
def open_browser(program: str, profile: Path) -> Iterator["Browser"]:
    """A browser with one empty page; it ends with the block."""
    command_out, command_in = os.pipe()
    answer_out, answer_in = os.pipe()
    # the browser reads from 3 and writes to 4, whatever the numbers are here
    ours = fcntl.fcntl(command_out, fcntl.F_DUPFD, 10), fcntl.fcntl(answer_in, fcntl.F_DUPFD, 10)
    options = (
        "--headless=new --remote-debugging-pipe --no-sandbox --disable-gpu --no-first-run --hide-scrollbars "
        "--disable-dev-shm-usage --disable-extensions --disable-background-networking --disable-component-update"
    )
    launch = f"import os, sys; os.dup2({ours[0]}, 3); os.dup2({ours[1]}, 4); os.execvp(sys.argv[1], sys.argv[1:])"
    process = subprocess.Popen(
        [sys.executable, "-c", launch, program, *options.split(), f"--user-data-dir={profile}"],
        pass_fds=ours,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    for handle in (command_out, answer_in, *ours):
        os.close(handle)
    browser = Browser(command_in, answer_out)
    try:
        browser.attach()
        yield browser
    finally:
        with contextlib.suppress(OSError, EOFError, TimeoutError):
            browser.call("Browser.close", session=False)
        process.terminate()
        process.wait(timeout=20)
        os.close(command_in)
        os.close(answer_out)


class Browser:
    """Calls, and the events that came meanwhile: `events` is a list of (method, parameters)."""

    def __init__(self, write: int, read: int) -> None:
        self._write, self._read, self._buffer, self._number = write, read, b"", 0
        self._session: str | None = None
        self.events: list[tuple[str, dict[str, Any]]] = []

    def attach(self) -> None:
        target = self.call("Target.createTarget", url="about:blank", session=False)["targetId"]
        attached = self.call("Target.attachToTarget", targetId=target, flatten=True, session=False)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.call(f"{domain}.enable")

    def call(self, method: str, *, session: bool = True, **parameters: Any) -> dict[str, Any]:
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": parameters}
        if session:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next(time.monotonic() + _PATIENCE)
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return answer["result"]

    def _next(self, until: float) -> dict[str, Any]:
        while b"\0" not in self._buffer:
            if not select.select([self._read], [], [], max(0.0, until - time.monotonic()))[0]:
                raise TimeoutError("the browser does not answer")
            more = os.read(self._read, 1 << 20)
            if not more:
                raise EOFError("the browser has ended")
            self._buffer += more
        line, _, self._buffer = self._buffer.partition(b"\0")
        message = json.loads(line)
        if "method" in message:
            self.events.append((message["method"], message["params"]))
        return message

    def open(self, page: Path, width: int = 1280, height: int = 900, *, dark: bool = False) -> None:
        """Load a page at a width of CSS pixels, and wait until its script has run."""
        self.resize(width, height)
        features = [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]
        self.call("Emulation.setEmulatedMedia", media="", features=features)
        self.events.clear()
        self.call("Page.navigate", url=page.as_uri())
        self.wait("document.readyState === 'complete' && document.documentElement.dataset.ready === 'yes'")
        self.settle()

    def resize(self, width: int, height: int) -> None:
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
        self.call("Emulation.setDeviceMetricsOverride", **size)

    def run(self, script: str) -> Any:
        """The value of an expression on the page."""
        done = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in done:
            raise RuntimeError(f"{script}: {done['exceptionDetails']}")
        return done["result"].get("value")

    def wait(self, condition: str) -> None:
        until = time.monotonic() + _PATIENCE
        while not self.run(condition):
            if time.monotonic() > until:
                raise TimeoutError(f"never came true: {condition}")
            time.sleep(0.02)

    def settle(self) -> None:
        """Until two frames are drawn."""
        self.run("new Promise(r => requestAnimationFrame(() => requestAnimationFrame(() => r(true))))")

    def press(self, key: str, *, shift: bool = False) -> None:
        """A key, by its name in the DOM: 'Tab', 'ArrowRight', '+', 'Enter'."""
        codes = {"Tab": 9, "Enter": 13, " ": 32, "End": 35, "Home": 36, "ArrowLeft": 37, "ArrowRight": 39, "Escape": 27}
        text = {"text": "\r"} if key == "Enter" else {"text": key} if len(key) == 1 else {}
        common = {"key": key, "windowsVirtualKeyCode": codes.get(key, ord(key[0])), "modifiers": 8 if shift else 0}
        self.call("Input.dispatchKeyEvent", type="keyDown", **common, **text)
        self.call("Input.dispatchKeyEvent", type="keyUp", **common)
        self.settle()

    def mouse(self, kind: str, x: float, y: float, **more: Any) -> None:
        """'mouseMoved', 'mousePressed' or 'mouseReleased' at a place in the window."""
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)
        self.settle()

    def box(self, selector: str) -> dict[str, float]:
        """Where the first element of a selector is in the window, once it is in sight."""
        place = f"document.querySelector({json.dumps(selector)})"
        self.run(f"{place}.scrollIntoView({{block: 'center', behavior: 'instant'}})")
        self.settle()
        return self.run(f"(({{x, y, width, height}}) => ({{x, y, width, height}}))({place}.getBoundingClientRect())")

    def picture(self, path: Path, *, whole: bool = True) -> None:
        """A PNG of the page."""
        done = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(done["data"]))

    def print(self, path: Path) -> None:
        """A PDF of the page, as printed."""
        path.write_bytes(base64.b64decode(self.call("Page.printToPDF")["data"]))

    def of(self, *methods: str) -> list[dict[str, Any]]:
        """The parameters of the events of these kinds since the page was opened."""
        return [parameters for method, parameters in self.events if method in methods]
