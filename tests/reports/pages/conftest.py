"""The four pages, made small, and the browser that opens them."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from instances.families import make_scenario
from instances.paths import Paths
from reports.pages.moving_cost import Case, write_moving_cost_page
from reports.pages.study import write_report

PAGES = ("study", "placement", "moving-cost", "mission")
PLACEMENT = """problem = "placement"
seeds = 2
time_limit = 5
tasks = [3, 4]
tests = "4x4"
[[methods]]
name = "greedy"
[[methods]]
name = "greedy-swap"
"""
MISSION = """airspeed = 50.0
size = [6000, 5000]
no_fly = "zones.geojson"
depots = [[500, 500], [5500, 500]]
tasks = 5
origin = [47.0, 8.0]
wind = { kind = "rotation", rate = 1e-3, centre = [3000, 2500] }
radio = { position = [3000, 2500] }
field = { model = "free-space", cells = 15 }
place = { method = "greedy", tests = [4, 4], certificate = false }
costs = { method = "dijkstra" }
routes = { solver = "greedy", time_limit = 20.0 }
map = { refit_every = 0, cells = 10, frames = 4 }
compare = { time_limit = 20.0, seeds = 2 }
"""
ZONES = {"type": "Polygon", "coordinates": [[[2600, 1500], [3400, 1600], [3000, 2200], [2600, 1500]]]}


def beside(name):
    """Return the module `name` of this folder."""
    spec = importlib.util.spec_from_file_location(name, Path(__file__).with_name(f"{name}.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    """Chromium; the same for all tests of a process."""
    driven = beside("browser")
    program = driven.chromium()
    if program is None:
        pytest.skip("Chromium is not installed")
    session = driven.Browser(program, tmp_path_factory.mktemp("profile"))
    yield session
    session.close()


@pytest.fixture(scope="session")
def pdf_text():
    """What reads a PDF."""
    return beside("pdf_text")


@pytest.fixture(scope="session")
def study(store_maker, tmp_path_factory):
    """A page with everything on it: a lie, a broken file, rubbish in a log, a comparison with a baseline."""
    folder = tmp_path_factory.mktemp("stores")
    old = store_maker(folder / "old").study(count=2, seeds=3)
    root = store_maker(folder / "new").study(count=4, seeds=3, sizes=((8, 2), (12, 3), (40, 4)))
    path = sorted(root.glob("*/ga-*.json"))[0]
    rubbish = {"objective": 1.0, "log": "</script><b>rubbish</b> \u2028 & <!-- ", "message": "<i>x</i>"}
    path.write_text(json.dumps(json.loads(path.read_text()) | rubbish))
    (path.parent / "broken.json").write_text("{")
    write_report([root], folder / "report.html", against=[old])
    return folder / "report.html"


def command(folder, *words):
    """Run the workbench in `folder`."""
    program = "import sys; from workbench.cli import main; main(sys.argv[1:])"
    said = subprocess.run([sys.executable, "-c", program, *words], cwd=folder, capture_output=True, text=True)
    assert said.returncode == 0, said.stderr[-2000:]


@pytest.fixture(scope="session")
def placement(tmp_path_factory):
    folder = tmp_path_factory.mktemp("placement")
    (folder / "study.toml").write_text(PLACEMENT)
    command(folder, "compare", "study.toml", "--out", "runs", "--jobs", "1")
    return folder / "runs" / "report.html"


@pytest.fixture(scope="session")
def mission(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mission")
    (folder / "zones.geojson").write_text(json.dumps(ZONES))
    (folder / "mission.toml").write_text(MISSION)
    command(folder, "mission", "mission.toml", "--out", "out")
    return folder / "out" / "report.html"


@pytest.fixture(scope="session")
def moving_cost(tmp_path_factory):
    scenario = make_scenario("wind-vortices", 4, 2, 1)
    p = scenario.points
    paths = Paths.of(6, [np.empty((0, 2)) if i == j else p[[i, j]] for i in range(6) for j in range(6)])
    rows = [("refined", "default", 0.5, 0.0, 0.0, 1e-6), ("fmt-star", "2 000", 0.1, 6e-2, 0.12, 1.5)]
    methods = pd.DataFrame(rows, columns=["method", "options", "cpu", "mean", "p95", "largest"])
    claim = pd.DataFrame({"starts": [5, 10], "one query a pair": [1.0, 4.0], "one tree a start": [0.2, 0.4]})
    run = {"method": "refined", "time_limit": 60.0, "threads": 1, "created": "", "environment": "e1"}
    runs = pd.DataFrame([run | {"code": "0" * 12, "revision": "abc"}])
    path = tmp_path_factory.mktemp("costs") / "report.html"
    write_moving_cost_page([Case(scenario, paths, methods, claim, "Much wind.")], runs, [], path, "Moving costs")
    return path


@pytest.fixture(scope="session", params=PAGES)
def any_page(request):
    """Each of the four pages in turn."""
    return request.getfixturevalue(request.param.replace("-", "_"))
