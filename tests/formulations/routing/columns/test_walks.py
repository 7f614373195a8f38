"""Walks: relaxations over tours that may return to tasks, and UAVs that are alike as one."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing.columns import walks
from formulations.routing.columns.completion import Memory
from formulations.routing.columns.generation import Ended, generate
from formulations.routing.columns.labelling import make_store
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.master import Master
from formulations.routing.columns.node import Node
from formulations.routing.columns.pricing import Column, Duals, Effort, Pricer
from formulations.routing.columns.recall import returns_of
from formulations.routing.columns.walks import WalkPricer, _remembered, relax_by_walks
from formulations.routing.subset_dp import SubsetDp
from instances import Instance, tour_costs
from tests.formulations.routing.test_branch_and_price import random_instance


def one_site(n: int, m: int, seed: int) -> Instance:
    """Tasks in a plane around one site of `m` UAVs, in wind."""
    points = np.random.default_rng(seed).uniform(0, 100, (n + 1, 2))
    points = np.vstack([points, np.repeat(points[-1:], m - 1, axis=0)])
    leg = points[None] - points[:, None]
    return Instance("site", np.hypot(leg[..., 0], leg[..., 1]) + 0.3 * leg[..., 0], n, m)


def pricer_of(instance: Instance, cap: float, near: int = 2) -> Pricer:
    legs = Legs.of(instance).under(cap)
    return Pricer(legs, cap, Effort(near, 60, 10**6), make_store(instance.n_tasks, 100_000))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("near", [3, 7])
def test_walks_cost_what_their_legs_do_and_no_tour_less(seed: int, near: int) -> None:
    instance = one_site(8, 2, seed)
    cap = float(instance.cost.mean() * 8)
    pricer = pricer_of(instance, cap, near)
    duals = Duals(np.random.default_rng(seed).normal(60, 40, 8), np.array([0.6, 0.4]), np.zeros(2), np.zeros(0))
    assert WalkPricer(pricer).price(0, duals, 0.0).columns
    for k in range(2):
        priced = WalkPricer(pricer).price(k, duals, 0.0)
        assert priced.least <= pricer.price(k, duals, 0.0).least + 1e-9
        values = []
        for walk in priced.columns:
            nodes = [8 + k, *walk.tasks, 8 + k]
            assert walk.cost == pytest.approx(instance.cost[nodes[:-1], nodes[1:]].sum())
            assert all(i != j for i, j in pairwise(nodes))
            values.append(duals.sigma[k] * walk.cost - duals.price[list(walk.tasks)].sum())
        assert values == pytest.approx(sorted(values))
        assert not values or values[0] == pytest.approx(priced.least)


@pytest.mark.parametrize("seed", range(6))
def test_a_relaxation_over_walks_bounds_that_over_tours(seed: int) -> None:
    instance = one_site(9, 3, seed) if seed % 2 else random_instance(9, 3, seed)
    best = SubsetDp().solve(instance, limits=Limits(time=60.0))
    assert best.objective is not None
    assert best.routes is not None
    cap = 1.2 * best.objective
    pricer = pricer_of(instance, cap)
    costs = tour_costs(instance, best.routes)
    known = [Column(k, route, float(costs[k])) for k, route in enumerate(best.routes) if route]
    walked = relax_by_walks(pricer, pricer.legs.kinds(), known)
    whole = generate(Master(9, pricer.legs.kinds(), cap), [pricer], cap, lambda: np.inf)
    assert whole.ended is Ended.SOLVED
    assert walked.best.value <= whole.best.value + 1e-6 * cap
    assert whole.best.value <= best.objective * (1 + 1e-9)
    for tour in walked.tours:
        assert len(set(tour.tasks)) == len(tour.tasks)
        assert tour.cost == pytest.approx(
            tour_costs(instance, [()] * tour.uav + [tour.tasks] + [()] * (2 - tour.uav))[tour.uav]
        )
        assert tour.cost <= cap


def test_what_walks_return_to_is_remembered_between() -> None:
    returns = returns_of([(0, 4, 5, 0), (1, 2, 3)], np.array([0.5, 1.0]), 6)
    assert returns[4, 0] == returns[5, 0] == 0.25
    assert returns.sum() == 0.5
    place = np.array([0.0, 1.0, 2.0, 3.0, 9.0, 10.0])
    between = np.abs(place[:, None] - place)
    before, after = Memory.nearest(between, 2), Memory.nearest(between, 2, returns)
    assert _remembered((0, 4, 5, 0), before)
    assert not _remembered((0, 4, 5, 0), after)
    assert [set(after.near[i]) for i in (4, 5)] == [{5, 0}, {4, 0}]
    assert (after.near[:4] == before.near[:4]).all()


def clusters(seed: int) -> Instance:
    """Four clusters of four tasks around a site of two UAVs."""
    rng = np.random.default_rng(seed)
    points = np.repeat(rng.uniform(0, 100, (4, 2)), 4, axis=0) + rng.uniform(0, 8, (16, 2))
    leg = (points := np.vstack([points, [[50.0, 50.0]] * 2]))[None] - points[:, None]
    return Instance("clusters", np.hypot(leg[..., 0], leg[..., 1]), 16, 2)


def test_memories_made_of_returns_raise_the_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    raised = []
    for seed in range(4):
        instance = clusters(seed)
        cap = float(instance.cost.mean() * 5)
        pricer = Pricer(Legs.of(instance).under(cap), cap, Effort(3, 300, 1), make_store(16, 1000))
        with monkeypatch.context() as only:
            only.setattr(walks, "_DULL", -1)
            once = relax_by_walks(pricer, pricer.legs.kinds(), []).best.value
        better = relax_by_walks(pricer, pricer.legs.kinds(), []).best.value
        assert better >= once
        raised.append(better / once)
    assert sorted(raised)[1] > 1.02


@pytest.mark.parametrize("seed", range(4))
def test_uavs_that_are_alike_are_one_and_lose_nothing(seed: int) -> None:
    """The same value, and duals that bound as well, as with every UAV and all its columns apart."""
    rng = np.random.default_rng(seed)
    tours = [tuple(np.flatnonzero(rng.random(6) < 0.5).tolist()) or (0,) for _ in range(30)]
    columns = [Column(1, tasks, float(rng.uniform(1, 9)) * len(tasks)) for tasks in tours]
    columns += [Column(0, tasks, column.cost + 1.0) for tasks, column in zip(tours, columns, strict=True)]
    one, apart = Master(6, np.array([0, 1, 1, 1]), 99.0), Master(6, np.arange(4), 99.0)
    one.add(columns)
    apart.add([replace(c, uav=k) for c in columns for k in ([0] if c.uav == 0 else [1, 2, 3])])
    together, each = one.solve(), apart.solve()
    assert together.value == pytest.approx(each.value)
    assert len(one.columns) < len(apart.columns)
    duals = together.duals
    assert duals.sigma.sum() == pytest.approx(1.0)
    assert duals.sigma[1] == duals.sigma[2] == duals.sigma[3]
    assert duals.price.sum() - duals.rent.sum() == pytest.approx(together.value)
    assert (duals.values(apart.columns) >= -duals.rent[[c.uav for c in apart.columns]] - 1e-9).all()


def test_a_task_given_to_one_of_those_alike_leaves_each_its_tours() -> None:
    instance = one_site(6, 3, 0)
    legs = Legs.of(instance)
    node = Node.root(legs, 0.0, [Column(0, (0, 1), 9.0), Column(0, (2, 3), 9.0)], legs.kinds())
    given = node.giving(2, 0, 1)
    left = {(c.uav, c.tasks) for c in given.restricted_master(99.0).columns}
    assert left == {(0, (0, 1)), (0, (2, 3)), (1, (0, 1))}
    assert len(given.restricted_master(99.0, apart=True).columns) == 4
