"""arc-tree: its bound holds at any prices, its splits miss no routes, and options change no optimum."""

import multiprocessing
import time
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.limits import Limits
from formulations.routing import arc_tree
from formulations.routing.arc_tree import ArcTree
from formulations.routing.arcs import helper, tree
from formulations.routing.arcs import programme as programme_module
from formulations.routing.arcs.case import Case, Fly, Give
from formulations.routing.arcs.helper import Helper
from formulations.routing.arcs.joint import Blossom, Crowd
from formulations.routing.arcs.lagrangian import ArcPrices, Cuts, bound_at, reduced_costs
from formulations.routing.arcs.programme import Programme
from formulations.routing.greedy import greedy_routes
from formulations.routing.recorder import Recorder
from formulations.routing.solver import Result, Status
from formulations.routing.subset_dp import SubsetDp
from instances import InputError, Instance, Routes, check_routes, makespan, tour_costs
from tests.formulations.routing.test_branch_and_cut import clusters, random_instance

LIMITS = Limits(time=300.0)


def solved(instance: Instance, limits: Limits = LIMITS, **options: int) -> Result:
    """Solve to the proof, and compare with subset programming."""
    solver = ArcTree(**options)
    solver.prepare(instance)
    result = solver.solve(instance, limits=limits, start=greedy_routes(instance))
    optimum = SubsetDp().solve(instance, limits=LIMITS).objective
    assert result.status is Status.OPTIMAL
    assert result.routes is not None
    assert check_routes(instance, result.routes) == []
    assert result.objective == makespan(instance, result.routes)
    assert result.bound is not None
    assert optimum is not None
    assert result.objective - result.bound <= result.tolerance <= 2.1e-7 * result.objective
    assert max(event.bound or 0.0 for event in result.trace) <= optimum
    assert optimum * (1 - 1e-12) <= result.objective <= optimum + result.tolerance
    return result


@settings(max_examples=15, deadline=None)
@given(n=st.integers(1, 9), m=st.integers(1, 3), seed=st.integers(0, 10**6), whole=st.booleans())
def test_it_ends_at_the_optimum_from_poor_routes(n: int, m: int, seed: int, whole: bool) -> None:
    solved(random_instance(n, m, seed, whole), starts=0)


@pytest.mark.parametrize("tried", [1, 3])
@pytest.mark.parametrize("starts", [0, 1])
def test_no_option_changes_the_optimum(tried: int, starts: int) -> None:
    result = solved(random_instance(11, 2, 7), tried=tried, starts=starts)
    assert result.statistics["nodes"] > 3


def test_cuts_are_needed_and_uavs_that_are_alike_told_apart() -> None:
    """Three pairs of tasks far apart: without cuts each is its own tour, through no depot."""
    xy = np.array(clusters(3).coordinates)
    xy[6:] = xy[6]
    instance = Instance("one-site", np.linalg.norm(xy[:, None] - xy[None], axis=-1), 6, 3, xy)
    assert solved(instance, starts=0).statistics["cuts"] > 0


