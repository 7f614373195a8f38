"""exact: who proves what, and two linked processes that share what they find."""

import multiprocessing

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing.exact import Exact
from formulations.routing.recorder import LinkedRecorder
from formulations.routing.solver import Event, Status, ignore
from formulations.routing.subset_dp import SubsetDp
from instances import Instance, Travel, check_routes


def random_instance(n: int, m: int, seed: int) -> Instance:
    rng = np.random.default_rng(seed)
    points = rng.uniform(0, 100, (n + m, 2))
    leg = points[None, :, :] - points[:, None, :]
    return Instance(f"plane-{n}-{m}-{seed}", np.hypot(leg[..., 0], leg[..., 1]) + 0.3 * leg[..., 0], n, m)


@pytest.mark.parametrize(
    ("n", "m", "threads", "by"),
    [
        (8, 2, 1, {"subset-dp"}),
        (17, 3, 1, {"branch-and-price"}),
        (18, 1, 1, {"branch-and-cut"}),
        (17, 2, 2, {"branch-and-price", "branch-and-cut"}),
        (17, 3, 2, {"branch-and-price"}),
    ],
)
def test_proves_the_optimum_and_says_by_whom(n: int, m: int, threads: int, by: set[str]) -> None:
    instance = random_instance(n, m, 1)
    events: list[Event] = []
    result = Exact().solve(instance, limits=Limits(time=300.0, threads=threads), observe=events.append)
    oracle = SubsetDp().solve(instance, limits=Limits(time=300.0))
    assert result.status is Status.OPTIMAL
    assert result.statistics["proved_by"] in by
    assert result.objective == pytest.approx(oracle.objective, abs=result.tolerance)
    assert result.objective is not None
    assert result.bound is not None
    assert result.objective - result.bound <= result.tolerance
    assert result.routes is not None
    assert not check_routes(instance, result.routes)
    assert any(event.routes == result.routes for event in events)
    assert not multiprocessing.active_children()


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("feasible", [True, False])
def test_a_fleet_that_cannot_fly_all_is_proved_to_be_one(threads: int, feasible: bool) -> None:
    """One UAV cannot serve a task, the other has a battery for it, or not."""
    cost = random_instance(17, 2, 1).cost
    without = cost.copy()
    without[0, 1:] = without[1:, 0] = np.inf
    there_and_back = cost[18, 0] + cost[0, 18]
    endurance = [np.inf, there_and_back * (1.0 if feasible else 0.5)]
    instance = Instance.of_travel("fleet", Travel.of_uavs([without, cost]), 17, endurance=endurance)
    result = Exact().solve(instance, limits=Limits(time=300.0, threads=threads))
    assert result.status is (Status.OPTIMAL if feasible else Status.INFEASIBLE)
    assert result.statistics["proved_by"] in {"branch-and-price", "branch-and-cut"}
    if feasible:
        oracle = SubsetDp().solve(instance, limits=Limits(time=300.0))
        assert result.objective == pytest.approx(oracle.objective, abs=result.tolerance)
        assert not check_routes(instance, result.routes or ())
    assert not multiprocessing.active_children()


def three_at_one_site(n: int, seed: int) -> Instance:
    """Return three UAVs that nothing tells apart."""
    nodes = [*range(n), n, n, n]
    return Instance("one-site", random_instance(n, 1, seed).cost[np.ix_(nodes, nodes)], n, 3)


@pytest.mark.parametrize("threads", [1, 2])
def test_three_uavs_of_one_site_are_proved_over_arcs_or_tours(threads: int) -> None:
    instance = three_at_one_site(17, 4)
    result = Exact().solve(instance, limits=Limits(time=300.0, threads=threads))
    assert result.status is Status.OPTIMAL
    assert result.statistics["proved_by"] in {"branch-and-price", "arc-tree"}
    oracle = SubsetDp().solve(instance, limits=Limits(time=300.0))
    assert result.objective == pytest.approx(oracle.objective, abs=result.tolerance)
    assert not multiprocessing.active_children()


@pytest.mark.slow
def test_columns_go_on_from_cuts_that_ended_early() -> None:
    """One node of cuts proves nothing here: columns take over, and nothing false is claimed."""
    instance = random_instance(36, 2, 3)
    result = Exact().solve(instance, limits=Limits(time=60.0, iterations=1))
    assert "cut_nodes" in result.statistics
    assert "rounds" in result.statistics
    assert result.routes is not None
    assert not check_routes(instance, result.routes)
    assert result.bound is not None
    assert result.bound <= (result.objective or 0.0)


def test_refuses_what_columns_refuse() -> None:
    cost = np.ones((303, 303)) - np.eye(303)
    assert Exact().accepts(Instance("fits", cost, 300, 3)) is None
    reason = Exact().accepts(Instance("too large", cost, 301, 2))
    assert reason is not None
    assert "300 tasks" in reason


def test_stopped_early_gives_routes() -> None:
    instance = random_instance(30, 3, 2)
    for threads in (1, 2):
        result = Exact().solve(instance, limits=Limits(time=0.3, threads=threads))
        assert result.routes is not None
        assert not check_routes(instance, result.routes)
        assert not multiprocessing.active_children()


def test_linked_recorders_share_incumbent_bound_and_proof() -> None:
    instance = random_instance(4, 2, 0)
    here, there = multiprocessing.Pipe()
    first, second = (LinkedRecorder(instance, Limits(), ignore) for _ in range(2))
    first.link, second.link = here, there
    first.incumbent(((0, 1), (2, 3)))
    first.raise_bound(1.0)
    assert second.remaining > 0
    assert second.routes == ((0, 1), (2, 3))
    assert second.bound == 1.0
    first.incumbent(((0, 1, 2, 3), ()))
    second.raise_bound(2.0)
    second.tell_proof(0.5)
    assert first.remaining == 0
    assert (first.bound, first.tolerance, first.met_by_peer) == (2.0, 0.5, True)


def test_a_peer_that_ends_leaves_what_it_said() -> None:
    instance = random_instance(4, 2, 0)
    here, there = multiprocessing.Pipe()
    recorder = LinkedRecorder(instance, Limits(), ignore, ((0, 1, 2, 3), ()))
    recorder.link = here
    there.send(("bound", 1.5))
    there.close()
    assert recorder.remaining > 0
    assert recorder.bound == 1.5
    recorder.raise_bound(1.6)
    recorder.listen()
    assert recorder.link is None
