"""Gaps of searches, a line for each instance; runs may be kept in a file, so that hours of them go on later."""

from __future__ import annotations

import argparse
import csv
from collections.abc import Callable
from functools import partial
from pathlib import Path
from statistics import fmean

from instances import Instance, Routes, check_routes, makespan
from instances.code import KERNEL_PACKAGES, code_digest
from instances.files import write_routes

Search = Callable[[Instance, float, int], Routes]
"""What takes an instance, CPU seconds and a seed."""
KEY = ("search", "instance", "seconds", "seed")
COLUMNS = (*KEY, "makespan", "code")
"""Of a file of kept runs; ``code`` is the digest of the sources that made the run."""


class KeptRuns:
    """Makespans in a CSV file that several processes may add to; without a path none is kept.

    Of a run that two of them made at once the first row counts.
    """

    def __init__(self, path: Path | None) -> None:
        self.path = path

    def makespan(self, key: tuple[object, ...], run: Callable[[], float]) -> float:
        """Return what is kept under `key`, whichever code made it, or what `run` returns, which is kept."""
        texts = [str(part) for part in key]
        known = [row for row in self.rows() if [row[column] for column in KEY] == texts]
        if known:
            return float(known[0]["makespan"])
        value = run()
        if self.path:
            begins = not self.path.exists()
            with self.path.open("a", newline="", encoding="utf-8") as file:
                lines = csv.writer(file, lineterminator="\n")
                if begins:
                    lines.writerow(COLUMNS)
                lines.writerow([*texts, repr(value), code_digest(KERNEL_PACKAGES)])
        return value

    def rows(self) -> list[dict[str, str]]:
        """Return the rows of the file."""
        if self.path is None or not self.path.exists():
            return []
        with self.path.open(newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))


def checked_makespan(routes: Routes, instance: Instance, best: float, keep: Path | None) -> float:
    """Return the makespan [s], recomputed, infinite where routes are wrong; write routes below `best` to `keep`."""
    if check_routes(instance, routes):
        return float("inf")
    value = makespan(instance, routes)
    if keep and value < best * (1.0 - 1e-8):
        write_routes(routes, instance, keep / f"{instance.name}-{value:.6f}.sol")
    return value


def gaps_of(
    search: Search,
    instance: Instance,
    best: float,
    seconds: float,
    seeds: int,
    *,
    keep: Path | None = None,
    runs: tuple[KeptRuns, str] | None = None,
) -> list[float]:
    """Return the gap [%] of each seed to `best`, recomputed from checked routes.

    Routes below `best` are written to `keep`; `runs` are those kept, and the name that the search has there.
    """
    kept, name = runs or (KeptRuns(None), "")

    def run(seed: int) -> float:
        return checked_makespan(search(instance, seconds, seed), instance, best, keep)

    keys = ((name, instance.name, f"{seconds:g}", seed) for seed in range(seeds))
    values = [kept.makespan(key, partial(run, seed)) for seed, key in enumerate(keys)]
    return [100.0 * (value / best - 1.0) for value in values]


def table(
    title: str,
    cases: list[tuple[Instance, float]],
    searches: dict[str, Search],
    args: argparse.Namespace,
    seconds: float,
) -> dict[str, list[list[float]]]:
    """Print a line for each instance and the means; return the gaps by search and instance."""
    seconds = args.seconds or seconds
    print(f"\n== {title}: {seconds:g} CPU s, {args.seeds} seeds, gap to best known [%]: mean (best) ==")
    print(f"{'instance':<14}{'n':>5}{'m':>4}  " + "".join(f"{name:>22}" for name in searches))
    gaps: dict[str, list[list[float]]] = {name: [] for name in searches}
    kept = KeptRuns(args.runs)
    for instance, best in cases:
        line = f"{instance.name:<14}{instance.n_tasks:>5}{instance.n_depots:>4}  "
        for name, search in searches.items():
            found = gaps_of(search, instance, best, seconds, args.seeds, keep=args.keep, runs=(kept, name))
            gaps[name].append(found)
            line += f"{fmean(found):>13.2f} ({min(found):6.2f})"
        print(line, flush=True)
    for name, of_search in gaps.items():
        means = [fmean(g) for g in of_search]
        print(f"{name}: mean {fmean(means):.2f} %, worst instance mean {max(means):.2f} %")
    return gaps
