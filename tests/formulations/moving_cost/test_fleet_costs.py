"""Moving costs of fleets: exact optima, confirmed paths of every class, and what has no potential."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.moving_cost.costing import instance_of
from formulations.moving_cost.families import generate
from formulations.moving_cost.fleet import leg_costs
from formulations.routing.subset_dp import SubsetDp
from instances import InputError, Instance
from instances.environment.region import Region
from instances.environment.wind import Rotation, Uniform
from instances.files import read_instance
from instances.fleet import Fleet, Return
from instances.paths import paths_file, read_paths
from instances.scenario import Scenario
from workbench.planning import plan, refute, write_plan

POINTS = np.random.default_rng(6200).uniform(0, 20000, (8, 2))
SCENARIO = Scenario("s", Region.rectangle(20000, 20000), POINTS[6:], 20.0, tasks=POINTS[:6])
KNOWN = {  # confirmed by enumeration elsewhere
    "alike": (Fleet(), 1977.104849),
    "service": (Fleet(service=60.0 * np.arange(1, 7)), 2457.104849),
    "open": (Fleet(returns=Return.NONE), 1126.196501),
    "any depot": (Fleet(returns=Return.ANY), 1972.513456),
    "speeds": (Fleet(speeds=np.array([20.0, 30.0])), 1354.868711),
    "endurance": (Fleet(endurance=np.array([2700.0, 1000.0])), 2341.116923),
}


FEW = {"samples": 50}


def optimum(instance: Instance) -> float | None:
    return SubsetDp().solve(instance, limits=Limits(time=60)).objective


@pytest.mark.parametrize("case", KNOWN)
def test_exact_values(case: str) -> None:
    fleet, value = KNOWN[case]
    instance, _ = instance_of(replace(SCENARIO, fleet=fleet), "closed-form")
    assert optimum(instance) == pytest.approx(value, abs=1e-6)


@pytest.mark.parametrize(
    ("n", "m", "seed", "slowest", "value"),
    [(8, 2, 0, 20, 1203.922087), (12, 3, 0, 20, 1094.343181), (12, 3, 1, 20, 1162.337208), (14, 2, 0, 18, 1543.266884)],
)
def test_the_family_has_the_known_optima(n: int, m: int, seed: int, slowest: float, value: float) -> None:
    assert optimum(generate("mixed-fleet", n, m, seed, slowest=slowest)) == pytest.approx(value, abs=1e-6)


def test_the_family_gives_endurance_and_names_speeds_that_do_not_fit() -> None:
    assert generate("mixed-fleet", 4, 2, 0, endurance=900).limits.tolist() == [900, 900]
    with pytest.raises(InputError, match="fastest must be at least slowest = 20 m/s, got 15"):
        generate("mixed-fleet", 4, 2, 0, fastest=15)


def test_service_keeps_symmetric_costs_symmetric() -> None:
    scenario = replace(SCENARIO, fleet=Fleet(service=60.0 * np.arange(1, 7)))
    costs = instance_of(scenario, "closed-form")[0].cost
    assert (costs == costs.T).all()
    assert costs[6, 0] + costs[0, 6] - 2 * instance_of(SCENARIO, "closed-form")[0].cost[0, 6] == pytest.approx(60)


FLEET = Fleet(np.array([30.0, 20.0]), np.array([np.inf, 3000.0]), 30.0, Return.ANY)


def test_paths_of_every_class_are_confirmed_kept_and_refuted(tmp_path: Path) -> None:
    scenario = replace(SCENARIO, wind=Uniform((6.0, -3.0)), fleet=FLEET)
    instance, paths = plan(scenario, "closed-form")
    assert len(paths.others) == 1
    write_plan(instance, paths, tmp_path / "s.json", tmp_path / "s.toml")
    again = read_instance(tmp_path / "s.json")
    kept = read_paths(paths_file(tmp_path / "s.json"), again)
    assert (again.digest, refute(again, kept, scenario)) == (instance.digest, [])
    assert "paths for 1 speeds" in refute(instance, replace(paths, others=()), scenario)[0]
    slower = replace(scenario, fleet=replace(FLEET, speeds=np.array([30.0, 19.0])))
    assert "not the" in refute(instance, paths, slower)[0]
    assert refute(instance, paths, replace(scenario, fleet=replace(FLEET, service=20.0)))
    assert refute(instance, paths, replace(scenario, fleet=replace(FLEET, returns=Return.OWN)))


def test_a_wind_stronger_than_the_uavs_needs_closed_tours() -> None:
    windy = replace(SCENARIO, wind=Uniform((40.0, 0.0)))
    speeds = Fleet(speeds=np.array([30.0, 20.0]))
    mixed, _ = plan(replace(windy, fleet=speeds), "dijkstra", FEW)
    calm, _ = plan(replace(SCENARIO, fleet=speeds), "dijkstra", FEW)
    assert np.shape(mixed.provenance["node_potential"]) == (2, 8)
    assert optimum(mixed) == pytest.approx(optimum(calm), rel=1e-9), "a uniform wind changes no closed tour"
    with pytest.raises(InputError, match="not with return = 'none'"):
        instance_of(replace(windy, fleet=Fleet(returns=Return.NONE)), "dijkstra", FEW)


def test_legs_of_the_plain_fleet_are_those_of_the_paths() -> None:
    cost = Rotation(1e-4, (0.0, 0.0))(POINTS)[:, :1] @ np.ones((1, 8))
    assert (leg_costs(SCENARIO, cost) == cost).all()
