"""Solvers that misbehave, for tests: named on the command line as ``misbehaving:Class``."""

from __future__ import annotations

import contextlib
import ctypes
import os
import sys
import time
from dataclasses import dataclass
from typing import ClassVar

from formulations.routing.solver import Event, Result, Solver, Status
from instances import Instance, Routes, makespan


def all_with_first(instance: Instance) -> Routes:
    """Return the routes on which the first UAV does everything."""
    return (tuple(instance.tasks), *(() for _ in range(instance.n_depots - 1)))


def told(instance: Instance, observe, bound: float | None = None) -> tuple[Routes, float]:
    """Stream honest routes and return them with their cost."""
    routes = all_with_first(instance)
    value = makespan(instance, routes)
    observe(Event(0.0, value, bound, routes))
    return routes, value


@dataclass(frozen=True)
class Honest(Solver):
    """Does everything with the first UAV; `delay` [s] of sleep makes it slow."""

    proves: ClassVar[bool] = False
    delay: float = 0.0

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        routes, value = told(instance, observe)
        time.sleep(self.delay)
        return Result(Status.FEASIBLE, value, None, 0.0, routes, stopped_by="finished")


class Crashes(Honest):
    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        told(instance, observe, bound=1.0)
        raise RuntimeError("the dog ate the basis matrix")


class Segfaults(Honest):
    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        told(instance, observe)
        ctypes.string_at(0)


class ExitsQuietly(Honest):
    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        told(instance, observe)
        os._exit(0)


class Hangs(Honest):
    """Ignores its limit, having started a process of its own that ignores it too."""

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        told(instance, observe, bound=1.0)
        grandchild = os.fork()
        if grandchild:
            print("grandchild", grandchild, flush=True)
        time.sleep(3600)


class LiesAboutCost(Honest):
    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        routes = all_with_first(instance)
        return Result(Status.FEASIBLE, 0.5 * makespan(instance, routes), None, 0.0, routes, stopped_by="finished")


class LiesWhileStreaming(Honest):
    """Streams a wrong cost, then hangs."""

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        routes = all_with_first(instance)
        observe(Event(0.0, 1.0, None, routes))
        time.sleep(3600)


class ForgetsATask(Honest):
    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        routes = (tuple(instance.tasks)[1:], *(() for _ in range(instance.n_depots - 1)))
        return Result(Status.FEASIBLE, makespan(instance, routes), None, 0.0, routes, stopped_by="finished")


class ClaimsOptimalWithGap(Honest):
    proves: ClassVar[bool] = True

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        routes, value = told(instance, observe)
        return Result(Status.OPTIMAL, value, 0.9 * value, 0.0, routes, stopped_by="proof", tolerance=1e-6)


class BoundAboveRoutes(Honest):
    proves: ClassVar[bool] = True

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        routes, value = told(instance, observe)
        return Result(Status.FEASIBLE, value, 1.1 * value, 0.0, routes, stopped_by="time")


class NoRoutes(Honest):
    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        return Result(Status.FEASIBLE, 12.0, None, 0.0, None)


class PrintsRubbish(Honest):
    """Prints what looks like messages, and bytes that are no text, but answers well."""

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        for _ in range(1000):
            print('{"kind": "result", "objective": 0}', flush=False)
        sys.stdout.flush()
        os.write(1, b"\xff\xfe\x00 the end")
        routes, value = told(instance, observe)
        return Result(Status.FEASIBLE, value, None, 0.0, routes, stopped_by="finished")


class WritesIntoEveryPipe(Honest):
    """Writes nonsense and false messages into whatever is open, then answers well."""

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        routes, value = told(instance, observe)
        for line in (b"rubbish\n", b"[]\n", b'{"kind": "event"}\n', b'{"kind": "result", "routes": 3}\n'):
            for descriptor in range(3, 256):
                with contextlib.suppress(OSError):
                    os.write(descriptor, line)
        return Result(Status.FEASIBLE, value, None, 0.0, routes, stopped_by="finished")


class Chatters(Honest):
    """Streams ten thousand bounds as fast as it can."""

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        routes, value = told(instance, observe)
        for number in range(10_000):
            observe(Event(0.0, value, 1e-4 * number * value, None))
        return Result(Status.FEASIBLE, value, None, 0.0, routes, stopped_by="finished")


class ReturnsRubbish(Honest):
    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        told(instance, observe)
        return "banana"


class EatsMemory(Honest):
    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        told(instance, observe)
        eaten = []
        while True:
            eaten.append(b"x" * 20_000_000)
            time.sleep(0.02)


class Declines(Honest):
    def accepts(self, instance):
        return "it only likes prime numbers of tasks"
