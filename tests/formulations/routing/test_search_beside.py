"""The search beside the tree: as many steps as the tree's work deserves, the more the wider the gap is."""

from collections import Counter

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing import search_beside
from formulations.routing.columns.node import Hint
from formulations.routing.columns.pricing import Column
from formulations.routing.recorder import Recorder
from formulations.routing.search_beside import Search
from formulations.routing.solver import ignore
from instances import Instance

N, M = 8, 2


@pytest.fixture
def steps(monkeypatch):
    """Return what follows the steps of every search that is asked for, none of which finds anything."""
    asked = []

    def search(recorder, steps, *rest, **how):
        asked.append(steps)
        return steps

    monkeypatch.setattr(search_beside, "search", search)
    return asked


@pytest.fixture
def around(monkeypatch):
    """Return what follows the tours that are searched around, with nothing found."""
    asked = []
    monkeypatch.setattr(search_beside, "search_around", lambda recorder, tour, *rest: asked.append(tour))
    return asked


@pytest.fixture
def recorder():
    xy = np.random.default_rng(1).random((N + M, 2))
    instance = Instance("plane", np.hypot(*(xy[:, None] - xy).transpose(2, 0, 1)), N, M)
    return Recorder(instance, Limits(time=60.0), ignore, (tuple(range(N // 2)), tuple(range(N // 2, N))))


def searches(recorder, steps, gap, rounds):
    """Return the rounds of a tree after which it is searched, at a gap, none of which finds anything."""
    steps.clear()
    counts, after = Counter(), []
    search = Search(recorder, counts, 0, 1, 1e-6)
    for _ in range(rounds):
        counts["rounds"] += 1
        before = len(steps)
        assert not search.better(Hint((1 - gap) * recorder.objective))
        if len(steps) > before:
            after.append(counts["rounds"])
    return after


def test_the_wider_the_gap_the_sooner_it_is_searched_up_to_a_limit(recorder, steps):
    narrow, wide, wider, widest, beyond = (
        searches(recorder, steps, gap, 200)[0] for gap in (1e-4, 0.01, 0.02, 0.3, 0.6)
    )
    assert narrow > wide > wider > widest == beyond


def test_a_gap_is_no_wider_than_what_is_proved_leaves_it_whatever_a_relaxation_says(recorder, steps):
    narrow, wide = (searches(recorder, steps, gap, 200)[0] for gap in (1e-4, 0.3))
    recorder.raise_bound((1 - 1e-4) * recorder.objective)
    assert searches(recorder, steps, 0.3, 200)[0] == narrow > wide


def test_after_searches_in_vain_a_wide_gap_is_searched_no_oftener_than_a_narrow_one(recorder, steps):
    wide, narrow = (np.diff(searches(recorder, steps, gap, 800)) for gap in (0.3, 1e-4))
    assert wide[0] < wide[-1]
    assert wide[-1] == pytest.approx(narrow[-1], abs=1)


def test_long_searches_begin_afresh(recorder, monkeypatch):
    begun = []

    def search(recorder, steps, *rest, afresh=False):
        begun.append(afresh)
        return steps

    monkeypatch.setattr(search_beside, "search", search)
    counts = Counter()
    search = Search(recorder, counts, 0, 1, 1e-6)
    while len(begun) < 3:
        counts["rounds"] += 10
        search.better(Hint(0.9 * recorder.objective))
    assert all(begun)


def test_what_was_due_at_a_wide_gap_stays_due_when_it_narrows(recorder, steps):
    counts = Counter(rounds=100)
    search = Search(recorder, counts, 0, 1, 1e-6)
    search.better(Hint(0.9 * recorder.objective))
    [first] = steps
    counts["rounds"] += 1
    search.better(Hint((1 - 1e-6) * recorder.objective))
    assert steps == [first]


LONG, OTHER, SELDOM = Column(0, (0, 1), 9.0), Column(1, (2, 3), 5.0), Column(1, (4,), 3.0)


def near(recorder, **tours):
    """Return the hint of a relaxation a little shorter than the routes known."""
    return Hint(0.999 * recorder.objective, **tours)


def test_a_near_relaxation_is_searched_around_its_long_tours_at_once_and_once_only(recorder, steps, around):
    search, hint = Search(recorder, Counter(), 0, 1, 1e-6), near(recorder, long=[LONG, OTHER], used=[(SELDOM, 1.0)])
    for _ in range(2):
        search.better(hint)
    assert around == [LONG, OTHER]
    search.better(hint)
    assert set(around[2:]) == {SELDOM}


def test_of_a_relaxation_far_from_the_routes_no_tour_is_searched_around(recorder, steps, around):
    hint = Hint(0.9 * recorder.objective, [LONG], [(LONG, 1.0)])
    Search(recorder, Counter(rounds=10_000), 0, 1, 1e-6).better(hint)
    assert around == []
    assert len(steps) == 1


def test_tours_to_search_around_are_drawn_by_their_weights(recorder, steps, around):
    counts = Counter(rounds=10_000)
    Search(recorder, counts, 0, 1, 1e-6).better(near(recorder, used=[(OTHER, 0.9), (SELDOM, 0.1)]))
    assert around.count(OTHER) > 4 * around.count(SELDOM) > 0
    assert len(around) == pytest.approx(4 * len(steps), abs=4)


def test_a_list_in_vain_makes_more_searches_due_where_the_relaxation_is_near(recorder, steps, around):
    counts = Counter()
    search = Search(recorder, counts, 0, 1, 1e-6)
    search.better(near(recorder, used=[(OTHER, 1.0)]))
    before = len(around) + len(steps)
    counts["lists in vain"] += 1
    search.better(near(recorder, used=[(OTHER, 1.0)]))
    assert len(around) + len(steps) > 2 * before


def test_the_more_searches_around_tours_find_nothing_the_fewer_are_due(recorder, steps, around):
    search, hint, asked = Search(recorder, Counter(), 0, 1, 1e-6), near(recorder, used=[(OTHER, 1.0)]), []
    for _ in range(40):
        before = len(around) + len(steps)
        search.better(hint)
        asked.append(len(around) + len(steps) - before)
    assert sum(asked[:10]) > 2 * sum(asked[-10:]) > 0
