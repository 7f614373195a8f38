"""branch-and-price against subset-dp, made hard on purpose: loose starts, permutations, tiny bins, no room."""

import itertools
from collections.abc import Callable

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing import branch_and_price
from formulations.routing.branch_and_price import BranchAndPrice, Patience
from formulations.routing.columns.generation import generate
from formulations.routing.columns.labelling import make_store
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.master import Master
from formulations.routing.columns.node import Node, Workspace
from formulations.routing.columns.pricing import Column, DualBound, Duals, Effort, Efforts, Pricer, efforts
from formulations.routing.columns.recall import Recall
from formulations.routing.columns.team import Team
from formulations.routing.columns.tree import Tree
from formulations.routing.proved import StoppedBy
from formulations.routing.recorder import Recorder
from formulations.routing.search.memetic import Memetic
from formulations.routing.search_beside import search
from formulations.routing.search_in_parts import part
from formulations.routing.solver import Result, Status, ignore
from formulations.routing.subset_dp import SubsetDp
from instances import Instance, Routes, check_routes, makespan

LIMITS = Limits(time=600.0)


def random_instance(n: int, m: int, seed: int) -> Instance:
    """One of four kinds: plane with a side wind, any costs, many ties and zeros, heavy tails."""
    rng = np.random.default_rng(seed)
    if seed % 4 == 0:
        points = rng.uniform(0, 100, (n + m, 2))
        leg = points[None, :, :] - points[:, None, :]
        cost = np.hypot(leg[..., 0], leg[..., 1]) + 0.3 * leg[..., 0]
    elif seed % 4 == 1:
        cost = rng.uniform(0, 100, (n + m, n + m))
    elif seed % 4 == 2:
        cost = rng.integers(0, 9, (n + m, n + m)).astype(float)
    else:
        cost = rng.uniform(0, 1, (n + m, n + m)) ** 6 * 100
    np.fill_diagonal(cost, 0.0)
    return Instance(f"random-{n}-{m}-{seed}", cost, n, m)


def loosened(routes: Routes, n: int, rng: np.random.Generator) -> Routes:
    """The same routes with three tasks thrown onto the ends of any tours."""
    tours = [list(route) for route in routes]
    for task in rng.integers(n, size=3):
        for tour in tours:
            if task in tour:
                tour.remove(task)
        tours[rng.integers(len(tours))].append(int(task))
    return tuple(tuple(tour) for tour in tours)


def agrees(instance: Instance, solver: BranchAndPrice, start: Routes | None, optimum: float) -> None:
    result = solver.solve(instance, limits=LIMITS, start=start)
    assert result.status is Status.OPTIMAL
    assert result.routes is not None
    assert not check_routes(instance, result.routes)
    assert result.objective == pytest.approx(optimum, abs=result.tolerance + 1e-12)
    assert result.bound is not None
    assert result.bound <= optimum * (1 + 1e-12)


