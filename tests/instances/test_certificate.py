"""Certificates: those of true bounds hold, what is false is refuted, by code that shares none with what makes them."""

from dataclasses import replace
from itertools import pairwise, permutations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from formulations.limits import Limits
from formulations.routing.arc_tree import ArcTree
from formulations.routing.branch_and_price import BranchAndPrice
from formulations.routing.certifying import certify
from formulations.routing.subset_dp import SubsetDp
from instances import InputError, Instance, makespan
from instances.certificate import (
    Blossom,
    Certificate,
    Crowd,
    Cut,
    Node,
    Prices,
    Step,
    read_certificate,
    verify,
    write_certificate,
)
from instances.certificate.joint import holds_no_tour
from instances.certificate.tours import TooManyError, UavLegs, list_tours


def drawn(n_tasks: int, n_depots: int, seed: int, **about: object) -> Instance:
    cost = np.random.default_rng(seed).uniform(10.0, 100.0, (n_tasks + n_depots,) * 2)
    np.fill_diagonal(cost, 0.0)
    return Instance(f"drawn-{seed}", cost, n_tasks, n_depots, **about)


def at_one_site(n_tasks: int, n_depots: int, seed: int) -> Instance:
    cost = drawn(n_tasks, 1, seed).cost
    nodes = [*range(n_tasks), *[n_tasks] * n_depots]
    return Instance(f"at-one-site-{seed}", cost[np.ix_(nodes, nodes)], n_tasks, n_depots)


@pytest.fixture(scope="module")
def proved() -> tuple[Instance, Certificate]:
    """A proof of several cases: in so little room no case ends before tasks are given to UAVs."""
    instance, start = drawn(10, 3, 0), ((0, 1, 2, 3), (4, 5, 6), (7, 8, 9))
    solver = BranchAndPrice(starts=0, tours=100, labels=1000)
    return instance, certify(instance, limits=Limits(time=60.0), start=start, solver=solver)


def test_a_proof_is_confirmed_also_from_its_file(proved, tmp_path):
    instance, certificate = proved
    assert certificate.bound == pytest.approx(certificate.objective, rel=1e-6)
    assert len(certificate.nodes) > 1
    assert verify(instance, certificate).problems == ()
    write_certificate(tmp_path / "a.certificate.json.gz", certificate)
    assert read_certificate(tmp_path / "a.certificate.json.gz") == certificate


def test_what_is_not_so_is_refuted(proved):
    instance, true = proved
    last = true.steps[-1]
    free = replace(last.prices, task=(0.0,) * 10, sets=(), rho=())
    false = {
        "not closed: its bound": replace(true, steps=(*true.steps[:-1], replace(last, prices=free))),
        "neither closed nor split": replace(true, steps=true.steps[:-1]),
        "the routes take": replace(true, objective=true.objective * 0.99),
        "is above the routes": replace(true, bound=true.objective * 1.01),
        "the routes: Task": replace(true, routes=((0, 1, 2, 3), (3, 4, 5), (6, 7, 8, 9))),
    }
    for said, certificate in false.items():
        assert said in " ".join(verify(instance, certificate).problems), said


def test_cases_must_miss_no_routes():
    instance = drawn(4, 2, 0)
    free = Prices((0.0,) * 4, (0.5, 0.5), (0.0, 0.0))
    nodes = (Node(), Node(0, 1, (0,)), Node(0, 1, (0,)))
    lost = Certificate(instance.name, instance.digest, 1.0, None, (), nodes, (Step(1, free), Step(2, free)))
    assert "miss no routes" in verify(instance, lost).problems[0]


def test_uavs_that_are_alike_are_certified_as_one():
    """A task is given to one of them and forbidden to all, in two cases that between them forget the others."""
    start = ((0, 1, 2), (3, 4, 5), (6, 7, 8))
    instance, solver = at_one_site(9, 3, 0), BranchAndPrice(starts=0, tours=100, labels=1000)
    certificate = certify(instance, limits=Limits(time=60.0), start=start, solver=solver)
    assert certificate.bound == pytest.approx(SubsetDp().solve(instance, limits=Limits(time=20.0)).objective, rel=1e-6)
    forgotten = [{*first.forbidden} & {*second.forbidden} for first, second in pairs_of_cases(certificate)]
    assert any(forgotten)
    assert verify(instance, certificate).problems == ()
    third_flies_less = replace(instance, endurance=(1e4, 1e4, 0.999 * certificate.bound))
    claimed = replace(certificate, digest=third_flies_less.digest, routes=(), objective=None)
    assert "miss no routes" in " ".join(verify(third_flies_less, claimed).problems)


def test_a_task_so_far_out_that_no_tour_holds_it_is_one_step():
    place = np.array([0.0, 1.0, 2.0, 50.0, 3.0, 3.0])
    instance = Instance("far", np.abs(place[:, None] - place), 4, 2)
    certificate = certify(instance, limits=Limits(time=20.0), start=((3,), (0, 1, 2)))
    assert certificate.bound == pytest.approx(94.0, rel=1e-6)
    assert len(certificate.steps) == 1
    assert verify(instance, certificate).problems == ()


