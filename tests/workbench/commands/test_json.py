"""`--json` of every command is one JSON object with the keys that docs/json.md states."""

import json
import re
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from instances.files import write_routes
from reports.figures.svg import Drawn
from tests.workbench.mission.small import SMALL
from workbench.cli import COMMANDS

PAGE = (Path(__file__).parents[3] / "docs/json.md").read_text(encoding="utf-8")
STATED = dict(re.findall(r"^\| `([^`]+)` \| (.*) \|$", PAGE, re.MULTILINE))
TYPED = {
    "generate": "generate uniform --tasks 3 --uavs 2 --count 2",
    "solve": "solve small.json --solver greedy",
    "check": "check small.json a.sol",
    "compare": "compare small.json --solvers greedy --out runs --no-report",
    "compare --dry-run": "compare small.json --solvers greedy --out runs --dry-run",
    "report": "report runs",
    "convert": "convert small.json b.json",
    "select": "select small.json --endurance 900 --information --method subset-dp",
    "place": "place --tasks 2 --method greedy --tests 4x4",
    "place --study": "place --study n=2..3 --method greedy --tests 4x4",
    "place --polish": "place --polish small.toml",
    "costs": "costs wind.toml --option samples=300 --out wind.json",
    "bound": "bound small.json --routes a.sol",
    "certify": "certify small.json --routes a.sol --time-limit 20",
    "mission": "mission m.toml --out m --stage environment",
    "figures": "figures --out figures",
    "status": "status runs",
    "solvers": "solvers greedy",
    "families": "families ring",
    "methods": "methods grid",
    "studies": "studies",
    "init": "init study",
    "warmup": "warmup greedy",
    "import": "import a.sol --into runs --instance r4-2-0 --solver LKH --elapsed 1 --time-limit 5",
    "record": "record runs --book records --add",
    "schema": "schema study",
    "completion": "completion bash",
}
ELSEWHERE = {"paper", "watch"}
"""What draws for seconds, and what serves until it is stopped: their own tests look at their JSON."""


@pytest.fixture
def ready(cli, instance, instance_file, tmp_path, monkeypatch):
    """Files that the commands read; figures that are empty and searches that are brief, as both take seconds."""
    write_routes([[0, 1], [2, 3]], instance, tmp_path / "a.sol")
    smaller = SMALL.replace('no_fly = "zones.geojson"', "").replace("tasks = 8", "tasks = 3")
    (tmp_path / "small.toml").write_text(smaller)
    for kind, name in (("scenario", "wind.toml"), ("mission", "m.toml")):
        cli("init", kind, name)
    for name in ("random_paths", "sensing"):
        monkeypatch.setattr(f"workbench.commands.figures.{name}", lambda seed: Drawn("a", "A", "b", Figure()))
    monkeypatch.setattr("workbench.commands.place_polish.QUICKLY", 0.5)
    return cli


def test_each_prints_one_object_with_the_keys_that_are_stated(ready):
    for name, words in TYPED.items():
        code, out, _ = ready(*words.split(), "--json")
        assert code == 0, name
        told, stated = json.loads(out), STATED[name]
        if stated.startswith("by name: "):
            keys, told = re.findall(r"`(\w+)`", stated), next(iter(told.values()))
        else:
            keys = re.findall(r"`(\w+)`", re.sub(r":[^;]*", "", stated))
        assert set(keys) <= set(told), name
        assert "and more" in stated or set(told) == set(keys), name


def test_every_command_is_stated():
    assert {name.split()[0] for name in STATED} == {name.split()[0] for name in TYPED} | ELSEWHERE == set(COMMANDS)
