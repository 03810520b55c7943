"""A headless Chromium, driven over its debugging pipe."""

import base64
import json
import os
import shutil
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

__all__ = ["Browser", "chromium", "opened"]


def chromium() -> str | None:
    """Path of a Chromium: $LUMPED_CHROMIUM, or what is on the PATH."""
    return os.environ.get("LUMPED_CHROMIUM") or shutil.which("chromium")


@contextmanager
def opened(profile: Path) -> Iterator["Browser"]:
    """A page until the end of a block; without a Chromium the test is skipped."""
    program = chromium()
    if program is None:
        pytest.skip("no Chromium: set LUMPED_CHROMIUM to its path, or have 'chromium' on the PATH")
    found = Browser(program, profile)
    try:
        yield found
    finally:
        found.close()


class Browser:
    """One page; notes what the page logs as errors and what it asks the network for."""

    def __init__(self, program: str, profile: Path) -> None:
        down, up = os.pipe(), os.pipe()
        # the browser reads from 3 and writes to 4
        command = 'exec 3<&"$0" 4>&"$1"; shift; exec "$@"'
        arguments = (program, "--headless", "--no-sandbox", "--disable-gpu", "--no-zygote")
        options = ("--remote-debugging-pipe", f"--user-data-dir={profile}", "about:blank")
        self.process = subprocess.Popen(
            ["bash", "-c", command, str(down[0]), str(up[1]), *arguments, *options],
            pass_fds=(down[0], up[1]),
            stderr=subprocess.DEVNULL,
        )
        os.close(down[0])
        os.close(up[1])
        self.out, self.back = os.fdopen(down[1], "wb"), os.fdopen(up[0], "rb")
        self.number, self.session, self.rest = 0, "", b""
        self.errors: list[str] = []
        self.requests: list[str] = []
        self.loaded = False
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        found = self.call("Target.attachToTarget", targetId=target, flatten=True)
        self.session = found["sessionId"]
        for domain in ("Runtime", "Log", "Page", "Network"):
            self.call(f"{domain}.enable")

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send a command and wait for its answer."""
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        self.out.write(json.dumps(message).encode() + b"\0")
        self.out.flush()
        while True:
            answer = self._next()
            if answer.get("id") == self.number:
                assert "error" not in answer, answer
                return answer["result"]

    def _next(self) -> dict[str, Any]:
        while b"\0" not in self.rest:
            piece = os.read(self.back.fileno(), 1 << 16)
            assert piece, "the browser ended"
            self.rest += piece
        text, _, self.rest = self.rest.partition(b"\0")
        message = json.loads(text)
        event, given = message.get("method"), message.get("params", {})
        if event == "Runtime.exceptionThrown":
            self.errors.append(given["exceptionDetails"]["text"])
        elif event == "Runtime.consoleAPICalled" and given["type"] in ("error", "warning"):
            self.errors.append(str(given["args"]))
        elif event == "Log.entryAdded":
            self.errors.append(given["entry"]["text"])
        elif event == "Network.requestWillBeSent":
            self.requests.append(given["request"]["url"])
        elif event == "Page.loadEventFired":
            self.loaded = True
        return message

    def open(self, address: Path | str, *, scripts: bool = True, query: str = "") -> None:
        """Open a file or an address and wait until it is there."""
        self.call("Emulation.setScriptExecutionDisabled", value=not scripts)
        self.size(1200, 900)
        self.loaded = False
        url = address.as_uri() if isinstance(address, Path) else address
        self.call("Page.navigate", url=url + query)
        while not self.loaded:
            self._next()

    def value(self, expression: str) -> Any:
        """Value of a JavaScript expression."""
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True)
        assert "exceptionDetails" not in result, result
        return result["result"].get("value")

    def size(self, width: int, height: int) -> None:
        """Size of the window."""
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )

    def wait(self, expression: str, seconds: float = 30.0) -> Any:
        """Value of a JavaScript expression as soon as it is true."""
        end = time.monotonic() + seconds
        while not (found := self.value(expression)):
            assert time.monotonic() < end, f"{expression} stays {found!r}"
            time.sleep(0.02)
        return found

    def key(self, name: str) -> None:
        """Press and release a key, such as ArrowRight."""
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=name, code=name)

    def mouse(self, kind: str, x: float, y: float, **more: Any) -> None:
        """What a hand does: mouseMoved, mousePressed, mouseReleased, mouseWheel."""
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def picture(self, file: Path) -> None:
        """Write what is seen as PNG."""
        file.write_bytes(base64.b64decode(self.call("Page.captureScreenshot")["data"]))

    def close(self) -> None:
        """End the browser."""
        self.process.terminate()
        self.process.wait(10)
        self.out.close()
        self.back.close()
