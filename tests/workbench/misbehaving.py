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
from instances import Instance, Routes, compilation, makespan


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


class StreamsAFalseBound(Honest):
    proves: ClassVar[bool] = True

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        routes, value = told(instance, observe)
        observe(Event(0.0, value, 1.5 * value, None))
        return Result(Status.FEASIBLE, value, None, 0.0, routes, stopped_by="time")


class ClaimsInfeasible(Honest):
    """Says that there are no routes, beside routes where `routes`."""

    proves: ClassVar[bool] = True

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        return Result(Status.INFEASIBLE, None, None, 0.0, None, stopped_by="proof")


class ClaimsInfeasibleBesideRoutes(Honest):
    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        routes, value = told(instance, observe)
        return Result(Status.INFEASIBLE, value, None, 0.0, routes, stopped_by="proof")


@dataclass(frozen=True)
class Says(Honest):
    """Writes `line` into the pipe of messages, after its routes, as often as `times`."""

    line: str = ""
    times: int = 1

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        routes, value = told(instance, observe)
        line = self.line.encode("utf-8", "surrogateescape") + b"\n"
        for descriptor in range(3, 64):
            with contextlib.suppress(OSError):
                if not os.isatty(descriptor) and os.path.realpath(f"/proc/self/fd/{descriptor}").startswith("/proc"):
                    for _ in range(self.times):
                        os.write(descriptor, line)
        return Result(Status.FEASIBLE, value, None, 0.0, routes, stopped_by="finished")


@dataclass(frozen=True)
class Returns(Honest):
    """Returns honest routes with a field that is not."""

    field: str = ""
    value: str = ""

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        routes, value = told(instance, observe)
        result = Result(Status.FEASIBLE, value, None, 0.0, routes, stopped_by="finished")
        values = {"deep": nested(100_000), "large": {"x": [0.5] * 100_000}, "digits": 10**400, "lone": "\ud800"}
        object.__setattr__(result, self.field, values[self.value] if self.value in values else float(self.value))
        return result


def nested(depth: int) -> dict:
    table: dict = {}
    for _ in range(depth):
        table = {"in": table}
    return table


class LeavesProcesses(Honest):
    """Starts a process in a session of its own, and one whose parent has ended; both hold memory and spin."""

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        routes, value = told(instance, observe)
        ready, tell = os.pipe()
        if os.fork() == 0:
            os.setsid()
            if os.fork() == 0:
                os.setsid()
                os.write(tell, f"left {os.getpid()}\n".encode())
                spin()
            os.write(tell, f"left {os.getpid()}\n".encode())
            os._exit(0) if self.delay else spin()
        said = b""
        while said.count(b"\n") < 2:
            said += os.read(ready, 100)
        print(said.decode(), flush=True)
        time.sleep(self.delay)
        return Result(Status.FEASIBLE, value, None, 0.0, routes, stopped_by="finished")


def spin():
    held = b"x" * 100_000_000
    while held:
        pass


class GrandchildEatsMemory(Honest):
    """A process in another session, whose parent has ended, takes more and more."""

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        told(instance, observe)
        if os.fork() == 0:
            os.setsid()
            if os.fork():
                os._exit(0)
            eaten = []
            while True:
                eaten.append(os.urandom(20_000_000))
                time.sleep(0.01)
        os.wait()
        time.sleep(3600)


class KillsItsParent(Honest):
    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        told(instance, observe)
        if os.fork() == 0:
            os.setsid()
            print("left", os.getpid(), flush=True)
            time.sleep(3600)
        time.sleep(0.2)
        os.kill(os.getppid(), 9)
        time.sleep(3600)


class StopsItsParent(Honest):
    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        told(instance, observe)
        os.kill(os.getppid(), 19)
        time.sleep(3600)


class TurnsClocksBack(Honest):
    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        time.perf_counter = time.monotonic = time.time = lambda: -5000.0
        routes, value = told(instance, observe)
        time.sleep(0.3)
        return Result(Status.FEASIBLE, value, None, -5000.0, routes, stopped_by="finished")


class SpinsWhilePreparing(Honest):
    def prepare(self, instance):
        while True:
            pass


class DiesCompiling(Honest):
    def prepare(self, instance):
        compilation.begun()
        os._exit(3)
