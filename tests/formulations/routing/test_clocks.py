"""Costs that change with time: published optima with legs in closed form, brute force, and laws of clocks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.moving_cost.families import generate
from formulations.routing.clocks import arrival_home, clocks_of, knot_at
from formulations.routing.fewest_uavs import of_uavs
from formulations.routing.registry import make_solver
from formulations.routing.solver import Status
from formulations.routing.symmetries import shared_depots
from instances import Instance, Routes, Travel, check_routes, makespan, tour_costs
from instances.arrays import Floats
from instances.environment.wind_changing import Turning
from instances.wind_arrivals import quickest_times

Oracle = Callable[[Instance], tuple[float, Routes]]
Clocked = Callable[..., Instance]
OMEGA = np.pi / 2 / 3600
KNOWN = [
    (4, 2, 0, OMEGA, 20.0, 1914.336280),
    (8, 2, 0, OMEGA, 20.0, 2423.080874),
    (8, 2, 1, OMEGA, 20.0, 1792.459749),
    (8, 2, 0, OMEGA, 100.0, 371.975702),
    (8, 2, 1, OMEGA, 100.0, 316.115159),
    (8, 2, 0, 0.0, 20.0, 2340.500147),
    (10, 3, 0, OMEGA, 20.0, 1673.403511),
    (12, 2, 0, OMEGA, 20.0, 2330.855487),
    (12, 2, 0, 4 * OMEGA, 20.0, 1964.814788),
]
"""n, m, seed, turning [rad/s], airspeed [m/s] → optimum [s] of legs in closed form in 10 m/s of wind."""

SLACK = {"subset-dp": 1e-12, "branch-and-price": 2e-7}
"""Exact methods by the clock, and by what share routes may be longer than the optimum they prove."""


def optimum(n: int, m: int, seed: int, turning: float, airspeed: float) -> float:
    """Held–Karp on earliest arrivals of legs by Newton's method, no knots, all sets of one size at once."""
    points = np.random.default_rng(1000 * n + 100 * m + seed).uniform(0, 20000, (n + m, 2))
    wind, sets = Turning((10.0, 0.0), turning), np.arange(1 << n)
    sizes = np.array([bin(s).count("1") for s in sets])

    def flown(times: Floats, i: int, j: int) -> Floats:
        way = np.broadcast_to(points[j] - points[i], (len(times), 2))
        return times + quickest_times(way, times, wind, airspeed)

    tours = []
    for k in range(n, n + m):
        arrival = np.full((1 << n, n), np.inf)
        for j in range(n):
            arrival[1 << j, j] = flown(np.zeros(1), k, j)[0]
        for size in range(2, n + 1):
            for j in range(n):
                now = sets[(sizes == size) & (sets >> j & 1 == 1)]
                for i in range(n):
                    through = now[(now >> i & 1 == 1)] if i != j else now[:0]
                    there = flown(arrival[through ^ 1 << j, i], i, j)
                    arrival[through, j] = np.minimum(arrival[through, j], there)
        home = np.zeros(1 << n)
        home[1:] = np.inf
        for j in range(n):
            ended = sets[sets >> j & 1 == 1]
            home[ended] = np.minimum(home[ended], flown(arrival[ended, j], j, k))
        tours.append(home)
    best = tours[0]
    for home in tours[1:]:
        best = np.array([_best_split(int(s), best, home) for s in sets])
    return float(best[-1])


def _best_split(s: int, first: Floats, second: Floats) -> float:
    part, best = s, np.inf
    while True:
        best = min(best, max(first[s ^ part], second[part]))
        if part == 0:
            return float(best)
        part = (part - 1) & s


