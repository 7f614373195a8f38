"""A UAV that sets the relaxation alone is counted no more: what is said of routes stays true."""

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing.branch_and_price import BranchAndPrice
from formulations.routing.certifying import certify
from formulations.routing.columns.exempting import sole_bottleneck
from formulations.routing.columns.master import Master
from formulations.routing.columns.node import Node
from formulations.routing.columns.pricing import Column, Duals
from formulations.routing.solver import Status
from formulations.routing.subset_dp import SubsetDp
from instances import Instance
from instances.certificate import verify

N, M = 9, 3


def with_a_task_far_out(seed, n=N):
    """Tasks and depots in a square, and one task so far from it that who flies there does hardly anything else."""
    points = np.random.default_rng(seed).uniform(0, 100, (n + M, 2))
    points[0] = 220.0, 50.0
    leg = points[None] - points[:, None]
    return Instance("far", np.hypot(leg[..., 0], leg[..., 1]) + 0.2 * leg[..., 0], n, M)


def two_alone(*, exempt=()):
    """UAV 0 has the far task, UAVs 1 and 2 share two tasks in halves."""
    master = Master(3, np.arange(3), 1000.0, exempt=exempt)
    tours = [(k, tasks, cost) for k in (1, 2) for tasks, cost in [((1,), 10.0), ((2,), 14.0), ((1, 2), 30.0)]]
    master.add([Column(0, (0,), 90.0), *(Column(*tour) for tour in tours)])
    return master


def test_the_cost_of_an_exempt_uav_sets_no_value_and_has_no_price():
    value, duals, weight = two_alone().solve()
    assert value == pytest.approx(90.0)
    assert sole_bottleneck(two_alone(), duals, weight) == 0
    value, duals, _ = two_alone(exempt={0}).solve()
    assert value == pytest.approx(12.0, abs=2.0)
    assert duals.sigma[0] == 0.0
    assert duals.sigma.sum() == pytest.approx(1.0)


def test_who_shares_its_tour_or_is_the_last_one_counted_does_not_set_it_alone():
    master, sigma = two_alone(), np.array([0.95, 0.05, 0.0])
    duals = Duals(np.zeros(3), sigma, np.zeros(3), np.zeros(0))
    halves = np.array([0.5, *np.zeros(6)])
    whole = np.array([1.0, *np.zeros(6)])
    assert sole_bottleneck(master, duals, whole) == 0
    assert sole_bottleneck(master, duals, halves) is None
    assert sole_bottleneck(master, Duals(np.zeros(3), sigma[::-1] * 0.8, np.zeros(3), np.zeros(0)), whole) is None
    assert sole_bottleneck(two_alone(exempt={1, 2}), duals, whole) is None


@pytest.mark.parametrize("seed", range(6))
def test_proofs_hold_where_one_uav_sets_the_relaxation(seed):
    instance = with_a_task_far_out(seed)
    found = BranchAndPrice().solve(instance, limits=Limits(time=60.0))
    assert found.status is Status.OPTIMAL
    assert found.objective == pytest.approx(SubsetDp().solve(instance, limits=Limits(time=600.0)).objective)


@pytest.mark.parametrize("seed", [7])
def test_what_is_proved_with_uavs_exempt_is_confirmed_by_who_knows_nothing_of_it(seed, monkeypatch):
    """In so little room no case ends before tasks are given to UAVs."""
    instance, exempted, exempt = with_a_task_far_out(seed, 10), [], Node.exempt_cost_of

    def noting(node, k, level):
        exempted.append(k)
        exempt(node, k, level)

    monkeypatch.setattr(Node, "exempt_cost_of", noting)
    start = ((*range(6),), (6, 7), (8, 9))
    solver = BranchAndPrice(starts=0, tours=100, labels=1000)
    certificate = certify(instance, limits=Limits(time=60.0), start=start, solver=solver)
    assert exempted
    assert certificate.bound == pytest.approx(certificate.objective, rel=1e-6)
    assert verify(instance, certificate).problems == ()
