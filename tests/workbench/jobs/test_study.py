"""Studies: grids, what overrides what, and the shipped ones."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import pytest

from instances import InputError
from workbench.jobs.execute import jobs_of
from workbench.jobs.job import Job, file_safe
from workbench.jobs.study import load_tables, shipped_studies, study_from
from workbench.problems.routing import ROUTING
from workbench.settings import key_values, shard
from workbench.sources import FamilySource, instance_files


def made(**tables):
    return study_from({"name": "s", **tables}, ROUTING, name="s", base=Path())


def test_every_list_of_a_family_is_a_grid():
    study = made(
        families=[
            {
                "family": ["uniform", "ring"],
                "tasks": [4, 5],
                "depots": 2,
                "seeds": 3,
                "parameters": {"wind": ["none", "shear"], "airspeed": 20.0},
            }
        ],
        solvers=[{"name": "greedy"}],
    )
    assert len(study.sources) == 2 * 2 * 2 * 3
    assert FamilySource("ring", 5, 2, 2, {"wind": "shear", "airspeed": 20.0}) in study.sources
    assert len({source.load().digest for source in study.sources}) == len(study.sources)


def test_every_list_of_options_is_a_grid_and_defaults_leave_no_trace():
    study = made(solvers=[{"name": "ga", "options": {"population": [200, 400], "generations": [10, 3000]}}])
    assert [entry.options for entry in study.entries] == [
        {"population": 200, "generations": 10},
        {"population": 200},
        {"generations": 10},
        {},
    ]


def test_a_solver_overrides_the_study_and_flags_override_both():
    tables = {
        "seeds": 2,
        "time_limit": [1, 2],
        "threads": 2,
        "solvers": [{"name": "greedy"}, {"name": "ga", "seeds": [7], "time_limit": 9, "threads": 1, "iterations": 5}],
    }
    plain, own = made(**tables).entries
    assert (plain.seeds, plain.time_limits, plain.threads, plain.iterations) == ((0, 1), (1.0, 2.0), 2, None)
    assert (own.seeds, own.time_limits, own.threads, own.iterations) == ((7,), (9.0,), 1, 5)
    for entry in study_from(tables, ROUTING, name="s", base=Path(), changes={"seeds": 1, "time_limit": 3}).entries:
        assert (entry.seeds, entry.time_limits) == ((0,), (3.0,))


def test_large_instances_are_kept_from_small_solvers():
    families = [{"family": "uniform", "tasks": [4, 9], "depots": 2}]
    study = made(families=families, solvers=[{"name": "milp", "max_tasks": 4}, {"name": "greedy"}])
    assert [(job.folder.split("-")[1], job.method) for job in jobs_of(study)] == [
        ("n4", "milp"),
        ("n4", "greedy"),
        ("n9", "greedy"),
    ]


def test_the_same_job_asked_for_twice_is_one():
    families = [{"family": "uniform", "tasks": 4, "depots": 2}]
    study = made(families=families, solvers=[{"name": "ga"}, {"name": "ga", "options": {"population": [400, 50]}}])
    assert [job.label for job in jobs_of(study)] == ["ga", "ga (population=50)"]


@pytest.mark.parametrize("name", ["quick", "paper", "benchmarks", "scaling", "ablation", "turns"])
def test_shipped_studies_are_sound(name):
    path = shipped_studies()[name]
    study = study_from(load_tables(path), ROUTING, name=path.stem, base=path.parent)
    assert study.name == name
    assert study.asked["description"]
    assert bool(study.sources) == (name != "benchmarks")
    smallest = min(study.sources, key=lambda source: source.n_tasks, default=None)
    if smallest is not None:
        assert smallest.load().n_tasks == smallest.n_tasks


def test_jobs_differ_in_their_path():
    jobs = [
        Job("f", "ga"),
        Job("f", "ga", {"population": 50}),
        Job("f", "ga", {"population": 500}),
        Job("f", "ga", seed=1),
        Job("f", "ga", time_limit=0.5),
        Job("f", "ga", threads=2),
        Job("f", "ga", iterations=0),
        Job("f", "a:b"),
        Job("f", "a_b"),
        Job("g", "ga"),
        Job("f", "ga", {"x": "a/b"}),
        Job("f", "ga", {"x": "a b"}),
        Job("f", "ga", {"x": "y" * 300}),
        Job("f", "ga", {"x": "y" * 301}),
    ]
    assert len({job.path for job in jobs}) == len(jobs)
    assert jobs[0].path == "f/ga-default-s0-t10.json"
    assert all(len(job.path) < 200 and job.path.count("/") == 1 for job in jobs)
    assert not file_safe("../x").startswith(".")


def test_settings_read_as_json_or_as_text():
    given = ["a=1", "b=0.5", "c=true", "d=word", "e=a=b", 'f=["x"]']
    assert key_values(given, "--set") == {"a": 1, "b": 0.5, "c": True, "d": "word", "e": "a=b", "f": ["x"]}
    assert shard("2/5") == (2, 5)
    for wrong in ("0/5", "6/5", "2", "a/b", "2/0"):
        with pytest.raises(InputError, match="--shard"):
            shard(wrong)


def test_a_folder_is_searched_for_instances(instance_folder):
    (instance_folder / "tours.json").write_text(json.dumps({"r4-2-0": [[0, 1]]}))
    (instance_folder / "README.md").write_text("about")
    (instance_folder / "r4-2-0.paths.json.gz").write_bytes(b"")  # the paths behind its costs
    assert [path.name for path in instance_files(instance_folder)] == [f"r4-2-{k}.json" for k in range(3)]
    assert [path.name for path in instance_files(instance_folder / "*-1.json")] == ["r4-2-1.json"]
    with pytest.raises(InputError, match="nothing"):
        instance_files(instance_folder / "nothing")


def test_planned_paths_beside_an_instance_are_no_instances(cli, tmp_path):
    cli("generate", "corridor", "--tasks", "4", "--depots", "2", "--out", tmp_path)
    assert len(list(tmp_path.glob("*.paths.json.gz"))) == 1
    (instance,) = instance_files(tmp_path)
    packed = tmp_path / "packed.json.gz"
    packed.write_bytes(gzip.compress(instance.read_bytes()))
    assert instance_files(tmp_path) == [instance, packed]
    assert instance_files(tmp_path / "*.json*") == [instance, packed]
    packed.write_bytes(packed.read_bytes()[:40])
    assert packed in instance_files(tmp_path)  # damage is told when it is read
