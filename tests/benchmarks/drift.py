"""Fields that drift: what ignoring it costs, beside the bars. Run by hand: python tests/benchmarks/drift.py [--quick]

The paper's three tours over 40 tasks measure draws of the planning kernel that drift with τ; the map at the end is
judged under the kernel that made them: static, with τ known, and with τ by likelihood. ± is a 95 % interval over the
fields (Student's t). Also the time of a tick, and what forgetting old samples would gain.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

import numpy as np
from scipy.stats import t as student
from threadpoolctl import threadpool_limits

from formulations.kernel import SquaredExponential
from formulations.mapping.flight import Flight
from formulations.mapping.gaussian_process import GaussianProcess
from formulations.mapping.map_model import MapModel, Offered
from formulations.mapping.survey import Score, last_map
from instances.arrays import Floats
from instances.environment.drift import DriftingField
from instances.environment.radio import RadioMap
from workbench.mission.baselines import Baselines
from workbench.mission.file import mission_of
from workbench.mission.place import place_tasks

KERNEL = SquaredExponential(30.0, (4000.0, 4000.0))
TAUS = (300.0, 1000.0, 3000.0, 1e4, 1e6)
NODES = np.linspace(0.0, 20e3, 51)
COVERED = (0.93, 0.97)
"""Bar of the mean coverage with τ known."""
MOST_MS = 10.0
"""Bar of a tick at 600 samples [ms]."""


def say(what: str, measured: str, bar: str, kept: bool) -> None:
    print(f"{'ok  ' if kept else 'MISS'} {what}: {measured} (bar: {bar})", flush=True)


def tours() -> list[Flight]:
    """Return the flights of the paper's square without wind: 3 UAVs, 40 tasks."""
    table = {
        "airspeed": 100.0,
        "size": [20000, 20000],
        "depots": [[10000, 19000], [1000, 1000], [19000, 1000]],
        "tasks": 40,
        "radio": {"position": [10000, 10000]},
        "compare": {"time_limit": 5.0},
    }
    mission = mission_of(table, Path(), "squares")
    tasks = place_tasks(mission, mission.scenario.region, 40, mission.place.method, {}).points
    with ThreadPoolExecutor(1) as pool:
        return Baselines(mission, mission.scenario, None, 0.0).routed(pool, tasks)()


@cache
def factor() -> Floats:
    """Return a factor of the kernel's covariance between the nodes."""
    grid = np.stack(np.meshgrid(NODES, NODES), -1).reshape(-1, 2)
    K = KERNEL(grid, grid)
    K[np.diag_indices_from(K)] += 1e-6 * KERNEL.signal_sd**2
    return np.asarray(np.linalg.cholesky(K))


def field(seed: int, tau: float) -> DriftingField:
    """Return a draw of the Gaussian process in space and time, a frame every 10 s."""

    def drawn(number: int) -> Floats:
        noise = np.random.default_rng([seed, number]).normal(size=len(NODES) ** 2)
        return np.asarray((factor() @ noise).reshape(len(NODES), -1))

    return DriftingField(RadioMap(NODES, NODES, np.full((len(NODES),) * 2, -90.0)), drawn, tau, 10.0)


def maps(flights: list[Flight], tau: float, fields: int) -> Iterator[tuple[Score, Score, Score]]:
    """Yield for each field the score at the end of the static map, with τ known, and with τ by likelihood."""
    centres = (np.arange(50) + 0.5) * 400.0
    points = np.stack(np.meshgrid(centres, centres), -1).reshape(-1, 2)
    arms = (
        (MapModel(KERNEL), Offered(), False),
        (MapModel(KERNEL, tau=tau), Offered(), False),
        (MapModel(KERNEL), Offered((SquaredExponential,), tau=None), True),
    )
    for seed in range(fields):
        drawn = field(seed, tau)
        static, known, auto = (
            last_map(flights, drawn, points, model=model, offered=offered, refit=refit, seed=seed).score
            for model, offered, refit in arms
        )
        yield static, known, auto


