"""The store: whole files only, instances kept beside their runs, and what was asked of a folder."""

from __future__ import annotations

import json

import pytest

from formulations.routing.solver import Status
from instances import InputError, Instance
from reports.record import Run, run_from
from workbench.jobs.census import census
from workbench.jobs.execute import plan
from workbench.jobs.job import Job, folder_of
from workbench.jobs.progress import COLD, STARTING, Estimate, duration
from workbench.jobs.runner import run
from workbench.jobs.store import Store
from workbench.problems.routing import ROUTING


@pytest.fixture
def store(tmp_path) -> Store:
    made = Store(tmp_path / "runs")
    made.create()
    return made


@pytest.fixture
def job(store, instance) -> Job:
    return Job(store.put_item(ROUTING, instance), "misbehaving:Honest", {"delay": 0.0}, time_limit=1)


@pytest.fixture
def honest(job, instance) -> Run:
    return run(ROUTING, job, instance)


def test_what_is_put_is_got(store, job, honest, instance):
    assert not store.has(job)
    store.put(job.path, honest)
    assert store.has(job)
    assert store.get(job.path) == honest
    assert list(store.paths()) == [job.path]
    kept = ROUTING.read(store.root / job.folder)
    assert (kept.digest, kept.name) == (instance.digest, instance.name)


def test_a_large_instance_is_compressed(store, instance):
    large = Instance("large", [[0.0 if i == j else 1.0 for j in range(502)] for i in range(502)], 500, 2)
    folder = store.put_item(ROUTING, large)
    assert (store.root / folder / "instance.json.gz").exists()
    assert ROUTING.read(store.root / folder).digest == large.digest


def test_an_exchanged_instance_is_noticed(store, instance):
    other = Instance("other", [[0.0, 1.0], [2.0, 0.0]], 1, 1)
    folder = store.put_item(ROUTING, instance)
    (store.root / folder / "instance.json").unlink()
    with pytest.raises(InputError, match="missing"):
        ROUTING.read(store.root / folder)
    copy = (store.root / store.put_item(ROUTING, other) / "instance.json").read_bytes()
    (store.root / folder / "instance.json").write_bytes(copy)
    with pytest.raises(InputError, match="is not the instance of its folder"):
        ROUTING.read(store.root / folder)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "is not valid JSON"),
        (b"[]", "not a run of this workbench"),
        (b'{"solver": "ga", "status": "OPTIMAL", "schema": 2}', "has schema 2"),
        (b'{"solver": "ga", "status": "OPTIMAL", "schema": 1}', "is missing"),
        (b"\xff\xfe", "is not UTF-8 text"),
    ],
)
def test_a_damaged_or_foreign_file_is_named(store, job, content, words):
    (store.root / job.path).write_bytes(content)
    with pytest.raises(InputError, match=words) as told:
        store.get(job.path)
    assert str(store.root / job.path) in str(told.value)
    planned = plan([job], store, retry=[Status.ERROR])
    assert (planned.todo, len(planned.damaged)) == ((), 1)  # left alone, not run over
    assert (store.root / job.path).read_bytes() == content


def test_half_written_files_aside_are_not_runs(store, job, honest):
    store.put(job.path, honest)
    (store.root / job.folder / ".greedy-default.json.part").write_text("{")
    assert list(store.paths()) == [job.path]
    assert census(store.root).damaged == ()


def test_a_folder_remembers_all_that_was_asked_of_it(store):
    store.put_study({"name": "one"}, ["a/x.json", "a/y.json"])
    store.put_study({"name": "two"}, ["a/y.json", "b/z.json"])
    assert store.planned() == ["a/x.json", "a/y.json", "b/z.json"]
    assert json.loads((store.root / "study.json").read_text())["study"] == {"name": "two"}


def test_a_run_survives_json(honest):
    assert run_from(json.loads(honest.to_json())) == honest
    text = json.loads(honest.to_json())
    assert (text["schema"], text["problem"], text["gap"]) == (1, "routing", None)
    assert text["instance"]["n_tasks"] == 4


def test_time_left_counts_compiling_once_a_method(instance):
    first, *later = [Job(folder_of(instance), "ga", seed=seed, time_limit=10) for seed in range(3)]
    other = Job(folder_of(instance), "memetic", time_limit=10)
    estimate = Estimate([first, *later, other], parallel=1)
    estimate.finished(first, wall=34, prepared=30)
    assert estimate.left() == 2 * (4 + COLD) + (10 + STARTING + 30)  # the other method is still to be compiled
    estimate.finished(other, wall=40, prepared=30)
    assert estimate.left() == 2 * (4 + COLD)
    estimate.finished(later[0], wall=5, prepared=1)
    assert estimate.left() == 4 + 1


def test_time_left_is_learnt_from_each_solver(instance):
    slow = [Job(folder_of(instance), "ga", seed=seed, time_limit=10) for seed in range(3)]
    fast = [Job(folder_of(instance), "greedy", seed=seed, time_limit=10) for seed in range(2)]
    estimate = Estimate([*slow, *fast], parallel=2)
    assert estimate.left() == 5 * 12 / 2  # nothing known but the limits
    estimate.finished(fast[0], wall=0.5)
    assert estimate.left() == (3 * 12 + 0.5) / 2
    estimate.finished(slow[0], wall=4)
    assert estimate.left() == (2 * 4 + 0.5) / 2
    assert [duration(s) for s in (45, 720, 12600)] == ["45 s", "12 min", "3.5 h"]
