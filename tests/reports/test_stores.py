"""Reading stores: what is there becomes a frame, what is damaged is named and left alone."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from shapely.geometry import Polygon, box

from instances import InputError, Instance, Travel, makespan, tour_costs
from instances.environment.region import Region
from instances.files import read_instance
from instances.scenario import Scenario
from reports import load
from reports.columns import listed_runs
from reports.pages.study import write_report
from reports.stores import COLUMNS, read_runs, read_stores, short_labels
from workbench.jobs.job import folder_of
from workbench.problems.moving_cost import MOVING_COST, MovingCostItem


def test_a_row_a_run_with_recomputed_value(make_store):
    root = make_store().study(count=2)
    runs = load(root)
    assert list(runs.columns) == list(COLUMNS)
    assert len(runs) == len(list(root.glob("*/*-s*-t*.json")))
    assert runs.attrs["warnings"] == []
    for run in runs.itertuples():
        record = json.loads(Path(run.path).read_text())
        instance = read_instance(Path(run.path).with_name("instance.json"))
        assert run.value == makespan(instance, record["routes"])
        assert run.trace.shape == (len(record["trace"]), 3)
    assert set(runs["method"]) == {"greedy", "ga", "memetic", "milp", "milp (cuts=false)"}


def calming() -> Instance:
    """One UAV, two tasks: the way round by task 1 is long at first, and short from 100 s on."""
    legs = np.full((3, 3), 100.0) - 100.0 * np.eye(3)
    first, then = legs.copy(), legs.copy()
    first[1, 0], then[1, 0] = 150.0, 60.0
    travel = Travel(np.stack([first, then])[None], np.array([0]), np.array([0.0, 100.0]))
    return Instance.of_travel("calming", travel, 2, provenance={"family": "wind"})


def test_what_routes_promise_and_take_where_costs_change(make_store):
    """Legs 2→0→1→2 take 300 s whenever; 2→1→0→2 would take 350 s at take-off's costs, and takes 260 s."""
    store = make_store()
    store.put(calming(), store.record(calming(), "ga", 0, ((0, 1),)))
    still = Instance("still", calming().cost, 2, 1, provenance={"family": "wind"})
    store.put(still, store.record(still, "ga", 0, ((0, 1),)))
    runs = load(store.root).set_index("instance")
    assert runs.loc["calming", ["promised", "value", "turned"]].tolist() == [300.0, 300.0, 260.0]
    assert runs.loc["still", ["promised", "turned"]].isna().all()
    assert {"promised", "turned"} <= {column.key for column in listed_runs(runs)}
    assert not {"promised", "turned"} & {column.key for column in listed_runs(runs.drop("calming"))}
    turned = replace(calming(), name="turned")
    store.put(turned, store.record(turned, "memetic", 1, ((1, 0),)))
    page = store.root / "report.html"
    write_report([store.root], page)
    text = re.sub(r"<[^>]*>|\s+", " ", page.read_text())
    assert "Planning by the clock" in text
    assert "Costs change with time on 1 instance." in text
    section = re.sub(r" +", " ", text[text.index("Costs change with time on") :])
    assert "15.4" in section[:1500], "300 s are 15.4 % more than 260 s"
    assert "-25.7" in section[:1500].replace("−", "-"), "260 s are 25.7 % less than the 350 s promised"


def test_how_much_of_its_fleet_a_run_uses(make_store):
    store = make_store()
    instance = Instance("unlimited", 9.0 - 9.0 * np.eye(6), 4, 2, provenance={"family": "even"})
    routes = ((0, 1, 2), (3,))
    long, short = tour_costs(instance, routes)
    for case, endurance in ((instance, None), (replace(instance, name="limited"), [2 * long, np.inf])):
        flown = replace(case, endurance=endurance)
        store.put(flown, store.record(flown, "ga", 0, routes))
    runs = load(store.root).set_index("instance")
    assert runs["utilisation"].tolist() == pytest.approx([(1 + short / long) / 2] * 2)
    assert np.isnan(runs.loc[instance.name, "endurance_margin"])
    assert runs.loc["limited", "endurance_margin"] == pytest.approx(0.5)
    assert "endurance_margin" in [column.key for column in listed_runs(runs)]
    assert "endurance_margin" not in [column.key for column in listed_runs(runs.drop("limited"))]


