"""What a generator family is: a description, parameters with units, a region, and where its tasks lie in it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from instances.arrays import Floats
from instances.environment.region import Region
from instances.errors import InputError, suggestion
from instances.families.depots import place_depots
from instances.families.parameter import Parameter, Values
from instances.families.winds import make_wind
from instances.instance import Instance
from instances.metrics import metric_cost
from instances.scenario import Scenario


@dataclass(frozen=True)
class Family:
    """One generator family, with moving costs in closed form."""

    name: str
    description: str
    parameters: tuple[Parameter, ...]
    region: Callable[[Values], Region]
    """Parameters → the region."""
    tasks: Callable[[Region, int, np.random.Generator, Values], Floats]
    """Region, n, random numbers, parameters → task points (n, 2) [m]."""
    walls: bool = False
    """Whether legs keep inside the region (`corner_paths`) or fly over open country (`closed_form`)."""

    def values(self, given: Mapping[str, Any]) -> Values:
        """Return every parameter's value, `given` ones checked, others by default; InputError with the near miss."""
        known = [p.name for p in self.parameters]
        for name in given:
            if name not in known:
                have = f" (it has: {', '.join(known)})" if known else " (it has none)"
                raise InputError(f"family {self.name} has no parameter '{name}'{suggestion(name, known)}{have}")
        try:
            return {p.name: p.checked(given.get(p.name, p.default)) for p in self.parameters}
        except InputError as error:
            raise InputError(f"family {self.name}: {error}") from None

    def scenario(self, n_tasks: int, n_depots: int, seed: int, given: Mapping[str, Any]) -> Scenario:
        """Return the mission of this size and seed; tasks and depots come from separate streams of random numbers."""
        values = self.values(given)
        region = self.region(values)
        for_tasks, for_depots = map(np.random.default_rng, np.random.SeedSequence(seed).spawn(2))
        wind = [] if values["wind"] == "none" else [f"{values['wind']}-wind"]
        depots = [] if values["depots"] == "spread" else [f"{values['depots']}-depots"]
        return Scenario(
            name="-".join([self.name, *wind, *depots, f"n{n_tasks}", f"m{n_depots}", f"s{seed}"]),
            region=region,
            depots=place_depots(region, n_depots, for_depots, values),
            airspeed=values["airspeed"],
            wind=make_wind(region, values),
            tasks=self.tasks(region, n_tasks, for_tasks, values),
            provenance={"family": self.name, "parameters": values, "seed": seed},
        )

    def instance(self, scenario: Scenario) -> Instance:
        """Return the scenario of this family with its moving costs in closed form [s]."""
        metric: dict[str, Any] = {
            "metric": "wind",
            "airspeed": scenario.airspeed,
            "wind": None if scenario.wind is None else scenario.wind.to_toml(),
        }
        if self.walls:
            metric["region"] = [ring.tolist() for ring in scenario.region.rings]
        points = scenario.points
        return Instance(
            scenario.name,
            metric_cost(metric, points),
            scenario.n_tasks,
            scenario.n_depots,
            points,
            {**scenario.provenance, "metric": metric},
        )
