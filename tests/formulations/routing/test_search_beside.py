"""The search beside the tree: as many steps as the tree's work deserves, the more the wider the gap is."""

from collections import Counter

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing import search_beside
from formulations.routing.recorder import Recorder
from formulations.routing.search_beside import STEPS, Search
from formulations.routing.solver import ignore
from instances import Instance

N, M = 8, 2


@pytest.fixture
def steps(monkeypatch):
    """Return what follows the steps of every search that is asked for, none of which finds anything."""
    asked = []
    monkeypatch.setattr(search_beside, "search", lambda recorder, steps, *rest: asked.append(steps))
    return asked


@pytest.fixture
def recorder():
    xy = np.random.default_rng(1).random((N + M, 2))
    instance = Instance("plane", np.hypot(*(xy[:, None] - xy).transpose(2, 0, 1)), N, M)
    return Recorder(instance, Limits(time=60.0), ignore, (tuple(range(N // 2)), tuple(range(N // 2, N))))


def searched(recorder, steps, gap, rounds):
    """Return the steps searched at a gap while the tree has so many rounds, one after the other."""
    steps.clear()
    counts = Counter()
    search = Search(recorder, counts, 0, 1, 1e-6)
    for _ in range(rounds):
        counts["rounds"] += 1
        assert not search.better((1 - gap) * recorder.objective, ())
    return sum(steps)


def test_a_wide_gap_deserves_more_steps_in_proportion_up_to_a_limit(recorder, steps):
    narrow, wide, wider, widest = (searched(recorder, steps, gap, 400) for gap in (1e-4, 0.01, 0.02, 0.5))
    assert narrow > 0
    once = STEPS * N**2  # what is left to be due in the end is less than a search
    assert wide == pytest.approx(2 * narrow, abs=once)
    assert wider == pytest.approx(4 * narrow, abs=2 * once)
    assert wider < widest <= 10 * narrow


def test_what_was_due_at_a_wide_gap_stays_due_when_it_narrows(recorder, steps):
    counts = Counter(rounds=100)
    search = Search(recorder, counts, 0, 1, 1e-6)
    search.better(0.9 * recorder.objective, ())
    [first] = steps
    counts["rounds"] += 1
    search.better((1 - 1e-6) * recorder.objective, ())
    assert steps == [first]
