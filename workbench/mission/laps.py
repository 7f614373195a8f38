"""Laps: how often each UAV flies its tour, and which way round where the field drifts.

`[flight] laps` is a number, or "endurance": as often as the UAV's endurance lasts. All laps together cost no more than
it. A lap is turned where that promises a better map at the end (`formulations.mapping.directions`), as far as it is
free: within the endurance, and no UAV's laps costing more than the longest did.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from formulations.mapping.directions import Directions, choose_directions
from formulations.mapping.flight import Flight
from instances import Instance, Routes
from instances.arrays import Bools, Floats
from instances.disk import read_json
from instances.errors import InputError
from instances.routes import ENDURANCE_ROUNDING, tour_costs
from instances.scenario import Scenario
from workbench.mission.belief import map_model_of
from workbench.mission.settings import MOST_LAPS, Mission

LAPS_FILE = "laps.json"


@dataclass(frozen=True, eq=False)
class Laps:
    """Which laps each UAV turns, one entry a lap, and √J by them and with none turned; None where that is not known."""

    turned: Directions
    sd: float | None = None
    unturned_sd: float | None = None

    def tours(self, routes: Routes) -> list[list[tuple[int, ...]]]:
        """Return of each UAV its laps in order, each its tasks in flying order."""
        return [
            [route[::-1] if turn else route for turn in turned]
            for route, turned in zip(routes, self.turned, strict=True)
        ]

    def said(self) -> list[str]:
        """Return sentences for people; none where every tour is flown once and no more is known."""
        counts = [len(turned) for turned in self.turned]
        words = [] if max(counts, default=1) <= 1 else [f"{', '.join(map(str, counts))} laps"]
        if self.sd is not None:
            turned = sum(int(each.sum()) for each in self.turned)
            words.append(
                f"{turned} of {sum(counts)} laps turned for what decays: rms sd {self.sd:.3g} at the end, "
                f"{self.unturned_sd:.3g} with none turned"
            )
        return words

    def to_json(self) -> dict[str, Any]:
        """Return the laps as JSON values."""
        return {"turned": [each.tolist() for each in self.turned], "sd": self.sd, "unturned_sd": self.unturned_sd}

    @property
    def plain(self) -> bool:
        """Whether every UAV flies its tour once, as it was routed."""
        return all(len(turned) <= 1 and not turned.any() for turned in self.turned)


def laps_of(mission: Mission, instance: Instance, routes: Routes) -> Laps:
    """Return how often each UAV flies its tour; InputError where that is more than its endurance, naming it."""
    wanted, limits = mission.flight.laps, limits_of(mission, instance)
    counts = []
    for uav, cost in enumerate(tour_costs(instance, routes)):
        lasting = limits[uav] * (1 + ENDURANCE_ROUNDING) / cost if cost > 0 else 0.0
        count = (math.floor(min(lasting, MOST_LAPS + 1)) if wanted == "endurance" else wanted) if cost > 0 else 0
        if count > MOST_LAPS:
            raise InputError(f'flight.laps = "endurance": UAV {uav} could fly its tour more than {MOST_LAPS} times')
        if cost > 0 and not 1 <= count <= lasting:
            raise InputError(
                f"flight.laps = {wanted!r}: {max(count, 1)} × {cost:.1f} s is more than UAV {uav}'s endurance of "
                f"{limits[uav]:.1f} s"
            )
        counts.append(count)
    return Laps(tuple(np.zeros(count, dtype=bool) for count in counts))


def limits_of(mission: Mission, instance: Instance) -> Floats:
    """Return what all laps of each UAV may cost [s], shape (m,)."""
    return np.minimum(instance.limits, mission.flight.endurance or np.inf)


def directed(
    mission: Mission, scenario: Scenario, instance: Instance, routes: Routes, flights: Sequence[Flight]
) -> Laps:
    """Return the laps of each UAV over its tour in `flights`, those turned that promise a better map at the end.

    None is where the mission does not say how fast its field drifts.
    """
    laps = laps_of(mission, instance, routes)
    model = map_model_of(mission)
    if not model.tau < math.inf:
        return laps
    there, back = tour_costs(instance, routes), tour_costs(instance, [route[::-1] for route in routes])
    most = np.minimum(limits_of(mission, instance), _totals(laps.turned, there, back).max())

    def allowed(directions: Directions) -> bool:
        return bool((_totals(directions, there, back) <= most * (1 + ENDURANCE_ROUNDING)).all())

    chosen = choose_directions(
        flights,
        [len(turned) for turned in laps.turned],
        scenario.region.cell_centres(*mission.place.tests),
        model=model,
        noise_sd=mission.sensing.noise_sd,
        period=mission.sensing.period,
        allowed=allowed,
    )
    return Laps(chosen.directions, chosen.sd, chosen.unturned_sd)


def _totals(turned: Sequence[Bools], there: Floats, back: Floats) -> Floats:
    """Return what all laps of each UAV cost [s], of which one costs `there` or, turned, `back`, shape (m,)."""
    backward = np.array([each.sum() for each in turned])
    forward = np.array([len(each) for each in turned]) - backward
    return np.where(forward > 0, forward * there, 0.0) + np.where(backward > 0, backward * back, 0.0)


def kept_laps(folder: Path) -> int:
    """Return how often the UAVs that fly fly their tours, on average, as the flight stage kept it."""
    path = folder / LAPS_FILE
    if not path.exists():
        return 1
    counts = [len(each) for each in read_json(path)["turned"]]
    return max(1, round(sum(counts) / max(1, sum(count > 0 for count in counts))))
