"""Tables and sentences at the width there is: nothing is cut, what is left out is said."""

import json

import pytest

from instances.errors import InputError
from workbench.terminal import TextTable, print_json, print_table, say

KEYS = ["method", "solved", "gap", "time", "certified_by"]
TABLE = TextTable(
    KEYS,
    ["Method", "Solved [%]", "Gap to best found [%]", "Time to proof [s]", "Certified by"],
    [
        ["memetic (removals=3, 2 more) @ 100 s", "100", "< 0.01", "1,234", "own bound"],
        ["ga", "> 99", "12.3", "–", "branch-and-price, [b]exact[/b]"],
    ],
    first=("time",),
    left=("certified_by",),
)


@pytest.fixture
def printed(capsys, monkeypatch):
    def call(columns, *names, table=TABLE):
        if columns:
            monkeypatch.setenv("COLUMNS", str(columns))
        print_table(table, names)
        return capsys.readouterr().out.splitlines()

    return call


def texts_of(lines):
    return " ".join(" ".join(line.split()) for line in lines)


def test_in_a_pipe_all_is_there_on_one_line_each(printed):
    lines = printed(None)
    assert lines[1].split("   ")[0] == "Method"
    assert "Gap to best found [%]" in lines[1]
    assert len([line for line in lines if line]) == 4  # heads, a rule, two rows
    assert "branch-and-price, [b]exact[/b]" in lines[-1]


@pytest.mark.parametrize("columns", [40, 60, 80, 100, 120])
def test_no_line_is_wider_and_no_value_is_cut(printed, columns):
    lines = printed(columns)
    assert max(map(len, lines)) <= columns
    assert "…" not in texts_of(lines)
    told = texts_of(lines).partition("left out at")[2]
    for key, cell in zip(KEYS[1:], TABLE.rows[1][1:], strict=True):
        assert (key in told) != (cell.split()[-1] in texts_of(lines))


def test_what_comes_first_is_left_out_last(printed):
    lines = printed(60)
    assert "1,234" in texts_of(lines)
    assert "certified_by; --columns NAME,... or --columns all" in texts_of(lines)


def test_columns_that_are_asked_for_stand_below_each_other_rather_than_not_at_all(printed):
    lines = printed(40, "all")
    assert max(map(len, lines)) <= 40
    assert all(cell in texts_of(lines) for row in TABLE.rows for cell in row[1:4])
    assert "branch-and-price," in texts_of(lines)
    assert "[b]exact[/b]" in texts_of(lines)
    assert sum(line.startswith("ga") for line in lines) == 3


def test_only_what_is_asked_for_in_that_order(printed):
    lines = printed(200, "time", "gap")
    assert [line.split()[-2:] for line in lines[-2:]] == [["<", "0.01"], ["–", "12.3"]]
    with pytest.raises(InputError, match=r"no column 'tme'; did you mean 'time'\?"):
        printed(200, "tme")


def test_wide_signs_count_as_wide(printed):
    table = TextTable(["a", "b"], ["A", "B"], [["風" * 12, "1"], ["x", "2"]])
    lines = printed(60, table=table)
    assert [line.split() for line in lines[-2:]] == [["風" * 12, "1"], ["x", "2"]]


def test_a_sentence_is_wrapped_between_words(capsys, monkeypatch):
    sentence = "a sentence of words, and a/path/that/is/longer/than/the/terminal/is.json"
    say(sentence)
    monkeypatch.setenv("COLUMNS", "30")
    say(sentence)
    whole, *parts = capsys.readouterr().out.splitlines()
    assert whole == sentence
    assert [part.strip() for part in parts] == sentence.replace("and ", "and\n").splitlines()


def test_json_is_strict(capsys):
    print_json({"nan": float("nan"), "path": pytest, "list": (1, float("inf"))})
    assert json.loads(capsys.readouterr().out)["list"] == [1, None]
