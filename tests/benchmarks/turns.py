"""What routes that ignore turns lose, against the spacing ratio.

python tests/benchmarks/turns.py [TASKS UAVS SECONDS SEEDS]

Both plans are flown over the same headings; a line for each ratio and seed, as CSV.
"""

from __future__ import annotations

import sys

from formulations.limits import Limits
from formulations.moving_cost.families import generate
from formulations.routing.search.memetic import Memetic
from formulations.routing.search.states.searching import straight_legs
from instances import objective

RATIOS = (0.6, 1.0, 1.6, 2.0, 3.2, 4.0, 6.0, 10.0)


def main(tasks: int = 40, uavs: int = 3, seconds: float = 10.0, seeds: int = 2) -> None:
    """Print spacing, seed, both longest tours [s] and the loss of the plan without turns [%]."""
    print("spacing,seed,decoupled,coupled,loss")
    solver = Memetic()
    for ratio in RATIOS:
        for seed in range(seeds):
            instance = generate("dense-survey", tasks, uavs, seed, spacing=ratio)
            solver.prepare(instance)
            straight = solver.solve(straight_legs(instance), limits=Limits(time=seconds), seed=seed)
            coupled = solver.solve(instance, limits=Limits(time=seconds), seed=seed, start=straight.routes).objective
            assert straight.routes is not None
            assert coupled is not None
            decoupled = objective(instance, straight.routes)
            print(f"{ratio},{seed},{decoupled:.3f},{coupled:.3f},{100 * (decoupled / coupled - 1):.2f}", flush=True)


if __name__ == "__main__":
    main(*(kind(word) for kind, word in zip((int, int, float, int), sys.argv[1:], strict=False)))