def pairs_of_cases(certificate: Certificate) -> list[tuple[Node, Node]]:
    """Return the two cases after each that has any."""
    after: dict[int, list[Node]] = {}
    for node in certificate.nodes[1:]:
        after.setdefault(node.parent, []).append(node)
    return [(first, second) for first, second in after.values()]


def test_what_is_no_certificate_of_it_is_unusable(proved, tmp_path):
    instance, certificate = proved
    with pytest.raises(InputError, match="is the certificate of"):
        verify(drawn(10, 3, 4), certificate)
    with pytest.raises(InputError, match="must be finite numbers"):
        verify(instance, replace(certificate, steps=(Step(0, Prices((1.0,), (1.0,), (0.0,))),)))
    negative = replace(certificate.steps[0].prices, uav=(-0.1, 0.6, 0.5))
    with pytest.raises(InputError, match="must not be negative"):
        verify(instance, replace(certificate, steps=(replace(certificate.steps[0], prices=negative),)))
    with pytest.raises(TooManyError, match="more than 3 paths"):
        verify(instance, certificate, room=3)
    for text in ("{}", '{"format": "mmmdmtsp-certificate", "version": 1, "objective": null}'):
        (tmp_path / "a.json").write_text(text)
        with pytest.raises(InputError, match=r"a\.json: is no certificate"):
            read_certificate(tmp_path / "a.json")


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 10_000), allowance=st.floats(-200.0, 20.0), rho=st.floats(0.0, 40.0))
def test_all_tours_within_the_threshold_are_listed_and_no_others(seed, allowance, rho):
    instance, cap = drawn(5, 1, seed), 260.0
    cost, tasks = instance.cost, range(5)
    price = tuple(np.random.default_rng(seed + 1).uniform(0.0, 80.0, 5).tolist())
    prices = Prices(price, (0.7,), (0.0,), ((0, 1, 2), (1, 3, 4)), (rho, 2.0))
    legs = UavLegs(cost[5, :5], np.where(np.eye(5, dtype=bool), np.inf, cost[:5, :5]), cost[:5, 5])
    wanted = {}
    for size in range(1, 6):
        for order in permutations(tasks, size):
            held = frozenset(order)
            wanted[held] = min(wanted.get(held, np.inf), makespan(_alone(instance, held), (_numbered(order),)))
    paid = {
        held: sum(r for s, r in zip(prices.sets, prices.rho, strict=True) if len(held & {*s}) > 1) for held in wanted
    }
    reduced = {held: 0.7 * c - sum(price[i] for i in held) + paid[held] for held, c in wanted.items()}
    tours = list_tours(legs, cap, prices, 0, allowance, 10_000)
    found = {frozenset(np.flatnonzero(row).tolist()): c for row, c in zip(tours.holds, tours.cost, strict=True)}
    assert found == pytest.approx({h: c for h, c in wanted.items() if c <= cap and reduced[h] <= allowance})


def _alone(instance: Instance, held: frozenset[int]) -> Instance:
    kept = [*sorted(held), instance.n_tasks]
    return Instance("part", instance.cost[np.ix_(kept, kept)], len(held), 1)


def _numbered(order: tuple[int, ...]) -> tuple[int, ...]:
    return tuple(sorted(order).index(i) for i in order)


@settings(max_examples=5, deadline=None)
@given(seed=st.integers(0, 1000))
def test_fleets_and_endurance_are_certified_too(seed):
    instance = drawn(6, 2, seed, endurance=[400.0, 330.0])
    solved = SubsetDp().solve(instance, limits=Limits(time=20.0))
    assume(solved.routes is not None)
    certificate = certify(instance, limits=Limits(time=20.0), start=solved.routes)
    assert certificate.bound == pytest.approx(solved.objective, rel=1e-6)
    assert verify(instance, certificate).problems == ()


@pytest.fixture(scope="module")
def over_arcs() -> tuple[Instance, Certificate]:
    """A proof over arcs of many cases, of UAVs that are alike, with tasks given and arcs flown."""
    instance = at_one_site(12, 2, 3)
    return instance, certify(instance, limits=Limits(time=60.0), solver=ArcTree(starts=0, tried=2))


def test_a_proof_over_arcs_is_confirmed_also_from_its_file(over_arcs, tmp_path):
    instance, certificate = over_arcs
    optimum = SubsetDp().solve(instance, limits=Limits(time=20.0)).objective
    assert certificate.bound == pytest.approx(optimum, rel=1e-6)
    assert certificate.bound < optimum
    assert certificate.cuts
    assert any(node.task is not None for node in certificate.nodes)
    assert any(node.arcs for node in certificate.nodes)
    verdict = verify(instance, certificate)
    assert verdict.problems == ()
    assert verdict.closed == len(certificate.steps) > 5
    write_certificate(tmp_path / "a.certificate.json.gz", certificate)
    assert read_certificate(tmp_path / "a.certificate.json.gz") == certificate


