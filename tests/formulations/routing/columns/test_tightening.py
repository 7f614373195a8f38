"""What the work on a node can come to, each outcome checked against the optimum."""

import numpy as np
import pytest

import formulations.routing.columns.tightening as tightening
from formulations.limits import Limits
from formulations.routing.columns.fixing import fix_as_worth, fix_legs
from formulations.routing.columns.generation import Ended, Relaxation, generate
from formulations.routing.columns.labelling import make_store
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.master import Master
from formulations.routing.columns.node import Node, Tries, Workspace
from formulations.routing.columns.pricing import DualBound, Duals, Effort, Pricer, efforts
from formulations.routing.columns.recall import Recall
from formulations.routing.columns.team import Team
from formulations.routing.columns.tightening import (
    Branch,
    Dear,
    Improved,
    Interrupted,
    Overtaken,
    Pruned,
    Stuck,
    tighten,
)
from formulations.routing.subset_dp import SubsetDp
from instances import Instance, check_routes, makespan

N, M = 9, 2


def random_instance(seed, m=M):
    points = np.random.default_rng(seed).uniform(0, 100, (N + m, 2))
    leg = points[None] - points[:, None]
    return Instance("plane", np.hypot(leg[..., 0], leg[..., 1]) + 0.3 * leg[..., 0], N, m)


def optimum(instance):
    return SubsetDp().solve(instance, limits=Limits(time=600.0)).objective


def fresh(instance):
    return Node.root(Legs.of(instance), 0.0, [], np.arange(instance.n_depots))


def workspace(time_left=lambda: np.inf, labels=100_000, walks=None):
    team = Team(lambda: make_store(N, labels))
    return Workspace(time_left, team, 10_000, *efforts(N, 50), np.ones(N), Recall(N), walks=walks)


@pytest.mark.parametrize("seed", [*range(5), 10])
@pytest.mark.parametrize("share", [0.7, 0.99, 1.01, 1.3])
@pytest.mark.parametrize(
    ("m", "walks", "exempt"), [(M, None, ()), (M, Effort(2, 20, 0), ()), (3, None, (0,)), (3, None, (0, 2))]
)
def test_an_outcome_says_nothing_false(seed, share, m, walks, exempt):
    instance = random_instance(seed, m)
    best, node = optimum(instance), fresh(instance)
    cap = share * best
    for k in exempt:
        node.exempt_cost_of(k, -np.inf)
    outcome = tighten(node, cap, workspace(walks=walks))
    match outcome:
        case Pruned():
            assert node.bound > cap
            assert cap < best
        case Improved(routes):
            assert not check_routes(instance, routes)
            assert best * (1 - 1e-9) <= makespan(instance, routes) <= cap * (1 + 1e-9)
        case Branch(uav, task, _):
            assert node.may_visit()[:, task].sum() > 1
            assert node.may_visit()[uav, task]
        case _:
            pytest.fail(f"{outcome}: there was time, room and nobody beside")
    assert cap < best or node.bound <= best * (1 + 1e-9)


@pytest.mark.parametrize(("seed", "share", "expected"), [(0, 0.7, Pruned), (0, 1.3, Improved), (10, 1.3, Branch)])
def test_a_node_is_pruned_below_the_optimum_and_improved_or_branched_above_it(seed, share, expected):
    instance = random_instance(seed)
    assert isinstance(tighten(fresh(instance), share * optimum(instance), workspace()), expected)


@pytest.mark.parametrize("outside", [0.0, 990.0])
def test_cuts_are_sought_as_long_as_they_raise_the_relaxation_whatever_is_known_from_outside(outside, monkeypatch):
    """In trees under lower caps a bound from outside lies above the relaxation."""
    instance, values = random_instance(0, m=3), iter([930.0, 950.0, 970.0, 970.5, 971.0])
    triples = ([(a, a + 1, a + 2)] for a in range(5))

    def relaxed(master, *_, **how):
        duals = Duals(np.zeros(N), np.full(3, 0.3), np.zeros(3), np.zeros(len(master.cuts)), tuple(master.cuts))
        at = DualBound(next(values), duals, np.zeros(3))
        return Relaxation(Ended.SOLVED, at, np.zeros(len(master.columns)), 1)

    monkeypatch.setattr(tightening, "generate", relaxed)
    monkeypatch.setattr(tightening, "separate", lambda *_: next(triples))
    node, work = Node.root(Legs.of(instance), outside, [], np.arange(3)), workspace()
    assert isinstance(tighten(node, 1000.0, work), Branch | Stuck)
    assert work.counts["cuts"] == 4


