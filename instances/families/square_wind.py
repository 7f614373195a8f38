"""The family `square-wind`: random asymmetric instances with straight legs and published optima.

Tasks and depots P uniform in a 20 km square; v0 = 20 m/s; wind (4, −2) m/s plus a rigid rotation of 5·10⁻⁴ 1/s about
the centre. With Q = P − 10 km, straight legs i → j cost

    c_ij = |Q_j − Q_i|/v0 − (4, −2)·(Q_j − Q_i)/v0² − 5·10⁻⁴ (Q_i × Q_j)/v0².

The random numbers are those of ``numpy.random.default_rng(1000·n + 100·m + seed)``, tasks first, so that published
optima of these instances can be compared with. The two winds add up to one rotation about (14, 18) km.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from instances.arrays import Floats
from instances.environment.region import Region
from instances.environment.wind import Rotation
from instances.families.family import Family, Legs
from instances.families.square import uniform_tasks
from instances.scenario import Scenario

SIZE = 20_000.0
GROUND_SPEED = 20.0
VELOCITY = (4.0, -2.0)
RATE = 5e-4

WIND = Rotation(RATE, (SIZE / 2 - VELOCITY[1] / RATE, SIZE / 2 + VELOCITY[0] / RATE))
"""The sum of the uniform wind and the rotation."""


def points(n_tasks: int, n_depots: int, seed: int) -> Floats:
    """Return tasks, then depots, shape (n+m, 2) [m]."""
    rng = np.random.default_rng(1000 * n_tasks + 100 * n_depots + seed)
    return rng.uniform(0, SIZE, (n_tasks + n_depots, 2))


class SquareWind(Family):
    """The family as published: no parameters, one stream of random numbers."""

    def scenario(self, n_tasks: int, n_depots: int, seed: int, given: Mapping[str, Any]) -> Scenario:
        """Return the mission of this size and seed."""
        values = self.values(given)
        p = points(n_tasks, n_depots, seed)
        return Scenario(
            name=f"{self.name}-n{n_tasks}-m{n_depots}-s{seed}",
            region=self.region(values),
            depots=p[n_tasks:],
            speed=GROUND_SPEED,
            wind=WIND,
            tasks=p[:n_tasks],
            provenance={"family": self.name, "parameters": values, "seed": seed},
        )


SQUARE_WIND = SquareWind("square-wind", (), lambda values: Region.rectangle(SIZE, SIZE), uniform_tasks, Legs.STRAIGHT)
