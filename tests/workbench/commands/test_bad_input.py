"""Bad input: one sentence that names file, field and value; exit code 2; nothing half-written."""

from __future__ import annotations

import errno
import json
import os

import pytest


def refused(told: tuple[int, str, str], *words: str) -> None:
    """Assert that the command ended with code 2, nothing on stdout, and one sentence that holds `words`."""
    code, out, err = told
    assert (code, out) == (2, "")
    (sentence,) = [line for line in err.splitlines() if not line.startswith("warning")]
    assert sentence.startswith("workbench: ")
    for word in words:
        assert word in sentence


def changed(path, **fields):
    """Return a copy of an instance file with other fields."""
    other = path.with_name("other.json")
    other.write_text(json.dumps(json.loads(path.read_text()) | fields))
    return other


@pytest.mark.parametrize(
    ("cost", "words"),
    [
        ([[0, 1], [1]], ["cost"]),
        ([[0, 1, 2], [1, 0, 2]], ["cost", "3"]),
        ([[0, float("nan")], [1, 0]], ["cost"]),
        ([[0, 1], [float("inf"), 0]], ["cost"]),
        ([[0, -1], [1, 0]], ["cost", "-1"]),
    ],
)
def test_costs(cli, instance_file, cost, words):
    bad = changed(instance_file, n_tasks=1, n_depots=1, cost=cost, coordinates=None)
    refused(cli("solve", bad, "--solver", "greedy"), "other.json", *words)


@pytest.mark.parametrize("field", ["n_tasks", "n_depots"])
def test_no_tasks_or_no_depots(cli, instance_file, field):
    refused(cli("solve", changed(instance_file, **{field: 0}), "--solver", "greedy"), "other.json", field, "0")
    flag = {"n_tasks": "--tasks", "n_depots": "--depots"}[field]
    refused(cli("generate", "uniform", flag, 0, "--out", "made"), flag, "0")


@pytest.mark.parametrize(
    "content",
    [b"", b'{"schema": 1, "name"', b"\x00\xff\x00\xfe", b"[1, 2]", b'{"schema": 999}'],
    ids=["empty", "truncated", "binary", "foreign", "future"],
)
def test_unreadable_files(cli, tmp_path, content):
    (tmp_path / "bad.json").write_bytes(content)
    refused(cli("solve", "bad.json", "--solver", "greedy"), "bad.json")
    refused(cli("convert", "bad.json", "out.atsp"), "bad.json")
    assert not (tmp_path / "out.atsp").exists()
    refused(cli("solve", "missing.json", "--solver", "greedy"), "missing.json")


@pytest.mark.parametrize(("route", "word"), [("0 1 1 2 3", "Task 1"), ("0 1 2", "Task 3"), ("0 1 2 9 3", "9")])
def test_a_start_that_is_not_feasible(cli, tmp_path, instance_file, route, word):
    (tmp_path / "bad.sol").write_text(f"Route #1: {route}\n")
    refused(cli("solve", instance_file, "--solver", "greedy", "--start", "bad.sol"), "bad.sol", word)