@pytest.mark.parametrize("rough", [Ended.STUCK, Ended.SOLVED, Ended.PRUNED, Ended.INTERRUPTED])
def test_where_tours_are_not_listed_more_cuts_are_asked_for_before_all_are_priced_exactly(rough, monkeypatch):
    asked, triples = [], ([(a, a + 1, a + 2)] for a in range(7))

    def relaxed(master, pricers, *_, **how):
        asked.append((len(pricers), how["roughly"], len(master.cuts)))
        any_duals = Duals(np.zeros(N), np.full(M, 0.5), np.zeros(M), np.zeros(0))
        return Relaxation(rough, DualBound(-np.inf, any_duals, np.zeros(M)), np.zeros(len(master.columns)), 3)

    monkeypatch.setattr(tightening, "generate", relaxed)
    monkeypatch.setattr(tightening, "separate", lambda *_: next(triples))
    node, work = fresh(random_instance(0)), workspace()
    master = node.restricted_master(1000.0)
    tightening._cut(node, master, [(0, 3, 6)], 1000.0, work)
    on = rough in (Ended.STUCK, Ended.SOLVED)
    assert asked == [(1, True, 1), (1, True, 2)] if on else [(1, True, 1)]
    assert len(master.cuts) == work.counts["cuts"] == (3 if on else 1)
    assert work.counts["rounds"] == 3 * len(asked)


@pytest.mark.parametrize(
    ("hasty", "second", "left"), [(True, 950.0, True), (True, 970.0, False), (False, 950.0, False)]
)
def test_a_node_is_left_as_it_is_where_pricing_is_dear_and_gains_little_if_that_is_asked_for(
    hasty, second, left, monkeypatch
):
    values, triples = iter([930.0, second, 1001.0]), ([(a, a + 1, a + 2)] for a in range(5))

    def relaxed(master, *_, roughly=False, **how):
        duals = Duals(np.zeros(N), np.full(3, 0.3), np.zeros(3), np.zeros(len(master.cuts)), tuple(master.cuts))
        at = DualBound(-np.inf if roughly else next(values), duals, np.zeros(3))
        ended = Ended.INTERRUPTED if roughly else Ended.PRUNED if at.value > 1000.0 else Ended.SOLVED
        return Relaxation(ended, at, np.zeros(len(master.columns)), 1)

    monkeypatch.setattr(tightening, "generate", relaxed)
    monkeypatch.setattr(tightening, "separate", lambda *_: next(triples))
    monkeypatch.setattr(tightening, "_list", lambda *_: False)
    node, work = fresh(random_instance(0, m=3)), workspace()
    work.hasty = hasty
    outcome = tighten(node, 1000.0, work)
    assert isinstance(outcome, Dear if left else Pruned)
    assert node.bound == (second if left else 1001.0)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("share", [0.95, 1.01, 1.05])
