"""From a Scenario whose UAVs have turning radii to an Instance between headings.

    c_g[(i, a), (j, b)] = L_g((P_i, h_a) → (P_j, h_b)) / v_g + (s_i + s_j)/2

for each class g of UAVs with one radius and speed, s the time spent at a task. What is minimised is the flight time: in
calm air that is the paper's cost, and in a uniform wind it is asked for by cost = "time". A leg that leaves the region
or enters a no-fly zone cannot be flown: it costs +inf.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from shapely.geometry import Polygon

from formulations.moving_cost.turns.headings import headings
from formulations.moving_cost.turns.tracks import kept_inside
from formulations.moving_cost.turns.travel import Turns, said_of
from instances import Instance, Travel
from instances.arrays import Floats, Ints
from instances.environment.wind import Uniform
from instances.errors import InputError
from instances.fleet import Return
from instances.moving_cost import CostKind
from instances.scenario import Scenario


@dataclass(frozen=True)
class HeadingOptions:
    """Which headings nodes have (`headings.headings`).

    depots : "free", any headings at take-off and landing; "own", those that tasks have, any two of them; "closed", one
        of these for both.
    """

    uniform: int = 16
    sights: int = 0
    tangents: int = 0
    depots: str = "free"


def steady_wind(scenario: Scenario) -> tuple[float, float]:
    """Return the wind [m/s] that legs between headings are flown in; InputError where these are not known in it."""
    if scenario.wind is None:
        return (0.0, 0.0)
    if not isinstance(scenario.wind, Uniform):
        raise InputError(
            "[wind]: legs between headings are known in calm air and in a uniform wind (kind = 'uniform') alone"
        )
    if scenario.cost is not CostKind.TIME:
        raise InputError(
            "cost = 'energy' in wind: legs between headings cost the time they are flown in; give cost = 'time' and an "
            "airspeed"
        )
    return scenario.wind.velocity


def fleet_turns(scenario: Scenario) -> tuple[list[Turns], Ints]:
    """Return how the UAVs turn, each kind once, in the order of the UAVs; and the kind of each UAV (m,)."""
    fleet, wind, m = scenario.fleet, steady_wind(scenario), scenario.n_depots
    assert fleet.turning_radii is not None
    speeds = np.full(m, scenario.speed) if fleet.speeds is None else fleet.speeds
    each = [Turns(r, v, wind) for r, v in zip(fleet.turning_radii.tolist(), speeds.tolist(), strict=True)]
    kinds = list(dict.fromkeys(each))
    return kinds, np.array([kinds.index(turns) for turns in each])


def between_headings(
    scenario: Scenario,
    options: HeadingOptions,
    room: Polygon | None = None,
    also: tuple[Ints, Floats] | None = None,
) -> Instance:
    """Return the instance between headings of a scenario with turning radii.

    room : where legs must stay, over open country unless given; depots then have headings of their own. also : nodes
    (k,) and headings (k,) [rad] that they have besides. InputError for tours that need not end at their own depot, and
    for a wind in which no such legs are known.
    """
    if scenario.fleet.returns is not Return.OWN:
        raise InputError(
            f"return = '{scenario.fleet.returns}': legs between headings lead home to the own depot; leave return or "
            "turning_radius out"
        )
    if options.depots == "free" and room is not None:
        raise InputError("legs are checked against a region between given headings: free ones at depots have none")
    kinds, classes = fleet_turns(scenario)
    points, n = scenario.points, scenario.n_tasks
    states = headings(
        points,
        n,
        uniform=options.uniform,
        sights=options.sights,
        tangents=options.tangents,
        free_depots=options.depots == "free",
        drift=kinds[0].drift,  # a faster UAV heads into the wind a little less: its sights are nearly these
    )
    if also is not None:
        states = states.also(*also)
    lengths = [turns.lengths(points, states) for turns in kinds]
    if room is not None:
        lengths = [kept_inside(each, points, states, turns, room) for each, turns in zip(lengths, kinds, strict=True)]
    half = np.zeros(len(points))
    half[:n] = np.asarray(scenario.fleet.service) / 2
    waits = half[states.nodes][:, None] + half[states.nodes][None, :]
    waits[states.nodes[:, None] == states.nodes[None, :]] = 0.0
    costs = np.stack([each / turns.speed + waits for each, turns in zip(lengths, kinds, strict=True)])
    travel = Travel(costs[:, None], classes, nodes=states.nodes, closed=options.depots == "closed")
    said = {} if np.any(half) or len(kinds) > 1 else said_of(kinds[0], states)
    return Instance.of_travel(
        scenario.name,
        travel,
        n,
        coordinates=points,
        provenance={**scenario.provenance, **said},
        endurance=scenario.fleet.endurance,
    )
