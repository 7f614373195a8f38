"""A new store against a baseline."""

import json
import re
from itertools import pairwise

import pandas as pd
import pytest

from instances import InputError
from instances.files import read_instance
from reports import load
from reports.compare import compare_stores
from reports.pages.study import write_report

EFFORTS = {"greedy": 1, "ga": 5}


@pytest.fixture
def pair(make_store):
    """Two equal stores of 16 instances."""
    kept = {"sizes": ((7, 2), (9, 3)), "count": 8, "seeds": 1, "efforts": EFFORTS}
    return make_store("old").study(**kept), make_store("new").study(**kept)


def worsen(root, pattern, count):
    """Hand the first `count` runs of the pattern worse routes: all tasks to the first UAV, in order."""
    for path in sorted(root.glob(pattern))[:count]:
        record = json.loads(path.read_text())
        instance = read_instance(path.with_name("instance.json"))
        routes = [list(instance.tasks), *[[] for _ in range(instance.n_depots - 1)]]
        stops = [instance.n_tasks, *routes[0], instance.n_tasks]
        cost = float(sum(instance.cost[a, b] for a, b in pairwise(stops)))
        path.write_text(
            json.dumps(record | {"routes": routes, "objective": cost, "claimed_objective": cost, "trace": []})
        )


def test_the_same_store_is_unchanged(pair):
    old, _ = pair
    found = compare_stores(load(old), load(old))
    assert not found.regressed
    assert set(found.methods["verdict"]) == {"unchanged"}
    assert set(found.instances["verdict"]) == {"unchanged"}


def test_a_regression_is_significant_and_the_other_way_round_an_improvement(pair):
    old, new = pair
    worsen(new, "*/ga-*.json", 16)
    found = compare_stores(load(new), load(old))
    row = found.methods.set_index(["method", "measure"]).loc[("ga", "quality")]
    assert (row["better"], row["worse"], row["unchanged"], row["verdict"]) == (0, 16, 0, "worse")
    assert row["low"] > 0
    assert found.regressed
    assert "ga: quality" in found.regressions[0]
    back = compare_stores(load(old), load(new))
    assert not back.regressed
    assert back.methods.set_index(["method", "measure"]).loc[("ga", "quality"), "verdict"] == "better"


def test_one_bad_instance_is_too_few_to_conclude(pair):
    old, new = pair
    worsen(new, "*/ga-*.json", 1)
    found = compare_stores(load(new), load(old))
    row = found.methods.set_index(["method", "measure"]).loc[("ga", "quality")]
    assert row["verdict"] == "too few instances to conclude"
    assert not found.regressed
    assert (found.instances["verdict"] == "worse").sum() == 1


def test_slower_proofs_are_a_regression_and_lost_ones_are_remarked(pair):
    old, new = pair
    for path in sorted(new.glob("*/milp-default*.json")):
        record = json.loads(path.read_text())
        path.write_text(json.dumps(record | {"elapsed": 3 * record["elapsed"]}))
    assert [line for line in compare_stores(load(new), load(old)).regressions if "time to proof" in line]
    path = sorted(new.glob("*/milp-default*.json"))[0]
    record = json.loads(path.read_text())
    path.write_text(json.dumps(record | {"status": "FEASIBLE", "bound": 0.9 * record["bound"]}))
    assert any("1 instances" in line and "no longer" in line for line in compare_stores(load(new), load(old)).remarks)


def test_new_contradictions_are_a_regression(pair):
    old, new = pair
    path = sorted(new.glob("*/ga-*.json"))[0]
    path.write_text(json.dumps(json.loads(path.read_text()) | {"objective": 1.0}))
    assert any("contradiction" in line for line in compare_stores(load(new), load(old)).regressions)


def test_only_runs_with_a_partner_are_compared(pair):
    old, new = pair
    for path in sorted(old.glob("*/ga-*.json"))[:10]:
        path.unlink()
    found = compare_stores(load(new), load(old))
    assert found.methods.set_index(["method", "measure"]).loc[("ga", "quality"), "instances"] == 6
    assert "10 are only in the new store" in found.remarks[0]


@pytest.mark.usefixtures("without_figures")
def test_the_page_shows_the_comparison(pair, tmp_path):
    old, new = pair
    worsen(new, "*/ga-*.json", 16)
    report = write_report([new], tmp_path / "page.html", against=[old])
    assert report.comparison.regressed
    html = (tmp_path / "page.html").read_text()
    assert "Against the baseline" in html
    assert "Regression: ga: quality is significantly worse" in html


def test_a_store_without_runs_is_an_input_error(tmp_path):
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="empty: holds no run"):
        write_report([tmp_path / "empty"], tmp_path / "page.html")
    assert not (tmp_path / "page.html").exists()


@pytest.mark.usefixtures("without_figures")
def test_stores_without_a_common_run_compare_to_nothing(make_store, tmp_path):
    old = make_store("old").study(sizes=((5, 2),), count=1, seeds=1, efforts=EFFORTS)
    new = make_store("new").study(sizes=((6, 2),), count=1, seeds=1, efforts=EFFORTS)
    report = write_report([new], tmp_path / "page.html", against=[old])
    assert report.comparison.methods.empty
    assert not report.comparison.regressed
    assert report.comparison.pairs == 0
    page = (tmp_path / "page.html").read_text()
    assert "Nothing to compare: the stores have no instance in common (here: uniform-n6" in page
    assert "No significant regression" not in page


@pytest.mark.parametrize(
    ("column", "other", "said"),
    [
        ("method", "ga (population=9)", r"no method in common \(here: exact; there: ga \(population=9\)\)"),
        ("time_limit", 2.0, r"no time limit \[s\] in common \(here: 1; there: 2\)"),
        ("seed", 7, r"no seed in common \(here: 0, 1; there: 7\)"),
        (
            "digest",
            "x",
            r"no instance in common \(here: n5, n10, n40 and 1 more; there: n5, .*; those of one name have other",
        ),
    ],
)
def test_what_two_stores_do_not_share_is_said(column, other, said):
    names = ["n5", "n10", "n40", "n100"]
    made = [(name, name, "exact", 1.0, seed, 3.0, True, 0.1) for name in names for seed in (0, 1)]
    keys = ["instance", "digest", "method", "time_limit", "seed", "value", "proved", "elapsed"]
    frame = pd.DataFrame(made, columns=keys)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("reports.compare.contradictions", lambda runs: [])
        found = compare_stores(frame, frame.assign(**{column: other}))
    assert (found.pairs, found.regressed, len(found.methods)) == (0, False, 0)
    assert re.search(said, found.remarks[0])
