"""What a generator family is: parameters with units, a region, where its tasks lie, what legs are."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from instances.arrays import Floats
from instances.environment.region import Region
from instances.errors import InputError
from instances.families.depots import place_depots
from instances.families.parameter import Parameter, Values
from instances.families.winds import make_wind
from instances.registry import refuse_unknown
from instances.scenario import Scenario


class Legs(Enum):
    """What the legs of a family's instances are: from this `formulations.moving_cost` knows how to cost them."""

    OPEN = "the cheapest paths over open country, which may leave the region"
    STRAIGHT = "straight lines, whatever the wind"
    INSIDE = "the cheapest paths inside the region, around its no-fly zones"
    TURNS = "Dubins paths between headings, in calm air or a steady wind"


@dataclass(frozen=True)
class Family:
    """One generator family: it makes Scenarios."""

    name: str
    parameters: tuple[Parameter, ...]
    region: Callable[[Values], Region]
    """Parameters → the region."""
    tasks: Callable[[Region, int, np.random.Generator, Values], Floats]
    """Region, n, random numbers, parameters → task points (n, 2) [m]."""
    legs: Legs = Legs.OPEN

    def values(self, given: Mapping[str, Any]) -> Values:
        """Return every parameter's value, `given` ones checked, others by default; InputError with the near miss."""
        old = {p.formerly: p.name for p in self.parameters if p.formerly}
        refuse_unknown(f"family {self.name}", "parameter", given, [*(p.name for p in self.parameters), *old])
        for before, now in old.items():
            if before in given and now in given:
                raise InputError(f"family {self.name}: {before} is an old name of {now}: give {now} alone")
        named = {old.get(name, name): value for name, value in given.items()}
        try:
            return {p.name: p.checked(named.get(p.name, p.default)) for p in self.parameters}
        except InputError as error:
            raise InputError(f"family {self.name}: {error}") from None

    def scenario(self, n_tasks: int, n_depots: int, seed: int, given: Mapping[str, Any]) -> Scenario:
        """Return the mission of this size and seed; tasks and depots come from separate streams of random numbers."""
        values = self.values(given)
        region = self.region(values)
        for_tasks, for_depots = map(np.random.default_rng, np.random.SeedSequence(seed).spawn(2))
        blows = [] if values["wind"] == "none" else [f"{values['wind']}-wind"]
        depots = [] if values["depots"] == "spread" else [f"{values['depots']}-depots"]
        wind = make_wind(region, values)
        provenance: dict[str, Any] = {"family": self.name, "parameters": values, "seed": seed}
        if self.legs is Legs.INSIDE:  # for pictures: costs do not say what legs flew around
            provenance["surroundings"] = {"region": [ring.tolist() for ring in region.rings]}
            provenance["surroundings"] |= {} if wind is None else {"wind": wind.to_toml()}
        return Scenario(
            name="-".join([self.name, *blows, *depots, f"n{n_tasks}", f"m{n_depots}", f"s{seed}"]),
            region=region,
            depots=place_depots(region, n_depots, for_depots, values),
            speed=values["ground_speed"],
            wind=wind,
            tasks=self.tasks(region, n_tasks, for_tasks, values),
            provenance=provenance,
        )
