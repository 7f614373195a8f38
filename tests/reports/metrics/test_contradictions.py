"""Planted lies: each is caught, named, kept out of the figures and shown on top of the page."""

import json

import pytest

from reports import load
from reports.metrics import contradictions, summary
from reports.pages.study import write_report
from workbench.problems.routing import refute_cost

pytestmark = pytest.mark.usefixtures("without_figures")


@pytest.fixture
def store(make_store):
    """A small honest store and how to rewrite one of its runs."""
    root = make_store().study(count=2, sizes=((7, 2),), seeds=1)

    def plant(pattern, **keys):
        path = sorted(root.glob(pattern))[0]
        record = json.loads(path.read_text())
        path.write_text(json.dumps(record | {k: v(record) if callable(v) else v for k, v in keys.items()}))

    return root, plant


def shown(root, tmp_path):
    write_report([root], tmp_path / "page.html")
    html = (tmp_path / "page.html").read_text()
    return html[html.index("<main>") : html.index('id="summary"')]


def test_an_honest_store_has_none(store, tmp_path):
    root, _ = store
    assert contradictions(load(root)).empty
    assert 'class="alarm"' not in shown(root, tmp_path)
    assert "No contradictions" in shown(root, tmp_path)


LIES = [
    ("wrong cost", "*/ga-*.json", {"objective": lambda r: 0.9 * r["objective"]}, "its routes cost"),
    ("wrong cost", "*/ga-*.json", {"claimed_objective": lambda r: 0.5 * r["objective"], "status": "ERROR"}, "claims"),
    ("routes not feasible", "*/ga-*.json", {"routes": [[0, 1], [2]]}, "is visited by no route"),
    ("routes not feasible", "*/ga-*.json", {"routes": [[0, 1, 2, 3, 4, 5, 6], [0]]}, "is visited 2 times"),
    ("no routes", "*/ga-*.json", {"routes": None}, "holds no routes"),
    ("bound above routes", "*/milp-c*.json", {"bound": lambda r: 1.01 * r["bound"]}, "is above the routes of"),
    ("OPTIMAL with a gap", "*/milp-d*.json", {"bound": lambda r: 0.95 * r["bound"]}, "a gap of 5.00%"),
    ("OPTIMAL with a gap", "*/milp-d*.json", {"bound": None}, "holds no bound"),
    (
        "OPTIMAL with a gap",
        "*/milp-d*.json",
        {"bound": lambda r: 0.95 * r["bound"], "tolerance": lambda r: 0.1 * r["objective"]},
        "stated tolerance",
    ),
    ("INFEASIBLE refuted", "*/greedy*.json", {"status": "INFEASIBLE", "routes": None, "objective": None}, "infeasible"),
    ("INFEASIBLE refuted", "*/greedy*.json", {"status": "INFEASIBLE"}, "but holds routes of"),
    ("routes denied", "*/greedy*.json", {"status": "NO_SOLUTION"}, "but holds routes of"),
    *(
        (
            "bound above routes",
            "*/greedy*.json",
            {"status": status, "trace": lambda r: [[0.1, r["objective"], 1.5 * r["objective"]]]},
            "in its trace is above the routes of",
        )
        for status in ("FEASIBLE", "KILLED")
    ),
    ("bound without a proof", "*/greedy*.json", {"bound": lambda r: r["objective"]}, "its method proves nothing"),
    ("trace below routes", "*/ga*.json", {"trace": lambda r: [[0.1, 0.5 * r["objective"], None]]}, "Its trace claims"),
]


@pytest.mark.parametrize(("kind", "pattern", "keys", "words"), LIES)
def test_a_lie_is_caught(store, kind, pattern, keys, words):
    root, plant = store
    plant(pattern, **keys)
    found = contradictions(load(root))
    assert kind in set(found["kind"])
    assert words in " ".join(found["sentence"])


