"""A study is watched from its folder: counted, not touched; its page is this machine's alone and can change nothing."""

from __future__ import annotations

import http.client
import json
import shutil
import socket
import subprocess
import threading
from contextlib import contextmanager
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from instances import Instance
from instances.code import code_digest
from instances.errors import InputError
from reports.record import Run
from workbench.jobs.claims import Claims
from workbench.jobs.job import Job
from workbench.jobs.store import Store
from workbench.jobs.watching import Watch
from workbench.problems.routing import ROUTING
from workbench.watching import terminal
from workbench.watching.server import PageServer
from workbench.watching.standing import Observer


@pytest.fixture(scope="module")
def finished(tmp_path_factory) -> Path:
    """A complete study of three runs of greedy, each of which took 2 s."""
    folder = tmp_path_factory.mktemp("watched")
    store, paths = Store(folder / "runs"), []
    for k in range(3):
        instance = Instance(f"uniform-{k}", np.ones((3, 3)) - np.eye(3), 2, 1)
        job = Job(store.put_item(ROUTING, instance), "greedy", time_limit=5.0)
        told = (job.method, {}, job.label, job.seed, job.time_limit, 1, None, False, "FEASIBLE", 3.0, None, 0.1)
        ended = ("finished", "", 0.0, 3.0, 1.9, 2.0, 0.1, 10**8, "", code_digest(), "", "2026-01-01T00:00:00+00:00")
        own = ROUTING.own_columns(instance, ((0, 1),))
        store.put(job.path, Run("routing", ROUTING.describe(instance), *told, *ended, own=own))
        paths.append(job.path)
    store.put_study({"name": "watched"}, paths)
    (folder / "given").mkdir()
    shutil.copy(next(store.root.glob("uniform-0*/instance.json")), folder / "given")
    return folder / "runs"


@pytest.fixture
def runs(finished, tmp_path) -> Path:
    return Path(shutil.copytree(finished, tmp_path / "runs"))


def files_of(runs: Path) -> list[Path]:
    return sorted(runs.glob("uniform*/greedy*.json"))


@contextmanager
def served(runs: Path):
    """Serve the page of `runs`; gives what asks it: method, path, headers → status, headers, text."""
    with PageServer(Observer(runs)) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.02,))
        thread.start()

        def ask(method: str = "GET", path: str = "/", **headers: str):
            line = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=10)
            line.putrequest(method, path, skip_host="Host" in headers)
            for name, value in headers.items():
                line.putheader(name, value.format(port=server.server_port))
            line.endheaders()
            answer = line.getresponse()
            told = answer.status, dict(answer.getheaders()), answer.read().decode()
            line.close()
            return told

        try:
            yield server, ask
        finally:
            server.shutdown()
            thread.join()


def test_a_look_counts_what_is_done_running_and_left(runs):
    first, second, _ = files_of(runs)
    watch = Watch(runs)
    assert watch.look().complete
    second.unlink()
    first.unlink()
    look = watch.look()
    assert (look.census.planned, look.census.missing, look.running, look.left) == (3, 2, (), None)
    assert look.sentence == "1 of 3 runs done, 0 running, nobody is at work"
    with Claims() as claims:
        claims.take(first)
        look = watch.look()
        assert look.running == (str(first.relative_to(runs)),)
        assert look.left == 4.0  # two more as long as the one that is stored, one at a time
        assert not look.complete
    assert watch.look().running == ()


def test_a_claim_whose_process_has_ended_is_nobody_at_work(runs):
    first, *_ = files_of(runs)
    with Claims() as claims:
        claims.take(first)
        claim = first.with_name(f".{first.name}.claim")
        told = json.loads(claim.read_text())
        claim.write_text(json.dumps(told | {"began": "in another life"}))
        assert Watch(runs).look().running == ()


def test_only_new_files_are_read_again(runs, monkeypatch):
    read = []
    monkeypatch.setattr(Store, "get", lambda self, path, get=Store.get: (read.append(path), get(self, path))[1])
    watch = Watch(runs)
    watch.look()
    assert len(read) == 3
    changed = files_of(runs)[1]
    changed.write_text("{")
    read.clear()
    assert len(watch.look().census.damaged) == 1
    watch.look()
    assert read == [str(changed.relative_to(runs))]


