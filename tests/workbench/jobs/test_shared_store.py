"""A store that several processes share, and one in which a plug-in deletes, replaces and closes what it likes."""

from __future__ import annotations

import os
import resource
import shutil
import signal
import subprocess
import threading
import time
from collections import Counter
from contextlib import contextmanager
from pathlib import Path

import pytest

from instances import InputError
from instances.disk import write_aside
from reports.record import Run
from workbench.cli import signals_as_exits
from workbench.jobs import claims, execute
from workbench.jobs.backlog import Backlog
from workbench.jobs.execute import DAMAGED, plan, run_locally, shortfall
from workbench.jobs.job import Job, folder_of
from workbench.jobs.problem import Published
from workbench.jobs.store import Store
from workbench.problems.routing import ROUTING
from workbench.sources import FileSource

SEEDS = range(8)


class Told:
    """What a study tells of its progress."""

    def __init__(self) -> None:
        self.here: list[str] = []
        self.there: list[str] = []
        self.waited: list[int] = []

    def finished(self, job: Job, run: Run) -> None:
        self.here.append(job.path)

    def elsewhere(self, job: Job) -> None:
        self.there.append(job.path)

    def waiting(self, count: int) -> None:
        self.waited.append(count)


@pytest.fixture
def sources(instance, instance_file):
    return {folder_of(instance): FileSource(instance_file)}


@pytest.fixture
def jobs(sources) -> list[Job]:
    return [Job(next(iter(sources)), "fake", seed=seed, time_limit=1) for seed in SEEDS]


@pytest.fixture
def opened(tmp_path, sources, jobs):
    """Open the store as a process of its own would."""

    def call() -> Store:
        store = Store(tmp_path / "runs")
        store.create()
        store.keep_items(ROUTING, sources)
        store.put_study({"name": "shared"}, [job.path for job in jobs])
        return store

    return call


@pytest.fixture
def ran(monkeypatch, instance) -> Counter[int]:
    """Let a run take no process and no time, count what is run by seed; `ran.act` is called while seed 4 runs."""
    counted: Counter[int] = Counter()
    counted.act = lambda: None

    def fake(problem, job, item, **more) -> Run:
        counted[job.seed] += 1
        if job.seed == 4:
            counted.act()
        about = problem.describe(item)
        return Run(
            problem="routing", instance=about, solver=job.method, options={}, label="fake", seed=job.seed,
            time_limit=job.time_limit, threads=1, iterations=None, proves=False,
            status="ERROR" if job.seed == 0 else "FEASIBLE", objective=1.0, bound=None, elapsed=0.0, stopped_by="",
            message="x" * 3000 if job.seed == 4 else "", tolerance=0.0, claimed_objective=None, prepare_elapsed=0.0,
            wall_elapsed=0.0, cpu_seconds=0.0, peak_memory=0, environment="", code="", revision="",
            created="2001-01-01T00:00:00+00:00", own={"routes": None, "tour_costs": []},
        )  # fmt: skip

    monkeypatch.setattr(execute, "run", fake)
    return counted


def study(store: Store, todo, seen=None, parallel: int = 1) -> tuple[Told, list[str]]:
    told = Told()
    with Backlog(todo, store, seen) as backlog:
        return told, run_locally(backlog, ROUTING, parallel, told)


def hidden(folder: Path) -> list[Path]:
    return [path for path in folder.rglob(".*") if not path.name.endswith(".displaced")]