def test_the_lies_are_shown_on_top_of_the_page(store, tmp_path):
    root, plant = store
    for place in (0, 5, 6):
        plant(*LIES[place][1:2], **LIES[place][2])
    top = shown(root, tmp_path)
    assert 'class="alarm"' in top
    for kind, _, _, words in (LIES[0], LIES[5], LIES[6]):
        assert kind in top
        assert words in top


def test_a_bound_above_the_best_known_value_is_caught(store):
    root, plant = store
    plant("*/milp-d*.json", instance=lambda r: r["instance"] | {"best_known": 0.9 * r["objective"]})
    assert "bound above best known" in set(contradictions(load(root))["kind"])


def test_a_proof_within_its_tolerance_is_no_lie(store):
    root, plant = store
    plant("*/milp-d*.json", bound=lambda r: r["bound"] * (1 - 1e-6), tolerance=lambda r: 2e-6 * r["objective"])
    assert contradictions(load(root)).empty


def test_a_wrong_cost_counts_for_nothing(store):
    root, plant = store
    plant("*/ga-*.json", objective=lambda r: 1e-3 * r["objective"])
    table = summary(load(root))
    assert table.loc["ga", "solved"] == 0.5
    assert (table["gap_found"].dropna() >= 0).all()
    assert table.loc["milp", "gap_found"] == 0


def test_the_cheaper_liar_does_not_become_the_best(store):
    root, plant = store
    runs = load(root)
    best = runs.groupby("digest")["value"].min()
    plant("*/ga-*.json", routes=[[0], []], objective=1.0)
    assert (load(root).groupby("digest")["value"].min() >= best).all()


def test_a_refuted_or_crashed_run_is_shown_as_failed(store, tmp_path):
    root, plant = store
    plant("*/ga-*.json", status="ERROR", message="claimed a bound above its own routes", bound=None)
    top = shown(root, tmp_path)
    assert "1 run failed" in top
    assert "claimed a bound above its own routes" in top


def test_feasible_routes_of_a_refuted_run_still_refute_a_bound(store):
    root, plant = store
    plant("*/milp-default*.json", bound=lambda r: 1.02 * r["objective"], objective=lambda r: 1.03 * r["objective"])
    kinds = contradictions(load(root)).groupby("method")["kind"].agg(set)
    assert kinds["milp"] == {"wrong cost", "bound above routes"}


@pytest.mark.parametrize("place", [5, 6, 7, 8])
def test_a_proof_that_does_not_hold_is_none(store, place):
    root, plant = store
    before = load(root)
    _, pattern, keys, _ = LIES[place]
    plant(pattern.replace("milp-c*", "milp-d*"), **keys)
    after = load(root)
    assert before["proved"].sum() - after["proved"].sum() == 1
    assert summary(after).loc["milp", "proved"] == 0.5


def test_infeasible_is_false_where_nothing_stands_beside_it(store):
    root, plant = store
    for path in root.glob("*/*-s*.json"):
        plant(str(path.relative_to(root)), status="INFEASIBLE", routes=None, objective=None, bound=None, trace=[])
    found = contradictions(load(root))
    assert set(found["kind"]) == {"INFEASIBLE refuted"}
    assert "there are routes" in found["sentence"][0]


def test_a_bound_that_may_be_cut_off_certifies_nothing_and_a_bound_is_its_methods(store):
    root, plant = store
    alone = {"status": "FEASIBLE", "bound": lambda r: r["objective"], "trace": []}
    for path in [*root.glob("*/milp-*.json"), *root.glob("*/memetic-*.json")]:
        plant(str(path.relative_to(root)), **alone)
    assert summary(load(root))["certified"].max() == 0
    plant("*/milp-d*.json", status="OPTIMAL")
    table = summary(load(root))
    assert table.loc["milp", "certified_by"] == "own bound"
    assert table.loc["memetic", "certified_by"] == "milp"


def test_an_infinite_cost_is_close_to_none():
    assert refute_cost(5.0, float("inf"))
    assert not refute_cost(5.0, 5.0)
