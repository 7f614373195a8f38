"""Small worlds to re-plan in: a calm square of 8 km, three UAVs, smooth fields."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from formulations.kernel import SquaredExponential
from formulations.mapping.flight import Flight, plan_flight
from formulations.mapping.flight_check import margin
from formulations.mapping.map_model import MapModel
from formulations.replanning.aloft import Aloft, World
from formulations.replanning.replan import Planner
from formulations.replanning.ways import Ways
from instances.arrays import Floats
from instances.environment.region import Region
from instances.environment.wind import Uniform, WindField
from instances.moving_cost import CostKind, CostMeasure

SIDE, SPEED, RADIUS = 8000.0, 100.0, 50.0
SQUARE = Region.rectangle(SIDE, SIDE)
HOMES = np.array([[4000.0, 7500.0], [500.0, 500.0], [7500.0, 500.0]])
CALM = Uniform((0.0, 0.0))


def world(region: Region = SQUARE, wind: WindField = CALM, kind: CostKind = CostKind.ENERGY) -> World:
    """Return a world whose flights must stay in `region`."""

    def allowed(flights: list[Flight], rests: list[Flight]) -> str:
        room = min((margin(rest, region).distance for rest in rests if rest.length > 0), default=0.0)
        return f"{-room:.0f} m outside" if room < -0.05 else ""

    turns = Region(region.polygon.buffer(-2 * RADIUS))
    return World(Ways(turns, CostMeasure(kind, wind, SPEED)), turns, region.polygon, allowed)


def aloft(rng: np.random.Generator, endurance: float, per_uav: int = 3) -> Aloft:
    """Return UAVs at take-off, each with random tasks in random order."""
    flights, tasks = [], []
    for home in HOMES:
        own = rng.uniform(300.0, SIDE - 300.0, (per_uav, 2))
        stops = np.concatenate([[home], own, [home]])
        legs = [np.array(leg) for leg in pairwise(stops)]
        flights.append(plan_flight(legs, speed=SPEED, radius=RADIUS, within=SQUARE.polygon))
        tasks.append(own)
    return Aloft(flights, tasks, HOMES, np.full(3, endurance))


def planner(length: float = 2000.0, polish: bool = False) -> Planner:
    """Return a planner that believes in one length scale [m]."""
    kernel = SquaredExponential(30.0, (length, length))
    points = SQUARE.cell_centres(8, 8)
    return Planner(MapModel(kernel), 1.0, 5.0, points, points, polish=polish)


def field(points: Floats) -> Floats:
    """Return a smooth field at `points` (k, 2) [m]."""
    x, y = points.T
    return 30.0 * np.sin(x / 900.0) * np.cos(y / 1100.0)
