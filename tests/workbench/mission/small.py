"""A small mission in wind, with a zone: the file, and how tests run it again."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from workbench.mission.file import mission_of
from workbench.mission.pipeline import NAMES, run_mission

SMALL = """
airspeed = 50.0
size = [6000, 5000]
no_fly = "zones.geojson"
depots = [[500, 500], [5500, 500]]
tasks = 8
origin = [47.0, 8.0]

[wind]
kind = "rotation"
rate = 1e-3
centre = [3000, 2500]

[radio]
position = [3000, 2500]

[field]
model = "free-space"
shadowing_sd = 2.0
cells = 30

[place]
method = "greedy"
tests = [6, 6]
length_scale = 1500.0

[costs]
method = "dijkstra"

[routes]
solver = "greedy"
time_limit = 1.0
bound_time_limit = 0.0

[sensing]
period = 6.0

[map]
length_scale = 1500.0
refit_every = 50
cells = 20
frames = 4

[compare]
seeds = 2
time_limit = 0.5
"""
ZONE = {"type": "Polygon", "coordinates": [[[2600, 1800], [3400, 1800], [3400, 3000], [2600, 3000], [2600, 1800]]]}


def again(mission_file: Path, out: Path, text: str = SMALL, **how: str) -> list[str]:
    """Run a mission and return the stages that were made, not skipped."""
    told: list[str] = []
    mission = mission_of(tomllib.loads(text), mission_file.parent, "small")
    run_mission(mission, out, tell=told.append, **how)
    return [name for name in NAMES if any(re.match(rf"{name}: .* \(\d+\.\d s\)$", line) for line in told)]
