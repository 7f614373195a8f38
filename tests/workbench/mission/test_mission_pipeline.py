"""How a mission's stages are run: skipped where up to date, alone, from one on, continued after a kill."""

from __future__ import annotations

import json
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest

from instances.errors import InputError
from tests.workbench.mission.small import SMALL, ZONE, again
from workbench.mission import environment
from workbench.mission.file import read_mission
from workbench.mission.pipeline import FOLDERS, NAMES, STAGES


def test_nothing_is_made_twice(mission_file: Path, copied: Path) -> None:
    assert again(mission_file, copied) == []


@pytest.mark.usefixtures("plain_page")
def test_a_change_is_made_from_its_stage_on(mission_file: Path, copied: Path) -> None:
    before = (copied / "6-map/samples.csv").read_bytes()
    changed = SMALL.replace("[compare]", '[compare]\nbaselines = ["lawnmower"]')
    assert again(mission_file, copied, changed) == ["compare", "report"]
    assert (copied / "6-map/samples.csv").read_bytes() == before
    assert list(pd.read_csv(copied / "7-compare/compare.csv")["name"]) == ["mission", "lawnmower"]


def test_a_changed_file_that_the_mission_names_is_noticed(mission_file: Path, copied: Path, tmp_path: Path) -> None:
    moved = tmp_path / "small.toml"
    moved.write_text(SMALL)
    zone = json.dumps(ZONE).replace("2600", "2500")
    (tmp_path / "zones.geojson").write_text(zone)
    assert again(moved, copied, only="environment") == ["environment"]


def test_a_file_that_the_scenario_file_names_is_noticed(tmp_path: Path) -> None:
    (tmp_path / "zones.geojson").write_text(json.dumps(ZONE))
    scenario, own = tmp_path / "scenario.toml", tmp_path / "mission.toml"
    keys, rest = SMALL.split("origin = [47.0, 8.0]")
    wind, _, others = rest.partition("[radio]")
    radio, _, others = others.partition("[field]")
    scenario.write_text(f"{keys}{wind}[radio]{radio}")
    own.write_text(f'scenario = "scenario.toml"\n[field]{others}')
    before = environment.settings(read_mission(own))
    assert environment.settings(read_mission(own)) == before
    (tmp_path / "zones.geojson").write_text(json.dumps(ZONE).replace("2600", "2500"))
    assert environment.settings(read_mission(own)) != before


def test_one_stage_alone(mission_file: Path, copied: Path) -> None:
    shutil.rmtree(copied / "7-compare")
    shutil.rmtree(copied / "6-map")
    assert again(mission_file, copied, only="map") == ["map"]
    assert not (copied / "7-compare").exists()


@pytest.mark.usefixtures("plain_page")
def test_a_stage_can_be_forced(mission_file: Path, copied: Path) -> None:
    assert again(mission_file, copied, force_from="report") == ["report"]


def test_a_stage_without_what_it_starts_from(mission_file: Path, copied: Path) -> None:
    shutil.rmtree(copied / "4-routes")
    with pytest.raises(InputError, match="stage 'flight' starts from the products of 'routes', which are not there"):
        again(mission_file, copied, only="flight")


def test_a_product_that_was_changed_is_noticed(mission_file: Path, copied: Path) -> None:
    (copied / "2-place/tasks.csv").write_text("x,y\n1,1\n")
    with pytest.raises(InputError, match="products of stage 'place' are missing or were changed"):
        again(mission_file, copied, only="costs")


def test_a_failing_stage_leaves_the_old_products(mission_file: Path, copied: Path) -> None:
    before = (copied / "5-flight/flown.csv").read_bytes()
    with pytest.raises(InputError, match=r"sensing\.period = 1000 s is longer than the longest tour"):
        again(mission_file, copied, SMALL.replace("period = 6.0", "period = 1000.0"))
    assert (copied / "5-flight/flown.csv").read_bytes() == before
    assert not list(copied.glob(".*.part"))


@pytest.mark.parametrize(
    ("table", "words"),
    [
        (
            "border_clearance = 600.0",
            r"^UAV 0 would come within 3\d\d\.\d m of the region's border or a no-fly zone at .*",
        ),
        ("altitude = 20.0", r"^UAV 0 would come within 20\.0 m of the ground at .* \(flight\.clearance = 50 m\)"),
    ],
)
def test_a_flight_that_is_refused_leaves_no_plan(mission_file: Path, copied: Path, table: str, words: str) -> None:
    shutil.rmtree(copied / "5-flight")
    with pytest.raises(InputError, match=words):
        again(mission_file, copied, SMALL.replace("[sensing]", f"[flight]\n{table}\n\n[sensing]"), only="flight")
    assert not (copied / "5-flight").exists()
    assert not list(copied.rglob("*.plan"))


@pytest.mark.usefixtures("plain_page")
@pytest.mark.slow
def test_a_killed_mission_continues_where_it_was(mission_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    short = SMALL.replace("[compare]", '[compare]\nbaselines = ["lawnmower"]')
    slow = short.replace('solver = "greedy"\ntime_limit = 1.0', 'solver = "ruin-recreate"\ntime_limit = 60.0')
    (tmp_path / "zones.geojson").write_text(json.dumps(ZONE))
    (tmp_path / "slow.toml").write_text(slow)
    command = [sys.executable, "-c", "from workbench.cli import main; main()", "mission", "slow.toml", "--out", "out"]
    child = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    deadline = time.monotonic() + 120
    while not (out / "3-costs").exists() and time.monotonic() < deadline and child.poll() is None:
        time.sleep(0.05)
    child.send_signal(signal.SIGKILL)
    child.wait()
    assert (out / "3-costs").exists()
    assert not (out / "4-routes").exists()
    made_now = again(mission_file, out, short)
    assert made_now == [name for name in NAMES if name not in ("environment", "place", "costs")]
    assert not list(out.glob(".*.part"))


def test_folders_are_numbered_in_order() -> None:
    assert list(FOLDERS) == [stage.name for stage in STAGES]
    assert FOLDERS["flight"] == "5-flight"


def test_an_unknown_stage(cli) -> None:
    code, _, err = cli("mission", "--out", "made", "--stage", "flihgt")
    assert code == 2
    assert "unknown stage 'flihgt'; did you mean 'flight'?" in err


def test_stage_and_from_exclude_each_other(cli) -> None:
    code, _, err = cli("mission", "--out", "made", "--stage", "map", "--from", "map")
    assert code == 2
    assert "give one of them" in err


@pytest.mark.usefixtures("plain_page")
def test_a_mission_that_another_process_works_on_is_left_alone(mission_file: Path, copied: Path) -> None:
    other = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    try:
        (copied / f".8-report.{other.pid}.part").mkdir()
        with pytest.raises(InputError, match=f"process {other.pid} is working on this mission"):
            again(mission_file, copied, force_from="report")
    finally:
        other.communicate(b"\n")
    assert again(mission_file, copied, force_from="report") == ["report"]


@pytest.mark.usefixtures("plain_page")
@pytest.mark.slow
def test_stages_that_other_code_made_are_made_again(mission_file: Path, copied: Path, monkeypatch) -> None:
    assert again(mission_file, copied) == []
    stamp = json.loads((copied / "4-routes" / "stamp.json").read_text())
    assert len(stamp["code"]) == 12
    (copied / "4-routes" / "stamp.json").write_text(json.dumps(stamp | {"code": "0" * 12}))
    assert again(mission_file, copied)[0] == "routes"
    assert again(mission_file, copied) == []
