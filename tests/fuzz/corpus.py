"""The corpus: tiny files of every format and tiny results of every kind, made by the workbench's own writers."""

from __future__ import annotations

import contextlib
import io
import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from formulations.limits import Limits
from instances.code import code_digest
from instances.environment.radio import RadioMap
from instances.environment.radio_files import write_field
from instances.environment.region import Region
from instances.environment.wind_grid import Grid
from instances.files import read_instance, write_routes
from reports.record import Run
from workbench.cli import main
from workbench.jobs.job import Job
from workbench.jobs.machine import environment, environment_digest
from workbench.jobs.problem import Problem
from workbench.jobs.store import Store
from workbench.jobs.study import load_tables, study_from
from workbench.mission.pipeline import NAMES
from workbench.problems import PROBLEMS

ZONES = {"type": "Polygon", "coordinates": [[[2600, 1800], [3400, 1800], [3400, 3000], [2600, 3000], [2600, 1800]]]}
TSPLIB = """NAME: tiny
TYPE: TSP
DIMENSION: 4
EDGE_WEIGHT_TYPE: EUC_2D
VEHICLES: 2
NODE_COORD_SECTION
1 0 0
2 3 4
3 0 1.5
4 6 8
DEPOT_SECTION
4
2
-1
EOF
"""
SCENARIO = """airspeed = 20.0
size = [6000, 5000]
no_fly = "zones.geojson"
depots = [[500, 500], [5500, 500]]
tasks = [[1000, 4000], [3000, 4500]]
[wind]
"""
WINDS = {
    "grid": 'kind = "grid"\nfile = "wind.nc"\n',
    "ninja": 'kind = "grid"\nfile = "ninja_vel.asc"\nunits = "mph"\n',
    "sum": 'kind = "sum"\nparts = [{kind = "uniform", velocity = [-4, -4]}, {kind = "vortices", '
    "centres = [[3000, 4000]], circulation = [3e4], core = [800]}, {kind = \"shear\", rate = 1e-3, centre = [0, 0]}]\n",
    **{name: f'kind = "terrain"\ndem = "{dem}"\nvelocity = [3, 2]\nprofile = "log"\nreference = 100.0\n'
       "altitude = 100.0\ncells = 8\n" for name, dem in (("terrain", "dem.asc"), ("geotiff", "dem.tif"))},
}  # fmt: skip
MISSION = """airspeed = 50.0
size = [6000, 5000]
no_fly = "zones.geojson"
depots = [[500, 500], [5500, 500]]
tasks = 3
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
cells = 10
[place]
method = "greedy"
tests = [3, 3]
length_scale = 1500.0
certificate = false
[costs]
method = "dijkstra"
options = {samples = 60}
[routes]
solver = "greedy"
time_limit = 2.0
[sensing]
period = 10.0
[map]
length_scale = 1500.0
refit_every = 0
cells = 6
frames = 2
[compare]
baselines = ["random"]
time_limit = 2.0
"""
OTHERS = """instance,solver,seed,time_limit,elapsed,routes,objective,bound,machine
small.json,LKH-3,0,60,1.5,"[[0, 1], [2, 3]]",,100.5,a laptop
small.json,LKH-3,1,60,1.25,small.sol,,,
small.json,HGS,0,60,2,"Route #1: 0 1
Route #2: 2 3",,,
small.json,Claims,0,60,2,,1234.57,,
"""
SLURM = """jobs = 2
cores = 4
memory = "8GB"
walltime = "04:00:00"
queue = "short"
directives = ["--constraint=avx2"]
prologue = ["module load python"]
"""
MODEL = 'model = "free-space"\nshadowing_sd = 2.0\ncells = 10\n'
"""What a mission measures; in its place may stand a file."""
STUDIES = {  # the first item and the first method of each are stored as well
    "routing": 'files = ["small.json"]\nseeds = 2\ntime_limit = 2\n[[families]]\nfamily = "uniform"\ntasks = [3]\n'
    "depots = 2\nseeds = [1]\nparameters = {wind = [\"none\", \"shear\"]}\n"
    '[[solvers]]\nname = "greedy"\noptions = {variant = ["nearest", "cheapest"]}\nmax_tasks = 9\n',
    "placement": 'problem = "placement"\nregions = ["region.geojson"]\ntasks = [2]\ntests = "tests.csv"\n'
    "signal_sd = 20.0\nlength_scale = \"3000,4000\"\nnoise_sd = 0.5\n"
    'time_limit = 2\n[[methods]]\nname = "greedy"\n',
    "moving-cost": 'problem = "moving-cost"\nscenarios = ["sum.toml"]\nstarts = [4]\ntime_limit = 2\n'
    '[[methods]]\nname = "dijkstra"\noptions = {samples = 60}\n',
    "survey": 'problem = "survey"\nendurance = 80\ncells = 8\ntime_limit = 2\n'
    '[[fields]]\nkind = "gp"\nseeds = [1]\n[[methods]]\nname = "myopic"\noptions = {within = 1.0}\n',
}  # fmt: skip


def make(root: Path, tell: Callable[[str], None]) -> None:
    """Make the corpus below `root`: files of every format, a store of each problem and a mission's products."""
    making = root.with_name(f"{root.name}.part")
    shutil.rmtree(making, ignore_errors=True)
    make_files(making)
    with contextlib.chdir(making):
        tell("mission")
        for stage in NAMES[:-1]:  # its page is made again by every case that wants one
            call("mission", "mission.toml", "--out", "mission", "--stage", stage)
    making.rename(root)


