"""The cases of unchanged.py: what is run on the code under test, and what of its answer is kept."""

from __future__ import annotations

import csv
import gzip
import hashlib
import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

SEARCHES = {"memetic": 300_000, "ruin-recreate": 100_000, "ga": 40, "routing-library": 20}
"""Solver → its limit of iterations."""
PROVING = ("milp", "circuit", "subset-dp", "branch-and-cut", "branch-and-price", "exact")
PATIENCE = 900
"""Time limit [s] that no run shall reach."""
VOLATILE = frozenset(
    ("elapsed", "cpu_seconds", "prepare_elapsed", "wall_elapsed", "peak_memory", "time", "environment", "created",
     "log", "trace", "schema", "version", "seconds", "code", "revision")
)  # fmt: skip
"""Keys and columns that a clock, a machine or the code's own identity decides."""

FAMILIES = (
    "uniform",
    "clustered",
    "ring",
    "corridor",
    "square-wind",
    "wind-uniform",
    "wind-vortices",
    "wind-mountains",
)

VARIANTS = {  # options that take another way through the code
    "milp": ("depot_linked=false", "two_cycles=false", "every_solution=false", "symmetry=false"),
    "circuit": ("per_uav=true", "average=false"),
    "branch-and-cut": ("fractional=false", "branch_on_visits=false", "warm_start=false"),
    "branch-and-price": ("starts=0", "bins=50"),
    "greedy": ("variant=cheapest", "variant=shortest", "variant=nearest"),
    "memetic": ("reliefs=1", "powers=1", "focuses=0", "depth=0.1"),
}

SCENARIO = """
airspeed = 20.0
size = [10000, 10000]
no_fly = "zones.geojson"
depots = [[500, 500], [9500, 9000], [500, 500]]
tasks = [[2000, 8000], [8000, 2000], [7000, 7500]]
[wind]
kind = "sum"
parts = [
  {kind = "uniform", velocity = [-4, -4]},
  {kind = "vortices", centres = [[3000, 4000]], circulation = [3e4], core = [800]},
]
"""
ZONES = {"type": "Polygon", "coordinates": [[[4000, 4000], [6000, 4200], [5200, 6500], [4000, 4000]]]}

MISSION = """
airspeed = 50.0
size = [6000, 5000]
no_fly = "zones.geojson"
depots = [[500, 500], [5500, 500]]
tasks = 8
origin = [47.0, 8.0]
wind = { kind = "rotation", rate = 1e-3, centre = [3000, 2500] }
radio = { position = [3000, 2500] }
field = { model = "free-space", shadowing_sd = 2.0, cells = 30 }
place = { method = "nlp", tests = [6, 6], length_scale = 1500.0 }
costs = { method = "dijkstra" }
routes = { solver = "greedy", time_limit = 100.0 }
sensing = { period = 6.0 }
map = { length_scale = 1500.0, cells = 20, frames = 4 }
compare = { time_limit = 100.0, seeds = 2 }
"""

STUDY = """
iterations = 5000
time_limit = 900
seeds = 2
files = ["instances/*.json"]
[[families]]
family = "clustered"
tasks = 6
depots = 2
parameters = { wind = "shear" }
[[solvers]]
name = "memetic"
options = { powers = [1, 6] }
[[solvers]]
name = "greedy"
[[solvers]]
name = "subset-dp"
max_tasks = 10
"""

PLACEMENT = """
problem = "placement"
seeds = 2
time_limit = 900
regions = ["square"]
tasks = [4, 6]
tests = "8x8"
[[methods]]
name = "greedy"
seeds = 1
[[methods]]
name = "random"
[[methods]]
name = "nlp"
"""

Record = dict[str, Any]
Case = Callable[[Path], Record]


def cloud(n: int, m: int, seed: int, *, wind: bool = True, shared: bool = False, whole: bool = False) -> Record:
    """Return a native instance: straight legs in a 20 km square at 20 m/s, in a uniform wind and a rotation."""
    xy = np.random.default_rng(100_000 * n + 100 * m + seed).uniform(-1e4, 1e4, (n + m, 2))
    if shared:
        xy[n:] = xy[n]
    legs = xy[None] - xy[:, None]
    cost = np.sqrt((legs**2).sum(axis=2)) / 20
    if wind:
        x, y = xy.T
        cost -= (4 * legs[..., 0] - 2 * legs[..., 1] + 5e-4 * (np.outer(x, y) - np.outer(y, x))) / 400
    return native(np.rint(cost) if whole else cost, m, xy)


def native(cost: np.ndarray, m: int, xy: np.ndarray | None) -> Record:
    """Return the native file of a cost matrix as a JSON object; costs of 0 where nodes coincide stay 0."""
    np.fill_diagonal(cost, 0.0)
    points = None if xy is None else xy.tolist()
    cost = np.maximum(cost, 0.0)
    return {"schema": 1, "n_tasks": len(cost) - m, "n_depots": m, "cost": cost.tolist(), "coordinates": points}