def test_status_watch_ends_when_the_study_is_complete(runs, cli, monkeypatch):
    code, told, _ = cli("status", runs, "--watch")
    assert code == 0
    assert "greedy" in told
    assert "3 of 3 runs done, 0 running, complete" in told
    last = files_of(runs)[2]
    held = last.rename(last.with_name("aside"))
    monkeypatch.setattr(terminal.time, "sleep", lambda seconds: held.rename(last))
    code, told, _ = cli("status", runs, "--watch", "--json")
    lines = [json.loads(line) for line in told.splitlines()]
    assert code == 0
    assert [(line["stored"], line["missing"], line["complete"]) for line in lines] == [(2, 1, False), (3, 0, True)]


def test_status_watch_is_left_by_ctrl_c_and_tells_damage(runs, cli, monkeypatch):
    def interrupt(seconds):
        raise KeyboardInterrupt

    files_of(runs)[0].unlink()
    monkeypatch.setattr(terminal.time, "sleep", interrupt)
    assert cli("status", runs, "--watch")[0] == 130
    shutil.copytree(runs, runs.parent / "damaged")
    files_of(runs)[0].write_text("{")
    shutil.copy(files_of(runs)[1], runs.parent / "elsewhere.json")
    planned = json.loads((runs / "study.json").read_text())
    planned["runs"] = [str(path.relative_to(runs)) for path in files_of(runs)]
    (runs / "study.json").write_text(json.dumps(planned))
    code, _, error = cli("status", runs, "--watch")
    assert code == 1
    assert "left alone" in error


def test_the_page_and_its_data_say_how_far_the_study_is(runs):
    files_of(runs)[0].unlink()
    with served(runs) as (_, ask):
        status, headers, page = ask()
        assert status == 200
        assert headers["Content-Type"] == "text/html; charset=utf-8"
        for part in ("2 of 3", "nobody is at work", "greedy", "Latest runs", '<noscript><meta http-equiv="refresh"'):
            assert part in page
        status, headers, text = ask(path="/data.json")
        told = json.loads(text)
        assert (status, headers["Content-Type"]) == (200, "application/json")
        assert [told[key] for key in ("planned", "stored", "missing", "failed", "left")] == [3, 2, 1, 0, None]
        assert [run["label"] for run in told["latest"]] == ["greedy", "greedy"]
        assert f'data-version="{told["version"]}"' in page
        assert told["html"] in page
        assert ask("HEAD")[2] == ""


def test_without_scripts_and_without_the_network(runs):
    """What the page's own policy allows is its one script, its own styles, and to ask where it came from."""
    with served(runs) as (_, ask):
        _, headers, page = ask()
    rules = dict(rule.split(" ", 1) for rule in headers["Content-Security-Policy"].split("; "))
    assert rules["default-src"] == "'none'"
    assert rules["connect-src"] == "'self'"
    assert rules["frame-ancestors"] == "'none'"
    assert rules["script-src"].startswith("'sha256-")
    assert "http://" not in page.replace("http://www.w3.org", "")
    assert "https://" not in page


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "PATCH", "OPTIONS", "CONNECT", "TRACE", "NONSENSE"])
def test_nothing_but_reading_is_allowed(runs, method):
    before = {path: path.read_bytes() for path in runs.rglob("*") if path.is_file()}
    with served(runs) as (_, ask):
        status, headers, _ = ask(method)
        assert (status, headers["Allow"]) == (405, "GET, HEAD")
    assert {path: path.read_bytes() for path in runs.rglob("*") if path.is_file()} == before


@pytest.mark.parametrize(
    "path",
    ["/study.json", "/../runs/study.json", "/%2e%2e/study.json", "/..", "//etc/passwd", "/data.json/..", "/?", "/data",
     "*", "/index.html"],
)  # fmt: skip
def test_no_path_of_the_file_system_is_served(runs, path):
    with served(runs) as (_, ask):
        status, _, text = ask(path=path)
    assert (status, text) == (404, "404 Not Found\n")


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:{port}", "127.0.0.1", "127.0.0.1:1", "127.0.0.1:{port}.evil.example", ""]
)
def test_a_foreign_host_is_refused(runs, host):
    with served(runs) as (_, ask):
        assert ask(Host=host)[0] == 421
        assert ask(Host="localhost:{port}")[0] == 200


