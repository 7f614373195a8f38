"""The page of unusual stores: nothing solved, one run, costs of 0, 1e-6 and 1e9, no coordinates, no traces."""

import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest

from instances import Instance
from reports.pages.page import embedded
from reports.pages.study import write_report


class Outline(HTMLParser):
    """Notes what a page loads and whether its tags balance."""

    VOID = ("meta", "link", "br", "input", "img")

    def __init__(self):
        super().__init__()
        self.open, self.loaded = [], []

    def handle_starttag(self, tag, attrs):
        if tag not in self.VOID:
            self.open.append(tag)
        self.loaded += [v for k, v in attrs if k in ("src", "href", "xlink:href") and not v.startswith(("#", "data:"))]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def write(root, target):
    write_report([root], target)
    html = target.read_text()
    outline = Outline()
    outline.feed(html)
    assert outline.open == []
    assert outline.loaded == []
    assert "@import" not in html
    data = re.search(r'<script type="application/json" id="data">(.*?)</script>', html, flags=re.S).group(1)
    return html, json.loads(data)


def instance(name, cost, n, coordinates=None):
    return Instance(name, np.array(cost, dtype=float), n, len(cost) - n, coordinates, {"family": "file"})


def record(store_maker, given, routes, **keys):
    return store_maker.record(given, "greedy", 0, routes, **keys)


@pytest.mark.parametrize("scale", [0.0, 1e-6, 1.0, 1e9])
def test_costs_of_any_size(store_maker, make_store, tmp_path, scale):
    store = make_store()
    given = instance("tiny", scale * np.array([[0, 2.0], [3.0, 0]]), 1, np.zeros((2, 2)))
    store.put(given, record(store_maker, given, [[0]], values=[8.0 * scale, 5.0 * scale]))
    _, data = write(store.root, tmp_path / "page.html")
    assert data["runs"]["value"] == pytest.approx([5 * scale])
    assert data["runs"]["gap_found"] == [0]


def test_nothing_solved(store_maker, make_store, tmp_path):
    store = make_store()
    given = instance("hard", [[0, 2.0], [3.0, 0]], 1)
    for status in ("NO_SOLUTION", "KILLED", "ERROR"):
        made = record(store_maker, given, None, status=status, limit=float(len(status)))
        store.put(given, made | {"elapsed": None, "message": f"it ended {status}"})
    html, data = write(store.root, tmp_path / "page.html")
    assert data["runs"]["value"] == [None] * 3
    assert len(data["details"]) == 3
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
    assert 0 < len(data["details"]) < len(data["runs"]["seed"])
    assert f"routes, trace and log of {len(data['details'])} of {len(data['runs']['seed'])} runs" in html
    best = {(i, m) for i, m in zip(data["runs"]["instance"], data["runs"]["method"], strict=True)}
    held = [(data["runs"]["instance"][int(k)], data["runs"]["method"][int(k)]) for k in data["details"]]
    assert len(set(held)) == min(len(held), len(best))  # one of each method and instance before a second of any


def test_text_cannot_leave_its_script():
    assert "</" not in embedded({"log": "</script>"})
    assert json.loads(embedded({"log": "</script>"})) == {"log": "</script>"}


def test_the_page_is_the_same_for_the_same_store(make_store, tmp_path):
    root = make_store().study(count=1, seeds=1)
    for name in ("a.html", "b.html"):
        write_report([root], tmp_path / name)
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()
