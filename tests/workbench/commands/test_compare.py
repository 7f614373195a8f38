"""A study is run once, whatever interrupts it: what is stored is done."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time

import pytest

MEASURED = "elapsed"
"""In results.csv the columns from this one on are times, memory, machine: they differ between executions."""

STUDY = """
name = "tiny"
time_limit = 5
files = ["given/r4-2-[01].json"]

[[solvers]]
name = "misbehaving:Honest"
options = { delay = [0.1, 0.2] }

[[solvers]]
name = "misbehaving:Crashes"
seeds = [7]
"""
ALL = 2 * (2 + 1)


@pytest.fixture
def study(tmp_path, instance_folder):
    path = tmp_path / "tiny.toml"
    path.write_text(STUDY)
    return path


def unmeasured(path):
    """Return results.csv without its measured columns."""
    with path.open(newline="") as file:
        rows = list(csv.reader(file))
    return [row[: rows[0].index(MEASURED)] for row in rows]


def test_compare_runs_stores_and_reports(cli, study, tmp_path, stored_json):
    code, out, err = cli("compare", study, "--out", "runs", "--jobs", 2)
    assert (code, err.splitlines()[-1]) == (1, "2 runs ended in ERROR")
    runs = stored_json(tmp_path / "runs")
    assert len(runs) == ALL
    assert {run["status"] for name, run in runs.items() if "Honest" in name} == {"FEASIBLE"}
    assert {run["status"] for name, run in runs.items() if "Crashes" in name} == {"ERROR"}
    assert len(unmeasured(tmp_path / "runs" / "results.csv")) == 1 + ALL
    assert (tmp_path / "runs" / "report.html").read_text().startswith("<!")
    assert "Method" in out
    assert f"[{ALL}/{ALL}]" in err
    (environment,) = (tmp_path / "runs" / "environments").glob("*.json")
    assert {run["environment"] for run in runs.values()} == {environment.stem}
    assert set(json.loads((tmp_path / "runs" / "study.json").read_text())["runs"]) == set(runs)


def test_what_is_stored_is_not_run_again_unless_asked(cli, study, tmp_path):
    cli("compare", study, "--out", "runs", "--no-report")
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "runs").glob("r*/*.json")}
    _, _, err = cli("compare", study, "--out", "runs", "--no-report")
    assert f"{ALL} of {ALL} runs are stored already" in err
    assert {path: path.stat().st_mtime_ns for path in before} == before
    cli("compare", study, "--out", "runs", "--no-report", "--retry", "error,killed")
    changed = {path.name for path in before if path.stat().st_mtime_ns != before[path]}
    assert changed == {path.name for path in before if "Crashes" in path.name}


def signalled_half_way(args, folder, how: signal.Signals) -> int:
    """Start `compare`, send it a signal once some runs are stored but not all, and return its exit code."""
    program = "from workbench.cli import main; main()"
    process = subprocess.Popen(
        [sys.executable, "-c", program, *args],
        env=dict(os.environ),
        stderr=subprocess.DEVNULL,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # a shell's background jobs ignore it
    )
    until = time.monotonic() + 60
    while len(list(folder.glob("r*/misbehaving*.json"))) < 2 and time.monotonic() < until:
        time.sleep(0.02)
    process.send_signal(how)
    return process.wait(30)


@pytest.mark.slow
def test_interrupted_and_started_again_gives_the_same_csv(cli, study, tmp_path, stored_json):
    args = ["compare", str(study), "--jobs", "1", "--no-report", "--out"]
    assert cli(*args, tmp_path / "whole")[0] == 1  # some runs end in ERROR
    cli("report", tmp_path / "whole", "--csv", "whole.csv")
    for how, code in ((signal.SIGKILL, -signal.SIGKILL), (signal.SIGINT, 130)):
        folder = tmp_path / how.name
        assert signalled_half_way([*args, str(folder)], folder, how) == code
        kept = stored_json(folder)  # every stored run is whole
        assert 2 <= len(kept) < ALL
        assert cli(*args, folder)[0] == 1
        finished = stored_json(folder)
        assert {name: finished[name] for name in kept} == kept
        cli("report", folder, "--csv", "again.csv")
        assert unmeasured(tmp_path / "again.csv") == unmeasured(tmp_path / "whole.csv")


def test_a_damaged_file_is_named_and_left_alone(cli, study, tmp_path):
    cli("compare", study, "--out", "runs", "--no-report")
    paths = sorted((tmp_path / "runs").glob("r4-2-0*/*Honest*.json"))
    damaged, foreign = paths[:2]
    damaged.write_text(damaged.read_text()[:100])
    foreign.write_text('{"hello": "world"}')
    code, _, err = cli("compare", study, "--out", "runs", "--no-report", "--retry", "error")
    assert code == 1
    assert damaged.name in err
    assert foreign.name in err
    assert len(damaged.read_text()) == 100
    assert foreign.read_text() == '{"hello": "world"}'
    _, _, err = cli("report", "runs", "--csv", "rest.csv")
    assert damaged.name in err
    assert len(unmeasured(tmp_path / "rest.csv")) == 1 + ALL - 2


def test_shards_partition_the_study(cli, study, tmp_path):
    def planned(*more):
        return cli("compare", study, "--out", "runs", "--dry-run", *more)[1].splitlines()[:-1]

    parts = [planned("--shard", f"{part}/3") for part in (1, 2, 3)]
    assert [len(part) for part in parts] == [2, 2, 2]
    assert sorted(path for part in parts for path in part) == sorted(planned())
    assert len(set(planned())) == ALL


def test_shards_may_share_a_folder(cli, study, tmp_path, stored_json):
    for part in (1, 2):
        cli("compare", study, "--out", "runs", "--shard", f"{part}/2", "--no-report")
        assert len(stored_json(tmp_path / "runs")) == part * ALL / 2


def test_dry_run_writes_nothing(cli, study, tmp_path):
    code, out, _ = cli("compare", study, "--out", "runs", "--dry-run", "--jobs", 2)
    assert code == 0
    lines = out.splitlines()
    assert len(lines) == ALL + 1
    assert lines[-1].startswith("6 runs to do (0 of 6 stored), at most 21 s")
    assert not (tmp_path / "runs").exists()


def test_instances_with_solvers_make_a_study(cli, instance_folder, tmp_path, stored_json):
    args = [
        "compare",
        instance_folder,
        "--solvers",
        "misbehaving:Honest",
        "--time-limit",
        3,
        "--seeds",
        2,
        "--no-report",
    ]
    assert cli(*args, "--out", "runs")[0] == 0
    runs = stored_json(tmp_path / "runs")
    assert sorted((run["instance"]["name"], run["seed"], run["time_limit"]) for run in runs.values()) == [
        (f"r4-2-{k}", seed, 3.0) for k in range(3) for seed in range(2)
    ]


def test_flags_take_the_place_of_what_the_study_says(cli, study):
    _, out, _ = cli("compare", study, "--dry-run", "--time-limit", 3, "--seeds", 1)
    names = out.splitlines()[:-1]
    assert len(names) == 2 * 3
    assert all(name.endswith("-s0-t3.json") for name in names)
    _, out, _ = cli("compare", "--dry-run", "--solvers", "greedy")  # of the study quick
    assert len(out.splitlines()) > 4
    assert all("/greedy-" in name for name in out.splitlines()[:-1])


def test_a_false_claim_is_told_at_the_end(cli, instance_file):
    code, _, err = cli("compare", instance_file, "--solvers", "misbehaving:LiesAboutCost,greedy", "--out", "runs")
    assert code == 1
    assert "misbehaving:LiesAboutCost" in err.splitlines()[-2]
    assert err.splitlines()[-1] == "1 run ended in ERROR"


def test_too_many_threads_are_warned_of(cli, instance_file):
    args = ["compare", instance_file, "--solvers", "misbehaving:Honest", "--threads", 64, "--dry-run"]
    assert "64 threads each" in cli(*args)[2]


@pytest.mark.parametrize(("given", "meant"), [("2GB", 2 * 10**9), ("1.5 G", 15 * 10**8), ("700M", 7 * 10**8), ("9", 9)])
def test_a_memory_limit_is_that_of_each_run(cli, instance_file, monkeypatch, given, meant):
    limits = []

    def stopped(*args, memory_limit, **more):
        limits.append(memory_limit)
        raise KeyboardInterrupt

    monkeypatch.setattr("workbench.jobs.execute.run", stopped)
    assert cli("compare", instance_file, "--solvers", "greedy", "--out", "runs", "--memory-limit", given)[0] == 130
    assert limits == [meant]


@pytest.mark.parametrize("given", ["lots", "0", "-2GB", "1e9", "2GiB", "9" * 400, "nan"])
def test_a_memory_limit_that_is_none_is_refused(cli, instance_file, given):
    code, _, err = cli("compare", instance_file, "--solvers", "greedy", "--memory-limit", given)
    assert (code, err.count("\n")) == (2, 1)
    assert err.startswith("workbench: --memory-limit: must be a size such as 2GB")


def test_an_item_that_cannot_be_made_leaves_no_store(cli, study, tmp_path):
    study.write_text(study.read_text() + '[[families]]\nfamily = "uniform"\ntasks = [4, 200000000]\ndepots = 2\n')
    assert cli("compare", study, "--out", "runs")[0] == 2
    assert not (tmp_path / "runs").exists()