def test_unknown_names_get_the_near_miss(cli, instance_file):
    refused(cli("solve", instance_file, "--solver", "gredy"), "unknown solver 'gredy'", "did you mean 'greedy'")
    refused(cli("generate", "unifrom", "--out", "made"), "unknown family 'unifrom'", "did you mean 'uniform'")
    refused(cli("compare", "quik"), "'quik' is no study", "did you mean 'quick'")
    refused(cli("solve", instance_file, "--solver", "ga", "--option", "popluation=3"), "did you mean 'population'")
    refused(cli("generate", "uniform", "--set", "winf=shear", "--out", "made"), "did you mean 'wind'")
    refused(cli("generate", "uniform", "--set", "seed=3", "--out", "made"), "family uniform has no parameter 'seed'")
    code, _, err = cli("sovle")
    assert (code, "did you mean 'solve'" in err) == (2, True)


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["--time-limit", "0"], ["--time-limit", "0"]),
        (["--time-limit", "-1"], ["--time-limit", "-1"]),
        (["--time-limit", "nan"], ["--time-limit", "nan"]),
        (["--time-limit", "inf"], ["--time-limit", "inf"]),
        (["--seed", "-1"], ["seed", "-1"]),
        (["--iterations", "-1"], ["iterations", "-1"]),
        (["--threads", "0"], ["threads", "0"]),
        (["--option", "population"], ["--option", "key=value", "population"]),
        (["--option", "population=many"], ["population", "a whole number", "many"]),
        (["--out", "routes.txt"], ["routes.txt", ".sol"]),
        (["--out", "nowhere/routes.sol"], ["nowhere"]),
        (["--plot", "routes.doc"], ["routes.doc", ".svg"]),
    ],
)
def test_settings_of_solve(cli, instance_file, args, words):
    refused(cli("solve", instance_file, "--solver", "ga", *args), *words)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("seed = 3", ["unknown key 'seed'", "did you mean 'seeds'"]),
        ("[[solvers]]\nname = 'ga'\noption = {}", ["[[solvers]] 1", "'option'", "did you mean 'options'"]),
        ("[[families]]\nfamly = 'uniform'", ["[[families]] 1", "'famly'", "did you mean 'family'"]),
        ("[[families]]\nfamily = 'unifrm'\ntasks = 3\ndepots = 2", ["'unifrm'", "did you mean 'uniform'"]),
        ("[[families]]\nfamily = 'ring'\ntasks = 3\ndepots = 2\nparameters.winf = 1", ["did you mean 'wind'"]),
        ("[[families]]\nfamily = 'uniform'\ntasks = 3", ["[[families]] 1", "'depots' is missing"]),
        ("[[solvers]]\nname = 'gaa'", ["unknown solver 'gaa'", "did you mean 'ga'"]),
        ("[[solvers]]\nname = 'ga'\noptions = {population = 'x'}", ["population", "'x'"]),
        (
            "[[solvers]]\nname = 'ga'\ntime_limit = [10, 0]",
            ["[[solvers]] 1 time_limit[1] must be a positive", "0"],
        ),
        ("time_limit = 'long'\n[[solvers]]\nname = 'ga'", ["time_limit", "'long'"]),
        ("seeds = [-4]\n[[solvers]]\nname = 'ga'", ["seed", "-4"]),
        ("seeds = 0\n[[solvers]]\nname = 'ga'", ["seeds", "0"]),
        ("solvers = 'ga'", ["solvers", "[[solvers]]"]),
        ("files = ['none/*.json']\n[[solvers]]\nname = 'ga'", ["none"]),
        ("name = 'empty'", ["no solvers"]),
        ("name = ", ["is not valid TOML"]),
    ],
)
def test_studies(cli, tmp_path, text, words):
    (tmp_path / "bad.toml").write_text(text)
    refused(cli("compare", "bad.toml", "--out", "runs"), "bad.toml", *words)
    assert not (tmp_path / "runs").exists()


def test_a_study_without_instances(cli, tmp_path):
    (tmp_path / "bare.toml").write_text("[[solvers]]\nname = 'greedy'")
    refused(cli("compare", "bare.toml"), "names no instances")


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["--shard", "4/3"], ["--shard", "4/3"]),
        (["--shard", "half"], ["--shard", "half"]),
        (["--jobs", "0"], ["--jobs", "0"]),
        (["--retry", "kiled"], ["kiled", "did you mean 'killed'"]),
        (["--time-limit", "0"], ["--time-limit", "0"]),
        (["--solvers", ","], ["--solvers"]),
    ],
)
def test_settings_of_compare(cli, instance_file, args, words):
    given = args if "--solvers" in args else ["--solvers", "greedy", *args]
    refused(cli("compare", instance_file, "--out", "runs", *given), *words)


@pytest.mark.parametrize("out", ["small.json/runs", "/proc/runs"], ids=["in a file", "not writable"])
def test_a_folder_that_cannot_be_written(cli, instance_file, out):
    refused(cli("compare", instance_file, "--solvers", "greedy", "--out", out), out)
    refused(cli("generate", "uniform", "--out", out), out)


@pytest.mark.parametrize("room_for", [0, 1, 3])
def test_a_full_disk_leaves_nothing_half_written(cli, tmp_path, instance_folder, monkeypatch, room_for, stored_json):
    """The disk takes `room_for` files, then is full."""
    written = []

    def fsync(descriptor: int) -> None:
        written.append(descriptor)
        if len(written) > room_for:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", fsync)
    args = ["compare", instance_folder, "--solvers", "misbehaving:Honest", "--time-limit", 1, "--out", "runs"]
    code, out, err = cli(*args)
    assert (code, out) == (2, "")
    assert err.splitlines()[-1].endswith("cannot be written (No space left on device)")
    stored_json(tmp_path / "runs")  # whatever is there is whole
    left = [path for path in (tmp_path / "runs").rglob("*") if path.is_file()]
    assert len(left) <= room_for
    assert not [path for path in left if path.suffix not in (".json", ".gz")]
    monkeypatch.undo()


def test_things_that_are_not_stores(cli, tmp_path, instance_file):
    refused(cli("status", "nowhere"), "nowhere")
    refused(cli("check", instance_file), "small.json")
    refused(cli("check", tmp_path, "a.sol"), str(tmp_path))
    refused(cli("report", "nowhere", "--csv", "a.csv"), "nowhere")
    refused(cli("report", tmp_path, "--fail-on-regression"), "--fail-on-regression")
    (tmp_path / "study.json").write_text("{")
    refused(cli("status", tmp_path), "study.json")
