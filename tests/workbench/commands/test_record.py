"""`workbench record`: a store's better routes and bounds go into the book, contradictions are told."""

import json

import pytest


@pytest.fixture
def store(cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert cli("generate", "ring", "--tasks", "4", "--depots", "2", "--seed", "1", "--out", "given")[0] == 0
    solvers = ("--solvers", "subset-dp,greedy", "--time-limit", "2", "--jobs", "1")
    assert cli("compare", "given", *solvers, "--out", "runs", "--no-report")[0] == 0
    return "runs"


def test_a_store_fills_the_book_and_a_second_time_changes_nothing(cli, store, tmp_path):
    code, out, _ = cli("record", store, "--book", "records", "--json")
    assert (code, json.loads(out)["changed"]) == (0, [])
    code, out, _ = cli("record", store, "--book", "records", "--add")
    assert code == 0
    assert "new," in out
    assert "which proves the value" in out
    table = (tmp_path / "records" / "best_known.csv").read_text()
    assert ",true," in table
    assert "found here by" in table
    code, out, _ = cli("record", store, "--book", "records", "--add", "--json")
    assert (code, json.loads(out)["instances"], json.loads(out)["changed"]) == (0, 1, [])

    head, line = table.splitlines()
    name, digest, *size, value, _, _, source = line.split(",")
    false = ",".join([name, digest, *size, repr(0.5 * float(value)), "false", "", source])
    (tmp_path / "records" / "best_known.csv").write_text(f"{head}\n{false}\n")
    code, _, err = cli("record", store, "--book", "records")
    assert code == 1
    assert "contradicts" in " ".join(err.split())