class TestShared:
    """Several studies on one store."""

    def both(self, opened, jobs) -> list[Told]:
        found: list[Told] = []

        def one(store: Store) -> None:
            found.append(study(store, jobs, parallel=2)[0])

        study(opened(), [])  # the machine is stated by now: two processes have files aside of their own, threads do not
        threads = [threading.Thread(target=one, args=(opened(),)) for _ in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(60)
        return found

    @pytest.mark.parametrize("machine", [lambda: "this", lambda: threading.current_thread().name], ids=["one", "two"])
    def test_each_run_is_done_once_and_both_end_with_all(self, opened, jobs, ran, tmp_path, machine, monkeypatch):
        monkeypatch.setattr(claims, "_here", lambda: (machine(), "boot"))
        ran.act = lambda: time.sleep(0.7)  # longer than a look at what others do
        found = self.both(opened, jobs)
        assert ran == dict.fromkeys(SEEDS, 1)
        assert sorted(found[0].here + found[0].there) == sorted(job.path for job in jobs)
        assert sorted(found[0].here) == sorted(found[1].there)
        assert sorted(found[1].here) == sorted(found[0].there)
        assert any(told.waited for told in found)
        assert hidden(tmp_path / "runs") == []

    @pytest.mark.parametrize("year", [1971, 2000, 2037])
    def test_a_retry_is_done_once_whatever_the_clocks_said(self, opened, jobs, ran, year):
        store = opened()
        study(store, jobs)
        os.utime(store.root / jobs[0].path, ((year - 1970) * 31_556_952,) * 2)
        first, second = plan(jobs, store, ["ERROR"]), plan(jobs, store, ["ERROR"])
        assert [job.seed for job in first.todo] == [0]
        assert study(opened(), first.todo, first.seen)[0].here == [jobs[0].path]
        assert study(opened(), second.todo, second.seen)[0].there == [jobs[0].path]
        assert ran[0] == 2

    def test_what_another_lets_go_of_unfinished_is_run_here(self, opened, jobs, ran):
        with Backlog(jobs, opened()) as other:
            other._next(Told())
            threading.Timer(0.3, other.__exit__).start()
            told, _ = study(opened(), jobs)
        assert told.waited
        assert ran == dict.fromkeys(SEEDS, 1)

    def test_what_several_ask_is_kept(self, opened, tmp_path):
        store = opened()
        threads = [threading.Thread(target=Store(store.root).put_study, args=({}, [f"{k}/x.json"])) for k in range(12)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert {f"{k}/x.json" for k in range(12)} < set(store.planned())


def spoil_folder(store: Store, folder: Path) -> None:
    shutil.rmtree(folder)
    folder.write_text("not a folder")


def spoil_store(store: Store, folder: Path) -> None:
    shutil.rmtree(store.root)
    store.root.write_text("not a folder")


def spoil_instance(store: Store, folder: Path) -> None:
    (folder / "instance.json").unlink()
    (folder / "instance.json").mkdir()


def loop_store(store: Store, folder: Path) -> None:
    shutil.rmtree(store.root)
    store.root.symlink_to(store.root)


SPOILS = {
    "the store is deleted": lambda store, folder: shutil.rmtree(store.root),
    "the folder is deleted": lambda store, folder: shutil.rmtree(folder),
    "the store is replaced by a file": spoil_store,
    "the folder is replaced by a file": spoil_folder,
    "the instance is deleted": lambda store, folder: (folder / "instance.json").unlink(),
    "the instance is damaged": lambda store, folder: (folder / "instance.json").write_text("{"),
    "the instance is a folder": spoil_instance,
    "the store is a link to itself": loop_store,
    "rows are deleted": lambda store, folder: [path.unlink() for path in folder.glob("fake*")],
    "the claim is deleted": lambda store, folder: [path.unlink() for path in folder.glob(".*.claim")],
    "its row is a folder": lambda store, folder: (folder / "fake-default-s4-t1.json").mkdir(),
    "its row is a pipe": lambda store, folder: os.mkfifo(folder / "fake-default-s4-t1.json"),
    "the folder is closed": lambda store, folder: folder.chmod(0o500),
    "what was asked is deleted": lambda store, folder: (store.root / "study.json").unlink(),
    "the machine is deleted": lambda store, folder: shutil.rmtree(store.root / "environments"),
}


class TestSpoiled:
    """A plug-in with the rights of its user."""

    @pytest.mark.parametrize("read_again", [True, False])
    @pytest.mark.parametrize("spoil", SPOILS.values(), ids=SPOILS)
    def test_the_study_goes_on_and_ends_with_all(self, opened, jobs, ran, spoil, read_again, monkeypatch):
        if read_again:  # the item, before every run
            monkeypatch.setattr(execute, "lru_cache", lambda maxsize: lambda read: read)
        store = opened()
        ran.act = lambda: spoil(store, store.root / jobs[0].folder)
        told, given_up = study(store, jobs)
        assert given_up == []
        assert len(told.here) == len(jobs)
        assert shortfall(jobs, store) == ["1 run ended in ERROR"]
        assert set(store.planned()) == {job.path for job in jobs}
        assert len(list((store.root / "environments").glob("*.json"))) == 1
        assert ROUTING.read(store.root / jobs[0].folder)
        assert plan(jobs, Store(store.root)).damaged == ()

    def test_an_instance_whose_source_is_gone_too_costs_its_runs_only(self, opened, jobs, ran, instance_file):
        store = opened()
        shutil.rmtree(store.root / jobs[0].folder)
        instance_file.unlink()
        told, given_up = study(store, jobs)
        assert (told.here, len(given_up)) == ([], len(jobs))
        assert "small.json" in given_up[0]

    def test_runs_that_were_stored_before_are_missed(self, opened, jobs, ran):
        study(opened(), jobs[:3])
        store = opened()
        ran.act = lambda: shutil.rmtree(store.root)
        study(store, jobs[3:])
        assert shortfall(jobs, store) == ["3 runs missing: the same command runs what is missing"]


class TestNoRoom:
    """Disks that are full, small, or cannot be written."""

    @contextmanager
    def largest_file(self, size: int):
        before = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)

    def test_a_row_that_is_too_large_costs_only_itself(self, opened, jobs, ran, monkeypatch):
        store = opened()
        monkeypatch.setattr("workbench.jobs.store.PROBE", b"x")
        with self.largest_file(2500):
            told, given_up = study(store, jobs)
        assert [sentence.split(": ")[1] for sentence in given_up] == ["cannot be written (File too large)"]
        assert len(told.here) == len(jobs) - 1
        assert hidden(store.root) == []
        assert len(list(store.paths())) == len(jobs) - 1

    def test_a_disk_that_takes_nothing_ends_the_study_with_one_sentence(self, opened, jobs, ran):
        store = opened()
        study(store, jobs[:2])
        kept = {path: (store.root / path).read_bytes() for path in store.paths()}
        with self.largest_file(500), pytest.raises(InputError, match=r"cannot be written \(File too large\)"):
            study(store, jobs[2:])
        assert {path: (store.root / path).read_bytes() for path in store.paths()} == kept
        assert hidden(store.root) == []

    def test_a_full_file_system(self, tmp_path, sources, jobs, ran):
        root = tmp_path / "small"
        root.mkdir()
        mount = ["mount", "-t", "tmpfs", "-o", "size=256k", "tmpfs", str(root)]
        if subprocess.run(mount, capture_output=True, check=False).returncode:
            pytest.skip("only root may mount a file system here")
        try:
            store = Store(root / "runs")
            store.create()
            store.keep_items(ROUTING, sources)
            study(store, jobs[:2])
            kept = {path: (store.root / path).read_bytes() for path in store.paths()}
            with pytest.raises(OSError, match="No space"):
                (root / "filler").write_bytes(bytes(1 << 20))
            with pytest.raises(InputError, match="No space left on device"):
                study(store, jobs[2:])
            assert {path: (store.root / path).read_bytes() for path in store.paths()} == kept
            (root / "filler").unlink()
            assert len(study(store, jobs[2:])[0].here) == len(jobs) - 2
        finally:
            subprocess.run(["umount", str(root)], check=True)

    def test_a_store_that_is_read_only_is_refused_at_once(self, tmp_path):
        closed = tmp_path / "closed"
        closed.mkdir(mode=0o500)
        if os.access(closed, os.W_OK):
            pytest.skip("root writes everywhere")
        with pytest.raises(InputError, match=r"cannot be (made|written)"):
            Store(closed).create()
        assert closed.stat().st_mode & 0o777 == 0o500

    def test_no_links_are_needed(self, opened, jobs, ran, monkeypatch):
        def refuse(*_: object, **__: object) -> None:
            raise PermissionError(1, "Operation not permitted")

        monkeypatch.setattr(os, "link", refuse)
        monkeypatch.setattr(os, "symlink", refuse)
        assert len(study(opened(), jobs)[0].here) == len(jobs)


class TestInterrupted:
    """Ctrl-C, and what counts as it."""

    def test_a_run_that_cannot_be_stopped_is_not_waited_for(self, opened, jobs, ran, tmp_path):
        class Interrupted(Told):
            def finished(self, job: Job, run: Run) -> None:
                raise KeyboardInterrupt

        stuck = threading.Event()
        ran.act = lambda: stuck.wait(60)
        began = time.monotonic()
        with pytest.raises(KeyboardInterrupt), Backlog([jobs[4], jobs[5]], opened()) as backlog:
            run_locally(backlog, ROUTING, 2, Interrupted())
        assert time.monotonic() - began < 2
        assert hidden(tmp_path / "runs") == []
        stuck.set()

    @pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGHUP, 129)])
    def test_other_signals_unwind_as_it_does(self, number, code):
        before = signal.getsignal(number)
        with pytest.raises(SystemExit) as left, signals_as_exits():
            signal.raise_signal(number)
        assert left.value.code == code
        assert signal.getsignal(number) is before

    def test_a_signal_that_is_ignored_stays_so(self):
        before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
        try:
            with signals_as_exits():
                signal.raise_signal(signal.SIGHUP)  # as under nohup
        finally:
            signal.signal(signal.SIGHUP, before)


