"""The restricted master: the box of its duals."""

from __future__ import annotations

import numpy as np

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