def test_what_arcs_do_not_prove_is_refuted(over_arcs):
    instance, true = over_arcs
    last, free = true.steps[-1], true.steps[-1].prices
    nodes, by_arcs = true.nodes, next(k for k, node in enumerate(true.nodes) if node.arcs and node.flown)
    dear = replace(free, mu=tuple(10 * mu for mu in free.mu))
    false = {
        "is not closed: its bound": replace(true, steps=(*true.steps[:-1], replace(last, prices=dear))),
        "neither closed nor split": replace(true, steps=true.steps[:-1]),
        "nor split into two cases": replace(
            true, nodes=(*nodes[:by_arcs], replace(nodes[by_arcs], flown=False), *nodes[by_arcs + 1 :])
        ),
    }
    for said, certificate in false.items():
        assert said in " ".join(verify(instance, certificate).problems), said
    unusable = {
        "must be finite numbers": replace(free, use=(0.0,)),
        "must not be negative": replace(free, use=(1.0, 0.0)),
        "cuts are 0": replace(free, cuts=(*free.cuts, 10**6), mu=(*free.mu, 0.0)),
        "prices rho": replace(free, rho=(*free.rho, 0.0)),
    }
    for said, prices in unusable.items():
        with pytest.raises(InputError, match=said):
            verify(instance, replace(true, steps=(*true.steps[:-1], replace(last, prices=prices))))
    with pytest.raises(InputError, match="a cut must be of"):
        verify(instance, replace(true, cuts=(Cut(0, 11, (0, 1)), *true.cuts[1:])))


def test_cuts_of_all_uavs_are_checked_for_themselves(over_arcs):
    instance, true = over_arcs
    kinds = [type(cut) for cut in true.joint]
    parity, crowd = (next(cut for cut in true.joint if isinstance(cut, kind)) for kind in (Blossom, Crowd))
    assert any(step.prices.nu for step in true.steps)
    easy = replace(crowd, tasks=crowd.tasks[:2], potential=(0.0, 0.0, 0.0))
    where = kinds.index(Crowd)
    false = replace(true, joint=(*true.joint[:where], easy, *true.joint[where + 1 :]))
    assert "too many for one is not proved" in verify(instance, false).problems[0]
    unusable = {
        "odd number of teeth": replace(parity, teeth=parity.teeth[1:]),
        "which cross its handle": replace(parity, teeth=((parity.handle[0], parity.handle[1]), *parity.teeth[1:])),
        "must be different edges": replace(parity, teeth=(parity.teeth[1][::-1], *parity.teeth[1:])),
        "some of the tasks 0": replace(parity, handle=(*parity.handle, 12)),
        "finite potential": replace(crowd, potential=crowd.potential[1:]),
    }
    for said, cut in unusable.items():
        with pytest.raises(InputError, match=said):
            verify(
                instance, replace(true, joint=(*true.joint, cut) if isinstance(cut, Blossom) else (cut,) * len(kinds))
            )
    step = true.steps[-1]
    for said, prices in {
        "must be finite numbers": replace(step.prices, nu=(*step.prices.nu, 0.0)),
        "cuts of all UAVs are 0": replace(step.prices, nu=(1.0,), joint=(len(kinds),)),
        "must not be negative": replace(step.prices, nu=(-1.0,), joint=(0,)),
    }.items():
        with pytest.raises(InputError, match=said):
            verify(instance, replace(true, steps=(*true.steps[:-1], replace(step, prices=prices))))


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_a_crowd_is_believed_only_where_no_tour_of_any_uav_holds_it(seed):
    rng = np.random.default_rng(seed)
    instance = drawn(5, 2, seed)
    legs = [UavLegs(instance.cost[5 + k, :5], instance.cost[:5, :5].copy(), instance.cost[:5, 5 + k]) for k in range(2)]
    for of in legs:
        np.fill_diagonal(of.between, np.inf)
    tasks = tuple(rng.choice(5, 3, replace=False).tolist())
    others = [i for i in range(5) if i not in tasks]
    tours = [order for more in ([], others[:1], others[1:], others) for order in permutations((*tasks, *more))]
    shortest = min(
        of.out[order[0]] + sum(of.between[i, j] for i, j in pairwise(order)) + of.home[order[-1]]
        for of in legs
        for order in tours
    )
    potential = tuple(rng.normal(0, 15, 4).tolist())
    for share in rng.uniform(0.2, 1.0, 5):
        if holds_no_tour(Crowd(tasks, potential), legs, np.array([share * shortest, 20.0])):
            assert share < 1.0
    assert not holds_no_tour(Crowd(tasks, potential), legs, np.array([shortest, 20.0]))


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 1000))
def test_stopped_early_or_of_fleets_arcs_certify_what_they_reached(seed):
    instance = drawn(9, 3, seed, endurance=[400.0, 330.0, 1000.0])
    solved = SubsetDp().solve(instance, limits=Limits(time=20.0))
    assume(solved.routes is not None)
    for nodes in (3, None):
        limits = Limits(time=60.0, iterations=nodes)
        certificate = certify(instance, limits=limits, start=solved.routes, solver=ArcTree(starts=0))
        assert 0 < certificate.bound < solved.objective
        assert verify(instance, certificate).problems == ()
    assert certificate.bound == pytest.approx(solved.objective, rel=1e-6)
