"""`workbench report` on damaged and hostile stores: what is whole is reported, what is not is counted, exit code 1."""

import json
from pathlib import Path

import pandas as pd
import pytest

from instances import makespan, tour_costs
from instances.files import write_instance
from reports.figures import study_figures


@pytest.fixture
def store(tmp_path, instance):
    """A store of one instance with one run, and how to add others."""
    folder = tmp_path / "runs" / f"{instance.name}-{instance.digest}"
    folder.mkdir(parents=True)
    write_instance(instance, folder / "instance.json")
    routes = [[0, 1], [2, 3]]
    cost = makespan(instance, routes)
    run = {
        "schema": 1, "instance": {"name": instance.name, "digest": instance.digest, "n_tasks": 4, "n_depots": 2},
        "solver": "s", "label": "s", "seed": 0, "time_limit": 1.0, "status": "FEASIBLE", "objective": cost,
        "bound": None, "elapsed": 0.5, "routes": routes, "tour_costs": tour_costs(instance, routes).tolist(),
        "claimed_objective": cost, "message": "=cmd|' /C calc'!A0",
    }  # fmt: skip

    def put(name, **changes):
        (folder / name).write_text(json.dumps(run | changes))

    put("s-default-s0-t1.json")
    return put


def test_damaged_files_are_counted_and_end_in_exit_code_1(cli, store):
    assert cli("report", "runs")[0] == 0
    store("s-default-s1-t1.json", seed=1, time_limit=None)
    store("s-default-s2-t1.json", seed=2, routes="\x1b[31m")
    code, out, err = cli("report", "runs", "--csv", "a.csv")
    assert code == 1
    assert err.count("left alone") == 2
    assert "2 damaged files left out" in err
    assert "\x1b" not in out + err
    assert len(pd.read_csv("a.csv")) == 1


def test_formulas_are_marked_unless_asked_for_raw(cli, store):
    assert cli("report", "runs", "--csv", "a.csv")[0] == 0
    assert cli("report", "runs", "--csv", "b.csv", "--raw-csv")[0] == 0
    assert pd.read_csv("a.csv")["message"][0] == "'" + pd.read_csv("b.csv")["message"][0]


def test_figures_are_written_for_papers_without_a_page(cli, store, monkeypatch):
    monkeypatch.setattr("reports.pages.study.study_figures", study_figures)
    assert cli("report", "runs", "--figures", "paper/figures")[0] == 0
    written = {path.name for path in Path("paper/figures").iterdir()}
    assert {"convergence.pdf", "convergence.svg", "convergence.csv", "tradeoff.pdf"} <= written
    told = pd.read_csv("paper/figures/tradeoff.csv")
    assert list(told["time of the solve [s]"]) == [0.5, 0.5]  # the instance, and what is typical
    Path("a file").write_text("")
    code, _, err = cli("report", "runs", "--figures", "a file/figures")
    assert code == 2
    assert "a file/figures: cannot be made" in err


def test_check_names_whose_bounds_were_held_against_the_routes(cli, store):
    store("s-default-s1-t1.json", seed=1, bound=0.001)
    code, out, _ = cli("check", "runs")
    assert code == 0
    assert "1 lower bound claimed by s" in out
    store("s-default-s2-t1.json", seed=2, trace=[[0.1, None, 1e6]], message="")
    code, out, _ = cli("check", "runs")
    assert code == 1
    assert "in its trace is above the routes" in out


def test_a_store_with_nothing_in_common_is_said(cli, store, tmp_path):
    assert cli("report", "runs", "--against", "runs")[0] == 0
    (tmp_path / "runs").rename(tmp_path / "old")
    store_of_another_limit = tmp_path / "runs" / "other"
    store_of_another_limit.mkdir(parents=True)
    old = next((tmp_path / "old").glob("*"))
    for path in old.iterdir():
        kept = path.read_text().replace('"time_limit": 1.0', '"time_limit": 2.0')
        (store_of_another_limit / path.name).write_text(kept)
    code, out, err = cli("report", "runs", "--against", "old")
    assert code == 1
    assert "Against" not in out
    assert err == "Nothing to compare: the stores have no time limit [s] in common (here: 2; there: 1).\n"
    told = json.loads(cli("report", "runs", "--against", "old", "--json")[1])
    assert (told["comparable"], told["regressed"]) == (False, False)


def test_columns_are_chosen_and_their_names_checked(cli, store, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    assert cli("report", "runs", "--columns", "gap_found,time")[1].split()[:3] == ["Method", "Gap", "to"]
    code, _, err = cli("report", "runs", "--columns", "gap_fund")
    assert code == 2
    assert "did you mean 'gap_found'?" in " ".join(err.split())
