"""``import workbench as wb``: from what people have to a checked result, in one call."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import workbench as wb
from instances import InputError, Instance, makespan
from instances.files import write_instance


def costs(n: int = 7) -> np.ndarray:
    places = np.random.default_rng(1).uniform(0, 100, (n, 2))
    return np.hypot(*(places[:, None] - places).transpose(2, 0, 1))


def test_a_matrix_becomes_a_checked_proof() -> None:
    result = wb.solve(costs(), depots=2, solver="subset-dp")
    assert result.status == "OPTIMAL"
    assert result.routes is not None
    assert result.objective == pytest.approx(makespan(result.instance, result.routes))
    assert result.tours["cost"].max() == pytest.approx(result.objective)


def test_all_that_people_have_is_the_same_instance(tmp_path: Path) -> None:
    c = costs()
    table = pd.DataFrame(c, index=list("abcdefg"), columns=list("abcdefg"))
    np.savetxt(tmp_path / "plain.csv", c, delimiter=",", fmt="%.17g")
    table.to_csv(tmp_path / "named.csv")
    write_instance(Instance("file", c, 5, 2), tmp_path / "file.json")
    graph = pytest.importorskip("networkx").from_pandas_adjacency(table)
    wanted = Instance("wanted", c, 5, 2)
    for made in (
        wb.instance(c.tolist(), depots=2),
        wb.instance(table, depots=["f", "g"]),
        wb.instance(tmp_path / "plain.csv", depots=2),
        wb.instance(tmp_path / "named.csv", depots=["f", "g"]),
        wb.instance(tmp_path / "file.json"),
        wb.instance(graph, depots=["f", "g"]),
    ):
        assert made.cost == pytest.approx(wanted.cost)
        assert (made.n_tasks, made.n_depots) == (5, 2)


def test_depots_may_lie_anywhere_and_tours_keep_the_names() -> None:
    table = pd.DataFrame(costs(4), index=list("abcd"), columns=list("abcd"))
    result = wb.solve(table, depots=["b", "b"], solver="subset-dp")
    assert result.instance.provenance["labels"] == ["a", "c", "d", "b", "b"]
    assert result.tours["depot"].tolist() == ["b", "b"]
    assert sorted(task for tour in result.tours["tasks"] for task in tour) == ["a", "c", "d"]


def test_points_are_flown_straight() -> None:
    made = wb.instance([[0.0, 0.0], [30.0, 40.0]], depots=[[0.0, 0.0]], speed=10.0)
    assert made.cost[0, 1] == pytest.approx(5.0)
    assert (made.n_tasks, made.n_depots) == (2, 1)


@pytest.mark.parametrize(
    ("problem", "depots", "sentence"),
    [
        (np.ones((3, 4)), 1, "costs .* or points"),
        (costs(), None, "depots is missing"),
        (costs(), 7, "from 1 to 6"),
        (costs(), ["z"], "labels of nodes"),
        ("nonsense.xyz", 1, "nonsense.xyz"),
        ("abc.csv", 1, "abc.csv"),
    ],
)
def test_what_cannot_be_used_is_told(problem: object, depots: object, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        wb.instance(problem, depots=depots)  # type: ignore[arg-type]


def test_what_fits_is_selected() -> None:
    places = [[0.0, 0.0], [0.0, 10.0], [0.0, 300.0], [0.0, 5.0]]
    best = wb.select(places, depots=1, endurance=40.0, prizes=[1.0, 1.0, 50.0], method="subset-dp")
    assert best.tasks == (0, 1)
    assert best.bound == pytest.approx(2.0)
    told = wb.select(places, depots=1, endurance=40.0, method="subset-dp")
    assert told.tasks == (0, 1)


def test_a_solver_that_lies_is_refuted(monkeypatch: pytest.MonkeyPatch) -> None:
    from formulations.routing.greedy import Greedy
    from formulations.routing.solver import Result, Status

    lie = Result(Status.OPTIMAL, 1.0, 1.0, routes=((0, 1, 2, 3, 4), ()), stopped_by="proof")
    monkeypatch.setattr(Greedy, "solve", lambda *args, **more: lie)
    with pytest.raises(RuntimeError, match=r"claimed a longest tour of 1\.0 s"):
        wb.solve(costs(), depots=2, solver="greedy")


def test_in_a_notebook_it_is_drawn() -> None:
    page = wb.solve(np.random.default_rng(0).uniform(0, 9, (6, 2)), depots=2, solver="greedy")._repr_html_()
    assert page.count("<svg") == 1
    assert page.count("<tr") == 3


def test_runs_are_compared_and_loaded(tmp_path: Path) -> None:
    made = wb.instance(costs(), depots=2)
    solvers = ["subset-dp", {"name": "greedy", "options": {"variant": "nearest"}}]
    runs = wb.compare(made, solvers, time_limit=5, out=tmp_path, jobs=1)
    assert set(runs["solver"]) == {"subset-dp", "greedy"}
    assert runs["gap_found"].min() == 0
    assert set(runs["option.variant"].dropna()) == {"nearest"}
    assert all(len(routes) == 2 for routes in runs["routes"])


def test_families_and_pictures() -> None:
    made = wb.generate("uniform", tasks=5, depots=2, seed=3)
    assert wb.plot(made).axes
    assert wb.plot(wb.solve(made, solver="greedy")).axes


SCRIPT = """
import time
began = time.perf_counter()
import workbench as wb
assert time.perf_counter() - began < 5
import sys
assert "numpy" not in sys.modules
result = wb.solve([[0, 1, 2], [1, 0, 3], [2, 3, 0]], depots=1, solver="greedy")
print(result.objective, len(wb.compare(result.instance, ["greedy"], time_limit=2, jobs=1)))
"""


def test_a_file_called_instances_in_the_way_is_not_ours(tmp_path: Path) -> None:
    """A script's folder comes first on Python's path: what lies there must hide nothing of ours."""
    for name in ("instances", "reports", "formulations"):
        (tmp_path / f"{name}.py").write_text("raise RuntimeError('not ours')")
    (tmp_path / "script.py").write_text(SCRIPT)
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.stderr.count("not ours") == 0, done.stderr
    assert done.stdout.split() == ["6.0", "1"]


def test_a_mission_is_called_by_its_name_once_its_package_is_imported_too(tmp_path: Path) -> None:
    import workbench.mission.file  # noqa: F401 - what hides the function

    with pytest.raises(InputError, match=r"nowhere\.toml"):
        wb.mission(tmp_path / "nowhere.toml", tmp_path / "out")
