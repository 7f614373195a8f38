"""How far towards the master's duals the next prices lie."""

import numpy as np
import pytest

from formulations.routing.columns.master import Master
from formulations.routing.columns.pricing import Column, Duals, Priced
from formulations.routing.columns.smoothing import adapted

MASTER = Master(2, np.arange(1), 100.0)
PRICED = {0: Priced(-5.0, [Column(0, (0,), 10.0)], True)}


def duals(first, second):
    return Duals(np.array([first, second]), np.ones(1), np.zeros(1), np.zeros(0))


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_the_share_grows_where_the_bound_rises_towards_the_master_and_shrinks_where_it_falls(share):
    tried = duals(15.0, 20.0)
    # task 0 is in the best tour: its price comes in and goes out; that of task 1 comes in
    assert share < adapted(share, PRICED, tried, MASTER, duals(15.0, 30.0)) < 1.0
    assert 0.0 < adapted(share, PRICED, tried, MASTER, duals(15.0, 10.0)) < share
    assert adapted(share, PRICED, tried, MASTER, duals(99.0, 20.0)) < share


def test_with_no_tour_worth_adding_only_the_prices_count():
    nothing = {0: Priced(0.0, [], True)}
    assert adapted(0.5, nothing, duals(1.0, 1.0), MASTER, duals(2.0, 1.0)) > 0.5


def test_a_walk_earns_a_price_as_often_as_it_comes():
    [once, twice] = duals(3.0, 4.0).values([Column(0, (0, 1), 10.0), Column(0, (0, 1, 0), 10.0)])
    assert once == pytest.approx(3.0)
    assert twice == pytest.approx(0.0)
    assert duals(3.0, 4.0).values([]).size == 0
