"""The page of unusual stores: nothing solved, one run, costs of 0, 1e-6 and 1e9, no coordinates, no traces."""

import json
import re

import numpy as np
import pytest

from instances import Instance
from reports.pages.page import embedded
from reports.pages.study import write_report
from tests.reports.pages.outline import check_outline


def write(root, target):
    write_report([root], target)
    html = target.read_text()
    check_outline(html)
    data = re.search(r'<script type="application/json" id="data">(.*?)</script>', html, flags=re.S).group(1)
    return html, json.loads(data)


def listed(html, key):
    """Return the rows of a list as its columns' keys → texts."""
    table = re.search(rf'<table id="{key}-table".*?</table>', html, flags=re.S).group()
    keys = re.findall(r'data-key="(\w+)"', table)
    rows = table.split("<tbody>")[1].split("<tr>")[1:]
    return [dict(zip(keys, re.findall(r"<td[^>]*>([^<]*)", row), strict=True)) for row in rows]


def instance(name, cost, n, coordinates=None):
    return Instance(name, np.array(cost, dtype=float), n, len(cost) - n, coordinates, {"family": "file"})


def record(store_maker, given, routes, **keys):
    return store_maker.record(given, "greedy", 0, routes, **keys)


@pytest.mark.usefixtures("without_figures")
@pytest.mark.parametrize("scale", [0.0, 1e-6, 1.0, 1e9])
def test_costs_of_any_size(store_maker, make_store, tmp_path, scale):
    store = make_store()
    given = instance("tiny", scale * np.array([[0, 2.0], [3.0, 0]]), 1, np.zeros((2, 2)))
    store.put(given, record(store_maker, given, [[0]], values=[8.0 * scale, 5.0 * scale]))
    html, data = write(store.root, tmp_path / "page.html")
    assert data["details"]["0"]["end"] == [pytest.approx(5 * scale), None]
    assert [run["gap_found"] for run in listed(html, "run-list")] == ["0"]


def test_nothing_solved(store_maker, make_store, tmp_path):
    store = make_store()
    given = instance("hard", [[0, 2.0], [3.0, 0]], 1)
    for status in ("NO_SOLUTION", "KILLED", "ERROR"):
        made = record(store_maker, given, None, status=status, limit=float(len(status)))
        store.put(given, made | {"elapsed": None, "message": f"it ended {status}"})
    html, data = write(store.root, tmp_path / "page.html")
    assert [detail["end"] for detail in data["details"].values()] == [[None, None]] * 3
    assert "No contradictions" in html


def test_without_coordinates_nor_trace(store_maker, make_store, tmp_path):
    store = make_store()
    given = instance("file", [[0, 2.0, 1], [3.0, 0, 1], [1, 1, 0]], 2)
    store.put(given, record(store_maker, given, [[0, 1]]))
    _, data = write(store.root, tmp_path / "page.html")
    assert data["maps"] == {}
    assert data["details"]["0"]["tours"] == [4]


@pytest.mark.usefixtures("without_figures")
def test_a_large_store_embeds_only_so_much_and_says_so(make_store, tmp_path, monkeypatch):
    monkeypatch.setattr("reports.pages.payload.DETAILS_BUDGET", 12_000)
    html, data = write(make_store().study(count=2, seeds=3), tmp_path / "page.html")
    runs = listed(html, "run-list")
    assert 0 < len(data["details"]) < len(runs)
    assert f"routes, trace and log of {len(data['details'])} of {len(runs)} runs" in html
    assert [data["instances"]["instance"][i] for i in data["runs"]["instance"]] == [run["instance"] for run in runs]
    best = {(run["instance"], run["method"]) for run in runs}
    held = [(runs[int(k)]["instance"], runs[int(k)]["method"]) for k in data["details"]]
    assert len(set(held)) == min(len(held), len(best))  # one of each method and instance before a second of any


@pytest.mark.usefixtures("without_figures")
def test_lists_hold_every_run_and_instance_with_units_in_their_heads(make_store, tmp_path):
    html, data = write(make_store().study(count=2, seeds=3), tmp_path / "page.html")
    runs, instances = listed(html, "run-list"), listed(html, "instance-list")
    assert len(runs) == len(data["runs"]["instance"]) == 4 * 11
    assert {run["instance"] for run in runs} == {each["instance"] for each in instances}
    said, exact = ([run["value"] for run in runs], [data["details"][str(k)]["end"][0] for k in range(len(runs))])
    assert [float(text.replace(",", "")) for text in said] == pytest.approx(exact, rel=1e-5)
    assert 'data-key="gap_found" data-unit="%"' in html
    assert not any("%" in text for run in runs for text in run.values())
    assert '<th scope="col" data-key="elapsed" data-unit="s"' in html


def test_text_cannot_leave_its_script():
    assert "</" not in embedded({"log": "</script>"})
    assert json.loads(embedded({"log": "</script>"})) == {"log": "</script>"}


@pytest.mark.slow
def test_the_page_is_the_same_for_the_same_store(make_store, tmp_path):
    root = make_store().study(count=1, seeds=1)
    for name in ("a.html", "b.html"):
        write_report([root], tmp_path / name)
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


def best_in(html, key):
    """Return the rows' names → the texts marked as best in a table."""
    table = re.search(rf'<table class="sortable" id="{key}-table".*?</table>', html, flags=re.S).group()
    rows = re.findall(r"<tr><th scope=\"row\".*?</tr>", table, flags=re.S)
    name = r"<th scope=\"row\"[^>]*>(?:<svg.*?</svg>)?([^<]*)"
    return {re.search(name, row).group(1): re.findall(r'class="best"[^>]*>([^<]*)', row) for row in rows}


def small_study(store_maker, make_store, **skipped):
    """A store in which `slow` and `late` find longer tours than `fast`, and skip the instances named."""
    store, cost = make_store(), np.array([[0, 2.0, 3.0], [3.0, 0, 2.0], [2.0, 2.0, 0]])
    for k, name in enumerate(("one", "two")):
        given = instance(name, (1 + k) * cost, 2)
        for solver, route in (("fast", [[0, 1]]), ("slow", [[1, 0]]), ("late", [[1, 0]])):
            if skipped.get(solver) != name:
                store.put(given, store_maker.record(given, solver, 0, route))
    return store.root


@pytest.mark.usefixtures("without_figures")
@pytest.mark.parametrize(
    ("skipped", "best"),
    [
        ({}, {"fast": True, "slow": False, "late": False}),
        ({"fast": "two"}, {"fast": False, "slow": False, "late": False}),  # slow and late read the same
        ({"late": "one"}, {"fast": True, "slow": False, "late": False}),
        ({"fast": "two", "slow": "one"}, {"fast": False, "slow": False, "late": False}),
    ],
)
def test_the_best_is_marked_among_methods_on_the_same_instances(store_maker, make_store, tmp_path, skipped, best):
    html, _ = write(small_study(store_maker, make_store, **skipped), tmp_path / "page.html")
    assert {name: bool(found) for name, found in best_in(html, "summary").items()} == best
    assert ("ran on every instance" in html) == bool(skipped)
