"""How often `refined` is beaten where only vortices part the paths: random fields over open country.

Each field: a 20 km square, v0 = 20 m/s, one to five vortices of 3 to 8 m/s either way round, a uniform wind of up to
5 m/s, below 18 m/s in all; ten terminals, 90 ordered pairs. Best known: the cheapest of `refined` itself, of it on much
finer lattices with twelve and sixteen candidates, and of Dijkstra on 30 000 random samples with twice the radius.

    python tests/benchmarks/vortex_sides.py [--fields 40]

Before rivals around cores 4 of 3600 pairs were beaten by more than 2·10⁻⁴ (by 0.13, 0.39, 0.43 and 0.54 %), since then
none.
"""

from __future__ import annotations

import argparse
import itertools

import numpy as np

from formulations.moving_cost.method import Query
from formulations.moving_cost.registry import make_method
from instances.environment.region import Region
from instances.environment.wind import Uniform
from instances.environment.wind_table import Sum
from instances.environment.wind_vortices import Vortices

SIDE, SPEED, STRONGEST, MARGIN = 20_000.0, 20.0, 18.0, 2e-4
HEAVY = [
    make_method("refined", {"samples": 20_000, "slack": 0.1, "candidates": 12, "precision": 1e-7}),
    make_method("refined", {"samples": 6_000, "slack": 0.15, "candidates": 16, "precision": 1e-7}),
    make_method("dijkstra", {"samples": 30_000, "radius_factor": 2.0}),
]


def field(seed: int) -> Query | None:
    """Return the query of this seed, or None where its wind is too strong."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 6))
    centres, core = rng.uniform(2000, SIDE - 2000, (count, 2)), rng.uniform(800, 2500, count)
    fastest = rng.uniform(3, 8, count) * rng.choice([-1, 1], count)
    direction, steady = rng.uniform(0, 2 * np.pi), rng.uniform(0, 5)
    circulation = 4 * np.pi * core * fastest
    vortices = Vortices(tuple(map(tuple, centres.tolist())), tuple(circulation.tolist()), tuple(core.tolist()))
    wind = Sum((Uniform((steady * np.cos(direction), steady * np.sin(direction))), vortices))
    region = Region.rectangle(SIDE, SIDE)
    axis = np.linspace(0, SIDE, 161)
    if np.hypot(*wind(np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)).T).max() >= STRONGEST:
        return None
    return Query(region.sample(10, rng), region, wind, SPEED)


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fields", type=int, default=40)
    beaten = pairs = 0
    queries = ((seed, query) for seed in itertools.count() if (query := field(seed)) is not None)
    for seed, query in itertools.islice(queries, parser.parse_args().fields):
        off = ~np.eye(len(query.terminals), dtype=bool)
        found = make_method("refined").solve(query).cost[off]
        excess = found / np.min([found, *(method.solve(query).cost[off] for method in HEAVY)], axis=0) - 1
        beaten, pairs = beaten + int((excess > MARGIN).sum()), pairs + len(excess)
        print(f"field {seed}: largest excess {excess.max():.1e}; {beaten} of {pairs} pairs beaten so far", flush=True)


if __name__ == "__main__":
    main()
