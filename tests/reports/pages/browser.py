"""Browser: a page in headless Chromium, driven through a pipe by its DevTools protocol; nothing to install.

Messages are JSON, each ended by a zero byte: `--remote-debugging-pipe` reads them from descriptor 3 and writes to 4.
"""

import base64
import contextlib
import json
import os
import select
import shutil
import subprocess
import time

FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-dev-shm-usage",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--remote-debugging-pipe",
)  # fmt: skip
PATIENCE = 120
"""Seconds to wait for an answer."""
QUIET = ("file:", "data:", "blob:", "chrome", "about:")
"""What asks nothing of the network."""


def chromium():
    """Return the path of Chromium, None where it is not installed."""
    return next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


class Browser:
    """One tab of headless Chromium, and what it logged and asked for since it was last emptied."""

    def __init__(self, program, folder):
        there, self.pipe_in = os.pipe()
        self.pipe_out, back = os.pipe()
        high = [os.dup2(end, 60 + k) for k, end in enumerate((there, back))]  # out of the way of 3 and 4
        command = [program, *FLAGS, f"--user-data-dir={folder}", "about:blank"]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self.process = subprocess.Popen(
            command, close_fds=False, preexec_fn=lambda: [os.dup2(end, 3 + k) for k, end in enumerate(high)], **quiet
        )  # fmt: skip
        for end in (there, back, *high):
            os.close(end)
        self.rest, self.number, self.session, self.events = b"", 0, None, []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.size(1280, 1000)

    def call(self, method, **given):
        self.number += 1
        message = {"id": self.number, "method": method, "params": given}
        message |= {"sessionId": self.session} if self.session else {}
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self.pipe_in, data) :]
        return self._until(lambda said: said.get("id") == self.number, method)

    def _until(self, wanted, what):
        """Keep events until the message that is `wanted`; return its result or parameters."""
        end = time.monotonic() + PATIENCE
        while True:
            while b"\0" in self.rest:
                text, _, self.rest = self.rest.partition(b"\0")
                said = json.loads(text)
                if "method" in said:
                    self.events.append(said)
                if wanted(said):
                    assert "error" not in said, f"{what}: {said['error']}"
                    return said.get("result", said.get("params"))
            ready, _, _ = select.select([self.pipe_out], [], [], max(0.0, end - time.monotonic()))
            assert ready, f"{what}: no answer within {PATIENCE} s"
            self.rest += os.read(self.pipe_out, 1 << 20)

    def open(self, path, hash=""):
        """Open the file as if typed into an empty tab, and wait until it is loaded."""
        self._go("about:blank")
        self.call("Page.resetNavigationHistory")  # of 50 entries at most: a full one loses count of what is pushed
        self._go(path.as_uri() + hash)

    def _go(self, url):
        self.call("Page.navigate", url=url)
        self._until(lambda said: said.get("method") == "Page.loadEventFired", url)

    def reload(self):
        self.call("Page.reload")
        self._until(lambda said: said.get("method") == "Page.loadEventFired", "reload")

    def run(self, script, *arguments):
        """Return what the body of a function returns; promises are awaited."""
        words = ", ".join(map(json.dumps, arguments))
        expression = f"(async function() {{ {script}\n }})({words})"
        said = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in said, said["exceptionDetails"]["exception"].get("description")
        return said["result"].get("value")

    def keys(self, *names):
        """Press keys: by name, such as Enter, Escape, Tab, or a letter."""
        codes = {"Enter": 13, "Escape": 27, "Tab": 9, " ": 32}
        for name in names:
            key = {"key": name, "code": name, "windowsVirtualKeyCode": codes.get(name, 0)}
            text = {"text": "\r"} if name == "Enter" else {"text": name} if len(name) == 1 else {}
            self.call("Input.dispatchKeyEvent", type="keyDown", **key, **text)
            self.call("Input.dispatchKeyEvent", type="keyUp", **key)

    def settle(self):
        """Wait until what was asked of the history and of the layout has happened."""
        self.run("return new Promise(done => setTimeout(() => requestAnimationFrame(() => done()), 60));")

    def emulate(self, media="", **features):
        listed = [{"name": name.replace("_", "-"), "value": value} for name, value in features.items()]
        self.call("Emulation.setEmulatedMedia", media=media, features=listed)

    def size(self, width, height, mobile=False):
        given = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": mobile}
        self.call("Emulation.setDeviceMetricsOverride", **given)

    def scripts(self, on):
        self.call("Emulation.setScriptExecutionDisabled", value=not on)

    def pdf(self, **given):
        return base64.b64decode(
            self.call("Page.printToPDF", printBackground=True, preferCSSPageSize=True, **given)["data"]
        )

    def picture(self, path, whole=True):
        said = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(said["data"]))

    def errors(self):
        """Return what was thrown, logged as an error or refused by the page's policy."""
        thrown = [e["params"]["exceptionDetails"] for e in self.events if e["method"] == "Runtime.exceptionThrown"]
        entries = [e["params"]["entry"] for e in self.events if e["method"] == "Log.entryAdded"]
        called = [e["params"] for e in self.events if e["method"] == "Runtime.consoleAPICalled"]
        logged = [e["text"] for e in entries if e["level"] == "error"]
        return thrown + logged + [e["args"] for e in called if e["type"] in ("error", "assert")]

    def requests(self):
        """Return the addresses asked of the network."""
        sent = [e["params"]["request"]["url"] for e in self.events if e["method"] == "Network.requestWillBeSent"]
        return [url for url in sent if not url.startswith(QUIET)]

    def close(self):
        with contextlib.suppress(AssertionError, OSError):
            self.session = None
            self.call("Browser.close")
        self.process.wait(20)
        for end in (self.pipe_in, self.pipe_out):
            os.close(end)