@pytest.mark.parametrize("threads", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_helpers_change_no_optimum_and_are_gone_at_the_end(threads: int) -> None:
    for seed in range(3):
        solved(random_instance(11, 3, seed), Limits(time=300.0, threads=threads), starts=0)
    assert multiprocessing.active_children() == []


class FallenHelper(Helper):
    """One that ends in the middle of its second turn."""

    turns = 0

    def begin(self, cap: float, time: float) -> None:
        super().begin(cap, time)
        self.turns += 1
        if self.turns == 2:
            self.peer.process.kill()
            self.peer.process.join()


def test_a_helper_that_falls_loses_no_case(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(arc_tree, "Helper", FallenHelper)
    monkeypatch.setattr(helper, "TURN", 2)
    monkeypatch.setattr(tree, "TURN", 2)
    for seed in range(3):
        solved(random_instance(11, 3, seed), Limits(time=300.0, threads=2), starts=0)


def test_time_ends_helpers_too() -> None:
    instance = random_instance(14, 3, 1)
    began = time.monotonic()
    result = ArcTree(starts=0).solve(instance, limits=Limits(time=0.3, threads=2))
    assert time.monotonic() - began < 5.0
    assert result.stopped_by == "time" or result.status is Status.OPTIMAL
    assert multiprocessing.active_children() == []


def test_routes_that_cost_nothing_are_proved() -> None:
    cost = np.zeros((5, 5))
    cost[3, :2] = cost[:2, 3] = 7.0
    result = ArcTree(starts=0).solve(Instance("free", cost, 3, 2), limits=LIMITS, start=((0, 1, 2), ()))
    assert (result.status, result.objective, result.bound) == (Status.OPTIMAL, 0.0, 0.0)


def test_bad_options_are_refused() -> None:
    with pytest.raises(InputError, match="tried must be at least 1, got 0"):
        ArcTree(tried=0)
    assert "641600 variables" in (ArcTree().accepts(Instance("large", np.zeros((404, 404)), 400, 4)) or "")


def test_stopped_early_it_keeps_routes_and_a_true_bound() -> None:
    instance = random_instance(14, 3, 1)
    optimum = SubsetDp().solve(instance, limits=LIMITS).objective
    for limits, stopped_by in ((Limits(time=60, iterations=2), "iterations"), (Limits(time=1e-6), "time")):
        result = ArcTree(starts=0).solve(instance, limits=limits)
        assert result.stopped_by == stopped_by
        assert result.status is Status.FEASIBLE
        assert (result.bound or 0.0) <= optimum


def small(seed: int, m: int = 2, n: int = 5) -> tuple[np.ndarray, Instance]:
    """Costs (m, n + 1, n + 1) of a few tasks, the depot last, and the instance they are of."""
    instance = random_instance(n, m, seed)
    costs = np.array([instance.cost[np.ix_([*range(n), n + k], [*range(n), n + k])] for k in range(m)])
    costs[:, np.arange(n + 1), np.arange(n + 1)] = np.inf
    return costs, instance


def flown(routes: Routes, n: int) -> list[tuple[int, int, int]]:
    """Return the arcs of routes: UAV, tail, head, the depot as n."""
    stops = [(k, [n, *route, n]) for k, route in enumerate(routes) if route]
    return [(k, i, j) for k, tour in stops for i, j in pairwise(tour)]


def keeps(case: Case, routes: Routes) -> bool:
    """Say whether routes are of a case."""
    arcs = {(i, j) for _, i, j in flown(routes, case.forbidden.shape[1])}
    visits = all(not case.forbidden[k, i] for k, route in enumerate(routes) for i in route)
    return visits and not arcs & {*case.banned} and all(arcs & {*group} for group in case.needed)


def some_routes(rng: np.random.Generator, n: int, m: int) -> Routes:
    """Return random routes."""
    order, of = rng.permutation(n), rng.integers(0, m, n)
    return tuple(tuple(int(i) for i in order if of[i] == k) for k in range(m))


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_the_bound_of_a_case_holds_at_any_prices(seed: int) -> None:
    costs, instance = small(seed)
    rng, n, m = np.random.default_rng(seed), 5, 2
    case = Case.root(np.arange(m), n)
    for split in (Give(int(rng.integers(m)), int(rng.integers(n))), Fly(((0, 1), (1, 0))), Fly(((2, 3),))):
        case = split.within(case) if rng.random() < 0.5 else split.without(case)
    c = int(rng.integers(0, 5))
    tasks = np.zeros((c, n + 1), np.bool_)
    visited = rng.integers(0, n, c)
    tasks[:, :n] = rng.random((c, n)) < 0.5
    tasks[np.arange(c), visited] = True
    sigma, rho, limits = rng.dirichlet(np.ones(m)), rng.uniform(0, 40, len(case.needed)), np.array([np.inf, 150.0])
    w, u, mu = rng.normal(0, 30, (m, n + 1)), -rng.uniform(0, 20, m), rng.uniform(0, 40, c)
    endurance = np.array([0.0, rng.uniform(0, 0.5)])
    joint = Blossom(n, (0, 1, 3), ((0, 2), (n, 1), (3, 4))), Crowd(n, (0, 1, 2, 3, 4), ())
    nu = rng.uniform(0, 40, 2)
    prices = ArcPrices(sigma, endurance, w, u, Cuts(rng.integers(0, m, c), tasks, visited), mu, rho, joint, nu)
    bound = bound_at(prices, reduced_costs(prices, costs, case), limits, case.lost_arcs())
    for _ in range(300):
        routes = some_routes(rng, n, m)
        if keeps(case, routes) and tour_costs(instance, routes)[1] <= 150.0 and all(routes):  # a crowd asks for both
            assert bound <= makespan(instance, routes) + 1e-9


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_the_two_cases_of_a_split_miss_no_routes_but_for_names(seed: int) -> None:
    rng, n, m = np.random.default_rng(seed), 5, 3
    case = Case.root(np.array([0, 0, 2]), n)  # UAVs 0 and 1 are alike
    for _ in range(4):
        i, j = (int(i) for i in rng.choice(n, 2, replace=False))
        split = Give(int(rng.choice([0, 2])), i) if rng.random() < 0.6 else Fly(((i, j), (j, i))[: rng.integers(1, 3)])
        if isinstance(split, Give) and (case.kinds[: split.uav] == case.kinds[split.uav]).any():
            continue
        without, within = split.without(case), split.within(case)
        for _ in range(100):
            routes = some_routes(rng, n, m)
            if keeps(case, routes):
                renamed = (routes[1], routes[0], routes[2])
                names = [routes, renamed] if case.kinds[0] == case.kinds[1] else [routes]
                assert any(keeps(part, named) for part in (without, within) for named in names)
        case = within if rng.random() < 0.5 else without


def test_a_trial_leaves_the_programme_as_it_was() -> None:
    costs, _ = small(3)
    programme = Programme(costs / 300.0, np.full(2, np.inf))
    case = Case.root(np.arange(2), 5)
    programme.enter(case)
    programme.solve()
    while programme.cut(1.0) or programme.grow():
        programme.solve()
    before, bound = programme.value, programme.bound
    assert programme.trial(Give(0, 1).within(case), 100) >= before - 1e-9
    assert programme.trial(Fly(((0, 1), (1, 0))).within(case), 100) >= before - 1e-9
    programme.solve()
    assert programme.value == pytest.approx(before, rel=1e-9)
    assert programme.bound == pytest.approx(bound, rel=1e-9)
    programme.enter(Fly(((0, 1), (1, 0))).without(case))
    programme.solve()
    assert programme.theta[:, 0, 1].sum() + programme.theta[:, 1, 0].sum() == 0


def test_what_a_case_needs_may_be_none_of_the_arcs_held() -> None:
    """The programme is solved all the same, and prices the arcs."""
    costs, _ = small(3, n=14)
    programme = Programme(costs / 300.0, np.full(2, np.inf))
    held = np.zeros((15, 15), np.bool_)
    held[programme.tail, programme.head] = True
    i, j = np.argwhere(~held[:14, :14] & ~np.eye(14, dtype=np.bool_))[0].tolist()
    programme.enter(Fly(((i, j),)).within(Case.root(np.arange(2), 14)))
    assert programme.solve()
    while programme.grow() or programme.insist():
        assert programme.solve()
    assert programme.theta[:, i, j].sum() == pytest.approx(1.0)


def test_a_linear_programme_that_begins_anew_ends_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(programme_module, "_PIVOTS", 3)
    solved(random_instance(9, 2, 5), starts=0)


def test_a_recorder_that_runs_out_of_time_stops_the_tree() -> None:
    """As when a solver beside it has proved the routes."""

    class Impatient(Recorder):
        asked = 0

        @property
        def remaining(self) -> float:
            self.asked += 1
            return 0.0 if self.asked > 3 else 60.0

    instance = random_instance(14, 3, 5)
    recorder = Impatient(instance, LIMITS, lambda event: None)
    recorder.incumbent(greedy_routes(instance))
    result = ArcTree(starts=0).prove(recorder, 0)
    assert result.stopped_by == "time"
    assert result.status is Status.FEASIBLE
    assert result.statistics.get("nodes", 0) <= 1