@pytest.mark.parametrize("seed", range(12))
def test_agrees_with_subset_dp_whatever_the_start(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, m = int(rng.integers(1, 11)), int(rng.integers(1, 5))
    instance = random_instance(n, m, seed)
    oracle = SubsetDp().solve(instance, limits=LIMITS)
    assert oracle.objective is not None
    assert oracle.routes is not None
    agrees(instance, BranchAndPrice(starts=1), None, oracle.objective)
    loose = loosened(oracle.routes, n, rng)
    agrees(instance, BranchAndPrice(starts=0, bins=int(rng.integers(1, 9)), tours=200), loose, oracle.objective)
    everything_to_one = (tuple(range(n)), *[()] * (m - 1))
    agrees(instance, BranchAndPrice(starts=0), everything_to_one, oracle.objective)
    order = np.concatenate([rng.permutation(n), n + rng.permutation(m)])
    permuted = Instance("permuted", instance.cost[np.ix_(order, order)], n, m)
    agrees(permuted, BranchAndPrice(starts=0), everything_to_one, oracle.objective)


def with_shared_depots(n: int, at: list[int], seed: int) -> Instance:
    """Two kinds of costs; UAV k starts where UAV at[k] does."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(0, 100, (n + len(at), 2))
    points[n:] = points[n + np.array(at)]
    cost = np.hypot(*(points[None] - points[:, None]).transpose(2, 0, 1))
    cost[:n, :n] += rng.uniform(0, 40, (n, n)) * (seed % 2)
    np.fill_diagonal(cost, 0.0)
    return Instance(f"shared-{n}-{seed}", cost, n, len(at))


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("at", [[0, 0, 0], [0, 1, 0, 1]])
def test_uavs_that_are_alike_miss_no_routes(seed: int, at: list[int]) -> None:
    n = 10
    instance = with_shared_depots(n, at, seed)
    oracle = SubsetDp().solve(instance, limits=LIMITS)
    assert Legs.of(instance).kinds().tolist() == at
    assert oracle.objective is not None
    everything_to_one = (tuple(range(n)), *[()] * (len(at) - 1))
    agrees(instance, BranchAndPrice(starts=0, tours=200), everything_to_one, oracle.objective)


def test_a_uav_is_like_others_until_a_task_is_given_to_it() -> None:
    legs = Legs.of(with_shared_depots(5, [0, 0, 0, 3], 0))
    given = Node.root(legs, 0.0, [], legs.kinds()).giving(2, 1, 1)
    assert [given.alike(k) for k in range(4)] == [[0, 2], [1], [0, 2], [3]]
    assert given.may_visit()[:, 2].tolist() == [False, True, False, False]


@pytest.mark.parametrize("seed", range(6))
def test_without_the_arcs_that_no_better_routes_use_the_optimum_is_the_same(
    monkeypatch: pytest.MonkeyPatch, seed: int
) -> None:
    """As where tours are long: walks begin on what the capped total leaves, whatever the routes known."""
    monkeypatch.setattr(branch_and_price, "_LONG", 2)
    instance = with_shared_depots(8, [0] * (1 + seed % 3), seed)
    oracle = SubsetDp().solve(instance, limits=LIMITS)
    assert oracle.objective is not None
    assert oracle.routes is not None
    everything_to_one = (tuple(range(8)), *[()] * (seed % 3))
    for start in (oracle.routes, everything_to_one):
        agrees(instance, BranchAndPrice(starts=0), start, oracle.objective)


@pytest.mark.parametrize("seed", range(4))
def test_trials_of_lower_caps_raise_the_bound_to_the_optimum_and_no_further(seed: int) -> None:
    instance = random_instance(8, 2, seed)
    oracle, solver = SubsetDp().solve(instance, limits=LIMITS).objective, BranchAndPrice(starts=0)
    assert oracle is not None
    recorder = Recorder(instance, LIMITS, ignore, (tuple(range(8)), ()))
    legs, patience = Legs.of(instance), Patience(recorder)
    work = Workspace(patience.left, Team(lambda: make_store(8, 10_000)), 1000, *efforts(8, 50), np.ones(8), Recall(8))
    patience.share(1 / 2)
    solver.destroy(recorder, patience, Tree(legs, [], work), legs)
    assert 0.99 * oracle <= recorder.bound <= oracle * (1 + 1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_trials_of_caps_before_the_children_of_the_root_end_at_the_optimum(
    monkeypatch: pytest.MonkeyPatch, seed: int
) -> None:
    """As where pricing is dear at the root: it is left as it is."""
    grow = Tree.grow
    roots: list[Tree] = []

    def left_at_first(self: Tree, recorder: Recorder, tolerance: float, nodes: float) -> StoppedBy:
        roots.append(self)
        return StoppedBy.ITERATIONS if self.work.hasty else grow(self, recorder, tolerance, nodes)

    monkeypatch.setattr(Tree, "grow", left_at_first)
    instance = random_instance(8, 2, seed)
    oracle = SubsetDp().solve(instance, limits=LIMITS)
    assert oracle.objective is not None
    agrees(instance, BranchAndPrice(starts=0), (tuple(range(8)), ()), oracle.objective)
    assert len(roots) > 2
    assert len(set(map(id, roots))) == len(roots), "each tree grew once"
    assert min(tree.most for tree in roots) < makespan(instance, (tuple(range(8)), ()))


def test_where_short_tours_leave_a_wide_gap_trials_leave_the_tree_time_to_end(monkeypatch: pytest.MonkeyPatch) -> None:
    trials, trees = [], []

    def out_of_time(self: Tree, *_: object) -> StoppedBy:
        trees.append(self.work.time_left())
        return StoppedBy.TIME

    monkeypatch.setattr(Tree, "grow", out_of_time)
    monkeypatch.setattr(BranchAndPrice, "destroy", lambda _, recorder, patience, *rest: trials.append(patience.left()))
    instance = random_instance(8, 2, 0)
    BranchAndPrice(starts=0).solve(instance, limits=Limits(time=60.0), start=(tuple(range(8)), ()))
    assert trials == pytest.approx([30.0], abs=5.0)
    assert trees[-1] == pytest.approx(60.0, abs=5.0)


@pytest.mark.parametrize(("gap", "all_of_it"), [(0.01, True), (0.03, False)])
def test_the_tree_has_all_of_the_time_from_its_root_on_where_the_gap_is_narrow(
    monkeypatch: pytest.MonkeyPatch, gap: float, all_of_it: bool
) -> None:
    instance, start = random_instance(8, 2, 0), (tuple(range(8)), ())
    bound, left = (1 - gap) * makespan(instance, start), []

    def out_of_time(self: Tree, *_: object) -> StoppedBy:
        left.append(self.work.time_left())
        return StoppedBy.TIME

    monkeypatch.setattr(Tree, "grow", out_of_time)
    monkeypatch.setattr(Tree, "bound", lambda *_: bound)
    monkeypatch.setattr(Patience, "left", lambda _: 0.0)
    BranchAndPrice(starts=0).solve(instance, limits=Limits(time=60.0), start=start)
    assert (left[0] > 0) == all_of_it


@pytest.mark.parametrize("seed", range(12))
def test_fleets_whatever_the_start(
    fleets: Callable[..., Instance], held_karp: Callable[[Instance], tuple[float, Routes]], seed: int
) -> None:
    """Without routes to begin with, and from loose ones, which pass an endurance or not; with few bins and no room."""
    rng = np.random.default_rng(seed)
    n, m = int(rng.integers(2, 8)), int(rng.integers(1, 4))
    instance = fleets(n, m, seed)
    optimum, routes = held_karp(instance)
    loose = loosened(routes, n, rng) if routes else None
    for solver, start in ((BranchAndPrice(starts=0), None), (BranchAndPrice(starts=0, bins=3, tours=100), loose)):
        if np.isfinite(optimum):
            agrees(instance, solver, start, optimum)
        else:
            assert solver.solve(instance, limits=LIMITS, start=start).status is Status.INFEASIBLE


@pytest.mark.parametrize("share", [1.0, 1 - 1e-8])
def test_a_tour_may_take_all_of_the_endurance(share: float) -> None:
    """Legs whose sums depend on their order; a hair less, and there are no routes."""
    instance = random_instance(8, 1, 1)
    optimum = SubsetDp().solve(instance, limits=LIMITS).objective
    assert optimum is not None
    limited = Instance("limited", instance.cost, 8, 1, endurance=[optimum * share])
    result = BranchAndPrice(starts=0).solve(limited, limits=LIMITS)
    assert result.status is (Status.OPTIMAL if share == 1.0 else Status.INFEASIBLE)


def test_a_part_of_a_fleet_keeps_its_costs_and_endurance(fleets: Callable[..., Instance]) -> None:
    instance = fleets(6, 3, 2)
    few, nodes = part(instance, [4, 1, 2], [2, 0]), [4, 1, 2, 8, 6]
    for k, uav in enumerate([2, 0]):
        assert np.array_equal(few.uav_cost(k), instance.uav_cost(uav)[np.ix_(nodes, nodes)])
        assert few.limits[k] == instance.limits[uav]


def test_bound_of_the_relaxation_never_passes_the_optimum() -> None:
    for seed in range(4):
        instance = random_instance(8, 2, seed)
        optimum = SubsetDp().solve(instance, limits=LIMITS).objective
        assert optimum is not None
        for slack in (1.0, 1.3):
            cap = optimum * slack * (1 + 1e-9)
            master = Master(8, np.arange(2), cap)
            pricer = Pricer(Legs.of(instance).under(cap), cap, Effort(4, 100, 10**6), make_store(8, 100_000))
            assert generate(master, [pricer], cap, lambda: np.inf).best.value <= optimum * (1 + 1e-9)


def test_out_of_time_and_out_of_nodes_still_give_routes_and_a_valid_bound() -> None:
    instance = random_instance(14, 3, 0)
    optimum = SubsetDp().solve(instance, limits=LIMITS).objective
    assert optimum is not None
    for limits in (Limits(time=0.05), Limits(time=60.0, iterations=0), Limits(time=60.0, iterations=1)):
        result = BranchAndPrice().solve(instance, limits=limits)
        assert result.routes is not None
        assert not check_routes(instance, result.routes)
        assert result.bound is None or result.bound <= optimum * (1 + 1e-12)


@pytest.mark.parametrize("seed", [0, 3, 7])
def test_nodes_too_large_for_memory_are_left_and_said_so(seed: int) -> None:
    """One UAV has nothing to branch on: where its tours do not fit the label store, the bound is still valid."""
    instance = random_instance(12, 1, seed)
    optimum = SubsetDp().solve(instance, limits=LIMITS).objective
    assert optimum is not None
    result = BranchAndPrice(labels=1000, bins=5).solve(instance, limits=LIMITS)
    assert result.stopped_by in ("proof", "memory")
    assert result.status is (Status.OPTIMAL if result.stopped_by == "proof" else Status.FEASIBLE)
    assert result.bound is not None
    assert result.bound <= optimum * (1 + 1e-12)


def test_routes_that_cost_nothing_end_the_search() -> None:
    """A circle of free legs, found only on the way."""
    cost = np.full((6, 6), 5.0)
    cost[np.arange(6), np.roll(np.arange(6), -1)] = 0.0
    np.fill_diagonal(cost, 0.0)
    result = BranchAndPrice(starts=0).solve(Instance("free", cost, 5, 1), limits=LIMITS, start=((4, 2, 3, 1, 0),))
    assert result.status is Status.OPTIMAL
    assert result.objective == 0.0


@pytest.mark.parametrize("seed", range(4))
def test_lightening_changes_no_bound(seed: int) -> None:
    """Cuts of price zero and their columns' shares in them cost nothing; the rest keep their reduced costs."""
    rng = np.random.default_rng(seed)
    cuts = tuple(itertools.combinations(range(6), 3))
    rho = np.where(rng.random(len(cuts)) < 0.5, 0.0, rng.uniform(0, 5, len(cuts)))
    duals = Duals(rng.normal(10, 5, 6), np.array([0.5, 0.5]), np.zeros(2), rho, cuts)
    columns = [Column(int(rng.integers(2)), tuple(rng.permutation(6)[:4].tolist()), float(c)) for c in range(1, 20)]
    values = [
        0.5 * c.cost - duals.price[list(c.tasks)].sum()
        + sum(r for cut, r in zip(cuts, rho, strict=True) if len(set(cut) & set(c.tasks)) >= 2)
        for c in columns
    ]  # fmt: skip
    assert duals.values(columns) == pytest.approx(values)
    assert duals.paid().values(columns) == pytest.approx(values)
    assert duals.paid().offset == pytest.approx(duals.offset)
    assert (duals.paid().rho > 0).all()


def test_more_than_64_tasks() -> None:
    """Seventy tasks on a line beside seven depots, ten to each: the farthest of each ten sets the optimum."""
    x = np.concatenate([np.concatenate([k * 1000.0 + np.arange(1, 11) for k in range(7)]), np.arange(7) * 1000.0])
    instance = Instance("combs", np.abs(x[:, None] - x[None, :]), 70, 7)
    result = BranchAndPrice(starts=1).solve(instance, limits=LIMITS)
    assert result.status is Status.OPTIMAL
    assert result.objective == pytest.approx(20.0)


def test_same_seed_same_answer() -> None:
    instance = random_instance(12, 3, 4)
    first, second = (BranchAndPrice().solve(instance, limits=LIMITS, seed=3) for _ in range(2))
    assert first.routes == second.routes
    assert first.bound == second.bound


def test_searches_after_the_first_go_on_from_the_best_routes_known(monkeypatch: pytest.MonkeyPatch) -> None:
    instance, begun_from = random_instance(8, 2, 3), list[Routes | None]()

    def solve(self: Memetic, instance: Instance, *, limits: Limits, seed: int, start: Routes | None) -> Result:
        begun_from.append(start)
        return Result(Status.NO_SOLUTION, elapsed=0.0, stopped_by="time")

    monkeypatch.setattr(Memetic, "solve", solve)
    recorder = Recorder(instance, Limits(time=60.0), ignore, (tuple(range(8)), ()))
    for run in range(3):
        search(recorder, 100, 0, run, 60.0)
    search(recorder, 100, 0, 3, 60.0, afresh=True)
    assert begun_from == [None, recorder.routes, recorder.routes, None]


def test_of_equal_bounds_the_newest_node_is_next_and_the_bound_is_the_least() -> None:
    legs = Legs.of(random_instance(5, 2, 0))
    idle, team = Efforts((), Effort(1, 1, 1)), Team(lambda: make_store(5, 1000))
    work = Workspace(lambda: 0.0, team, 10, idle, idle, np.ones(5), Recall(5))
    tree = Tree(legs, [], work, 100.001)
    for bound in (200.0, 100.0, 100.002, 0.0):
        tree.push(Node.root(legs, bound, [], np.arange(2)))
    assert tree.bound(1e9) == 0.0
    assert [tree.pop().bound for _ in range(5)] == [0.0, 100.002, 100.0, 100.001, 200.0]


def test_a_node_goes_on_with_its_prices_inside_the_box(monkeypatch: pytest.MonkeyPatch) -> None:
    """A task far dearer than a fair share: with the box of the root, the master of a child would rather pay for it."""
    monkeypatch.setattr("formulations.routing.columns.node.WIDE", 3)
    cost = np.abs(np.subtract.outer(x := np.array([100.0, 1.0, 2.0, 3.0, 4.0, 5.0, 0.0]), x))
    legs = Legs.of(Instance("one far out", cost, 6, 1))
    node = Node.root(legs, 0.0, [Column(0, (5, 0, 4, 3, 2, 1), 200.0)], np.arange(1))
    price = np.array([200.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    node.centre = DualBound(200.0, duals := Duals(price, np.ones(1), np.zeros(1), np.zeros(0)), np.zeros(1))
    for near, width in ((None, 400.0), (duals, 6.7)):
        master = node.restricted_master(201.0, near=near)
        assert master.solve()[0] == pytest.approx(200.0)
        assert not master.penalised
        assert master.half.max() == pytest.approx(width)