def interval(values: Floats) -> str:
    """Return mean ± half of its 95 % interval."""
    half = student.ppf(0.975, len(values) - 1) * values.std(ddof=1) / math.sqrt(len(values))
    return f"{values.mean():.3g} ± {half:.2g}"


def ignoring(flights: list[Flight], fields: int) -> None:
    """Print a row a τ: static / τ known / τ by likelihood."""
    for tau in TAUS:
        scores = list(maps(flights, tau, fields))
        told = []
        for name in ("rmse", "nlpd", "coverage"):
            arms = [np.array([getattr(arm, name) for arm in each]) for each in zip(*scores, strict=True)]
            told.append(f"{name} {' / '.join(map(interval, arms))}")
        covered = float(np.mean([known.coverage for _, known, _ in scores]))
        bar = f"{COVERED[0]} to {COVERED[1]} with τ known"
        say(f"τ = {tau:g} s, {fields} fields", "; ".join(told), bar, COVERED[0] <= covered <= COVERED[1])


def ticks(repetitions: int, known: int = 600) -> None:
    """Time a tick of 3 samples at N = `known` with 10⁴ pixels, posterior included, static and with τ = 300 s."""
    rng = np.random.default_rng(1)
    X, y = rng.uniform(0, 20e3, (known + 3 * repetitions, 2)), rng.normal(0, 30, known + 3 * repetitions)
    centres = np.linspace(0, 20e3, 100)
    grid = np.stack(np.meshgrid(centres, centres), -1).reshape(-1, 2)
    for tau in (math.inf, 300.0):
        process, taken = GaussianProcess(MapModel(KERNEL, tau=tau), 1.0, grid), []
        for k in range(0, len(y), 3):
            began = time.process_time()
            process.extend(X[k : k + 3], y[k : k + 3], 10.0 * (k // 3))
            process.posterior()
            taken.append(time.process_time() - began)
        ms = 1e3 * float(np.median(taken[known // 3 :]))
        most = MOST_MS * known / 600  # it grows with the samples
        say(f"GP tick at N = {known}, 10⁴ pixels, τ = {tau:g} s", f"{ms:.2f} ms", f"≤ {most:g} ms", ms <= most)


def forgetting(count: int = 1800) -> None:
    """Print what the map of the last samples alone, not older than 4 τ, differs by, and what it costs to make."""
    rng, tau = np.random.default_rng(2), 300.0
    X, t = rng.uniform(0, 20e3, (count, 2)), 10.0 * (np.arange(count) // 3)
    model = MapModel(KERNEL, tau=tau)
    y = -90.0 + np.linalg.cholesky(model.covariance(X, t, X, t) + np.eye(count)) @ rng.normal(size=count)
    centres = np.linspace(0, 20e3, 100)
    grid = np.stack(np.meshgrid(centres, centres), -1).reshape(-1, 2)
    whole, recent = GaussianProcess(model, 1.0, grid), GaussianProcess(model, 1.0, grid)
    whole.extend(X, y, t)
    fresh = t >= t[-1] - 4 * tau
    began = time.process_time()
    recent.extend(X[fresh], y[fresh], t[fresh])
    taken = time.process_time() - began
    one, other = whole.posterior(), recent.posterior()
    print(
        f"     samples older than 4 τ forgotten, {fresh.sum()} of {count} kept: means differ by at most "
        f"{np.abs(one.mean - other.mean).max():.2g}, sds by {np.abs(one.sd - other.sd).max():.2g}, level by "
        f"{abs(one.coefficients[0] - other.coefficients[0]):.2g}; factorised afresh in {taken:.2f} s"
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="4 fields instead of 16")
    quick = parser.parse_args().quick
    with threadpool_limits(1, user_api="blas"):
        ticks(30 if quick else 100)
        ticks(20, 1800)
        forgetting()
        ignoring(tours(), 4 if quick else 16)
