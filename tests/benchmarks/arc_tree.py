"""Proofs over arcs beside those of SCIP, and what strong branching is worth, in one run.

    python tests/benchmarks/arc_tree.py [--seconds 120] [--instances eil76_2,rat99_2] [--benchmarks DIR]

Each line: how a method ended on an instance of mTSPLib with two or three UAVs, gap, CPU seconds of one thread from the
same routes (a memetic search of ten seconds, not counted), cases of its tree. `tried` 1 branches on what is most
undecided; the certificate's line says how long its check takes, and how large its file is.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import public_sets

from formulations.limits import Limits
from formulations.routing.arc_tree import ArcTree
from formulations.routing.branch_and_cut import BranchAndCut
from formulations.routing.certifying import certify
from formulations.routing.registry import make_solver
from instances import Instance, Routes
from instances.certificate import verify, write_certificate

NAMES = ("eil51_2", "berlin52_2", "eil76_2", "rat99_2", "berlin52_3", "eil51_3")
METHODS = {"arc-tree": ArcTree(), "arc-tree, tried 1": ArcTree(tried=1), "branch-and-cut": BranchAndCut()}


def proof(name: str, instance: Instance, start: Routes, seconds: float) -> None:
    """Print how one method ends."""
    method = METHODS[name]
    method.prepare(instance)
    began = time.process_time()
    result = method.solve(instance, limits=Limits(time=seconds), start=start)
    print(f"{instance.name} | {name} | {result.status} | {result.gap or 0:.2%} | {time.process_time() - began:.1f} | "
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
    parser.add_argument("--instances", default=",".join(NAMES), help="names, with commas between")
    public_sets.add_option(parser)
    asked = parser.parse_args()
    search = make_solver("memetic")
    print("instance | method | status | gap | CPU s | cases")
    for instance, _ in public_sets.public(asked.benchmarks, "single_mtsplib", only=tuple(asked.instances.split(","))):
        search.prepare(instance)
        start = search.solve(instance, limits=Limits(time=10.0)).routes
        assert start is not None
        for name in METHODS:
            proof(name, instance, start, asked.seconds)
        certificate(instance, start, asked.seconds)


if __name__ == "__main__":
    main()
