"""Mass-consistent wind over terrain: time, memory and exactness, and exact line integrals against sampling.

Each size runs in a process of its own, so that its peak memory is its own. Ground: synthetic mountains of 1800 m on
the paper's 20 km square; 10 m/s from the north-east, log profile; the slice at 3000 m.

    python tests/benchmarks/wind.py [--quick]
"""

import argparse
import json
import resource
import subprocess
import sys
import time

import numpy as np

from instances.environment.mass_consistent import Inflow, solve_flow
from instances.environment.terrain import Terrain, mountains
from instances.environment.wind_grid import Grid
from instances.environment.wind_turbulence import Turbulence

NORTH_EAST = (-7.0710678, -7.0710678)
FAILED: list[str] = []


def bar(what: str, figure: float, limit: float, unit: str = "") -> None:
    """Print a measured figure beside its bar, and remember where it is missed."""
    kept = figure <= limit
    print(f"  {'ok  ' if kept else 'MISS'} {what}: {figure:.3g}{unit} (bar {limit:g}{unit})", flush=True)
    if not kept:
        FAILED.append(what)


def solve_one(cells: int) -> None:
    """Solve one size after compilation and print its figures as JSON."""
    solve_flow(mountains(cells=16), Inflow(NORTH_EAST), layers=5).slice(3000.0)
    ground = mountains(cells=cells, relief=1800.0, seed=3)
    wall, cpu = time.perf_counter(), time.process_time()
    flow = solve_flow(ground, Inflow(NORTH_EAST), layers=30)
    wind = flow.slice(3000.0)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    d = wind.spacing[0]
    curl = np.gradient(wind.v, d, axis=1) - np.gradient(wind.u, d, axis=0)
    figures = {
        "wall": wall,
        "cpu": cpu,
        "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6,
        "iterations": flow.iterations,
        "curl": float(np.sqrt((curl**2).mean())),
    }
    print(json.dumps(figures))


def sizes(quick: bool) -> None:
    """Time and memory of the two sizes, side by side."""
    for cells, seconds in ((200, 6.0), (1000, 150.0)):
        if quick and cells > 500:
            continue
        run = subprocess.run(
            [sys.executable, __file__, "--cells", str(cells)], check=True, capture_output=True, text=True
        )
        f = json.loads(run.stdout)
        print(
            f"{cells + 1}² × 30, {20_000 / cells:.0f} m: {f['cpu']:.2f} s CPU, {f['wall']:.2f} s wall, "
            f"{f['memory']:.2f} GB, {f['iterations']} iterations, rms curl at 3000 m {f['curl']:.1e} 1/s"
        )
        bar("CPU", f["cpu"], seconds, " s")
        bar("peak memory of the process", f["memory"], 8.0, " GB")


def exactness() -> None:
    """The hemisphere's closed form and flat ground."""
    a, side, n = 1000.0, 12_000.0, 160
    x = np.linspace(-side / 2, side / 2, n + 1)
    h = np.sqrt(np.maximum(a**2 - x[:, None] ** 2 - x[None, :] ** 2, 0.0))
    ground = Terrain((-side / 2, -side / 2), (side / n, side / n), h)
    flow = solve_flow(ground, Inflow((10.0, 0.0), "uniform"), layers=30, top=8000.0)
    heights = np.linspace(1.05 * a, 4 * a, 20)
    errors = [abs(flow.slice(z)([[0.0, 0.0]])[0, 0] / (10 * (1 + a**3 / (2 * z**3))) - 1) for z in heights]
    bar("hemisphere, axis, u = U(1 + a³/2z³)", 100 * max(errors), 0.5, " %")
    flat = Terrain((0.0, 0.0), (100.0, 100.0), np.full((61, 61), 300.0))
    inflow = Inflow(NORTH_EAST, "log")
    wind = solve_flow(flat, inflow).slice(1500.0)
    error = np.abs(wind.u / (NORTH_EAST[0] * float(inflow.factor(np.array(1200.0)))) - 1).max()
    bar("flat ground, relative", float(error), 1e-12)


def line_integrals() -> None:
    """Exact integrals over a bilinear field beside Gauss sampling at the same cost and at a hundred times it."""
    rng = np.random.default_rng(0)
    nodes = np.stack(np.meshgrid(*2 * [np.linspace(0.0, 20_000.0, 201)]), axis=-1)
    u, v = Turbulence(5.0, 4000.0, seed=1)(nodes).reshape(201, 201, 2).transpose(2, 0, 1)
    grid = Grid((0.0, 0.0), (100.0, 100.0), u, v)
    a = rng.uniform(0, 20_000, (100_000, 2))
    b = np.clip(a + rng.normal(0, 600, a.shape), 0, 20_000)
    grid.line_integral(a[:2], b[:2])
    began = time.process_time()
    exact = grid.line_integral(a, b)
    cpu = time.process_time() - began
    scale = np.abs(exact).max()
    print(f"line integrals: {1e6 * cpu / len(a):.2f} µs a segment of {np.hypot(*(b - a).T).mean():.0f} m, exact")
    for points in (4, 400):
        began = time.process_time()
        s = (np.arange(points) + 0.5) / points
        sampled = sum(np.einsum("ij,ij->i", grid(a + t * (b - a)), b - a) for t in s) / points
        spent = time.process_time() - began
        error = np.abs(sampled - exact).max() / scale
        print(
            f"  {points:4d} samples a segment: {1e6 * spent / len(a):.2f} µs, largest error {error:.1e} of the largest"
        )


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="without the largest grid")
    parser.add_argument("--cells", type=int, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.cells:
        solve_one(given.cells)
        return
    exactness()
    line_integrals()
    sizes(given.quick)
    sys.exit(f"missed: {FAILED}" if FAILED else 0)


if __name__ == "__main__":
    main()
