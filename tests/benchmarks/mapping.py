"""Mapping: the measured figures beside their bars. Run by hand: python tests/benchmarks/mapping.py [--quick]

Times are process CPU seconds, the median of many repetitions, kernels compiled before, one BLAS thread.
"""

from __future__ import annotations

import argparse
import math
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from formulations.kernel import SquaredExponential
from formulations.mapping import dubins
from formulations.mapping.gaussian_process import GaussianProcess
from formulations.mapping.map_model import EVERY_KERNEL
from instances.environment.radio import RadioMap
from workbench.mission.baselines import Baselines, Plan
from workbench.mission.belief import Belief, map_model_of
from workbench.mission.file import mission_of
from workbench.mission.map import survey_of
from workbench.mission.place import place_tasks
from workbench.mission.settings import Mission

KERNEL = SquaredExponential(30.0, (4000.0, 4000.0))


def say(what: str, measured: str, bar: str, kept: bool) -> None:
    print(f"{'ok  ' if kept else 'MISS'} {what}: {measured} (bar: {bar})", flush=True)


def samples(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return positions of three UAVs sampling every kilometre on wavy tours, and values."""
    rng = np.random.default_rng(1)
    X = rng.uniform(0, 20e3, (count, 2))
    return X, -90 + 20 * np.sin(X[:, 0] / 3000) * np.cos(X[:, 1] / 4000) + rng.normal(0, 1, count)


def tick(repetitions: int) -> None:
    """Time one tick of 3 samples at N = 600 with 10⁴ pixels, posterior included."""
    X, y = samples(600 + 3 * repetitions)
    grid = np.stack(np.meshgrid(np.linspace(0, 20e3, 100), np.linspace(0, 20e3, 100)), -1).reshape(-1, 2)
    process = GaussianProcess(KERNEL, 1.0, grid)
    for k in range(0, 600, 3):
        process.extend(X[k : k + 3], y[k : k + 3])
    times = []
    for k in range(600, len(y), 3):
        began = time.process_time()
        process.extend(X[k : k + 3], y[k : k + 3])
        process.posterior()
        times.append(time.process_time() - began)
    ms = 1e3 * float(np.median(times))
    say("GP tick of 3 samples at N = 600, 10⁴ pixels", f"{ms:.2f} ms", "≤ 10 ms", ms <= 10)


def exactness() -> None:
    """Compare incremental, batch and scikit-learn, and look for negative variances with replicates."""
    X, y = samples(600)
    X[300:] = X[:300]  # every place twice: the worst for rounding
    points = np.concatenate([X[:100], np.random.default_rng(2).uniform(0, 20e3, (400, 2))])
    batch = GaussianProcess(KERNEL, 1.0, points, -90.0)
    batch.extend(X, y)
    grown = GaussianProcess(KERNEL, 1.0, points, -90.0)
    for k in range(0, 600, 3):
        grown.extend(X[k : k + 3], y[k : k + 3])
    one, other = batch.posterior(), grown.posterior()
    away = max(np.abs(one.mean - other.mean).max(), np.abs(one.sd - other.sd).max())
    say("incremental against batch, N = 600", f"{away:.1e}", "≤ 1e-8", away <= 1e-8)
    variance = KERNEL.signal_sd**2 - grown._squares  # before the clip at 0
    say("least variance with every sample twice", f"{variance.min():.2e}", "never < 0", variance.min() >= 0)
    try:
        from sklearn.gaussian_process import GaussianProcessRegressor
        from sklearn.gaussian_process.kernels import RBF, ConstantKernel
    except ImportError:
        return
    model = GaussianProcessRegressor(ConstantKernel(900.0) * RBF([4000.0, 4000.0]), alpha=1.0, optimizer=None)
    mean, sd = model.fit(X, y + 90).predict(points, return_std=True)
    away = max(np.abs(other.mean - (mean - 90)).max(), np.abs(other.sd - sd).max())
    say("against scikit-learn, N = 600", f"{away:.1e}", "≤ 1e-8", away <= 1e-8)


def dubins_speed(pairs: int) -> None:
    """Time Dubins lengths in a compiled loop."""
    rng = np.random.default_rng(3)
    points = rng.uniform(0, 20e3, (pairs // 256 + 1, 2))
    headings = rng.uniform(-math.pi, math.pi, (len(points), 16))
    dubins.heading_costs(points[:2], headings[:2], 50.0)
    times = []
    for _ in range(5):
        began = time.process_time()
        dubins.heading_costs(points, headings, 50.0)
        times.append((time.process_time() - began) / (256 * len(points)))
    us = 1e6 * min(times)
    say("Dubins length", f"{us:.2f} µs", "≤ 1 µs", us <= 1.0)


def mission_of_squares(time_limit: float) -> Mission:
    """Return the paper's square without wind: 3 UAVs, 40 tasks."""
    table = {
        "airspeed": 100.0,
        "size": [20000, 20000],
        "depots": [[10000, 19000], [1000, 1000], [19000, 1000]],
        "tasks": 40,
        "radio": {"position": [10000, 10000]},
        "routes": {"time_limit": time_limit},
        "compare": {"time_limit": time_limit},
    }
    return mission_of(table, Path(), "squares")


def field(seed: int, cells: int = 50) -> RadioMap:
    """Return a draw of the Gaussian process with the paper's σ_f and l, level −90 dBm."""
    x = np.linspace(0, 20e3, cells + 1)
    grid = np.stack(np.meshgrid(x, x), -1).reshape(-1, 2)
    K = KERNEL(grid, grid)
    K[np.diag_indices_from(K)] += 1e-6 * KERNEL.signal_sd**2
    drawn = np.linalg.cholesky(K) @ np.random.default_rng(seed).normal(size=len(grid))
    return RadioMap(x, x, -90.0 + drawn.reshape(len(x), -1))


def random_fields(count: int, time_limit: float) -> None:
    """Map random fields along the mission's tours and along the lawnmower of at least that length."""
    mission = mission_of_squares(time_limit)
    scenario = mission.scenario
    tasks = place_tasks(mission, scenario.region, scenario.n_tasks, mission.place.method, {}).points
    with ThreadPoolExecutor(1) as pool:
        own = Plan("mission", 40, Baselines(mission, scenario, None, 0.0).routed(pool, tasks)())
    (other,) = Baselines(mission, scenario, None, own.length).lawnmower()
    belief = Belief(map_model_of(mission), EVERY_KERNEL, KERNEL)
    rows = []
    for seed in range(count):
        drawn = field(seed)
        last = [survey_of(mission, belief, scenario.region, drawn, plan.flights).ticks[-1] for plan in (own, other)]
        ends = [tick.score for tick in last]
        rows.append([ends[0].rmse, ends[1].rmse, ends[0].nlpd, ends[1].nlpd, ends[0].coverage])
    table = np.array(rows)
    ratio = table[:, 0].mean() / table[:, 1].mean()
    lengths = f"{own.length / 1e3:.1f} km against {other.length / 1e3:.1f} km of {other.count} lanes"
    say(
        f"RMSE over {count} random fields, n = 40, {lengths}",
        f"{table[:, 0].mean():.3f} / {table[:, 1].mean():.3f} = {ratio:.0%} (single fields "
        f"{(table[:, 0] / table[:, 1]).min():.0%} to {(table[:, 0] / table[:, 1]).max():.0%})",
        "≤ 80 %",
        ratio <= 0.8 and own.length <= other.length,
    )
    say("NLPD of the same", f"{table[:, 2].mean():.3f} against {table[:, 3].mean():.3f}", "lower",
        table[:, 2].mean() < table[:, 3].mean())  # fmt: skip
    mean = table[:, 4].mean()
    say("95 % interval after MLE covers", f"{mean:.1%} (single fields {table[:, 4].min():.1%} to "
        f"{table[:, 4].max():.1%})", "90 to 98 %", 0.90 <= mean <= 0.98)  # fmt: skip


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="3 fields instead of 12")
    quick = parser.parse_args().quick
    with threadpool_limits(1, user_api="blas"):
        tick(30 if quick else 200)
    exactness()
    dubins_speed(50_000 if quick else 500_000)
    random_fields(3 if quick else 12, 2.0 if quick else 10.0)
