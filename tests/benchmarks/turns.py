"""What routes that ignore turns lose, against the spacing ratio.

python tests/benchmarks/turns.py [TASKS UAVS SEEDS STEPS RATIO ...]

Both plans are flown over the same headings and were searched for by so many steps a task, four times as many without
turns; a line for each ratio and seed, as CSV. Loss: how much longer the plan without turns is; saved: how much shorter
the other one is; seconds of processor time of the search with turns.
"""

from __future__ import annotations

import sys
import time

from formulations.limits import Limits
from formulations.moving_cost.families import generate
from formulations.routing.search.memetic import Memetic
from formulations.routing.search.states.searching import straight_legs
from instances import objective

RATIOS = (0.6, 1.0, 1.6, 2.0, 3.2, 4.0, 6.0, 10.0)


def main(tasks: int = 40, uavs: int = 3, seeds: int = 2, steps: int = 2500, *ratios: float) -> None:
    """Print spacing, seed, both longest tours [s], loss and saving [%] and processor time [s]."""
    print("spacing,seed,decoupled,coupled,loss,saved,seconds")
    solver = Memetic()
    for ratio in ratios or RATIOS:
        for seed in range(seeds):
            instance = generate("dense-survey", tasks, uavs, seed, spacing=ratio)
            solver.prepare(instance)
            many, few = (Limits(time=3600.0, iterations=times * steps * tasks) for times in (4, 1))
            straight = solver.solve(straight_legs(instance), limits=many, seed=seed)
            began = time.process_time()
            coupled = solver.solve(instance, limits=few, seed=seed).objective
            took = time.process_time() - began
            assert straight.routes is not None
            assert coupled is not None
            decoupled = objective(instance, straight.routes)
            loss, saved = 100 * (decoupled / coupled - 1), 100 * (1 - coupled / decoupled)
            print(f"{ratio},{seed},{decoupled:.3f},{coupled:.3f},{loss:.2f},{saved:.2f},{took:.1f}", flush=True)


if __name__ == "__main__":
    words = sys.argv[1:]
    main(*map(int, words[:4]), *map(float, words[4:]))
