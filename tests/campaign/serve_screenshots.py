"""Screenshots of odom serve's page in Chromium, without a window: serve_screenshots.py URL FOLDER

One picture of the whole page, light and dark, for each width of 1280 and 390 pixels. Fails if the page is wider than
the window, if its script fails, or if car and sources are not shown at once."""
import base64
import json
import pathlib
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager

import websocket  # python3-websocket

PORT = 9333


class Tab:
    def __init__(self) -> None:
        for _ in range(100):
            try:
                pages = json.load(urllib.request.urlopen(f"http://127.0.0.1:{PORT}/json"))
                break
            except OSError:
                time.sleep(0.1)
        address = next(page["webSocketDebuggerUrl"] for page in pages if page["type"] == "page")
        self.socket = websocket.create_connection(address, suppress_origin=True, timeout=60)

    def call(self, method: str, **parameters: object) -> dict:
        self.socket.send(json.dumps({"id": 1, "method": method, "params": parameters}))
        while (answer := json.loads(self.socket.recv())).get("id") != 1:
            assert answer["method"] != "Runtime.exceptionThrown", answer
        return answer["result"]

    def value(self, expression: str) -> object:
        return self.call("Runtime.evaluate", expression=expression)["result"].get("value")


def photograph(tab: Tab, url: str, folder: pathlib.Path, width: int, scheme: str) -> None:
    tab.call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=width < 500)
    tab.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
    tab.call("Page.navigate", url=url)
    time.sleep(1.0)
    assert tab.value("car !== null && $('#sources tbody').rows.length > 0")
    time.sleep(5.0)
    assert tab.value("rows.length") > 50
    name = f"serve-{width}-{scheme}.png"
    picture = tab.call("Page.captureScreenshot", captureBeyondViewport=True)["data"]
    (folder / name).write_bytes(base64.b64decode(picture))
    wide = tab.value("document.documentElement.scrollWidth")
    print(f"{name}: {wide} pixels wide")
    assert wide == width


@contextmanager
def browser() -> Iterator[Tab]:
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        chromium = subprocess.Popen(
            ["chromium", "--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
             f"--user-data-dir={profile}", f"--remote-debugging-port={PORT}", "about:blank"], stderr=subprocess.DEVNULL)
        try:
            tab = Tab()
            tab.call("Runtime.enable")
            yield tab
        finally:
            chromium.terminate()
            chromium.wait()


if __name__ == "__main__":
    with browser() as tab:
        for width in (1280, 390):
            for scheme in ("light", "dark"):
                photograph(tab, sys.argv[1], pathlib.Path(sys.argv[2]), width, scheme)
