"""The builder: every block becomes HTML that closes, text is escaped once, numbers sort and the best are marked."""

import re
from html.parser import HTMLParser

import pandas as pd
import pytest
from markupsafe import Markup

from reports import columns, numbers
from reports.columns import Column, least, most
from reports.figures.style import new_figure
from reports.figures.svg import Drawn
from reports.pages.blocks import Beside, Facts, Folded, Lines, Note, Section, Source, column_help, table_of
from reports.pages.page import Page, write_page

NASTY = "<b>&amp; 1 %"


class Balance(HTMLParser):
    """Notes tags that do not close and the text that is read."""

    def __init__(self):
        super().__init__()
        self.open, self.text = [], []

    def handle_starttag(self, tag, attrs):
        if tag not in ("meta", "link"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def written(tmp_path, *blocks, **more):
    write_page(Page(NASTY, NASTY, blocks, "SI units.", **more), tmp_path / "page.html")
    return (tmp_path / "page.html").read_text(encoding="utf-8")


def test_text_is_escaped_once_in_every_block(tmp_path):
    frame = pd.DataFrame({"a": [NASTY]})
    nasty = table_of(frame, [Column("a", NASTY, NASTY, meaning=NASTY)], caption=NASTY)
    drawn = Drawn("f", NASTY, NASTY, new_figure())
    inner = [NASTY, Note(NASTY), Lines([NASTY]), Facts([(NASTY, NASTY)]), Source(NASTY), nasty, drawn, [NASTY]]
    html = written(tmp_path, Section(NASTY, [Beside(inner), Folded(NASTY, [Section(NASTY, [])])], "key"))
    reader = Balance()
    reader.feed(html)
    assert reader.open == []
    said = "\n".join(reader.text).replace("\u00a0", " ")
    assert said.count(NASTY) == 23  # each place once
    assert "&lt;" not in said
    assert "<b>&" not in html.replace("<figcaption><b>&lt;", "")


def test_markup_is_left_as_it_is_and_only_sections_with_a_key_are_named_above(tmp_path):
    parts = Section("Inner", [Markup('<div id="here"></div>')])
    html = written(tmp_path, Section("Long", [parts], "long", "Short"), Section("Bad", [], "bad", tone="alarm"))
    assert '<div id="here"></div>' in html
    assert re.findall(r'<a href="(#\w+)">([^<]+)</a>', html) == [("#long", "Short")]
    assert '<section id="bad" aria-labelledby="bad-h" class="alarm" role="alert">' in html


@pytest.fixture
def frame():
    return pd.DataFrame({"name": ["x", "y", "z"], "time": [2.0, float("nan"), 1.0], "share": [0.0, 0.5, 0.5]})


def test_the_best_are_marked_and_the_missing_sort_last(frame):
    found = table_of(
        frame,
        [
            Column("name", "Name"),
            Column("time", "Time", "s", numbers.seconds, mark=least),
            Column("share", "Share", "", numbers.share, mark=most),
        ],
        methods=["x", "y"],
    )
    assert [[c.text for c in row] for row in found.rows] == [["x", "2.00", "0"], ["y", "–", "50"], ["z", "1.00", "50"]]
    assert [c.heading for c in found.columns] == ["Name", "Time [s]", "Share [%]"]
    assert [[c.mark for c in row] for row in found.rows] == [["", "", ""], ["", "", "best"], ["", "best", "best"]]
    assert [row[1].sort for row in found.rows] == [2.0, None, 1.0]
    assert [row[0].line is not None for row in found.rows] == [True, True, False]


def test_where_all_are_equal_none_is_the_best():
    assert (
        least(pd.Series([1.0, 1.0])) == most(pd.Series([1.0, 1.0])) == most(pd.Series([0.0, float("nan")])) == ["", ""]
    )


def test_the_best_is_what_reads_as_the_best():
    time = Column("time", "Time", "s", numbers.seconds, mark=least)
    assert time.marks(pd.Series([1.001, 1.004, 2.0])) == ["best", "best", ""]
    assert time.marks(pd.Series([1.001, 1.004])) == ["", ""]
    assert time.marks(pd.Series([1.0, float("nan")])) == ["best", ""]


def test_only_rivals_can_be_the_best(frame):
    found = table_of(frame, [Column("time", "Time", "s", numbers.seconds, mark=least)], rivals=[True, True, False])
    assert [row[0].mark for row in found.rows] == ["best", "", ""]


def test_a_unit_goes_into_the_heading_where_all_that_is_there_has_it():
    gap, memory = Column("gap", "Gap", "", numbers.gap), Column("m", "Memory", "", numbers.memory)
    assert gap.with_unit(["< 0.01\u00a0%", "–", "∞"])[0].heading == "Gap [%]"
    assert gap.with_unit(["< 0.01\u00a0%", "–"])[1] == ["< 0.01", "–"]
    assert memory.with_unit(["1.20 GB", "120 MB"]) == (memory, ["1.20 GB", "120 MB"])
    text = Column("i", "Interval")
    assert text.with_unit(["1\u00a0% … 2\u00a0%"]) == (text, ["1\u00a0% … 2\u00a0%"])


@pytest.mark.parametrize(
    ("low", "high", "said"),
    [
        (-2e-4, -1e-4, "> −0.001"),
        (-2e-4, 1e-4, "> −0.001 … < 0.001"),
        (-2.0, 1.0, "−2.00 … 1.00"),
        (float("nan"), 1.0, "–"),
    ],
)
def test_intervals_of_small_differences_can_be_read(low, high, said):
    assert numbers.interval(numbers.signed_seconds, low, high) == said


def test_columns_are_explained_by_name_unit_and_meaning():
    (folded,) = column_help([Column("a", "A", "s", meaning="so"), Column("b", "B")])
    assert folded.blocks == [Facts([("A [s]", "so")])]
    assert column_help([Column("b", "B")]) == []


@pytest.mark.parametrize("name", ["SUMMARY", "INSTANCES", "RUNS", "PLACEMENTS", "EXCESS", "SCALING", "FLIGHT"])
def test_every_column_is_described_once(name):
    keys = [column.key for column in getattr(columns, name)]
    assert len(keys) == len(set(keys))
