"""The page in headless Chromium: no console error, no request, sorting, filtering, panels, themes and keys work.

Chromium is driven through chromedriver's plain HTTP interface (W3C WebDriver), so no Python package is needed.
"""

import json
import shutil
import socket
import subprocess
import time
import urllib.error
import urllib.request

import pytest

from reports.pages.study import write_report

pytestmark = pytest.mark.slow

FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--window-size=1280,1000",
)  # fmt: skip


class Browser:
    """A session of headless Chromium."""

    def __init__(self, driver, folder):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        self.process = subprocess.Popen(
            [driver, f"--port={port}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        self.base = f"http://127.0.0.1:{port}"
        wanted = {
            "browserName": "chrome",
            "goog:chromeOptions": {"args": [*FLAGS, f"--user-data-dir={folder}"]},
            "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"},
        }
        for _ in range(100):
            try:
                session = self.call("POST", "/session", {"capabilities": {"alwaysMatch": wanted}})
                break
            except (ConnectionError, urllib.error.URLError):
                time.sleep(0.1)
        self.base += f"/session/{session['sessionId']}"

    def call(self, method, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.base + path, data=data, method=method)
        request.add_header("Content-Type", "application/json")
        try:
            with urllib.request.urlopen(request, timeout=120) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            raise AssertionError(error.read().decode()[:500]) from None

    def open(self, path):
        self.call("POST", "/url", {"url": path.as_uri()})

    def run(self, script, *arguments):
        return self.call("POST", "/execute/sync", {"script": script, "args": list(arguments)})

    def keys(self, text):
        actions = [{"type": kind, "value": key} for key in text for kind in ("keyDown", "keyUp")]
        self.call("POST", "/actions", {"actions": [{"type": "key", "id": "keys", "actions": actions}]})

    def emulate(self, **features):
        listed = [{"name": name.replace("_", "-"), "value": value} for name, value in features.items()]
        body = {"cmd": "Emulation.setEmulatedMedia", "params": {"features": listed}}
        self.call("POST", "/goog/cdp/execute", body)

    def errors(self):
        return [entry for entry in self.call("POST", "/se/log", {"type": "browser"}) if entry["level"] == "SEVERE"]

    def requests(self):
        events = [json.loads(e["message"])["message"] for e in self.call("POST", "/se/log", {"type": "performance"})]
        sent = [e["params"]["request"]["url"] for e in events if e["method"] == "Network.requestWillBeSent"]
        return [url for url in sent if not url.startswith(("file:", "data:", "chrome", "about:"))]

    def close(self):
        try:
            self.call("DELETE", "")
        finally:
            self.process.terminate()
            self.process.wait(10)


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    driver = shutil.which("chromedriver")
    if driver is None:
        pytest.skip("chromedriver (and Chromium) is not installed")
    session = Browser(driver, tmp_path_factory.mktemp("profile"))
    yield session
    session.close()


@pytest.fixture(scope="module")
def written(store_maker, tmp_path_factory):
    """A page with everything on it: a lie, a broken file, rubbish in a log, a comparison with a baseline."""
    folder = tmp_path_factory.mktemp("stores")
    old = store_maker(folder / "old").study(count=2, seeds=3)
    root = store_maker(folder / "new").study(count=4, seeds=3, sizes=((8, 2), (12, 3), (40, 4)))
    path = sorted(root.glob("*/ga-*.json"))[0]
    rubbish = {"objective": 1.0, "log": "</script><b>rubbish</b> \u2028 & <!-- ", "message": "<i>x</i>"}
    path.write_text(json.dumps(json.loads(path.read_text()) | rubbish))
    (path.parent / "broken.json").write_text("{")
    write_report([root], folder / "report.html", against=[old])
    return folder / "report.html"


@pytest.fixture
def page(browser, written):
    """The page open in the browser; afterwards nothing was logged as an error, nothing asked of the network."""
    browser.open(written)
    yield browser
    assert browser.errors() == []
    assert browser.requests() == []


COLUMN = """
const table = document.getElementById(arguments[0]), i = arguments[1];
return [...table.tBodies[0].rows].map(row => row.cells[i].textContent);
"""
PRESS = "document.querySelectorAll(`#${arguments[0]} thead button`)[arguments[1]].click();"


def figures(texts):
    return [float(t.replace(",", "").replace("%", "").replace("<", "").replace("−", "-")) for t in texts if t != "–"]


def test_static_tables_sort_both_ways_with_the_missing_last(page):
    column = page.run(
        "return [...document.querySelectorAll('#summary-table th')].findIndex(h => /proof/.test(h.textContent))"
    )
    for way in ("ascending", "descending"):
        page.run(PRESS, "summary-table", column)
        texts = page.run(COLUMN, "summary-table", column)
        values = figures(texts)
        assert values == sorted(values, reverse=way == "descending")
        assert all(t == "–" for t in texts[len(values) :])
        assert page.run("return document.querySelectorAll('#summary-table th')[arguments[0]].ariaSort", column) == way


def test_runs_sort_filter_and_search(page):
    page.run(PRESS, "run-list-table", 4)
    values = figures(page.run(COLUMN, "run-list-table", 4))
    assert len(values) > 10
    assert values == sorted(values)
    choose = (
        "const s = document.getElementById(arguments[0]); s.value = arguments[1]; s.dispatchEvent(new Event('change'));"
    )
    page.run(choose, "run-list-method", "milp")
    assert set(page.run(COLUMN, "run-list-table", 1)) == {"milp"}
    page.run(choose, "run-list-status", "OPTIMAL")
    assert set(page.run(COLUMN, "run-list-table", 3)) == {"OPTIMAL"}
    type_in = (
        "const s = document.getElementById(arguments[0]); s.value = arguments[1]; s.dispatchEvent(new Event('input'));"
    )
    page.run(type_in, "run-list-search", "ring n8")
    names = page.run(COLUMN, "run-list-table", 0)
    assert names
    assert all("ring" in name and "n8" in name for name in names)
    page.run(type_in, "run-list-search", "no such thing")
    assert page.run(COLUMN, "run-list-table", 0) == []
    assert "0 of 0 shown" in page.run("return document.querySelector('#runs-list output').textContent")


def test_a_row_opens_its_run_and_the_instance(page):
    page.run("document.querySelector('#run-list-table tbody tr').click()")
    text = page.run("return document.getElementById('panel').innerText")
    for word in ("Routes", "Trace", "Options", "Cost of each tour", "Status"):
        assert word in text
    assert page.run("return document.querySelectorAll('#panel svg polyline').length") >= 1
    page.run("[...document.querySelectorAll('#panel button')].find(b => b.textContent.startsWith('All runs')).click()")
    assert "Best found" in page.run("return document.getElementById('panel').innerText")
    assert page.run("return document.querySelectorAll('#panel tbody tr').length") > 3
    page.run("document.getElementById('panel-close').click()")
    assert not page.run("return document.getElementById('panel').open")


def test_the_keyboard_alone_opens_and_closes_a_run(page):
    page.run("document.querySelector('#run-list-table tbody button').focus()")
    page.keys(["\ue007"])  # Enter
    assert page.run("return document.getElementById('panel').open")
    page.keys(["\ue00c"])  # Escape
    assert not page.run("return document.getElementById('panel').open")
    assert page.run("return document.activeElement.closest('#run-list-table') !== null")


def test_what_a_run_printed_is_shown_as_text(page):
    script = """
    const s = document.getElementById('run-list-method'); s.value = 'ga'; s.dispatchEvent(new Event('change'));
    for (const row of document.querySelectorAll('#run-list-table tbody tr')) {
      row.click();
      const body = document.getElementById('panel-body');
      if (body.textContent.includes('rubbish')) return [body.textContent, body.querySelectorAll('b, i').length];
    }
    """
    text, elements = page.run(script)
    assert "</script><b>rubbish</b>" in text
    assert elements == 0


def test_light_dark_and_the_toggle(page):
    colour = "return getComputedStyle(document.body).backgroundColor"
    page.run("localStorage.clear(); delete document.documentElement.dataset.theme")
    page.emulate(prefers_color_scheme="light")
    light = page.run(colour)
    page.emulate(prefers_color_scheme="dark")
    dark = page.run(colour)
    assert light != dark
    page.run("document.getElementById('theme').click()")
    assert page.run(colour) == light
    page.run("document.getElementById('theme').click()")
    assert page.run(colour) == dark
    page.emulate(prefers_color_scheme="light")


def test_alarms_are_on_top_and_everything_has_a_name(page):
    assert page.run("return document.querySelector('main section').id") == "contradictions"
    assert "broken.json" in page.run("return document.getElementById('warnings').textContent")
    assert page.run("return [...document.querySelectorAll('main svg:not([aria-hidden])')].every(s => s.ariaLabel)")
    assert page.run("return [...document.querySelectorAll('input, select')].every(e => e.labels.length)")
    assert page.run("return [...document.querySelectorAll('main figure')].every(f => f.querySelector('figcaption'))")
    assert page.run(
        "const i = [...document.querySelectorAll('[id]')].map(e => e.id); return i.length === new Set(i).size"
    )


def test_nothing_overflows_a_narrow_screen(page):
    size = {"width": 420, "height": 800, "deviceScaleFactor": 1, "mobile": True}
    page.call("POST", "/goog/cdp/execute", {"cmd": "Emulation.setDeviceMetricsOverride", "params": size})
    wide = page.run("return document.documentElement.scrollWidth")
    page.call("POST", "/goog/cdp/execute", {"cmd": "Emulation.clearDeviceMetricsOverride", "params": {}})
    assert wide <= 420
