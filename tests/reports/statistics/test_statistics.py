"""Statistics against published and hand-computed examples."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import norm

from reports.statistics import blocks, bootstrap_interval, friedman, holm, pairwise
from reports.statistics.friedman import cliques, critical_difference
from reports.statistics.pairwise import differences, enough, signed_rank

# J. Demšar, J. Mach. Learn. Res. 7 (2006), table 6: AUC of C4.5 and three variants on 14 data sets (more is better).
# In "voting" the last two print equal but were ranked 2 and 3, so the hidden digit is restored.
DEMSAR = pd.DataFrame(
    [
        [0.763, 0.768, 0.771, 0.798],
        [0.599, 0.591, 0.590, 0.569],
        [0.954, 0.971, 0.968, 0.967],
        [0.628, 0.661, 0.654, 0.657],
        [0.882, 0.888, 0.886, 0.898],
        [0.936, 0.931, 0.916, 0.931],
        [0.661, 0.668, 0.609, 0.685],
        [0.583, 0.583, 0.563, 0.625],
        [0.775, 0.838, 0.866, 0.875],
        [1.000, 1.000, 1.000, 1.000],
        [0.940, 0.962, 0.965, 0.962],
        [0.619, 0.666, 0.614, 0.669],
        [0.972, 0.981, 0.9751, 0.975],
        [0.957, 0.978, 0.946, 0.970],
    ],
    columns=["C4.5", "C4.5+m", "C4.5+cf", "C4.5+m+cf"],
)


def test_friedman_as_in_demsar():
    found = friedman(-DEMSAR)
    expected = {"C4.5": 3.143, "C4.5+m": 2.000, "C4.5+cf": 2.893, "C4.5+m+cf": 1.964}
    assert found.ranks.to_dict() == pytest.approx(expected, abs=5e-4)
    assert found.ranks.index[0] == "C4.5+m+cf"
    assert found.chi_square == pytest.approx(9.28, abs=0.005)
    assert found.f_statistic == pytest.approx(3.69, abs=0.005)
    assert 0.01 < found.p < 0.05
    assert found.critical_difference == pytest.approx(1.25, abs=0.005)
    assert critical_difference(4, 14, 0.10) == pytest.approx(1.12, abs=0.005)
    assert cliques(found.ranks, found.critical_difference) == [(0, 3)]  # Nemenyi at 0.05 finds no difference
    assert cliques(found.ranks, 1.12) == [(0, 2), (2, 3)]  # at 0.10: C4.5 is worse than C4.5+m+cf and C4.5+m


@pytest.mark.parametrize(("k", "q"), [(2, 1.960), (3, 2.343), (5, 2.728), (10, 3.164)])
def test_nemenyi_quantiles_of_demsars_table_5(k, q):
    assert critical_difference(k, 1) / np.sqrt(k * (k + 1) / 6) == pytest.approx(q, abs=1e-3)


def test_wilcoxon_as_in_demsar():
    statistic, p = signed_rank((DEMSAR["C4.5+m"] - DEMSAR["C4.5"]).round(6))
    assert statistic == 12.0  # table 2: R+ = 93, R- = 12
    z = (12 - 14 * 15 / 4) / np.sqrt(14 * 15 * 29 / 24)
    assert p == pytest.approx(2 * norm.cdf(z), rel=0.02)  # ties change the variance a little
    assert p < 0.05


def test_wilcoxon_of_five_equal_signs_is_exact():
    assert signed_rank([1.0, 2.0, 3.0, 4.0, 5.0]) == (0.0, 0.0625)
    assert signed_rank([0.0, 0.0]) == (1.5, 1.0)


def test_holm_by_hand():
    np.testing.assert_allclose(holm([0.01, 0.04, 0.03, 0.005]), [0.03, 0.06, 0.06, 0.02])
    np.testing.assert_allclose(holm([0.6, 0.9]), [1.0, 1.0])


@given(st.lists(st.floats(0, 1), min_size=1, max_size=8))
@settings(deadline=None)
def test_holm_lies_between_raw_and_bonferroni_and_keeps_the_order(p):
    adjusted = holm(p)
    assert (adjusted >= np.array(p) - 1e-15).all()
    assert (adjusted <= np.minimum(1, np.array(p) * len(p)) + 1e-15).all()
    assert (np.diff(adjusted[np.argsort(p, kind="stable")]) >= 0).all()


def test_too_few_instances_is_said_even_where_one_always_wins():
    rng = np.random.default_rng(0)
    for count, words in ((4, "too few instances to conclude"), (12, "a is better")):
        b = rng.uniform(1, 2, count)
        found = pairwise(pd.DataFrame({"a": b - rng.uniform(0.1, 0.5, count), "b": b}))
        assert found["verdict"].tolist() == [words]
        assert found.loc[0, ["wins", "ties", "losses"]].tolist() == [count, 0, 0]
    assert not enough(5, 1)
    assert enough(6, 1)
    assert not enough(8, 10)


def test_no_difference_is_not_called_one():
    table = pd.DataFrame({"a": [1.0, 2.0, 3.0], "b": [1.0, 2.0, 3.0]})
    assert pairwise(table)["verdict"].tolist() == ["no difference on any instance"]
    rng = np.random.default_rng(1)
    noise = pd.DataFrame({"a": rng.normal(size=40), "b": rng.normal(size=40)})
    assert pairwise(noise)["verdict"].tolist() == ["no difference shown"]


def test_a_method_without_routes_loses_by_the_largest_rank():
    a, b = np.array([np.inf, np.inf, 1.0, 3.0]), np.array([1.0, np.inf, np.inf, 2.0])
    found = differences(a, b)
    assert found[1] == 0
    assert found[0] == -found[2] > found[3] == 1.0


def test_bootstrap_interval():
    assert bootstrap_interval([3.0, 3.0, 3.0]) == (3.0, 3.0)
    assert np.isnan(bootstrap_interval([1.0])).all()
    rng = np.random.default_rng(0)
    held = 0
    for repeat in range(100):
        low, high = bootstrap_interval(rng.normal(5, 2, 40), seed=repeat)
        held += low <= 5 <= high
        assert high - low < 4 * 2 * 1.96 / np.sqrt(40)
    assert held >= 85  # 95 of 100 expected; BCa is a little narrow at 40


def test_blocks_take_the_median_over_seeds_and_the_worst_for_nothing():
    runs = pd.DataFrame(
        {
            "digest": ["x", "x", "x", "y", "y"],
            "method": ["a", "a", "a", "a", "b"],
            "gap": [0.1, 0.3, 0.2, np.nan, 0.0],
        }
    )
    table = blocks(runs, "gap")
    assert table.loc["x", "a"] == 0.2
    assert table.loc["y", "a"] == np.inf
    assert np.isnan(table.loc["x", "b"])
