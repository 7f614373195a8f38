"""What the machinery promises holds for every problem: routing, placement, moving costs and surveys."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import psutil
import pytest

from workbench.jobs.job import Job
from workbench.jobs.process import child
from workbench.jobs.runner import run
from workbench.jobs.study import load_tables, study_from
from workbench.problems import PROBLEMS

SCENARIO = """
airspeed = 20.0
size = [1000, 1000]
depots = [[10, 10], [990, 10]]
tasks = [[500, 900]]
"""


@dataclass(frozen=True)
class Case:
    """A problem, its methods that misbehave, how its study names two items, and the words of a lie."""

    problem: str
    module: str
    entries: str
    items: str
    lie: str
    lies: str

    def study(self, *methods: str, seeds: int = 1) -> str:
        tables = "".join(f'[[{self.entries}]]\nname = "{self.module}:{m}"\noptions = {{OPTIONS}}\n' for m in methods)
        return f'problem = "{self.problem}"\nseeds = {seeds}\ntime_limit = 5\n{self.items}\n' + tables


CASES = [
    Case("routing", "misbehaving", "solvers", 'files = ["given/r4-2-[01].json"]', "LiesAboutCost", "claimed a longest"),
    Case("placement", "misplacing", "methods", 'tasks = [2, 3]\ntests = "4x4"', "Liar", "claimed 99.0 nats"),
    Case("moving-cost", "misplanning", "methods", 'scenarios = ["calm.toml", "warm.toml"]', "Liar", "s claimed"),
    Case(
        "survey",
        "misflying",
        "methods",
        'endurance = [80, 90]\n[[fields]]\nkind = "gp"',
        "Liar",
        "more than the 8000 m",
    ),
]


LONGER = pytest.mark.slow  # routing shows the same of the machinery sooner
RUN = [pytest.param(c, id=c.problem, marks=[LONGER] if c.problem != "routing" else []) for c in CASES]


@pytest.fixture(params=RUN)
def case(request, tmp_path, instance_folder, monkeypatch) -> Case:
    """A problem, with the files its studies name in an empty folder."""
    monkeypatch.chdir(tmp_path)
    Path("calm.toml").write_text(SCENARIO)
    Path("warm.toml").write_text(SCENARIO.replace("900", "600"))
    return request.param


def written(case: Case, *methods: str, seeds: int = 1, options: str = "") -> Path:
    path = Path("study.toml")
    path.write_text(case.study(*methods, seeds=seeds).replace("OPTIONS", options))
    return path


def first_item(case: Case) -> tuple[Any, Any]:
    problem = PROBLEMS.load(case.problem)
    tables = load_tables(written(case, "Honest"))
    item = next(iter(study_from(tables, problem, name="x", base=Path()).sources)).load()
    problem.write(item, Path.cwd())
    return problem, item


@pytest.fixture
def finish(case, monkeypatch):
    """Run one method that misbehaves on the first item, with the grace shortened."""
    monkeypatch.setattr(child, "grace", lambda limit: 1.0)
    problem, item = first_item(case)

    def go(method: str, time_limit: float = 0.5, **settings: Any):
        return run(problem, Job("", f"{case.module}:{method}", time_limit=time_limit), item, **settings)

    return go


def runs_in(folder: Path) -> dict[tuple[Any, ...], Any]:
    """Return what does not depend on time or machine, by item, method and seed."""
    found = {}
    for path in sorted(folder.glob("*/*-s*-t*.json")):
        run = json.loads(path.read_text())
        key = (run["instance"]["digest"], run["label"], run["seed"])
        found[key] = [run.get(name) for name in ("status", "objective", "bound", "routes", "points", "cost", "code")]
    return found


class TestEveryProblem:
    """One class for all; the suite of the machinery."""

    def test_a_crash_is_a_run(self, finish):
        found = finish("Crashes")
        assert (found.status, found.stopped_by) == ("ERROR", "error")
        assert "the dog ate" in found.message

    def test_a_hang_is_killed(self, finish):
        found = finish("Hangs")
        assert (found.status, found.stopped_by) == ("KILLED", "killed")
        assert "ignored its time limit of 0.5 s" in found.message

    def test_a_flood_of_memory_is_killed(self, finish):
        found = finish("EatsMemory", 60, memory_limit=700 * 2**20)
        assert (found.status, found.stopped_by) == ("KILLED", "memory")

    def test_a_lie_is_an_error(self, case, finish):
        found = finish(case.lie)
        assert found.status == "ERROR"
        assert case.lies in found.message

    def test_shards_make_the_whole(self, case, cli, tmp_path):
        study = written(case, "Honest", "Crashes")
        assert cli("compare", study, "--out", "whole", "--no-report")[0] == 1  # some runs end in ERROR
        for part in (1, 2):
            cli("compare", study, "--out", "parts", "--shard", f"{part}/2", "--no-report")
            assert len(runs_in(tmp_path / "parts")) == 2 * part
        assert runs_in(tmp_path / "parts") == runs_in(tmp_path / "whole")
        code, said, _ = cli("status", "parts", "--json")
        told = json.loads(said)
        assert (code, told["planned"], told["stored"], told["stale"], told["missing"]) == (0, 4, 4, 0, 0)

    def test_only_what_failed_runs_again(self, case, cli, tmp_path):
        study = written(case, "Honest", "Crashes")
        cli("compare", study, "--out", "runs", "--no-report")
        before = {path: path.stat().st_mtime_ns for path in (tmp_path / "runs").glob("*/*-s0-*.json")}
        cli("compare", study, "--out", "runs", "--no-report", "--retry", "error")
        again = {path.name for path, then in before.items() if path.stat().st_mtime_ns != then}
        assert again == {path.name for path in before if "Crashes" in path.name}

    def test_stale_runs_are_counted_and_run_again(self, case, cli, tmp_path):
        study = written(case, "Honest", seeds=2)
        cli("compare", study, "--out", "runs", "--no-report")
        (old, *others) = sorted((tmp_path / "runs").glob("*/*-s*-*.json"))
        old.write_text(json.dumps(json.loads(old.read_text()) | {"code": "0" * 12}))
        before = {path: path.stat().st_mtime_ns for path in others}
        assert json.loads(cli("status", "runs", "--json")[1])["stale"] == 1
        assert "1 of them stale" in cli("check", "runs")[1]
        _, out, err = cli("compare", study, "--out", "runs")
        assert "1 stored runs are stale" in err
        assert "1 of 4 runs were made by other code than today's, by 2 different versions" in out
        assert "1 of 4 runs were made by other code" in (tmp_path / "runs" / "report.html").read_text()
        cli("compare", study, "--out", "runs", "--no-report", "--retry", "stale")
        assert json.loads(old.read_text())["code"] != "0" * 12
        assert {path: path.stat().st_mtime_ns for path in others} == before

    def test_kill_9_of_the_parent_loses_and_repeats_nothing(self, case, cli, tmp_path):
        study = written(case, "Honest", seeds=3, options="delay = 0.6")
        program = "from workbench.cli import main; main()"
        args = ["compare", str(study), "--out", "runs", "--jobs", "2", "--no-report"]
        parent = subprocess.Popen(
            [sys.executable, "-c", program, *args], stderr=subprocess.DEVNULL, env=dict(os.environ)
        )
        until = time.monotonic() + 60
        while len(runs_in(tmp_path / "runs")) < 2 and time.monotonic() < until:
            time.sleep(0.02)
        children = psutil.Process(parent.pid).children(recursive=True)
        parent.send_signal(signal.SIGKILL)
        parent.wait()
        _, alive = psutil.wait_procs(children, timeout=10)
        assert not alive
        kept = {path: path.read_bytes() for path in (tmp_path / "runs").glob("*/*-s*-*.json")}
        assert 2 <= len(kept) < 6
        assert cli(*args)[0] == 0
        assert len(runs_in(tmp_path / "runs")) == 6
        assert {path: path.read_bytes() for path in kept} == kept
        assert cli("check", "runs")[0] == 0

    @pytest.mark.slow
    def test_a_cluster_gives_the_same_rows(self, case, cli, tmp_path):
        distributed = pytest.importorskip("distributed", reason="the extra 'cluster' is not installed")
        study = written(case, "Honest", "Crashes")
        with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
            there = ["--scheduler", cluster.scheduler_address]
            assert cli("compare", study, "--out", "there", "--no-report", *there)[0] == 1
        assert cli("compare", study, "--out", "here", "--no-report")[0] == 1
        assert runs_in(tmp_path / "there") == runs_in(tmp_path / "here")
