"""`workbench import`: results of other programs are checked like ours, marked, and stored all or none."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from instances import Instance, makespan
from instances.files import read_instance, write_instance
from reports import load
from reports.pages.study import write_report
from workbench.cli import main

OURS = "compare given --solvers greedy --time-limit 5 --out runs --no-report"
HEAD = "instance,solver,seed,time_limit,elapsed,routes,objective,bound\n"


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """An instance and a store with one run of ours.

    Tasks at 1, 2 and 5 on a line with depots at 0 and 6: [0, 1] and [2] cost 4 and 2, the least possible C_max.
    """
    folder = tmp_path_factory.mktemp("made")
    x = np.array([1.0, 2.0, 5.0, 0.0, 6.0])
    (folder / "given").mkdir()
    write_instance(Instance("line", np.abs(x[:, None] - x), 3, 2), folder / "given" / "line.json")
    with pytest.raises(SystemExit):
        main([*OURS.replace("given", f"{folder}/given").replace("runs", f"{folder}/runs").split()])
    return folder


@pytest.fixture
def line(made, tmp_path) -> Instance:
    shutil.copytree(made / "given", tmp_path / "given")
    return read_instance(tmp_path / "given" / "line.json")


@pytest.fixture
def store(line, made, tmp_path) -> str:
    shutil.copytree(made / "runs", tmp_path / "runs")
    return "runs"


def table(*rows: str) -> None:
    Path("others.csv").write_text(HEAD + "".join(f"{row}\n" for row in rows))


def foreign(folder: str = "runs") -> pd.DataFrame:
    runs = load(folder)
    return runs[runs["foreign"]].reset_index(drop=True)


def test_routes_are_costed_here_and_the_method_is_marked(cli, store, line):
    table('line,LKH-3,7,60,1.5,"[[0, 1], [2]]",4,')
    code, told, _ = cli("import", "others.csv", "--into", store)
    assert (code, told) == (0, "1 run imported into runs\n")
    run = foreign().iloc[0]
    assert (run["method"], run["seed"], run["elapsed"], run["time_limit"]) == ("LKH-3†", 7, 1.5, 60.0)
    assert (run["status"], run["value"], run["recomputed"]) == ("FEASIBLE", 4.0, makespan(line, [[0, 1], [2]]))
    assert cli("check", store)[:2] == (
        0,
        "2 runs on 1 instances, 1 of them foreign: imported, their times as claimed: all right\n",
    )


@pytest.mark.parametrize(
    ("routes", "objective", "bound", "sentence"),
    [
        ("[[0, 1], [2]]", "3.5", "", "claimed a longest tour of 3.5 s, but its routes cost 4.0 s"),
        ("[[0, 1], [2]]", "4", "4.6", "claimed a lower bound of 4.6 s, but its routes cost 4.0 s"),
        ("[[0, 1], []]", "4", "", "the routes are not feasible: Task 2 is visited by no route."),
        ("[[0, 1, 2, 3], []]", "", "", "UAV 0 visits 3, which is not a task"),
    ],
)
def test_a_claim_that_its_routes_do_not_bear_out_is_an_error_with_both_numbers(
    cli, store, routes, objective, bound, sentence
):
    table(f'line,LKH-3,0,60,1,"{routes}",{objective},{bound}')
    code, told, error = cli("import", "others.csv", "--into", store)
    assert code == 1
    assert "1 wrong" in told
    assert error.startswith("others.csv: row 2: ")
    assert sentence in error
    run = foreign().iloc[0]
    assert (run["status"], run["value"], run["bound"]) == (
        "ERROR",
        pytest.approx(np.nan, nan_ok=True),
        pytest.approx(np.nan, nan_ok=True),
    )
    assert cli("check", store)[0] == 1


@pytest.mark.parametrize(("objective", "bound", "status"), [
    ("4", "", "FEASIBLE"), ("4.000", "", "FEASIBLE"), ("4.04", "", "ERROR"), ("4.000", "3.990", "FEASIBLE"),
    ("4.000", "4.000", "OPTIMAL"), ("4.0004", "4.00039", "FEASIBLE"), ("4.000", "4.002", "ERROR"),
    ("4.0", "4.0", "FEASIBLE"),  # it may be 3.95: too far below for a proof
])  # fmt: skip
def test_numbers_are_taken_to_the_digits_they_are_given_with(cli, line, objective, bound, status):
    scaled = Instance("line", line.cost * 1.0001, 3, 2)
    write_instance(scaled, Path("given/line.json"))
    assert makespan(scaled, [[0, 1], [2]]) == 4.0004
    table(f'given/line.json,X,0,60,1,"[[0, 1], [2]]",{objective},{bound}')
    cli("import", "others.csv", "--into", "runs")
    run = json.loads(next(Path("runs").glob("line-*/X*.json")).read_text())
    assert run["status"] == status
    assert run["objective"] == makespan(scaled, [[0, 1], [2]])


def test_a_value_without_routes_is_kept_and_not_ranked(cli, store, tmp_path, without_figures):
    table("line,Claims,0,60,1,,3.9,", "line,Bounds,0,60,1,,,3.5")
    code, told, _ = cli("import", "others.csv", "--into", store, "--json")
    assert code == 0
    assert (json.loads(told)["imported"], json.loads(told)["without_routes"]) == (2, 2)
    assert foreign()["method"].tolist() == ["Bounds†"]
    kept = json.loads(next(Path(store).glob("line-*/Claims*.json")).read_text())
    assert (kept["claimed_objective"], kept["objective"], kept["foreign"]) == (3.9, None, True)
    write_report([store], tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    assert "Claims† on line, seed 0: a longest tour of 3.9 s in 1.00 s." in page
    assert "no evidence and is not ranked" in page
    assert cli("check", store)[0] == 0


def test_a_foreign_bound_that_our_routes_refute_is_a_contradiction(cli, store):
    table("line,Bounds,0,60,1,,,4.5")
    assert cli("import", "others.csv", "--into", store)[0] == 0
    code, told, _ = cli("check", store)
    assert code == 1
    assert re.search(r"Its lower bound of 4\.45 s is above the routes of greedy", told)


def test_a_solution_file_with_tasks_from_1(cli, line):
    Path("line.sol").write_text("Route #1: 1 2\nRoute #2: 3\nCost 4\n")
    given = ["--solver", "HGS", "--elapsed", 2, "--time-limit", 10, "--machine", "a laptop"]
    assert cli("import", "line.sol", "--into", "runs", "--instance", "given/line.json", *given)[0] == 0
    assert cli("import", "line.sol", "--into", "runs", *given)[1] == (
        "1 run imported into runs, 1 in place of earlier ones\n"
    )
    run = foreign().iloc[0]
    assert (run["routes"], run["value"]) == ([[0, 1], [2]], 4.0)
    about = json.loads((Path("runs/environments") / f"{run['environment']}.json").read_text())
    assert about["machine"] == {"stated": "a laptop"}


def test_lists_of_tasks_from_1(cli, store):
    table('line,LKH-3,0,60,1,"[[1, 2], [3]]",4,')
    assert cli("import", "others.csv", "--into", store, "--first-task", 1)[0] == 0
    assert foreign().iloc[0]["routes"] == [[0, 1], [2]]


def test_parquet_and_the_text_of_a_solution_in_a_table(cli, store):
    pytest.importorskip("pyarrow")
    rows = {"instance": ["line", "line"], "elapsed": [1, 2.5], "objective": [4.0, None]}
    rows |= {"routes": [[[0, 1], [2]], [[0], [1, 2]]], "seed": [0, 1]}
    pd.DataFrame(rows).to_parquet("others.parquet")
    assert cli("import", "others.parquet", "--into", store, "--solver", "A", "--time-limit", 9)[0] == 0
    table('line,B,0,9,1,"Route #1: 0 1\nRoute #2: 2",,')
    assert cli("import", "others.csv", "--into", store)[0] == 0
    assert foreign()["value"].tolist() == [4.0, 8.0, 4.0]


def test_foreign_runs_are_neither_stale_nor_runs_of_the_study(cli, store):
    table('line,greedy,0,5,1,"[[0, 1], [2]]",,')  # called as one of ours: another method all the same
    cli("import", "others.csv", "--into", store)
    path = next(Path(store).glob("line-*/greedy_*.json"))
    path.write_text(json.dumps(json.loads(path.read_text()) | {"code": "of another day"}))
    told = json.loads(cli("status", store, "--json")[1])
    assert [told[key] for key in ("planned", "stored", "missing", "stale", "foreign")] == [1, 1, 0, 0, 1]
    assert cli("status", store)[1].endswith("1 of 1 runs stored, 0 missing; 1 foreign (imported)\n")
    assert "1 of 1 runs are stored already" in cli(*OURS.split(), "--retry", "stale")[2]
    assert sorted(load(store)["method"]) == ["greedy", "greedy†"]


def test_tables_and_pages_name_the_mark(cli, store, tmp_path, without_figures):
    table('line,LKH-3,0,60,1,"[[0, 1], [2]]",,')
    cli("import", "others.csv", "--into", store)
    code, told, _ = cli("report", store, "--out", "page.html", "--csv", "runs.csv", "--latex", "runs.tex")
    assert code == 0
    note = "† 1 run of LKH-3† was made elsewhere and imported: routes were checked"
    assert "LKH-3†" in told
    assert note in told
    assert note in Path("page.html").read_text()
    assert r"LKH-3\textdagger{}" in Path("runs.tex").read_text()
    assert pd.read_csv("runs.csv").set_index("method")["foreign"].to_dict() == {"greedy": False, "LKH-3†": True}


ROUTES = '"[[0, 1], [2]]"'
BAD = [
    (f"{HEAD}lime,X,0,60,1,{ROUTES},,", "row 2: instance 'lime' is not one of runs, and no file; did you mean 'line'?"),
    (f"{HEAD}line,X,0,60,,{ROUTES},,", "row 2: 'elapsed' is empty"),
    (f"{HEAD}line,X,0,60,-1,{ROUTES},,", "row 2: elapsed must be a number of seconds of at least 0, got '-1'"),
    (f"{HEAD}line,X,0,nan,1,{ROUTES},,", "row 2: time_limit must be a number of seconds above 0, got 'nan'"),
    (f"{HEAD}line,X,1.5,60,1,{ROUTES},,", "row 2: seed must be a whole number from 0 to 2147483647, got '1.5'"),
    (f"{HEAD}line,X,0,60,1,{ROUTES},four,", "row 2: objective must be a number of seconds, got 'four'"),
    (f"{HEAD}line,X,0,60,1,,,", "row 2: states neither routes nor an objective nor a bound"),
    (f'{HEAD}line,X,0,60,1,"[[0, 1.5]]",,', "row 2: routes must be a list of lists of task numbers, got '[[0, 1.5]]'"),
    (f"{HEAD}line,X,0,60,1,0 1 2,,", "row 2: routes must be [[tasks], …], the text of a .sol or the name of one"),
    (f"{HEAD}line,X,0,60,1,gone.sol,,", "row 2: gone.sol: cannot be read (No such file or directory)"),
    (f"{HEAD}line,X,0,60,1", "row 2: has 5 cells under 8 headings"),
    (f"{HEAD}line,X,0,60,1,{ROUTES},,\nline,X,0,60,2,{ROUTES},,",
     "row 3: solver X†, seed 0, limit 60 s on line is stated before, in others.csv: row 2"),
    (f'{HEAD}"line,X,0', "is no CSV (unexpected end of data)"),
    (HEAD.replace("bound", "bounds"), "unknown column 'bounds'; did you mean 'bound'?"),
    (HEAD.replace("seed", "solver"), "column 'solver' is there twice"),
    (HEAD.replace("elapsed,", ""), "has no 'elapsed'; give --elapsed or a column of that name"),
    (HEAD, "holds no row"),
    ("", "has no 'instance'"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "sentence"), BAD)
def test_bad_input_is_one_sentence_and_leaves_the_store_alone(cli, store, text, sentence):
    before = {path: path.read_bytes() for path in Path(store).rglob("*") if path.is_file()}
    good = f"\nline,Good,0,60,1,{ROUTES},," if text.startswith(f"{HEAD}l") else ""
    Path("others.csv").write_text(text + good)
    code, _, told = cli("import", "others.csv", "--into", store)
    assert code == 2
    assert told.startswith("workbench: others.csv: ")
    assert sentence in told
    assert {path: path.read_bytes() for path in Path(store).rglob("*") if path.is_file()} == before


def test_an_option_beside_its_column_and_an_unknown_ending_are_refused(cli, store):
    table(f"line,X,0,60,1,{ROUTES},,")
    assert (
        "--solver: others.csv has a column 'solver' of its own"
        in cli("import", "others.csv", "--into", store, "--solver", "Y")[2]
    )
    assert "must end in .csv, .parquet or .sol" in cli("import", "others.txt", "--into", store)[2]
    Path("others.parquet").write_text("no")
    assert "others.parquet: is no Parquet file" in cli("import", "others.parquet", "--into", store)[2]


def test_what_cannot_be_written_leaves_all_as_it_was(cli, store, monkeypatch):
    from workbench.jobs.store import Store

    table(f"line,A,0,60,1,{ROUTES},,")
    cli("import", "others.csv", "--into", store)
    before = {path: path.read_bytes() for path in Path(store).rglob("*") if path.is_file()}
    table(f"line,A,0,60,9,{ROUTES},,", f"line,B,0,60,1,{ROUTES},,")
    put = Store.put

    def full(self, path, run):
        if run.label == "B†":
            raise OSError(28, "No space left on device")
        put(self, path, run)

    monkeypatch.setattr(Store, "put", full)
    assert cli("import", "others.csv", "--into", store)[0] == 2
    assert {path: path.read_bytes() for path in Path(store).rglob("*") if path.is_file()} == before
