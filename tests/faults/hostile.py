"""What hostile solvers are made of: honest routes, and a decorator that makes a solver of a function."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

from formulations.routing.solver import Event, Observer, Result, Solver, Status
from instances import Instance, Routes, makespan


def routes_of(instance: Instance) -> Routes:
    """Return the routes on which the first UAV does everything."""
    return (tuple(instance.tasks), *(() for _ in range(instance.n_depots - 1)))


@dataclass(frozen=True)
class Honest(Solver):
    """Streams honest routes and returns them."""

    proves: ClassVar[bool] = True

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        return honest(instance, observe)


def honest(instance: Instance, observe: Observer, **changed: Any) -> Result:
    """Stream honest routes; return them, with fields that are not."""
    routes = routes_of(instance)
    value = makespan(instance, routes)
    observe(Event(0.0, value, None, routes))
    given = {"objective": value, "routes": routes, "stopped_by": "finished"} | changed
    return Result(given.pop("status", Status.FEASIBLE), **given)


def plug_in(act: Callable[[Instance, Observer], Any]) -> type[Solver]:
    """Return the solver that streams honest routes and then does `act`; honest again where that returns nothing."""

    @dataclass(frozen=True)
    class Hostile(Honest):
        def solve(self, instance, *, limits, seed=0, observe=None, start=None):
            result = honest(instance, observe)
            done = act(instance, observe)
            return result if done is None else done

    return Hostile


def pipes() -> Iterator[int]:
    """Yield every pipe this process holds but the standard streams: that of the messages is among them."""
    for descriptor in range(3, 64):
        with contextlib.suppress(OSError):
            if os.readlink(f"/proc/self/fd/{descriptor}").startswith("pipe:"):
                yield descriptor


def say(line: bytes) -> None:
    """Write a line into every pipe."""
    for descriptor in list(pipes()):
        with contextlib.suppress(OSError):
            rest = memoryview(line + b"\n")
            while rest:
                rest = rest[os.write(descriptor, rest) :]
