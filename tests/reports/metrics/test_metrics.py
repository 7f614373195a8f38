"""Metrics on figures small enough to check by hand."""

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reports import load
from reports.metrics import (
    contributions,
    instance_table,
    references,
    scores,
    shifted_geometric_mean,
    summary,
    time_to_proof,
    time_to_target,
    virtual_best,
    with_gaps,
    with_integrals,
)
from reports.metrics.gaps import relative_gap
from reports.metrics.integrals import primal_dual_integral, primal_integral
from reports.metrics.scores import banded

NAN = float("nan")


def frame(rows):
    """Runs from (digest, method, seed, value, bound, status, elapsed, trace); limit 10 s."""
    keys = ["digest", "method", "seed", "value", "bound", "status", "elapsed", "trace"]
    runs = pd.DataFrame([dict(zip(keys, row, strict=True)) for row in rows])
    runs["trace"] = [np.array(t, dtype=float).reshape(-1, 3) for t in runs["trace"]]
    return runs.assign(
        instance=runs["digest"], family="f", n_tasks=5, n_depots=2, asymmetry=0.0, best_known=NAN,
        objective=runs["value"], recomputed=runs["value"], fault="", tolerance=0.0,
        proved=runs["status"] == "OPTIMAL", time_limit=10.0, proves=runs["method"] == "exact", peak_memory=1.0,
    )  # fmt: skip


@pytest.fixture
def runs():
    return frame(
        [
            ("x", "exact", 0, 100.0, 100.0, "OPTIMAL", 4.0, [[1, 120, NAN], [2, 120, 80], [3, 100, 90]]),
            ("x", "search", 0, 110.0, NAN, "FEASIBLE", 10.0, [[0.5, 130, NAN], [5, 110, NAN]]),
            ("y", "exact", 0, NAN, 150.0, "NO_SOLUTION", 10.0, [[1, NAN, 150]]),
            ("y", "search", 0, 200.0, NAN, "FEASIBLE", 10.0, [[2, 200, NAN]]),
        ]
    )


def test_gaps(runs):
    known = with_gaps(runs.assign(best_known=[90.0, 90.0, NAN, NAN]))
    np.testing.assert_allclose(known["gap_found"], [0, 0.1, NAN, 0])
    np.testing.assert_allclose(known["gap_known"], [10 / 90, 20 / 90, NAN, NAN])
    np.testing.assert_allclose(known["gap_best"], [10 / 90, 20 / 90, NAN, 0])
    np.testing.assert_allclose(known["gap_bound"], [0, 10 / 110, NAN, 0.25])
    part = known[known["method"] == "search"]
    assert with_gaps(part) is part  # a part stays measured against the best of the whole


def test_a_bound_that_routes_contradict_is_no_reference(runs):
    lie = runs.copy()
    lie.loc[2, "bound"] = 250.0  # above the routes of 200
    assert math.isnan(references(lie).loc["y", "best_bound"])
    assert references(runs).loc["y", "best_bound"] == 150.0


def test_gap_to_zero():
    np.testing.assert_array_equal(relative_gap(np.array([0.0, 1.0, NAN]), np.array([0.0, 0.0, 0.0])), [0, np.inf, NAN])


def test_primal_integral_by_hand():
    trace = np.array([[1, 120, NAN], [3, 100, NAN]])
    # 1 s of nothing, 2 s of a gap of 20/120, then the best
    assert primal_integral(trace, 100.0, 10.0) == pytest.approx(1 + 2 * 20 / 120)
    assert primal_integral(np.empty((0, 3)), 100.0, 10.0) == 10.0
    assert primal_integral(trace, 100.0, 2.0) == pytest.approx(1 + 1 * 20 / 120)


def test_primal_dual_integral_by_hand():
    trace = np.array([[1, 120, NAN], [2, 120, 60], [4, 100, 60], [5, 100, 100]])
    # 2 s without a bound, 2 s of 60/120, 1 s of 40/100, then proved
    assert primal_dual_integral(trace, 10.0) == pytest.approx(2 + 2 * 0.5 + 0.4)


