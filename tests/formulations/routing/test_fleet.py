"""Fleets and endurance: exact values, brute force, and who cannot take what."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing.registry import SOLVERS, make_solver
from formulations.routing.solver import ABLE, Status, refusal
from instances import Instance, Routes, Travel, check_routes, tour_costs
from instances.arrays import Floats

Oracle = Callable[[Instance], tuple[float, Routes]]
Case = tuple[int, int, int]
EXACT = [
    name for name in sorted(SOLVERS.targets()) if SOLVERS.why_unavailable(name) is None and make_solver(name).proves
]


def straight(n: int, m: int, seed: int) -> Floats:
    places = np.random.default_rng(1000 * n + 100 * m + seed).uniform(0, 20000, (n + m, 2))
    return np.hypot(*(places[:, None] - places).transpose(2, 0, 1))


def fleet(costs: list[Floats], n: int, endurance: tuple[float, ...] | None = None) -> Instance:
    return Instance.of_travel("fleet", Travel.of_uavs(costs), n, endurance=endurance)


def forbidden(cost: Floats, task: int) -> Floats:
    without = cost.copy()
    without[task, :] = without[:, task] = np.inf
    without[task, task] = 0.0
    return without


def known_values() -> dict[str, tuple[Instance, float]]:
    """Return instances with their optima, confirmed by enumeration elsewhere."""
    d = straight(6, 2, 0)
    c = d / 20
    return {
        "alike": (fleet([c, c], 6), 1977.104849),
        "speeds 20, 30": (fleet([d / 20, d / 30], 6), 1354.868711),
        "speeds 30, 20": (fleet([d / 30, d / 20], 6), 1357.637417),
        "a task forbidden": (fleet([forbidden(c, 0), c], 6), 2020.784033),
        "endurance 3000, 1500": (fleet([c, c], 6, (3000, 1500)), 2036.456126),
        "endurance 2200, 1300": (fleet([c, c], 6, (2200, 1300)), 2036.456126),
        "endurance 2700, 1000": (fleet([c, c], 6, (2700, 1000)), 2341.116923),
        "endurance 2000, 1200": (fleet([c, c], 6, (2000, 1200)), np.inf),
        "share of the endurance": (fleet([c / 2000, c / 1200], 6), 1.047950),
    }


@pytest.mark.parametrize("case", known_values())
@pytest.mark.parametrize("name", EXACT)
def test_known_values(name: str, case: str) -> None:
    solver = make_solver(name)
    instance, optimum = known_values()[case]
    if reason := refusal(solver, instance):
        pytest.skip(reason)
    solver.prepare(instance)
    result = solver.solve(instance, limits=Limits(time=60))
    if np.isinf(optimum):
        assert result.status is Status.INFEASIBLE
    else:
        assert result.status is Status.OPTIMAL
        assert result.objective == pytest.approx(optimum, abs=1e-6)


@pytest.mark.parametrize("share", [1 - 3e-7, 1 - 1e-8, 1 - 5e-10, 1.0])
@pytest.mark.parametrize("name", EXACT)
def test_endurance_is_exact_at_the_boundary(
    windy: Callable[..., Instance], held_karp: Oracle, name: str, share: float
) -> None:
    """Optimal tours stay if they just fit; a hair less, finer than what an engine works in, forbids them."""
    solver, base = make_solver(name), windy(6, 2, 1)
    lengths = tour_costs(base, held_karp(base)[1])
    instance = replace(base, endurance=np.maximum(lengths, 1.0) * share)
    if reason := refusal(solver, instance):
        pytest.skip(reason)
    optimum, _ = held_karp(instance)
    assert np.isinf(optimum) == (share < 1 - 1e-9), "all other routes are longer"
    result = solver.solve(instance, limits=Limits(time=60))
    assert result.status is (Status.INFEASIBLE if np.isinf(optimum) else Status.OPTIMAL)
    loose = replace(base, endurance=[lengths[0] * share, np.inf])
    result, (optimum, _) = solver.solve(loose, limits=Limits(time=60)), held_karp(loose)
    assert result.objective == pytest.approx(optimum, abs=result.tolerance)
    assert check_routes(loose, result.routes or ()) == []


def test_who_lacks_an_axis_says_who_has_it() -> None:
    instance = known_values()["speeds 20, 30"][0]

    class Plain:
        proves = False

        def accepts(self, instance: Instance) -> str | None:
            return None

    assert refusal(Plain(), instance) == (  # type: ignore[arg-type]
        f"the instance has UAVs that differ ('fleet'), which this solver cannot take; {ABLE['fleet']}"
    )


def random_fleets(count: int) -> list[Case]:
    rng = np.random.default_rng(20)
    return [(int(rng.integers(2, 9)), int(rng.integers(1, 4)), seed) for seed in range(count)]


def disagreements(
    name: str, cases: list[tuple[int, int, int]], fleets: Callable[..., Instance], oracle: Oracle
) -> list[str]:
    """Solve each case by `name` and return what contradicts the oracle."""
    solver, wrong = make_solver(name), []
    for n, m, seed in cases:
        instance = fleets(n, m, seed)
        if refusal(solver, instance):
            continue
        solver.prepare(instance)
        result, optimum = solver.solve(instance, limits=Limits(time=60)), oracle(instance)[0]
        if np.isinf(optimum):
            right = result.status is Status.INFEASIBLE
        else:
            right = (
                result.status is Status.OPTIMAL
                and abs((result.objective or 0) - optimum) <= result.tolerance + 1e-9 * optimum
            )
        if not right:
            wrong.append(f"{name} {n}/{m} seed {seed}: {result.summary()}, not {optimum!r}")
    return wrong


@pytest.mark.parametrize("name", EXACT)
def test_random_fleets(name: str, fleets: Callable[..., Instance], held_karp: Oracle) -> None:
    assert disagreements(name, random_fleets(12), fleets, held_karp) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", EXACT)
def test_many_random_fleets(name: str, fleets: Callable[..., Instance], held_karp: Oracle) -> None:
    """By hand: ``pytest -m slow tests/formulations/routing/test_fleet.py``."""
    assert disagreements(name, random_fleets(300), fleets, held_karp) == []
