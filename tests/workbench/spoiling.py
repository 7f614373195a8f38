"""Solvers that leave traces outside their run, for tests: named on the command line as ``spoiling:Class``."""

from __future__ import annotations

import os
import time
from pathlib import Path

from misbehaving import Honest, told

from formulations.routing.solver import Result, Status


class Marks(Honest):
    """Adds its seed to the file named by MARKS once it has solved, after `delay` [s]."""

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        routes, value = told(instance, observe)
        time.sleep(self.delay)
        with Path(os.environ["MARKS"]).open("a") as file:
            file.write(f"{seed}\n")
        return Result(Status.FEASIBLE, value, None, 0.0, routes, stopped_by="finished")
