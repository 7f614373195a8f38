"""Exports: stable columns, the same file for the same runs."""

import csv
import io
import json

import pandas as pd
import pytest

import reports.tables
from instances import InputError
from reports import load, numbers
from reports.csv_text import write_csv
from reports.metrics import summary
from reports.tables import RUN_COLUMNS, run_table, write_latex, write_markdown, write_parquet


@pytest.fixture
def root(make_store):
    return make_store().study(count=1, seeds=2)


def test_csv_is_the_same_for_the_same_runs_but_for_times(root, tmp_path):
    write_csv(run_table(load(root)), tmp_path / "a.csv")
    for path in root.glob("*/*-s*-t*.json"):
        record = json.loads(path.read_text())
        again = {"wall_elapsed": 1.2, "cpu_seconds": 9.9, "peak_memory": 1, "created": "2030-01-01T00:00:00Z"}
        path.write_text(json.dumps(record | again))
    write_csv(run_table(load(root)), tmp_path / "b.csv")
    rows = [list(csv.reader(io.StringIO((tmp_path / name).read_text()))) for name in ("a.csv", "b.csv")]
    assert rows[0][0] == RUN_COLUMNS
    steady = RUN_COLUMNS.index("elapsed")
    assert [row[:steady] for row in rows[0]] == [row[:steady] for row in rows[1]]
    assert rows[0] != rows[1]


def test_csv_reads_back(root, tmp_path):
    runs = load(root)
    write_csv(run_table(runs), tmp_path / "a.csv")
    back = pd.read_csv(tmp_path / "a.csv")
    assert len(back) == len(runs)
    pd.testing.assert_series_equal(back["value"], runs["value"], rtol=0, atol=0)


def test_parquet_reads_back(root, tmp_path):
    pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    write_parquet(load(root), tmp_path / "a.parquet")
    assert list(pd.read_parquet(tmp_path / "a.parquet").columns) == RUN_COLUMNS


def test_parquet_without_pyarrow_says_so(root, tmp_path, monkeypatch):
    monkeypatch.setattr(reports.tables.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(InputError, match="needs pyarrow"):
        write_parquet(load(root), tmp_path / "a.parquet")
    assert not (tmp_path / "a.parquet").exists()


def test_markdown_has_a_row_a_method_and_a_row_an_instance(root, tmp_path):
    runs = load(root)
    write_markdown(runs, tmp_path / "a.md")
    lines = (tmp_path / "a.md").read_text().splitlines()
    tables = [line for line in lines if line.startswith("|")]
    assert len(tables) == 4 + runs["method"].nunique() + runs["digest"].nunique()
    assert len({line.count("|") for line in tables[: 2 + runs["method"].nunique()]}) == 1


def test_latex_escapes_and_balances(root, tmp_path):
    write_latex(load(root), tmp_path / "a.tex")
    text = (tmp_path / "a.tex").read_text()
    assert text.count(r"\begin{longtable}") == text.count(r"\end{longtable}") == 2
    body = text[text.index("\n") :]
    assert "–" not in body
    assert "%" not in body.replace(r"\%", "")


def test_an_unwritable_target_is_one_sentence(root, tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        write_csv(run_table(load(root)), tmp_path / "nowhere" / "a.csv")


def test_summary_is_the_same_whatever_the_order_of_runs(root):
    runs = load(root)
    shuffled = runs.sample(frac=1, random_state=0).reset_index(drop=True)
    pd.testing.assert_frame_equal(summary(runs), summary(shuffled))


@pytest.mark.parametrize(
    ("write", "value", "text"),
    [
        (numbers.gap, 0.0, "0 %"),
        (numbers.gap, 1e-9, "0 %"),
        (numbers.gap, 3e-5, "< 0.01 %"),
        (numbers.gap, 0.01234, "1.23 %"),
        (numbers.gap, 0.1234, "12.3 %"),
        (numbers.gap, -0.02, "−2.00 %"),
        (numbers.gap, float("nan"), "–"),
        (numbers.gap, float("inf"), "∞"),
        (numbers.share, 1.0, "100 %"),
        (numbers.share, 0.999, "> 99 %"),
        (numbers.share, 0.001, "< 1 %"),
        (numbers.seconds, 0.0123, "0.012"),
        (numbers.seconds, 0.0001, "< 0.001"),
        (numbers.seconds, 1234.5, "1,234"),
        (numbers.memory, 2.5e9, "2.50 GB"),
        (numbers.p_value, 1e-9, "< 0.001"),
    ],
)
def test_numbers_as_words(write, value, text):
    assert write(value).replace("\u00a0", " ") == text
