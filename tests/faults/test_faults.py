"""Whatever a plug-in does, its study has one row more, goes on, and leaves no process behind.

``pytest tests/faults -m slow`` runs all of them, in about three minutes on two cores.
"""

from __future__ import annotations

import os
import uuid
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest

from instances import Instance
from reports.record import Run
from tests.faults.faults import FAULTS, MODULES, Fault
from tests.faults.remains import TOKEN, left_after
from tests.workbench.conftest import random_instance
from workbench.jobs.backlog import Backlog
from workbench.jobs.execute import run_locally
from workbench.jobs.job import Job, folder_of
from workbench.jobs.process import child
from workbench.jobs.store import Store
from workbench.problems.routing import ROUTING

ROOT = Path(__file__).parents[2]
HONEST = "tests.faults.hostile:Honest"


@pytest.fixture
def token(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """Mark the processes of this test, let them import plug-ins, and lower limits."""
    mark = uuid.uuid4().hex
    (tmp_path / "modules").mkdir()
    for name, text in MODULES.items():
        (tmp_path / "modules" / f"{name}.py").write_text(text)
    monkeypatch.setenv(TOKEN, mark)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(ROOT), str(tmp_path / "modules")]), prepend=os.pathsep)
    monkeypatch.setattr(child, "grace", lambda limit: 3.0)
    monkeypatch.setattr(child, "EXIT_GRACE", 1.0)
    monkeypatch.setattr(child, "KILLER_GRACE", 0.1)
    (tmp_path / "cwd").mkdir()
    monkeypatch.chdir(tmp_path / "cwd")
    yield mark
    left_after(mark, 0)


@dataclass(frozen=True)
class Given:
    """An item of a study that is already made."""

    instance: Instance

    def load(self) -> Instance:
        """Return it."""
        return self.instance


def kept(store: Store) -> str:
    """Begin a store that holds one instance; return the folder of its runs."""
    instance = random_instance(4, 2, 0)
    store.create()
    store.keep_items(ROUTING, {folder_of(instance): Given(instance)})
    return folder_of(instance)


def study_of(faults: Sequence[Fault], store: Store, memory_limit: int) -> list[Job]:
    """Run `faults` as one study, two at once, and return its jobs, an honest one at the end."""
    folder = kept(store)
    jobs = [Job(folder, f.method, f.options, number, 1.0) for number, f in enumerate(faults)]
    jobs.append(Job(folder, HONEST, {}, 0, 5.0))
    told = work_off(jobs, store, parallel=2, memory_limit=memory_limit)
    assert sorted(told) == sorted(job.path for job in jobs)
    return jobs


class Heard:
    """Listens to a study: the paths of the runs that have ended."""

    def __init__(self) -> None:
        self.paths: list[str] = []

    def finished(self, job: Job, run: Run) -> None:
        self.paths.append(job.path)

    def elsewhere(self, job: Job) -> None:
        raise AssertionError(f"{job.path} is said to be run by another")

    def waiting(self, count: int) -> None:
        raise AssertionError(f"waits for {count} runs of another")


def work_off(jobs: Sequence[Job], store: Store, parallel: int, memory_limit: int = 4 << 30) -> list[str]:
    """Run jobs as `compare` does; return the paths of those that have ended."""
    heard = Heard()
    with Backlog(jobs, store) as backlog:
        assert run_locally(backlog, ROUTING, parallel, heard, memory_limit) == []
    return heard.paths


def judge(faults: Sequence[Fault], tmp_path: Path, token: str, memory_limit: int = 4 << 30) -> None:
    """Run a study and assert what is stored and what is left."""
    store = Store(tmp_path / "runs")
    jobs = study_of(faults, store, memory_limit)
    left = left_after(token, 5)
    wrong = [f"left running: {process}" for process in left]
    for fault, job in zip([*faults, Fault(HONEST, ("FEASIBLE",))], jobs, strict=True):
        run = store.get(job.path)
        if run.status not in fault.statuses or fault.words not in run.message:
            wrong.append(f"{fault.name}: {run.status}: {run.message[:200]}")
        if len(run.message) > 5000 or (tmp_path / "runs" / job.path).stat().st_size > 1 << 20:
            wrong.append(f"{fault.name}: more is stored than anybody reads")
        if run.status == "FEASIBLE" and (run.objective is None or run.elapsed < 0):
            wrong.append(f"{fault.name}: feasible with {run.objective} s after {run.elapsed} s")
    assert list(store.paths()) == sorted(job.path for job in jobs)  # a row each
    assert not wrong, "\n".join(wrong)


def those(kind: str) -> list[Fault]:
    return [fault for fault in FAULTS if fault.kind == kind]


def test_sixty_plug_ins_and_more() -> None:
    assert len({fault.name for fault in FAULTS}) == len(FAULTS) >= 60


def test_some_hostile_plug_ins(tmp_path: Path, token: str) -> None:
    judge([fault for fault in FAULTS if fault.quick], tmp_path, token)


@pytest.mark.slow
def test_every_hostile_plug_in(tmp_path: Path, token: str) -> None:
    judge(those("solve"), tmp_path, token)


@pytest.mark.slow
def test_what_is_left_without_a_keeper(tmp_path: Path, token: str) -> None:
    judge(those("keeper"), tmp_path, token)


@pytest.mark.slow
def test_memory_is_that_of_all_processes(tmp_path: Path, token: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(child, "grace", lambda limit: 60.0)
    judge(those("memory"), tmp_path, token, memory_limit=600 << 20)


@pytest.mark.slow
def test_preparing_has_limits(tmp_path: Path, token: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(child, "PREPARE_CPU", 6.0)
    monkeypatch.setattr(child, "PREPARE_WALL", 40.0)
    judge(those("prepare"), tmp_path, token)


DELETES = """
import os, shutil
from tests.faults.hostile import plug_in

@plug_in
def the_store(instance, observe):
    shutil.rmtree(os.environ["STORE"])

@plug_in
def the_instances(instance, observe):
    for folder in os.listdir(os.environ["STORE"]):
        shutil.rmtree(os.path.join(os.environ["STORE"], folder), ignore_errors=True)
"""


@pytest.mark.parametrize("name", ["the_store", "the_instances"])
def test_a_plug_in_that_deletes(tmp_path: Path, token: str, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """The store is made again; the row is written, and the study goes on."""
    (tmp_path / "modules" / "deletes.py").write_text(DELETES)
    store = Store(tmp_path / "runs")
    monkeypatch.setenv("STORE", str(store.root))
    folder = kept(store)
    jobs = [Job(folder, f"deletes:{name}", {}, 0, 2.0), Job(folder, HONEST, {}, 0, 2.0)]
    work_off(jobs, store, parallel=1)
    assert [store.get(job.path).status for job in jobs] == ["FEASIBLE", "FEASIBLE"]
    assert not left_after(token, 5)
