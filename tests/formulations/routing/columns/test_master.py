"""The restricted master: its columns, and the box of its duals."""

from __future__ import annotations

import numpy as np
import pytest

from formulations.routing.columns.master import Master
from formulations.routing.columns.pricing import Column


def test_the_box_opens_where_it_binds_and_after_some_times_everywhere():
    """Task 0 has a tour of its own, task 1 none: the box binds at task 1 alone."""
    master, halves = Master(2, np.zeros(1, np.int64), 1.0), []
    master.add([Column(0, (0,), 0.5)])
    for _ in range(8):
        master.solve()
        assert master.penalised
        assert master.widen(1000.0)
        halves.append(master.half[:2].tolist())
    assert halves[0] == [1.0, 2.0]
    assert halves[-1][0] > 1.0
    assert halves[-1][1] == 256.0


def test_the_box_opens_no_wider_than_it_may():
    """At its largest it stays shut, though it binds."""
    master = Master(1, np.zeros(1, np.int64), 1.0)
    master.solve()
    assert master.widen(1.5)
    master.solve()
    assert master.penalised
    assert not master.widen(1.5)


def test_a_programme_that_time_is_too_short_for_is_not_solved_and_later_is():
    """The limit is one of a run, not of all: time that others took counts for nothing, and what is left is kept to."""
    rng, n = np.random.default_rng(0), 60
    master = Master(n, np.zeros(1, np.int64), 1.0)
    master.add([Column(0, tuple(rng.choice(n, 5, replace=False).tolist()), rng.uniform(1, 2)) for _ in range(2000)])
    assert master.solve(lambda: 0.0) is None
    value = [optimum.value for left in (60.0, np.inf) if (optimum := master.solve(lambda left=left: left)) is not None]
    assert value == [pytest.approx(value[0])] * 2
    assert value[0] > 0


def test_a_cheaper_tour_over_known_tasks_replaces_the_known_one() -> None:
    master = Master(2, np.arange(1), 100.0)
    assert master.add([Column(0, (0, 1), 10.0)]) == 1
    assert master.add([Column(0, (1, 0), 8.0)]) == 1
    assert master.add([Column(0, (0, 1), 9.0)]) == 0
    assert master.solve()[0] == pytest.approx(8.0)
