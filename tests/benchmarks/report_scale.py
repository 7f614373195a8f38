"""Report at scale: a store of 10,000 runs must be reported in 30 s and 1 GB, and the page must stay small.

    python tests/benchmarks/report_scale.py [--quick] [--keep FOLDER]

Makes a synthetic store (50 tasks a run, traces of 30 points, a log each), reports on it in a fresh process, and prints
each measured figure beside its bar. Wall clock depends on what else the machine does; processor time is printed too.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import runpy
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from instances import Instance

RUNS, QUICK_RUNS = 10_000, 1_000
METHODS = ("greedy", "ga", "memetic", "milp", "circuit")
SEEDS = 10
BARS = {"time": 30.0, "memory": 1e9, "page": 4e6}

REPORT = """
import sys
from reports.pages.study import write_report
from reports.csv_text import write_csv
from reports.tables import run_table
report = write_report([sys.argv[1]], sys.argv[2])
write_csv(run_table(report.runs), sys.argv[3])
assert report.contradictions.empty, report.contradictions.sentence.head(3).tolist()
print(len(report.runs))
"""


def make_store(root: Path, runs: int) -> None:
    """Write `runs` runs over as many instances as that takes."""
    helpers = runpy.run_path(str(Path(__file__).parents[1] / "reports" / "conftest.py"))
    store, record = helpers["StoreMaker"](root), helpers["run_record"]
    rng = np.random.default_rng(0)
    sizes = ((20, 3), (50, 5), (100, 8))
    for number in range(runs // (len(METHODS) * SEEDS)):
        instance: Instance = helpers["synthetic_instance"](
            *sizes[number % 3], number, ("uniform", "ring")[number % 2], 0.2
        )
        for method in METHODS:
            for seed in range(SEEDS):
                order = rng.permutation(instance.n_tasks)
                routes = [part.tolist() for part in np.array_split(order, instance.n_depots)]
                values = np.linspace(2e4, 1.5e4, 30).tolist()
                proves = method in ("milp", "circuit")
                made = record(
                    instance, method, seed, routes, values=values, proves=proves, bound=1.0 if proves else None
                )
                store.put(instance, made | {"log": "round 1: objective, bound\n" * 20})


def report(root: Path, folder: Path) -> dict[str, float]:
    """Return wall clock [s], processor time [s], peak memory [bytes] and page size [bytes] of one report."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    page, table = folder / "report.html", folder / "results.csv"
    command = [sys.executable, "-c", REPORT, str(root), str(page), str(table)]
    said = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    wall, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    sizes = {"page": float(page.stat().st_size), "csv": float(table.stat().st_size)}
    return {"runs": float(said), "wall": wall, "cpu": cpu, "memory": after.ru_maxrss * 1024.0} | sizes


def main() -> None:
    """Make, report, print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--quick", action="store_true", help=f"{QUICK_RUNS:,} runs in place of {RUNS:,}")
    parser.add_argument("--keep", type=Path, help="make the store here and leave it (used as it is where it exists)")
    chosen = parser.parse_args()
    runs = QUICK_RUNS if chosen.quick else RUNS
    with tempfile.TemporaryDirectory() as temporary:
        root = chosen.keep or Path(temporary) / "runs"
        if not root.exists():
            make_store(root, runs)
        folder = chosen.keep.parent if chosen.keep else Path(temporary)
        figures = report(root, folder)
    print(json.dumps({"cores": os.cpu_count(), **figures}))
    print(f"{figures['runs']:,.0f} runs: page and CSV written")
    print(f"  wall clock {figures['wall']:6.1f} s   (bar {BARS['time']:.0f} s for {RUNS:,} runs)")
    print(f"  processor  {figures['cpu']:6.1f} s")
    print(f"  memory     {figures['memory'] / 1e6:6.0f} MB  (bar {BARS['memory'] / 1e6:.0f} MB)")
    print(f"  page       {figures['page'] / 1e6:6.2f} MB  (bar {BARS['page'] / 1e6:.0f} MB)")


if __name__ == "__main__":
    main()
