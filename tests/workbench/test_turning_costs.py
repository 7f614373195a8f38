"""`workbench costs` of a scenario whose UAVs have turning radii: an instance between headings that solvers take."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from instances.files import read_instance
from instances.scenario import read_scenario, write_scenario

SCENARIO = """
cost = "time"
airspeed = 20.0
size = [900, 800]
depots = [[100, 100], [800, 100]]
tasks = [[200, 500], [450, 600], [700, 400], [450, 250]]
service = 10.0
[wind]
kind = "uniform"
velocity = [4.0, -3.0]
[[uav]]
depot = 0
turning_radius = 50.0
[[uav]]
depot = 1
turning_radius = 80.0
speed = 25.0
"""


def test_a_scenario_with_turning_radii_becomes_an_instance_between_headings(cli, tmp_path: Path) -> None:
    path = tmp_path / "survey.toml"
    path.write_text(SCENARIO)
    code, out, err = cli("costs", path, "--out", "a.json", "--option", "uniform=8", "--json")
    assert code == 0, err
    told = json.loads(out)
    assert told["states"] == 6 * 8
    assert told["spacing"] == pytest.approx((900 * 800 / 4) ** 0.5 / 80)
    made = read_instance(tmp_path / "a.json")
    assert made.axes == {"states", "fleet"}
    assert made.travel is not None
    assert len(made.travel.cost) == 2
    assert np.isinf(made.travel.cost).any()  # legs that would leave the region
    code, out, err = cli("solve", "a.json", "--solver", "subset-dp", "--json")
    assert code == 0, err
    assert json.loads(out)["status"] == "OPTIMAL"
    read = read_scenario(path)
    write_scenario(read, tmp_path / "again.toml")
    again = read_scenario(tmp_path / "again.toml").fleet
    assert again.turning_radii is not None
    assert again.turning_radii.tolist() == [50.0, 80.0]


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("turning_radius = 50.0\n", "", "[[uav]] turning_radius: give it for all UAVs or for none"),
        ("turning_radius = 50.0", "turning_radius = -1", "[[uav]] 1 turning_radius must be a positive number [m]"),
        ('kind = "uniform"\nvelocity = [4.0, -3.0]', 'kind = "rotation"\nrate = 1e-3', "a uniform wind (kind"),
        ("velocity = [4.0, -3.0]", "velocity = [19.0, -13.0]", "not less than the airspeed of 20 m/s"),
        ("service = 10.0", 'return = "any"', "lead home to the own depot"),
        ("size = [900, 800]", "size = [900, 800]", "--option uniform: must be a whole number"),
    ],
)
def test_what_cannot_be_flown_is_one_sentence(cli, tmp_path: Path, before: str, after: str, words: str) -> None:
    path = tmp_path / "survey.toml"
    path.write_text(SCENARIO.replace(before, after))
    option = ("--option", "uniform=-8") if before == after else ("--option", "uniform=4")
    code, _, err = cli("costs", path, "--out", "a.json", *option)
    assert code == 2
    assert words in err
    assert not (tmp_path / "a.json").exists()