def rough(n: int, m: int) -> Record:
    """Return whole-number costs far from symmetry and the triangle inequality, without coordinates."""
    return native(np.rint(np.random.default_rng(5).uniform(1, 10, (n + m, n + m)) ** 3), m, None)


def instances() -> dict[str, Record]:
    """Return the instances; those of at most 12 tasks are proved by every proving method."""
    return {
        "6-2-calm": cloud(6, 2, 0, wind=False),
        "8-3-wind": cloud(8, 3, 1),
        "9-2-rough": rough(9, 2),
        "10-2-shared": cloud(10, 2, 2, shared=True),
        "12-3-whole": cloud(12, 3, 3, wind=False, whole=True),
        "15-3-wind": cloud(15, 3, 4),
        "20-1-wind": cloud(20, 1, 5),
        "20-5-calm": cloud(20, 5, 6, wind=False),
        "30-3-wind": cloud(30, 3, 7),
        "40-4-whole": cloud(40, 4, 8, whole=True),
        "50-5-shared": cloud(50, 5, 9, wind=False, shared=True),
        "60-4-wind": cloud(60, 4, 10),
        "200-6-wind": cloud(200, 6, 11),
    }


SMALL = ("6-2-calm", "8-3-wind", "9-2-rough", "10-2-shared", "12-3-whole")
QUICK = ("6-2-calm", "12-3-whole", "30-3-wind", "50-5-shared")


def workbench(folder: Path, *arguments: object) -> tuple[int, str, str]:
    """Run a command of the code under test in `folder`; return its exit code, stdout and stderr."""
    code = "from workbench.cli import main; main()"
    command = [sys.executable, "-P", "-c", code, *map(str, arguments)]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


def failed(code: int, err: str) -> Record:
    """Return what is recorded of a command that did not succeed."""
    return {"exit code": code, "error": (err.strip().splitlines() or [""])[-1]}


def flat(value: Any, prefix: str = "") -> Record:
    """Return a JSON object as dotted key → value, volatile keys left out; lists of objects by their place."""
    if isinstance(value, list) and value and isinstance(value[0], dict):
        value = {str(number): item for number, item in enumerate(value)}
    if not isinstance(value, dict):
        return {prefix: value}
    found: Record = {}
    for key, item in value.items():
        if key not in VOLATILE:
            found |= flat(item, f"{prefix}.{key}" if prefix else key)
    return found


def digest(content: bytes | str) -> str:
    """Return a short digest."""
    return hashlib.sha256(content.encode() if isinstance(content, str) else content).hexdigest()[:16]


def cost_digest(path: Path) -> str:
    """Return the digest of an instance's cost matrix, bit for bit."""
    from instances.files import read_instance

    return digest(np.ascontiguousarray(read_instance(path).cost, dtype=np.float64).tobytes())


def answer(*arguments: object) -> Case:
    """Return a case: the JSON object that a command prints."""

    def case(folder: Path) -> Record:
        code, out, err = workbench(folder, *arguments, "--json")
        try:
            return {"exit code": code} | flat(json.loads(out))
        except ValueError:
            return failed(code, err)

    return case


def generated(family: str) -> Case:
    """Return a case: costs, and where there are any paths, of two instances of a family."""

    def case(folder: Path) -> Record:
        tasks, depots = (20, 3) if family == "square-wind" else (5, 2) if family.startswith("wind-") else (12, 3)
        size = ("--tasks", tasks, "--depots", depots)
        code, out, err = workbench(folder, "generate", family, *size, "--count", 2, "--seed", 1)
        return {Path(line).name: made(folder / line) for line in out.split()} if code == 0 else failed(code, err)

    return case


def made(path: Path) -> list[str]:
    """Return the digests of an instance's costs and, where there are any, of its paths."""
    paths = path.with_name(path.name.removesuffix(".json") + ".paths.json.gz")
    if not paths.exists():
        return [cost_digest(path)]
    kept = json.loads(gzip.decompress(paths.read_bytes()))
    return [cost_digest(path), digest(json.dumps([kept["offsets"], kept["points"]]))]


def costs(method: str, *options: str) -> Case:
    """Return a case: moving costs and paths of a scenario with vortices, a no-fly zone and a depot for two UAVs."""

    def case(folder: Path) -> Record:
        (folder / "s.toml").write_text(SCENARIO)
        (folder / "zones.geojson").write_text(json.dumps(ZONES))
        more = [text for option in options for text in ("--option", option)]
        code, out, err = workbench(folder, "costs", "s.toml", "--method", method, *more, "--out", "s.json")
        return {"made": made(folder / "s.json"), "wind": out.splitlines()[1:]} if code == 0 else failed(code, err)

    return case


def study(text: str, *named: str) -> Case:
    """Return a case: the results.csv of a study, a row by its place; `named` are instances it finds in a folder."""

    def case(folder: Path) -> Record:
        (folder / "study.toml").write_text(text)
        (folder / "instances").mkdir()
        for name in named:
            shutil.copy(folder.parent / "instances" / f"{name}.json", folder / "instances")
        code, _, err = workbench(folder, "compare", "study.toml", "--out", "out", "--jobs", 1)
        return rows(folder / "out/results.csv") if code == 0 else failed(code, err)

    return case


