"""`workbench select`, and `workbench check` of what it wrote."""

import json
from typing import NamedTuple

import numpy as np
import pytest

from instances import Instance
from instances.files import write_instance

FILE = "n 5\nm 2\ntmax 12\n0\t0\t0\n3\t4\t10\n3\t0\t5\n90\t0\t50\n0\t8\t0\n"


class Answer(NamedTuple):
    exit_code: int
    stdout: str
    stderr: str


@pytest.fixture
def run(tmp_path, cli):
    (tmp_path / "top.txt").write_text(FILE)
    points = np.random.default_rng(6200).uniform(0, 20_000, (8, 2))
    cost = np.hypot(*(points[:, None] - points).transpose(2, 0, 1)) / 20
    write_instance(Instance("six", cost, 6, 2, points), tmp_path / "six.json")
    write_instance(Instance("bare", cost, 6, 2), tmp_path / "bare.json")
    (tmp_path / "prizes.csv").write_text("task,prize\n0,3\n4,7.5\n")
    return lambda words: Answer(*cli(*words.split()))


def test_a_team_orienteering_file_needs_nothing_else(run):
    answer = run("select top.txt --json")
    found = json.loads(answer.stdout)
    assert (found["tasks"], found["worth"], found["bound"], found["status"]) == ([0, 1], 15, 15, "OPTIMAL")
    assert found["left_out"] == [2]


def test_information_is_written_and_checked(run, tmp_path):
    answer = run("select six.json --endurance 1200 --information --out chosen.json")
    assert answer.exit_code == 0
    assert "OPTIMAL: 3 of 6 tasks, 9.52862 of 19.0217 (nats)" in answer.stdout
    assert run("check six.json chosen.json").exit_code == 0
    document = json.loads((tmp_path / "chosen.json").read_text())
    assert document["worth"] == pytest.approx(9.528619, abs=1e-6)


def test_prizes_and_an_endurance_for_each(run):
    found = json.loads(run("select bare.json --endurance 1980,2000 --prizes prizes.csv --json").stdout)
    assert found["tasks"] == [0, 4]
    assert found["endurance"] == [1980, 2000]
    assert (np.array(found["tour_costs"]) <= found["endurance"]).all()


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"worth": 12.0}, "claimed a worth of 12.0, but its tasks are worth 9.52861"),
        ({"endurance": [1200, 500]}, "more than its endurance of 500 s"),
        ({"tasks": [1, 4]}, "tasks are not those that the routes visit"),
        ({"routes": [[1, 1], [4, 5]]}, "Task 1 is visited 2 times"),
        ({"routes": [[9], []]}, "visits 9, which is not a task"),
        ({"bound": 9.0}, "the bound 9.0 is below the worth"),
        ({"bound": 19.0}, "claimed OPTIMAL, but the bound 19.0 is above the worth"),
        ({"tour_costs": [1.0, 2.0]}, "claimed tours of [1.0, 2.0] s"),
        ({"digest": "0" * 12}, "is of another instance"),
    ],
)
def test_a_wrong_selection_is_found_out(run, tmp_path, change, sentence):
    run("select six.json --endurance 1200 --information --out chosen.json")
    document = json.loads((tmp_path / "chosen.json").read_text())
    (tmp_path / "wrong.json").write_text(json.dumps(document | change))
    answer = run("check six.json wrong.json")
    assert answer.exit_code == 1
    assert sentence in answer.stdout


def test_prizes_of_another_are_found_out(run, tmp_path):
    run("select top.txt --out chosen.json")
    document = json.loads((tmp_path / "chosen.json").read_text())
    document["about"]["prizes"][0], document["worth"], document["bound"] = 1000.0, 1005.0, 1005.0
    (tmp_path / "wrong.json").write_text(json.dumps(document))
    assert "its prizes are not those of the instance" in run("check top.txt wrong.json").stdout
    document["endurance"] = [99, 99]
    (tmp_path / "wrong.json").write_text(json.dumps(document))
    assert "is 99 s, more than the 12 s of the instance" in run("check top.txt wrong.json").stdout


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("select six.json", "has no prizes; give --prizes FILE.csv, or --information"),
        ("select bare.json --information", "has no coordinates"),
        ("select six.json --prizes prizes.csv --information", "answer different questions"),
        ("select top.txt --noise-sd 2", "--noise-sd: only says something with --information"),
        ("select six.json --endurance 1,2,3 --information", "--endurance: must be one positive number or 2 of them"),
        ("select six.json --endurance -1 --information", "--endurance: must be one positive number or 2 of them"),
        ("select six.json --endurance 9 --prizes top.txt", "must have columns 'task' and 'prize'"),
        ("select top.txt --method magic", "unknown selection method 'magic'"),
        ("select six.json --information --criterion literal", "ill-posed"),
        ("select top.txt --out chosen.txt", "chosen.txt"),
        ("check six.json prizes.json", "prizes.json"),
        ("check six.json six.json", "is no selection"),
    ],
)
def test_what_cannot_be_used_is_named(run, words, sentence):
    answer = run(words)
    assert answer.exit_code == 2
    assert sentence in answer.stderr


@pytest.mark.parametrize(
    ("rows", "sentence"),
    [
        ("9,1\n", "line 2: task must be a number from 0 to 5, got '9'"),
        ("1,x\n", "line 2: prize must be a number of at least 0, got 'x'"),
        ("1,-1\n", "line 2: prize must be a number of at least 0, got '-1'"),
        ("1,1\n1,2\n", "line 3: task 1 is given twice"),
    ],
)
def test_prizes_that_cannot_be_used(run, tmp_path, rows, sentence):
    (tmp_path / "wrong.csv").write_text(f"task,prize\n{rows}")
    answer = run("select six.json --endurance 900 --prizes wrong.csv")
    assert answer.exit_code == 2
    assert sentence in answer.stderr