@pytest.mark.parametrize(("n", "m", "seed", "turning", "airspeed", "best"), KNOWN)
def test_published_optima(n: int, m: int, seed: int, turning: float, airspeed: float, best: float) -> None:
    """The oracle without knots to 1e-6 s; subset-dp on knots of the family, to what whole tours of these are off by."""
    if n <= 8:
        assert optimum(n, m, seed, turning, airspeed) == pytest.approx(best, abs=1e-6)
    instance = generate("wind-turning", n, m, seed, turning=np.degrees(turning) * 3600, airspeed=airspeed)
    result = make_solver("subset-dp").solve(instance, limits=Limits(time=60))
    assert result.status is Status.OPTIMAL
    assert result.objective == pytest.approx(best, rel=3e-4 if turning else 1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(("n", "m", "seed", "turning", "airspeed", "best"), [case for case in KNOWN if case[0] > 8])
def test_published_optima_of_more_tasks(
    n: int, m: int, seed: int, turning: float, airspeed: float, best: float
) -> None:
    assert optimum(n, m, seed, turning, airspeed) == pytest.approx(best, abs=1e-6)


def test_the_papers_energy_is_no_clock() -> None:
    """Keeping the cheapest way to a set and last task misses the optimum where energies change with time."""
    points, wind = np.random.default_rng(10).uniform(0, 20000, (6, 2)), Turning((10.0, 0.0), 4 * OMEGA)

    def leg(clock: float, i: int, j: int) -> tuple[float, float]:
        far = float(np.hypot(*(points[j] - points[i])))
        carried = np.diff(wind.displacement(np.array([clock, clock + far / 20])), axis=0)[0]
        return clock + far / 20, far / 20 - float(carried @ (points[j] - points[i])) / far / 20

    def energy(order: tuple[int, ...]) -> float:
        clock = spent = 0.0
        for i, j in zip((5, *order), (*order, 5), strict=True):
            clock, cost = leg(clock, i, j)
            spent += cost
        return spent

    labels: dict[tuple[frozenset[int], int], tuple[float, tuple[int, ...]]] = {
        (frozenset({j}), j): (leg(0.0, 5, j)[1], (j,)) for j in range(5)
    }
    for _ in range(4):
        longer: dict[tuple[frozenset[int], int], tuple[float, tuple[int, ...]]] = {}
        for (tasks, _), (_, order) in labels.items():
            for j in set(range(5)) - tasks:
                way = (*order, j)
                spent = energy(way) - leg(_clock(points, way), j, 5)[1]
                if spent < longer.get((tasks | {j}, j), (np.inf, ()))[0]:
                    longer[tasks | {j}, j] = spent, way
        labels = longer
    assert min(energy(order) for order in permutations(range(5))) == pytest.approx(2085.960769, abs=1e-6)
    assert min(energy(order) for _, order in labels.values()) == pytest.approx(2128.710962, abs=1e-6)


def _clock(points: Floats, order: tuple[int, ...]) -> float:
    """Return when the last of `order` is reached from node 5 at 20 m/s over ground [s]."""
    return float(np.hypot(*np.diff(points[[5, *order]], axis=0).T).sum() / 20)


def compared(name: str, clocked: Clocked, oracle: Oracle, cases: range) -> list[str]:
    """Return what a solver that proves says otherwise than enumeration."""
    solver, wrong = make_solver(name), []
    for seed in cases:
        rng = np.random.default_rng([7, seed])
        instance = clocked(int(rng.integers(2, 9 if seed % 10 == 0 else 7)), int(rng.integers(1, 4)), seed)
        best, _ = oracle(instance)
        result = solver.solve(instance, limits=Limits(time=60))
        if np.isinf(best):
            wrong += [] if result.status is Status.INFEASIBLE else [f"{instance.name}: {result.status}, no routes"]
        elif result.status is not Status.OPTIMAL or result.bound > best * (1 + 1e-12):  # type: ignore[operator]
            wrong.append(f"{instance.name}: {result.status}, bound {result.bound}, best {best}")
        elif not best * (1 - 1e-12) <= result.objective <= best * (1 + SLACK[name]):  # type: ignore[operator]
            wrong.append(f"{instance.name}: {result.objective}, bound {result.bound}, best {best}")
    return wrong


@pytest.mark.parametrize("name", SLACK)
def test_exact_methods_find_what_enumeration_finds(clocked: Clocked, brute_force: Oracle, name: str) -> None:
    assert compared(name, clocked, brute_force, range(1, 30)) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", SLACK)
def test_exact_methods_find_what_enumeration_finds_300_times(clocked: Clocked, brute_force: Oracle, name: str) -> None:
    assert compared(name, clocked, brute_force, range(300)) == []


def still(instance: Instance, knots: list[float]) -> Instance:
    """Return a static instance with a clock on which nothing changes."""
    cost = np.repeat(instance.cost[None, None], len(knots), axis=1)
    travel = Travel(cost, np.zeros(instance.n_depots, dtype=np.int64), np.array(knots))
    return Instance.of_travel("still", travel, instance.n_tasks)


@pytest.mark.parametrize("name", ["subset-dp", "greedy"])
def test_a_clock_on_which_nothing_changes_changes_nothing(windy: Clocked, name: str) -> None:
    solver, instance = make_solver(name), windy(9, 2, 0)
    first, second = (solver.solve(i, limits=Limits(time=60)) for i in (instance, still(instance, [0, 70, 100, 900])))
    assert first.objective == second.objective
    assert first.routes == second.routes


def test_knots_are_found_wherever_they_lie() -> None:
    knots = np.array([0.0, 1e-3, 5.0, 5.5, 400.0, 1000.0])
    cost = np.repeat((1.0 - np.eye(3))[None, None], len(knots), axis=1)
    clocks = clocks_of(Instance.of_travel("knots", Travel(cost, np.array([0]), knots), 2))
    times = np.concatenate([knots, np.random.default_rng(0).uniform(0, 1200, 300), [1e9]])
    found = [knot_at(clocks, float(t)) for t in times]
    assert found == (np.searchsorted(knots, times, side="right") - 1).tolist()


def test_kernels_fly_tours_as_the_independent_check_does(clocked: Clocked) -> None:
    for seed in range(20):
        instance = clocked(7, 2, seed)
        order = np.random.default_rng(seed).permutation(7)
        routes = tuple(tuple(part.tolist()) for part in np.split(order, [3]))
        flown = [arrival_home(clocks_of(instance), k, 7, np.array(route)) for k, route in enumerate(routes)]
        assert flown == pytest.approx(tour_costs(instance, routes), rel=1e-12)


def test_waiting_never_helps_the_makespan_but_endurance() -> None:
    """First in, first out: a later take-off is a later landing, though it may be a shorter flight."""
    instance = generate("wind-turning", 6, 1, 0, turning=360)
    assert instance.travel is not None
    travel, order = instance.travel, (0, 3, 1, 4, 2, 5)
    landings, flights = [], []
    for wait in np.linspace(0, 3600, 13):
        time = wait
        for i, j in zip((6, *order), (*order, 6), strict=True):
            time += float(np.interp(time, travel.departures, travel.cost[0, :, i, j]))
        landings.append(time)
        flights.append(time - wait)
    assert (np.diff(landings) > 0).all()
    assert min(flights) < 0.9 * flights[0]


def test_endurance_is_kept_by_the_clock(clocked: Clocked, brute_force: Oracle) -> None:
    instance = clocked(5, 2, 3)
    unlimited = replace(instance, endurance=None)
    lengths = tour_costs(unlimited, brute_force(unlimited)[1])
    tight = replace(instance, endurance=np.array([0.9 * lengths.max(), np.inf]))
    best, _ = brute_force(tight)
    result = make_solver("subset-dp").solve(tight, limits=Limits(time=60))
    assert result.routes is not None
    assert check_routes(tight, result.routes) == []
    assert makespan(tight, result.routes) == pytest.approx(best, rel=1e-12)


def test_fewer_uavs_keep_their_clock(clocked: Clocked) -> None:
    instance = clocked(5, 3, 3)
    fewer = of_uavs(instance, (2, 0))
    assert fewer.axes >= {"time"}
    assert tour_costs(fewer, ((0, 1), (2, 3, 4))) == pytest.approx(
        tour_costs(instance, ((2, 3, 4), (), (0, 1)))[[2, 0]]
    )
    assert sum(map(len, shared_depots(instance))) == 3