def test_damaged_and_foreign_files_are_named_and_left_alone(make_store):
    root = make_store().study(count=1, sizes=((6, 2),), seeds=2)
    good = sorted(root.glob("*/ga-*.json"))
    before = len(load(root))
    good[0].write_text(good[0].read_text()[:200])
    others = {
        "empty.json": "",
        "foreign.json": '{"hello": 1}',
        "list.json": "[1, 2]",
        "future.json": json.dumps(json.loads(good[1].read_text()) | {"schema": 99}),
        "status.json": json.dumps(json.loads(good[1].read_text()) | {"status": "GREAT"}),
        "routes.json": json.dumps(json.loads(good[1].read_text()) | {"routes": "none"}),
        "trace.json": json.dumps(json.loads(good[1].read_text()) | {"trace": [[1, 2]]}),
        "placement.json": json.dumps(json.loads(good[1].read_text()) | {"problem": "task_location"}),
        "nan.json": good[1].read_text().replace('"objective": ', '"objective": NaN, "x": '),
    }
    for name, text in others.items():
        (good[0].parent / name).write_text(text)
    (good[0].parent / "binary.json").write_bytes(bytes(range(256)))
    content = {path: path.read_bytes() for path in root.rglob("*.json")}
    runs = load(root)
    assert len(runs) == before - 1
    for name in [*others, "binary.json", good[0].name]:
        assert sum(name in warning for warning in runs.attrs["warnings"]) == 1, name
    assert len(runs.attrs["warnings"]) == len(others) + 2
    assert content == {path: path.read_bytes() for path in root.rglob("*.json")}


def test_damaged_instance_is_named_and_its_runs_are_kept(make_store):
    root = make_store().study(count=1, sizes=((6, 2),), seeds=1)
    next(root.glob("*/instance.json")).write_text("{")
    stores = read_stores(root)
    assert any("instance.json" in warning for warning in stores.warnings)
    assert stores.runs["recomputed"].isna().all()
    np.testing.assert_array_equal(stores.runs["value"], stores.runs["objective"])


def test_merging_counts_a_run_once_and_keeps_the_latest(make_store):
    first, second = make_store("a").study(count=1, seeds=2), make_store("b").study(count=2, seeds=2)
    path = sorted(second.glob("uniform*/ga-*.json"))[0]
    path.write_text(json.dumps(json.loads(path.read_text()) | {"created": "2027-01-01T00:00:00Z", "message": "new"}))
    both, latter = load(first, second), load(second)
    assert len(both) == len(latter)
    assert (both["message"] == "new").sum() == 1
    assert any("more than once" in warning for warning in both.attrs["warnings"])


def test_several_limits_make_several_methods(make_store):
    store = make_store()
    root = store.study(count=1, sizes=((6, 2),), seeds=1)
    path = next(root.glob("*/ga-*.json"))
    record = json.loads(path.read_text()) | {"time_limit": 60.0}
    path.with_name("ga-default-s0-t60.json").write_text(json.dumps(record))
    assert {"ga @ 10 s", "ga @ 60 s", "greedy"} <= set(load(root)["method"])


def test_region_and_zones_of_a_scenario_are_part_of_it_and_no_damaged_runs(tmp_path):
    region, zone = Region(Polygon([(0, 0), (900, 50), (400, 800)])), box(390, 200, 420, 230)
    depots, tasks = np.array([[100.0, 20.0]]), np.array([[400.0, 500.0]])
    scenario = Scenario("s", region, depots, 20.0, tasks=tasks, no_fly=[zone])
    item = MovingCostItem(scenario, None)
    (tmp_path / folder_of(item)).mkdir()
    MOVING_COST.write(item, tmp_path / folder_of(item))
    assert {"scenario-region.json", "scenario-no-fly.json"} <= {path.name for path in tmp_path.glob("*/*")}
    assert read_runs(tmp_path, problem="moving-cost") == ({}, [])
    assert MOVING_COST.check(tmp_path)[1] == []
    (tmp_path / folder_of(item) / "other.json").write_text("{}")
    assert "other.json" in read_runs(tmp_path, problem="moving-cost")[1][0]


def test_missing_folder_is_an_input_error(tmp_path):
    with pytest.raises(InputError, match="nowhere"):
        load(tmp_path / "nowhere")


def test_import_is_cheap():
    import subprocess
    import sys

    code = "import sys, reports; sys.exit(any(m in sys.modules for m in ('pandas', 'numpy', 'matplotlib')))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_long_labels_become_short_and_stay_different():
    labels = [
        "milp",
        "milp (symmetry=false)",
        "milp (depot_linked=false, hint=false, reach=false)",
        "milp (depot_linked=false, hint=false, symmetry=false)",
        "x" * 60,
    ]
    names = short_labels(labels)
    assert names["milp"] == "milp"
    assert names[labels[1]] == labels[1]
    assert names[labels[2]] == "milp (depot_linked=false, 2 more)"
    assert names[labels[3]] == "milp (depot_linked=false, 2 more) #2"
    assert len(set(names.values())) == len(labels)
    assert max(map(len, names.values())) <= 40
