"""Survey planners that misbehave, for tests: named as ``misflying:Class``. On the paper's square."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from formulations.surveying.problem import SurveyPlanner, readings

MIDDLE = np.array([10_000.0, 10_000.0])


@dataclass(frozen=True)
class Honest(SurveyPlanner):
    """Flies towards the middle and back; `delay` [s] of sleep makes it slow."""

    delay: float = 0.0

    def plan(self, problem, sensor, *, limits, seed):
        time.sleep(self.delay)
        self.misbehave()
        return [self.towards(problem, depot, 0.499) for depot in problem.depots]

    def misbehave(self):
        pass

    def towards(self, problem, depot, share):
        way = MIDDLE - depot
        return np.stack([depot, depot + share * problem.length * way / np.hypot(*way), depot])


class Liar(Honest):
    """Flies farther than it may."""

    def plan(self, problem, sensor, *, limits, seed):
        return [self.towards(problem, depot, 0.6) for depot in problem.depots]


class Stray(Honest):
    """Leaves the region on the way."""

    def plan(self, problem, sensor, *, limits, seed):
        return [self.towards(problem, depot, -0.499) for depot in problem.depots]


class Lost(Honest):
    """Does not come home."""

    def plan(self, problem, sensor, *, limits, seed):
        return [self.towards(problem, depot, 0.499)[:2] for depot in problem.depots]


class Elsewhere(Honest):
    """Reads, in flight, where it does not fly."""

    def plan(self, problem, sensor, *, limits, seed):
        sensor.read(0, 1, MIDDLE)
        return super().plan(problem, sensor, limits=limits, seed=seed)


class Backwards(Honest):
    """Reads what is to come before what has been."""

    def plan(self, problem, sensor, *, limits, seed):
        tours = super().plan(problem, sensor, limits=limits, seed=seed)
        for tick in (2, 1):
            sensor.read(0, tick, readings(tours[0], problem.spacing)[tick - 1])
        return tours


class Asks(Honest):
    """Reads all that it flies past, in order."""

    def plan(self, problem, sensor, *, limits, seed):
        tours = super().plan(problem, sensor, limits=limits, seed=seed)
        places = [readings(tour, problem.spacing) for tour in tours]
        for tick in range(len(places[0])):
            for uav, at in enumerate(places):
                sensor.read(uav, tick + 1, at[tick])
        return tours


class Idle(Honest):
    """Stays home."""

    def plan(self, problem, sensor, *, limits, seed):
        return [np.empty((0, 2)) for _ in problem.depots]


class Crashes(Honest):
    def misbehave(self):
        raise RuntimeError("the dog ate the propeller")


class Hangs(Honest):
    def misbehave(self):
        time.sleep(3600)


class EatsMemory(Honest):
    def misbehave(self):
        eaten = []
        while True:
            eaten.append(b"x" * 20_000_000)
            time.sleep(0.02)
