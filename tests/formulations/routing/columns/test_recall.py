"""What pricing learns to remember where it loses labels."""

import numpy as np
import pytest

from formulations.routing.columns.completion import Memory
from formulations.routing.columns.label_search import no_limit, search
from formulations.routing.columns.labelling import make_store
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.pricing import Duals, Effort, Pricer
from tests.formulations.routing.columns.test_walks import one_site

EACH_TASK = Duals(np.full(16, 15.0), np.array([0.5, 0.5]), np.zeros(2), np.zeros(0))


def pricer_of(seed: int, beam: int) -> Pricer:
    instance = one_site(16, 2, seed)
    cap = 15.0 * 16
    return Pricer(Legs.of(instance).under(cap), cap, Effort(3, 200, beam), make_store(16, 2_000_000))


def labels_below(pricer: Pricer, threshold: float) -> tuple[int, float]:
    """How many labels it takes to find UAV 0's tours below a threshold, and the least of these."""
    problem = pricer.subproblem(0, EACH_TASK)
    found = search(problem, pricer.store.of_uav(0), threshold, no_limit, tours=1_000_000)
    assert found.complete
    return found.labels, float(found.values.min(initial=np.inf))


@pytest.mark.parametrize("size", [0, 1, 3, 5])
def test_a_memory_goes_on_with_what_is_remembered_there_and_forbids_the_rest(size: int) -> None:
    rng = np.random.default_rng(size)
    memory = Memory.nearest(rng.random((7, 7)), size, rng.random((7, 7)))
    near, held = memory.near.tolist(), range(size)
    for i in range(7):
        for j in range(7):
            for number in range(1 << size):
                remembered = {near[i][q] for q in held if number >> q & 1}
                after = sum(1 << q for q in held if near[j][q] in remembered | {i})
                assert memory.step[i, j, number] == (1 << size if j in remembered else after)


def test_lost_labels_teach_what_to_remember_and_fewer_are_made() -> None:
    before = after = 0
    for seed in range(4):
        pricer = pricer_of(seed, beam=20)
        least = labels_below(pricer, np.inf)[1] + 0.5
        before += labels_below(pricer, least)[0]
        for _ in range(30):
            priced = pricer.price_all([0, 1], EACH_TASK, np.full(2, least))[0]
            assert priced.complete != bool(priced.lost)
        after += labels_below(pricer, least)[0]
    assert after < 0.8 * before


def test_nothing_is_learnt_where_no_label_is_lost() -> None:
    pricer = pricer_of(0, beam=10**6)
    priced = pricer.price_all([0, 1], EACH_TASK, np.full(2, -1.0))
    assert priced[0].complete
    assert not priced[0].lost
    assert pricer.recall.lessons == 0


def test_all_pricers_of_a_tree_remember_what_one_has_learnt() -> None:
    pricer = pricer_of(1, beam=20)
    other = pricer.at(Effort(4, 200, 20), pricer.legs)
    before = other.memory
    pricer.price_all([0], EACH_TASK, np.full(2, -1.0))
    assert other.memory is not before
    assert (other.memory.near != before.near).any()
    assert other.memory is other.memory


def test_nothing_is_learnt_where_cuts_are_paid_for() -> None:
    pricer = pricer_of(1, beam=20)
    cut = Duals(*(getattr(EACH_TASK, name) for name in ("price", "sigma", "rent")), np.array([1.0]), ((0, 1, 2),))
    priced = pricer.price_all([0], cut, np.full(2, -1.0))[0]
    assert not priced.complete
    assert not priced.lost
    assert pricer.recall.lessons == 0