def rows(path: Path) -> Record:
    """Return the cells of a CSV by row and column."""
    with path.open(newline="", encoding="utf-8") as file:
        return {f"row {n}": flat(dict(row)) for n, row in enumerate(csv.DictReader(file))}


def mission(folder: Path) -> Record:
    """Return a case: the products of a mission's stages, by their digests where they are long."""
    (folder / "m.toml").write_text(MISSION)
    zone = [[2600, 1800], [3400, 1800], [3400, 3000], [2600, 3000], [2600, 1800]]
    (folder / "zones.geojson").write_text(json.dumps({"type": "Polygon", "coordinates": [zone]}))
    code, _, err = workbench(folder, "mission", "m.toml", "--out", "out")
    if code:
        return failed(code, err)
    found: Record = {}
    for path in sorted((folder / "out").rglob("*")):
        name = path.relative_to(folder / "out").as_posix()
        if path.is_file() and path.suffix not in (".html", ".svg") and path.name != "stamp.json":
            found[name] = product(path)
    return found


def product(path: Path) -> Any:
    """Return what is kept of one product of a mission."""
    if path.suffix == ".csv":
        return rows(path) if path.stat().st_size < 2000 else digest(path.read_bytes())
    if path.suffix == ".json" and path.stem != "instance":
        return flat(json.loads(path.read_bytes()))
    if path.stem == "instance" or path.name.endswith(".paths.json.gz"):
        return made(path.with_name("instance.json"))
    if path.suffix == ".nc":
        return grids(path)
    return path.read_text() if path.suffix == ".sol" else digest(path.read_bytes())


def grids(path: Path) -> Record:
    """Return the digests of a NetCDF file's variables."""
    import netCDF4

    with netCDF4.Dataset(path) as data:
        return {name: digest(np.ma.getdata(variable[:]).tobytes()) for name, variable in data.variables.items()}


def cases(quick: bool) -> dict[str, Case]:
    """Return every case by name, the quick ones first."""
    found: dict[str, Case] = {"solvers": answer("solvers"), "families": answer("families")}
    for family in ("uniform", "ring", "corridor") if quick else FAMILIES:
        found[f"generate/{family}"] = generated(family)
    for name in QUICK if quick else instances():
        for seed in (0,) if quick else (0, 1):
            for solver, steps in SEARCHES.items():
                found[f"solve/{name}/{solver}/{seed}"] = solve(name, solver, seed, "--iterations", steps)
        found[f"solve/{name}/greedy/0"] = solve(name, "greedy", 0)
    for name in SMALL[:1] if quick else SMALL:
        for solver in PROVING:
            found[f"solve/{name}/{solver}/0"] = solve(name, solver, 0)
    found["place/greedy"] = place("greedy", 0)
    found["costs/dijkstra"] = costs("dijkstra", "samples=500")
    return found if quick else found | more_cases()


def more_cases() -> dict[str, Case]:
    """Return what a quick recording leaves out."""
    found: dict[str, Case] = {}
    for name in SMALL[-2:]:
        found |= {f"solve/{name}/{solver}/1": solve(name, solver, 1) for solver in PROVING}
    for solver, options in VARIANTS.items():
        limit = ("--iterations", SEARCHES[solver]) if solver in SEARCHES else ()
        for name in (SMALL if solver in PROVING else QUICK)[1:2]:
            for option in options:
                found[f"solve/{name}/{solver}/0/{option}"] = solve(name, solver, 0, "--option", option, *limit)
    for solver, name in (("branch-and-price", "20-5-calm"), ("branch-and-price", "15-3-wind"), ("exact", "15-3-wind")):
        found[f"solve/{name}/{solver}/0"] = solve(name, solver, 0)
    found["solve/30-3-wind/branch-and-price/0"] = solve("30-3-wind", "branch-and-price", 0, "--iterations", 2)
    for method in ("nlp", "random", "greedy-swap"):
        found[f"place/{method}"] = place(method, 1)
    found["place/latent"] = place("l-bfgs-b", 0, "--criterion", "a")
    found["costs/refined"] = costs("refined")
    found["costs/fmt-star"] = costs("fmt-star", "samples=800")
    found["bound/10-2-shared"] = answer("bound", "../instances/10-2-shared.json", "--time-limit", PATIENCE)
    found["study"] = study(STUDY, "12-3-whole")
    found["placement study"] = study(PLACEMENT)
    found["mission"] = mission
    return found


def solve(name: str, solver: str, seed: int, *more: object) -> Case:
    """Return a case: one solver on one instance."""
    given = (f"../instances/{name}.json", "--solver", solver, "--seed", seed, "--time-limit", PATIENCE)
    return answer("solve", *given, *more)


def place(method: str, seed: int, *more: object) -> Case:
    """Return a case: six task locations in the 20 km square."""
    return answer("place", "--tasks", 6, "--tests", "8x8", "--method", method, "--seed", seed, *more)