def test_an_outcome_says_nothing_false_where_tours_find_no_room(seed, share):
    instance = random_instance(seed, m=3)
    best, node, work = optimum(instance), fresh(instance), workspace()
    work.tours_room = 3
    outcome = tighten(node, share * best, work)
    assert isinstance(outcome, Pruned | Improved | Branch)
    assert share < 1 or not isinstance(outcome, Pruned)
    assert share < 1 or node.bound <= best * (1 + 1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_fixing_is_thorough_where_that_leaves_far_fewer_legs(seed):
    instance, uavs = random_instance(seed), np.arange(M)
    cap, work = 1.02 * optimum(instance), workspace()
    allowed, blunt, sharp = Legs.of(instance).under(cap), Effort(0, 3, 50), Effort(5, 200, 50)
    at = generate(Master(N, uavs, cap), [work.pricer(allowed, cap, sharp)], cap, lambda: np.inf).best

    def legs_left(legs):
        return [int(np.isfinite(legs.between[k]).sum()) for k in uavs]

    roughly, well = (legs_left(fix_legs(work.pricer(allowed, cap, effort), uavs, at)) for effort in (blunt, sharp))
    either = legs_left(fix_as_worth(work.pricer(allowed, cap, blunt), sharp, uavs, at))
    assert either[0] <= well[0]
    assert either[1] <= (well[1] if either[0] < 0.9 * roughly[0] else roughly[1])
    assert sum(legs_left(fix_as_worth(work.pricer(allowed, cap, sharp), blunt, uavs, at))) <= sum(well)


def test_a_node_out_of_time_is_interrupted_and_one_overtaken_is_left():
    instance = random_instance(0)
    cap = 1.3 * optimum(instance)
    assert tighten(fresh(instance), cap, workspace(lambda: 0.0)) == Interrupted()
    work = workspace()
    work.better = lambda *_: True
    assert tighten(fresh(instance), cap, work) == Overtaken()


@pytest.mark.parametrize("seed", range(4))
def test_a_node_taken_up_again_goes_on_with_the_columns_that_routes_under_its_cap_may_use(seed, monkeypatch):
    instance = random_instance(seed, m=3)
    found, node, work, begun = SubsetDp().solve(instance, limits=Limits(time=600.0)), fresh(instance), workspace(), []
    best = found.objective
    work.better = lambda *_: True
    assert tighten(node, 1.1 * best, work) == Overtaken()
    before = node.columns

    def noted(master, *rest, **how):
        begun.append(list(master.columns))
        return generate(master, *rest, **how)

    monkeypatch.setattr(tightening, "generate", noted)
    tighten(node, 1.01 * best, work)
    cheap = [c for c in before if c.cost <= 1.01 * best]
    assert len(begun[0]) < len(cheap)
    optimal = {(k, frozenset(route)) for k, route in enumerate(found.routes)}
    assert [c for c in cheap if (c.uav, frozenset(c.tasks)) in optimal and c not in begun[0]] == []


def test_a_node_with_nothing_to_branch_on_and_no_room_is_stuck():
    instance = random_instance(0, m=1)
    node = fresh(instance)
    outcome = tighten(node, 1.05 * optimum(instance), workspace(labels=30))
    assert isinstance(outcome, Stuck)


def test_column_generation_says_how_it_ended():
    instance = random_instance(1)
    best = optimum(instance)
    legs, store = Legs.of(instance), make_store(N, 100_000)

    def ended(cap, effort, time_left=lambda: np.inf, **how):
        pricer = Pricer(legs.under(cap), cap, effort, store)
        return generate(Master(N, np.arange(M), cap), [pricer], cap, time_left, **how).ended

    told = []

    def overtaken(at, in_vain):
        told.append((at.value <= best, in_vain > 0))
        return True

    assert ended(1.2 * best, Effort(4, 100, 10**6)) is Ended.SOLVED
    assert ended(0.7 * best, Effort(4, 100, 10**6)) is Ended.PRUNED
    assert ended(1.2 * best, Effort(0, 1, 1)) is Ended.STUCK
    assert ended(1.2 * best, Effort(4, 100, 10**6), lambda: 0.0) is Ended.INTERRUPTED
    assert ended(1.2 * best, Effort(4, 100, 10**6), meanwhile=overtaken) is Ended.SOLVED
    assert told == []
    assert ended(1.2 * best, Effort(0, 1, 1), meanwhile=overtaken) is Ended.OVERTAKEN
    assert told == [(True, True)]


def test_what_fails_is_tried_ever_less_often_until_it_works() -> None:
    tries, done = Tries(), list[int]()
    for step in range(18):
        if tries.due():
            done.append(step)
            tries.note(worked=len(done) == 5)
    assert done == [0, 2, 5, 9, 14, 15, 17]
