"""Sections `threads` and `size` of search.py: what a second thread is worth, and 20,000 tasks without a matrix."""

from __future__ import annotations

import argparse
import resource
import time
from statistics import fmean

from formulations.limits import Limits
from formulations.moving_cost.families import generate
from formulations.routing.registry import make_solver
from instances import check_routes

STEPS = {
    (50, 3): 100_000,
    (50, 5): 100_000,
    (100, 4): 200_000,
    (100, 10): 200_000,
    (200, 5): 400_000,
    (200, 10): 400_000,
    (500, 10): 800_000,
    (500, 20): 800_000,
    (1000, 20): 1_500_000,
}
"""Steps of one thread for (n, m): so few that more of them tell."""
WAYS = {"1 thread, half": (1, 2), "1 thread": (1, 1), "2 threads, half": (2, 2)}
"""Threads of a run and what its steps in each of them are divided by."""


def threads(args: argparse.Namespace) -> None:
    """Two threads of half the steps each reach what one of all of them does: as close, as often; in half the time.

    Limits are steps, so that what else runs on the machine changes the last column alone.
    """
    print(f"\n== threads: % above the best of all runs (share that reaches the mean of one thread), {args.seeds} seeds")
    print(f"{'instance':<28}" + "".join(f"{way:>22}" for way in WAYS) + f"{'time, 1 over 2':>16}")
    solver, means, shares = make_solver("memetic"), dict.fromkeys(WAYS, 0.0), dict.fromkeys(WAYS, 0.0)
    for (n, m), steps in STEPS.items():
        instance = generate("square-wind", n, m, 0)
        solver.prepare(instance)
        found: dict[str, list[float]] = {way: [] for way in WAYS}
        took = dict.fromkeys(WAYS, 0.0)
        for seed in range(args.seeds):
            for way, (count, part) in WAYS.items():
                began = time.perf_counter()
                limits = Limits(time=3600.0, iterations=steps // part, threads=count)
                value = solver.solve(instance, limits=limits, seed=seed).objective
                assert value is not None
                found[way].append(value)
                took[way] += time.perf_counter() - began
        best, target = min(map(min, found.values())), fmean(found["1 thread"]) * (1 + 1e-9)
        line = f"{instance.name:<28}"
        for way, values in found.items():
            gap, share = 100.0 * (fmean(values) / best - 1.0), fmean(value <= target for value in values)
            means[way] += gap / len(STEPS)
            shares[way] += share / len(STEPS)
            line += f"{gap:>15.3f} ({share:4.0%})"
        print(line + f"{took['1 thread'] / took['2 threads, half']:>16.2f}", flush=True)
    for way in WAYS:
        print(f"{way}: mean {means[way]:.3f} %, the mean of one thread reached in {shares[way]:.0%} of runs")
    print("bar: 2 threads, half: as 1 thread, in half the time where two cores are free")


def size(args: argparse.Namespace) -> None:
    """20,000 tasks, 50 UAVs: within 3 % of a long run after 120 s; memory ≤ 2 GiB."""
    instance, solver = generate("uniform", 20_000, 50, 0), make_solver("memetic")
    solver.prepare(instance)
    seconds = args.seconds or 120.0
    values = []
    for limit, seed in (*((seconds, seed) for seed in range(args.seeds)), (args.long, args.seeds)):
        result = solver.solve(instance, limits=Limits(time=limit), seed=seed)
        assert result.routes is not None
        assert result.objective is not None
        assert check_routes(instance, result.routes) == []
        values.append(result.objective)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024**2
        print(f"{limit:g} CPU s, seed {seed}: longest {values[-1]:.1f} s, memory {peak:.2f} GiB (bar 2)", flush=True)
    print(f"{fmean(values[:-1]) / values[-1] - 1:+.2%} after {seconds:g} s to {args.long:g} s (bar 3 %)")
