"""`workbench paper`: what LaTeX reads is whole, aligned at the decimal point, and cites every method that ran."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from types import SimpleNamespace

import pytest
from matplotlib.figure import Figure

from formulations.moving_cost.registry import METHODS as COSTS
from formulations.routing.registry import SOLVERS
from formulations.selection.registry import METHODS as SELECTION
from formulations.task_location.registry import METHODS as PLACEMENT
from reports import load
from reports.metrics import summary
from reports.paper import document
from reports.paper.document import Cited, paper_files, references
from reports.paper.size_tables import size_tables
from reports.tex import tex
from workbench.cli import main


@pytest.fixture(scope="module")
def store(store_maker, tmp_path_factory):
    """Two sizes, two fleets, a method of others and one whose name LaTeX would read."""
    maker = store_maker(tmp_path_factory.mktemp("paper") / "runs")
    maker.study(count=2, seeds=2)
    for path in sorted(maker.root.glob("*/ga-*.json")):
        run = json.loads(path.read_text())
        for name, more in (("LKH†", {"foreign": True}), ("mine_50%:A&B", {})):
            path.with_name(path.name.replace("ga-", f"{len(name)}-")).write_text(
                json.dumps(run | {"solver": name, "label": name} | more)
            )
    return maker.root


@pytest.fixture(scope="module")
def paper(store, tmp_path_factory):
    """What the command line writes, figures left to a test of their own."""
    out = tmp_path_factory.mktemp("written") / "paper"
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(document, "study_figures", lambda runs: [])
        with pytest.raises(SystemExit) as ended:
            main(["paper", str(store), "--out", str(out)])
    assert not ended.value.code
    return out


def rows_of(table: str) -> list[list[str]]:
    """Return the cells below the rule under the head."""
    body = table.partition("\\midrule\n")[2].partition("\\bottomrule")[0]
    return [re.split(r"(?<!\\) & ", line.removesuffix(r" \\")) for line in body.splitlines() if " & " in line]


def number(cell: str) -> float:
    return float(cell.removeprefix(r"\bfseries "))


def test_a_cell_is_the_mean_of_its_methods_runs_of_that_size_and_fleet(store, paper):
    runs = load(store)
    table = (paper / "tables" / "gap.tex").read_text()
    assert re.search(r"^Method & \{8\} & \{12\} \\\\$", table, re.M)
    of_two = table.partition("$m = 2$")[2].partition("$m = 3$")[0]
    rows = [line.removesuffix(r" \\").split(" & ") for line in of_two.splitlines() if "&" in line]
    cells = {name: cells for name, *cells in rows}
    wanted = summary(runs[runs["n_depots"] == 2])["gap_found"]
    assert cells["ga"][1] == "{--}"  # no instance of twelve tasks has two UAVs
    assert {name: number(cell[0]) for name, cell in cells.items() if name in wanted} == {
        name: pytest.approx(100 * gap, abs=0.005) for name, gap in wanted.items() if name in cells
    }


def test_columns_are_as_wide_as_their_numbers(paper):
    for name in ("gap", "time", "proved"):
        table = (paper / "tables" / f"{name}.tex").read_text()
        formats = re.findall(r"S\[table-format=(\d+)\.(\d+)\]", table)
        assert len(formats) == 2
        for column, (whole, digits) in enumerate(formats, 1):
            cells = [row[column].removeprefix(r"\bfseries ") for row in rows_of(table)]
            parts = [cell.partition(".") for cell in cells if not cell.startswith("{")]
            assert (max(len(p[0]) for p in parts), max(len(p[2]) for p in parts)) == (int(whole), int(digits))


def test_the_best_that_is_printed_is_bold_and_equals_are_all_bold(store, paper):
    table = (paper / "tables" / "gap.tex").read_text()
    part = [row[1] for row in rows_of(table.partition("$m = 3$")[0])]
    bold = {number(cell) for cell in part if cell.startswith(r"\bfseries")}
    assert bold == {min(map(number, part))}
    assert all(cell.startswith(r"\bfseries") for cell in part if number(cell) in bold)


def test_a_method_that_ran_on_fewer_instances_is_never_the_best(store):
    runs = load(store)
    size = runs["n_tasks"] == 8
    first = runs.loc[size, "digest"].iloc[0]
    best = runs.loc[runs.groupby("digest")["value"].idxmin(), ["digest", "value"]].set_index("digest")["value"]
    lucky = (runs["method"] == "greedy") & size
    runs = runs[~lucky | (runs["digest"] == first)].copy()
    runs.loc[runs["method"] == "greedy", "value"] = runs["digest"].map(best)
    table, _ = size_tables(runs[size.reindex(runs.index)])["gap"]
    cells = {row[0]: row[1] for row in rows_of(table)}
    assert cells["greedy"] == "0.00"
    assert r"\bfseries" in table or len(set(cells.values())) == 1


def test_what_all_share_gets_no_table(store):
    runs = load(store)
    assert set(size_tables(runs)) == {"gap", "time", "proved"}
    assert "proved" not in size_tables(runs[~runs["proved"]])
    runs.loc[runs.index[0], "value"] = None
    assert "solved" in size_tables(runs)


def test_main_is_whole_and_names_only_what_is_there(paper):
    text = (paper / "main.tex").read_text()
    assert text.count("{") - text.count(r"\{") == text.count("}") - text.count(r"\}")
    assert re.findall(r"\\begin\{(\w+)\}", text).count("table") == text.count(r"\end{table}") == 3
    for name in re.findall(r"\\input\{([^}]*)\}", text):
        assert (paper / f"{name}.tex").is_file()
    cited = {key for keys in re.findall(r"\\cite\{([^}]*)\}", text) for key in keys.split(",")}
    assert cited == set(re.findall(r"^@\w+\{([^,]*),", (paper / "references.bib").read_text(), re.M))
    assert {"ombuki2009using", "cho2018informative", "potvin1993parallel"} <= cited
    assert r"mine\_50\%:A\&B" in text
    assert r"LKH\textdagger{}" in text
    assert r"\textdagger{} 8 runs of LKH\textdagger{} were made elsewhere" in text
    assert all(path.read_text().isascii() for path in paper.rglob("*.tex"))


def test_figures_are_pdf(store, monkeypatch):
    drawn = SimpleNamespace(key="a b/c", title="50 %", caption="Lower is better.", figure=Figure())
    monkeypatch.setattr(document, "study_figures", lambda runs: [drawn])
    files = paper_files("A study", load(store), [], [Cited("ga", "genetic", ("ombuki2009using",))])
    (name,) = [name for name in files if name.startswith("figures/")]
    assert name == "figures/a-b-c.pdf"
    assert files[name].startswith(b"%PDF")
    assert rb"\textbf{50 \%.} Lower is better." in files["main.tex"]
    assert rf"\includegraphics[width=\linewidth]{{{name.removesuffix('.pdf')}}}".encode() in files["main.tex"]


@pytest.mark.parametrize("registry", [SOLVERS, PLACEMENT, COSTS, SELECTION], ids=lambda registry: registry.kind)
def test_every_method_says_what_to_cite_for_it(registry):
    assert set(registry.sources) == set(registry.built_in)
    assert all(keys and set(keys) <= set(references()) for keys in registry.sources.values())


def test_every_entry_is_cited_and_names_author_and_title():
    sources = [registry.sources for registry in (SOLVERS, PLACEMENT, COSTS, SELECTION)]
    assert set(references()) == {key for of in sources for keys in of.values() for key in keys}
    for key, entry in references().items():
        assert entry.count("{") == entry.count("}"), key
        assert re.search(r"^  author\s+= \{", entry, re.M), key
        assert re.search(r"^  title\s+= \{", entry, re.M), key
        assert key in {"workbench", "ortools"} or re.search(r"^  year\s+= \{\d{4}\}", entry, re.M), key


@pytest.mark.parametrize(
    ("text", "set_as"),
    [
        (r"50 % of a_b & \c", r"50 \% of a\_b \& \textbackslash{}c"),
        ("Held–Karp, C ≤ 3 …", r"Held--Karp, C $\leq$ 3 \dots{}"),
        ("Rohe, André", "Rohe, André"),
        ("巡回 \u202e\x07", r"\texttt{U+5DE1}\texttt{U+56DE} \texttt{U+202E} "),
    ],
)
def test_text_is_set_as_it_reads(text, set_as):
    assert tex(text) == set_as


def test_bad_input_is_a_sentence_and_writes_nothing(tmp_path, store, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty").mkdir()
    (tmp_path / "file").write_text("")
    for words, sentence in (
        (["nowhere", "--out", "p"], "nowhere: is not a folder of stored runs"),
        (["empty", "--out", "p"], "empty: holds no run that can be read"),
        ([str(store), "--out", "file"], "file: is no folder"),
    ):
        with pytest.raises(SystemExit) as ended:
            main(["paper", *words])
        assert ended.value.code == 2
        assert capsys.readouterr().err.strip() == f"workbench: {sentence}"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["empty", "file"]


def test_latex_takes_it(paper, tmp_path):
    if shutil.which("pdflatex") is None:
        pytest.skip("pdflatex is not installed")
    folder = shutil.copytree(paper, tmp_path / "paper")
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "main.tex"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-3000:]