class TestDamaged:
    """Files that are not the run their name says."""

    @pytest.mark.parametrize("content", ["", "{}", "[1]", "another's"])
    def test_they_are_told_and_run_again_where_asked(self, opened, jobs, ran, content, cli):
        store = opened()
        study(store, jobs)
        wrong = store.root / jobs[2].path
        wrong.write_text((store.root / jobs[3].path).read_text() if content == "another's" else content)
        code, out, err = cli("status", store.root)
        assert (code, str(wrong) in err) == (1, True)
        assert out.splitlines()[-1].startswith("7 of 8 runs stored, 7 of them stale (made by other code), 1 damaged")
        assert len(plan(jobs, store).damaged) == 1
        again = plan(jobs, store, [DAMAGED])
        assert (again.todo, again.damaged) == ((jobs[2],), ())
        study(store, again.todo, again.seen)
        assert plan(jobs, store).damaged == ()

    def test_what_publishing_leaves_unsaid_is_said(self, instance_file, ran, cli, tmp_path, monkeypatch):
        monkeypatch.setattr("workbench.commands.compare._published", lambda folder: Published([], []))
        asked = ["compare", instance_file, "--solvers", "greedy", "--seeds", 3, "--out", "runs"]
        cli(*asked, "--no-report")
        one, other = sorted((tmp_path / "runs").glob("*/greedy*"))[1:]
        one.write_text(other.read_text())
        code, _, err = cli(*asked)
        assert code == 1
        assert f"{one.name}: holds another run than its name and its folder say; left alone" in err

    def test_what_was_asked_must_be_a_list_of_paths(self, opened):
        store = opened()
        for content in ('{"runs": "abc"}', '{"runs": [1]}', "[]", "[" * 100_000, ""):
            write_aside(store.root / "study.json", content)
            with pytest.raises(InputError, match=r"study\.json: is damaged or not ours"):
                store.planned()