def test_two_hosts_and_none_are_refused(runs):
    with served(runs) as (server, _):
        for lines in ("Host: 127.0.0.1:{0}\r\nHost: evil.example\r\n", ""):
            with socket.create_connection(("127.0.0.1", server.server_port), timeout=10) as line:
                line.sendall(f"GET / HTTP/1.1\r\n{lines.format(server.server_port)}\r\n".encode())
                assert line.recv(100).startswith(b"HTTP/1.1 421 ")


def test_only_this_machine_is_listened_to_and_a_taken_port_is_told(runs, cli):
    with served(runs) as (server, _):
        assert server.socket.getsockname()[0] == "127.0.0.1"
        with pytest.raises(InputError, match=f"--port: {server.server_port} cannot be used"):
            PageServer(Observer(runs), server.server_port)
    assert cli("watch", "nowhere")[0] == 2
    assert "--port: must be a whole number from 0 to 65535" in cli("watch", runs, "--port", 70000)[2]


def test_the_address_is_told_and_ctrl_c_ends_it(runs, cli, monkeypatch):
    def interrupt(self):
        raise KeyboardInterrupt

    monkeypatch.setattr(PageServer, "serve_forever", interrupt)
    monkeypatch.setattr("os.nice", lambda by: None)
    code, told, _ = cli("watch", runs, "--json")
    assert code == 130
    assert json.loads(told)["address"].startswith("http://127.0.0.1:")


class Elements(HTMLParser):
    def __init__(self):
        super().__init__()
        self.names = []

    def handle_starttag(self, tag, attrs):
        self.names.append(tag)


def test_names_in_the_folder_can_only_be_read(runs):
    path = files_of(runs)[0]
    hostile = "<img src=x onerror=alert(1)><script>alert(2)</script>"
    told = json.loads(path.read_text())
    path.write_text(json.dumps(told | {"label": hostile, "instance": told["instance"] | {"family": hostile}}))
    with served(runs) as (_, ask):
        html = json.loads(ask(path="/data.json")[2])["html"]
    elements = Elements()
    elements.feed(html)
    assert "&lt;script&gt;" in html
    assert {"img", "script"}.isdisjoint(elements.names)


def test_a_folder_that_is_gone_is_told(runs, monkeypatch):
    with served(runs) as (_, ask):
        shutil.rmtree(runs)
        monkeypatch.setattr("workbench.watching.standing.FRESH", -1.0)
        status, _, text = ask(path="/data.json")
    assert status == 503
    assert "is not a folder of runs" in text


def test_it_runs_beside_a_compare_on_the_same_folder(finished, tmp_path, cli, monkeypatch):
    monkeypatch.setattr("workbench.watching.standing.FRESH", -1.0)  # two short runs may be over while a look is kept
    given = finished.parent / "given"
    asked = f"compare {given} --solvers misbehaving:Honest --time-limit 5 --seeds 2 --jobs 2 --out runs --no-report"
    (tmp_path / "runs").mkdir()
    seen: list[dict] = []
    with served(tmp_path / "runs") as (_, ask):
        over = threading.Event()

        def look() -> None:
            while not over.wait(0.02):
                status, _, text = ask(path="/data.json")
                assert status == 200
                seen.append(json.loads(text))

        looker = threading.Thread(target=look)
        looker.start()
        assert cli(*asked.split())[0] == 0
        over.set()
        looker.join()
    assert max(len(told["running"]) for told in seen) in (1, 2)
    assert sorted(path.name for path in (tmp_path / "runs").rglob(".*")) == []
    assert Watch(tmp_path / "runs").look().sentence == "2 of 2 runs done, 0 running, complete"


@pytest.mark.slow  # a browser
def test_the_page_updates_itself(runs, monkeypatch):
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    if chromium is None:
        pytest.skip("Chromium is not installed")
    last = files_of(runs)[0]
    held = last.rename(last.with_name("aside"))
    monkeypatch.setattr("workbench.watching.standing.FRESH", -1.0)
    with served(runs) as (server, _):
        page = server.observer.page()
        assert "2 of 3" in page
        held.rename(last)
        monkeypatch.setattr(server.observer, "page", lambda: page)  # as it was when it was loaded
        flags = ["--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=5000", "--dump-dom"]
        seen = subprocess.run([chromium, *flags, server.url], capture_output=True, text=True, timeout=120, check=False)
    assert "3 of 3" in seen.stdout
    assert "2 of 3" not in seen.stdout
