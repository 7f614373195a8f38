"""Compiles every kernel, or loads it from numba's cache, so that no timed solve waits for that."""

from __future__ import annotations

import numpy as np

from formulations.routing.columns.cuts import separate
from formulations.routing.columns.fixing import fix_legs
from formulations.routing.columns.labelling import compile_beam, make_store
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.pool import Pool, list_tours
from formulations.routing.columns.pricing import DualBound, Duals, Effort, Pricer
from instances import Instance


def warm_up() -> None:
    """Use each kernel once, on six tasks in a circle."""
    compile_beam()
    angle = np.arange(7.0)
    place = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    place[6] = 0.0
    instance = Instance("circle", np.hypot(*(place[:, None] - place).transpose(2, 0, 1)), 6, 1)
    cap, tours = 10.0, [(0, 1, 2), (2, 3, 4), (0, 4, 5)]
    cuts = tuple(separate(tours, np.full(3, 0.9), 6, set(), 5)) or ((0, 2, 4),)
    duals = Duals(np.ones(6), np.ones(1), np.zeros(1), np.full(len(cuts), 0.1), cuts)
    pricer = Pricer(Legs.of(instance).under(cap), cap, Effort(2, 10, 5, 2), make_store(6, 10_000))
    at = DualBound(0.0, duals, np.array([pricer.price(0, duals, 0.0).least]))
    fix_legs(pricer, [0], at)
    pool, _ = list_tours(Pool.empty(1, 6), pricer, at, 10_000, 10_000)
    pool.needed(at, cap)