def make_files(root: Path) -> None:
    """Make what needs no process of its own: all but the mission's products."""
    root.mkdir()
    with contextlib.chdir(root):
        _environment()
        _instances()
        for name, wind in WINDS.items():
            Path(f"{name}.toml").write_text(SCENARIO + wind)
        call("costs", "sum.toml", "--method", "dijkstra", "--option", "samples=60", "--out", "planned.json")
        Path("mission.toml").write_text(MISSION)
        for ending in ("csv", "nc"):
            Path(f"field-{ending}.toml").write_text(MISSION.replace(MODEL, f'file = "field.{ending}"\n'))
        for name, study in STUDIES.items():
            Path(f"{name}.toml").write_text(study)
            _store(Path(f"{name}.toml"), Store(name))


def _store(file: Path, store: Store) -> None:
    """Store a run of each seed on the first item of a study, as if a process had ended with it."""
    tables = load_tables(file)
    problem = PROBLEMS.load(tables.get("problem", "routing"))
    study = study_from(tables, problem, name=file.stem, base=Path())
    store.create()
    item = study.sources[0].load()
    entry = study.entries[0]
    jobs = list(entry.jobs(store.put_item(problem, item), problem.size(item)))
    store.put_study(study.asked, [job.path for job in jobs])
    store.put_environment(environment_digest(environment()), environment())
    for job in jobs:
        store.put(job.path, _run(problem, problem.read(store.root / job.folder), job))


def _run(problem: Problem[Any], item: Any, job: Job) -> Run:
    method = problem.methods.make(job.method, job.options)
    found = problem.solve(method, item, Limits(time=job.time_limit), job.seed, lambda claim: None, None)
    product = json.loads(json.dumps(found.product))
    objective, wrong = problem.judge(item, product, found.objective)
    assert not wrong, wrong
    about = {"options": dict(job.options), "label": job.label, "threads": 1, "iterations": None, "proves": False}
    times = {"elapsed": 0.1, "prepare_elapsed": 0.2, "wall_elapsed": 0.3, "cpu_seconds": 0.1, "peak_memory": 10**8}
    made = {"environment": environment_digest(environment()), "code": code_digest(), "revision": "", "created": "2025"}
    return Run(
        problem=problem.name,
        instance=problem.describe(item),
        solver=job.method,
        seed=job.seed,
        time_limit=job.time_limit,
        status=found.status,
        objective=objective,
        bound=problem.bound(item),
        stopped_by=found.stopped_by,
        message="",
        tolerance=0.0,
        claimed_objective=found.objective,
        trace=[(0.1, objective, problem.bound(item))],
        statistics=dict(found.statistics),
        own=problem.own_columns(item, product),
        **about,
        **times,
        **made,
    )


def call(*args: object) -> None:
    """Run the command line in this process; SystemExit where it does not end well."""
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as told:
            main([str(arg) for arg in args])
    except SystemExit as ended:
        if ended.code:
            raise SystemExit(f"the corpus cannot be made: {args} ends with {ended.code}: {told.getvalue()}") from None


def _instances() -> None:
    call("generate", "uniform", "--tasks", 4, "--depots", 2, "--seed", 1)
    Path("uniform-n4-m2-s1.json").rename("small.json")
    call("convert", "small.json", "small.json.gz")
    call("convert", "small.json", "small.atsp")
    for ending in ("tsp", "mtsp", "mdm", "vrp"):
        Path(f"small.{ending}").write_text(TSPLIB)
    for ending in ("sol", "tour"):
        write_routes([[0, 1], [2, 3]], read_instance("small.json"), f"small.{ending}")
    Path("others.csv").write_text(OTHERS)
    pd.read_csv("others.csv").to_parquet("others.parquet")
    Path("slurm.toml").write_text(SLURM)


def _environment() -> None:
    Path("zones.geojson").write_text(json.dumps(ZONES))
    Region.rectangle(6000.0, 5000.0).write("region.geojson")
    Path("tests.csv").write_text("x,y,weight\n1000,1000,1\n4000,3000,2\n2000,4000,1\n")
    ramp = np.add.outer(np.arange(5.0), np.arange(6.0))
    field = RadioMap(np.arange(6) * 1200.0, np.arange(5) * 1250.0, ramp, "dBm")
    write_field(field, "field.csv")
    write_field(field, "field.nc")
    Grid((0.0, 0.0), (1200.0, 1250.0), 1 + ramp, 2 - ramp, "made").to_toml(Path())
    _ascii("dem.asc", 10 * ramp)
    _ascii("ninja_vel.asc", 1 + ramp)
    _ascii("ninja_ang.asc", 10 * ramp)
    _geotiff("dem.tif", 10 * ramp)


def _ascii(name: str, values: np.ndarray) -> None:
    rows = "\n".join(" ".join(f"{value:g}" for value in row) for row in values)
    head = f"ncols {values.shape[1]}\nnrows {values.shape[0]}\nxllcorner -650\nyllcorner -650\ncellsize 1300\n"
    Path(name).write_text(f"{head}NODATA_value -9999\n{rows}\n")


def _geotiff(name: str, values: np.ndarray) -> None:
    import rasterio

    rows, columns = values.shape
    shape = {"height": rows, "width": columns, "count": 1, "dtype": "float64"}
    turned = rasterio.transform.from_origin(-650, 5850, 1300, 1300)
    with rasterio.open(name, "w", driver="GTiff", crs="EPSG:32633", transform=turned, **shape) as out:
        out.write(values, 1)


def traps(folder: Path) -> None:
    """Lay beside the files of a case what `nasty.FILES` names."""
    (folder / "zero").symlink_to("/dev/zero")
    (folder / "self").symlink_to("self")
    (folder / "folder").mkdir()
    os.mkfifo(folder / "fifo")
