"""Proofs over arcs beside those of SCIP, and what trials, cuts of all UAVs and threads are worth, in one run.

    python tests/benchmarks/arc_tree.py [--seconds 120] [--instances eil76_2,100:2:0] [--tried 1,3] [--benchmarks DIR]

Instances: names of mTSPLib, or tasks:UAVs:seed of the family square-wind, whose depots are apart. Each line: how a
method ended, gap, seconds by the clock from the same routes (a memetic search of ten seconds, not counted), cases of
its tree. `--threads` are those of arc-tree; SCIP has one. The certificate's line says how long its check takes, and how
large its file is; `--no-certificate` leaves it out.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import public_sets

from formulations.limits import Limits
from formulations.moving_cost.families import generate
from formulations.routing.arc_tree import ArcTree
from formulations.routing.branch_and_cut import BranchAndCut
from formulations.routing.certifying import certify
from formulations.routing.registry import make_solver
from instances import Instance, Routes
from instances.certificate import verify, write_certificate

NAMES = ("eil51_2", "berlin52_2", "eil76_2", "rat99_2", "berlin52_3", "eil51_3")


def proof(name: str, method: ArcTree | BranchAndCut, instance: Instance, start: Routes, limits: Limits) -> None:
    """Print how one method ends."""
    method.prepare(instance)
    result = method.solve(instance, limits=limits, start=start)
    print(f"{instance.name} | {name} | {result.status} | {result.gap or 0:.2%} | {result.elapsed:.1f} | "
          f"{result.statistics.get('nodes', 0)}", flush=True)  # fmt: skip


def certificate(instance: Instance, start: Routes, seconds: float) -> None:
    """Print what a certificate takes."""
    kept = certify(instance, limits=Limits(time=seconds), start=start, solver=ArcTree())
    began = time.process_time()
    verdict = verify(instance, kept)
    lasted = time.process_time() - began
    with tempfile.TemporaryDirectory() as folder:
        write_certificate(Path(folder) / "a", kept)
        size = (Path(folder) / "a").stat().st_size
    holds = "holds" if not verdict.problems else verdict.problems[0]
    print(f"{instance.name} | certificate of {kept.bound:.6f} s {holds} | checked in {lasted:.1f} s, {size // 1000} kB",
          flush=True)  # fmt: skip


def main() -> None:
    """Print the lines."""
    parser = argparse.ArgumentParser(description="Proofs over arcs.")
    parser.add_argument("--seconds", type=float, default=120.0, help="limit of each method")
    parser.add_argument("--instances", default=",".join(NAMES), help="names, or n:m:seed, with commas between")
    parser.add_argument("--tried", default="1,3", help="splits tried, with commas between")
    parser.add_argument("--threads", default="1", help="threads of arc-tree, with commas between")
    parser.add_argument("--no-certificate", action="store_true")
    public_sets.add_option(parser)
    asked = parser.parse_args()
    search, methods = make_solver("memetic"), dict[str, tuple[ArcTree | BranchAndCut, int]]()
    for threads in map(int, asked.threads.split(",")):
        of_threads = f", {threads} threads" if threads > 1 else ""
        for tried in map(int, asked.tried.split(",")):
            methods[f"arc-tree, {tried} tried{of_threads}"] = ArcTree(tried=tried), threads
    methods["arc-tree, no cuts of all UAVs"] = ArcTree(joint=False), 1
    methods["branch-and-cut"] = BranchAndCut(), 1
    print("instance | method | status | gap | s by the clock | cases")
    for name in asked.instances.split(","):
        if ":" in name:
            instance = generate("square-wind", *map(int, name.split(":")))
        else:
            instance = public_sets.public(asked.benchmarks, "single_mtsplib", only=(name,))[0][0]
        search.prepare(instance)
        start = search.solve(instance, limits=Limits(time=10.0)).routes
        assert start is not None
        for label, (method, threads) in methods.items():
            proof(label, method, instance, start, Limits(time=asked.seconds, threads=threads))
        if not asked.no_certificate:
            certificate(instance, start, asked.seconds)


if __name__ == "__main__":
    main()