@given(st.lists(st.tuples(st.floats(0, 20), st.floats(100, 200)), max_size=8))
@settings(deadline=None)
def test_the_integral_lies_between_nothing_and_the_horizon_and_a_better_trace_has_less(points):
    trace = np.array([[t, z, NAN] for (t, _), (_, z) in zip(sorted(points), points, strict=True)]).reshape(-1, 3)
    whole = primal_integral(trace, 100.0, 10.0)
    assert -1e-12 <= whole <= 10.0 + 1e-12
    better = trace.copy()
    better[:, 1] = 100.0
    assert primal_integral(better, 100.0, 10.0) <= whole + 1e-12


def test_integrals_of_a_frame_use_the_end_of_the_run(runs):
    found = with_integrals(runs)
    assert found.loc[0, "primal_integral"] == pytest.approx(1 + 2 * 20 / 120)
    assert found.loc[1, "primal_integral"] == pytest.approx(0.5 + 4.5 * 30 / 130 + 5 * 10 / 110)
    assert found.loc[2, "primal_integral"] == 10.0
    assert found.loc[0, "primal_dual_integral"] == pytest.approx(2 + 1 * 40 / 120 + 1 * 10 / 100)


def test_shifted_geometric_mean_by_hand():
    assert shifted_geometric_mean([1.0, 7.0], shift=1.0) == pytest.approx(3.0)  # √(2·8) − 1
    assert math.isnan(shifted_geometric_mean([]))


@given(st.lists(st.floats(0, 1e4), min_size=1, max_size=20))
@settings(deadline=None)
def test_shifted_geometric_mean_lies_between_least_and_mean(times):
    mean = shifted_geometric_mean(times)
    assert min(times) - 1e-6 <= mean <= np.mean(times) + 1e-6


def test_times_to_target_and_proof(runs):
    times = time_to_target(runs, [0.2, 0.1, 0.0])
    np.testing.assert_array_equal(times.to_numpy(), [[1, 3, 3], [5, 5, np.inf], [np.inf] * 3, [2, 2, 2]])
    np.testing.assert_array_equal(time_to_proof(runs), [4, np.inf, np.inf, np.inf])


def test_summary_by_hand(runs):
    table = summary(runs)
    exact, search = table.loc["exact"], table.loc["search"]
    assert (exact["runs"], exact["solved"], exact["proved"], exact["certified"]) == (2, 0.5, 0.5, 0.5)
    assert (search["runs"], search["solved"], search["proved"], search["certified"]) == (2, 1.0, 0.0, 0.0)
    assert exact["gap_found"] == 0
    assert search["gap_found"] == pytest.approx(0.05)
    assert exact["proof_time"] == pytest.approx(math.sqrt(5 * 21) - 1)  # 4 s and a penalty of 2 × 10 s, shift 1 s
    assert math.isnan(search["proof_time"])
    assert search["target_time"] == pytest.approx(math.sqrt(21 * 3) - 1)
    assert list(table.index) == ["exact", "search"]


def test_scores_by_group_keep_the_order_of_bands(make_store):
    sizes = [(n, 2) for n in (*range(4, 14), 105)]
    runs = load(make_store().study(sizes=sizes, count=2, seeds=1, efforts={"greedy": 1, "ga": 3}))
    table = scores(banded(runs), ["n_tasks"])
    assert list(dict.fromkeys(table.index.get_level_values(0))) == ["1-10", "11-20", "101-200"]
    assert table.loc[("1-10", "milp"), "proved"] == 1.0
    assert table.loc[("11-20", "milp"), "proved"] == 0.0
    bands = set(banded(runs)["asymmetry"])
    assert "0 (symmetric)" in bands
    assert len(bands) > 1
    few = banded(runs[runs["n_tasks"] < 10])
    assert set(few["n_tasks"]) == {4, 5, 6, 7, 8, 9}


def test_virtual_best_and_contributions(runs):
    best = virtual_best(runs)
    assert best["method"].to_dict() == {"x": "exact", "y": "search"}
    assert best["value"].to_dict() == {"x": 100.0, "y": 200.0}
    added = contributions(runs)
    assert added.loc["exact"].to_dict() == {"best": 1, "alone": 1, "proof_alone": 1}
    assert added.loc["search"].to_dict() == {"best": 1, "alone": 1, "proof_alone": 0}


def test_instance_table(runs):
    table = instance_table(runs)
    assert table.loc["x", ["best_found", "best_bound", "gap", "proved", "best_method"]].tolist() == [
        100.0, 100.0, 0.0, True, "exact",
    ]  # fmt: skip
    assert table.loc["y", "gap"] == 0.25
    assert not table.loc["y", "proved"]
