"""Names and sentences from files can only be read: in a page, a figure, CSV, LaTeX, Markdown and on a terminal."""

import base64
import csv
import hashlib
import io
import json
import re
from html.parser import HTMLParser

import pandas as pd
import pytest
from matplotlib import rc_context

from reports import load
from reports.csv_text import csv_text, write_csv
from reports.figures.style import RC, new_figure
from reports.figures.svg import Drawn, inline_svg, save_figure
from reports.pages.blocks import Section
from reports.pages.page import Page, embedded, write_page
from reports.pages.study import write_report
from reports.tables import run_table, write_latex, write_markdown
from tests.reports.pages.outline import check_outline
from workbench.terminal import TextTable, print_table, say

HOSTILE = "=[/b] \x1b[31m\a <!--<script>alert(1)</script> $x_{ |`a` \\ \u202e\ud800\n* [l](u)"


class Elements(HTMLParser):
    """Keeps the scripts that run, the data for them, and the policy."""

    def __init__(self):
        super().__init__()
        self.scripts, self.data, self.policy, self.handlers, self.into = [], [], "", [], None

    def handle_starttag(self, tag, attrs):
        if tag == "script":
            self.into = self.data if ("type", "application/json") in attrs else self.scripts
        self.handlers += [name for name, _ in attrs if name.startswith("on")]
        if ("http-equiv", "Content-Security-Policy") in attrs:
            self.policy = dict(attrs)["content"]

    def handle_data(self, data):
        if self.into is not None:
            self.into.append(data)

    def handle_endtag(self, tag):
        self.into = None


@pytest.fixture(scope="module")
def root(store_maker, tmp_path_factory):
    """A store whose every text is hostile, in one run of three."""
    store = store_maker(tmp_path_factory.mktemp("hostile"))
    root = store.study(count=1, sizes=((6, 2),), seeds=1, efforts={"greedy": 1, "ga": 4})
    path = next(root.glob("*/ga-*.json"))
    record = json.loads(path.read_text())
    hostile = HOSTILE.replace("\ud800", "")  # no JSON file that is read holds it
    texts = dict.fromkeys(("solver", "label", "message", "stopped_by", "log", "code", "revision"), hostile)
    about = record["instance"] | {"name": hostile, "family": hostile}
    tables = {"options": {hostile: hostile}, "statistics": {hostile: [hostile], "much": "x" * 100_000}}
    path.write_text(json.dumps(record | texts | tables | {"instance": about, "status": "ERROR"}))
    return root


@pytest.fixture(scope="module")
def page(root, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "page.html"
    write_report([root], path)
    return path.read_text(encoding="utf-8")


def test_a_page_has_its_own_scripts_only_and_names_them_in_its_policy(page):
    found = Elements()
    found.feed(page)
    assert found.handlers == []
    assert len(found.scripts) == 2  # Bokeh's and the page's own
    assert HOSTILE[:4] in found.data[-1]
    assert len(json.loads(found.data[-1])["details"]["0"]["statistics"]) < 5000
    assert all(json.loads(chart)["roots"] for chart in found.data[:-1])
    digests = [base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in found.scripts]
    assert f"script-src 'sha256-{digests[0]}' 'sha256-{digests[1]}';" in found.policy
    assert "default-src 'none'" in found.policy
    assert "unsafe" not in found.policy.replace("style-src 'unsafe-inline'", "")


def test_a_page_with_all_figures_is_whole_and_loads_nothing(page):
    assert page.count("<svg role") >= 10
    check_outline(page)


def test_nothing_in_the_data_of_a_page_is_read_as_html():
    told = embedded({HOSTILE: HOSTILE, "line": "\u2028"})
    assert told.isascii()
    assert not set("<>&") & set(told)
    assert json.loads(told) == {HOSTILE: HOSTILE, "line": "\u2028"}


def test_a_page_names_files_whose_names_are_no_text(tmp_path):
    write_page(Page("t", "runs/\udcff", [Section("s", [], "s")], "SI"), tmp_path / "page.html")
    assert "runs/\\udcff" in (tmp_path / "page.html").read_text(encoding="utf-8")


@pytest.mark.filterwarnings("ignore:Glyph")
def test_a_figure_takes_no_name_for_a_formula_nor_for_markup(tmp_path):
    figure = new_figure()
    drawn = Drawn('f"><script>', HOSTILE, "c", figure)
    with rc_context(RC):
        figure.add_subplot().set_title("$x_{ <script>\x08")
    svg = inline_svg(drawn)
    assert "$x_{ &lt;script&gt;\ufffd" in svg
    assert "<script>" not in svg
    assert "f---script--" in svg
    save_figure(figure, tmp_path / "f.svg")
    assert "\x08" not in (tmp_path / "f.svg").read_text()


@pytest.mark.parametrize("start", ["=", "+", "-", "@", "\t", "\r"])
def test_a_formula_is_text_in_a_spreadsheet_and_numbers_stay(start):
    frame = pd.DataFrame({"a": [f"{start}1+1", "a=1"], "b": [-1.5, float("nan")], "c": pd.array([-1, None], "Int64")})
    for raw, mark in ((False, "'"), (True, "")):
        text = start.replace("\r", "\n") + "1+1"
        row = list(csv.reader(io.StringIO(csv_text(frame, raw), newline="")))[1]
        assert row == [mark + text, "-1.5", "-1"]


def test_exports_keep_their_rows(root, tmp_path):
    runs = load(root)
    write_csv(run_table(runs), tmp_path / "a.csv")
    assert len(pd.read_csv(tmp_path / "a.csv")) == len(runs)
    assert {text[:2] for text in pd.read_csv(tmp_path / "a.csv")["message"].dropna()} == {"'="}
    write_markdown(runs, tmp_path / "a.md")
    tables = (tmp_path / "a.md").read_text().split("##")[1:]
    for table in tables:
        cells = {len(re.findall(r"(?<!\\)\|", line)) for line in table.splitlines() if line.startswith("|")}
        assert len(cells) == 1
    assert "`a`" not in (tmp_path / "a.md").read_text().replace("\\`", "")
    write_latex(runs, tmp_path / "a.tex")
    rows = (tmp_path / "a.tex").read_text().split("\\midrule")[1:]
    assert not re.search(r"\\\\\s*[\[*]", "".join(rows))
    assert "={[}/b{]} " in rows[0]


def test_a_terminal_shows_control_characters_and_obeys_none(capsys):
    say(HOSTILE)
    say(HOSTILE, err=True)
    print_table(TextTable(["a", "b"], ["a", HOSTILE], [[HOSTILE, HOSTILE]]))
    told = capsys.readouterr()
    for text in (told.out, told.err):
        assert "\\x1b[31m" in text
        assert not re.search("[\x00-\x09\x0b-\x1f\x7f\u202e]", text)
    assert "[/b]" in told.out
