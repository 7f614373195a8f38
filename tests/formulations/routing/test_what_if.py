"""What an extra UAV or battery is worth: the changes, and the interval of the gain."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from formulations.routing.what_if import changes, gain
from instances import Instance, Routes, objective

Oracle = Callable[[Instance], tuple[float, Routes]]


def test_every_change_can_only_help(fleets: Callable[..., Instance], held_karp: Oracle) -> None:
    instance = fleets(5, 3, 1)
    before, routes = held_karp(instance)
    found = list(changes(instance))
    assert {change.uav for change in found} == {0, 1, 2}
    for change in found:
        assert objective(change.instance, change.start(routes)) == before
        assert held_karp(change.instance)[0] <= before
    assert min(held_karp(change.instance)[0] for change in found) < before


def test_uavs_that_can_be_exchanged_are_changed_once(windy: Callable[..., Instance]) -> None:
    base = windy(4, 1, 0)
    nodes = [0, 1, 2, 3, 4, 4, 4]
    alike = Instance("alike", base.cost[np.ix_(nodes, nodes)], 4, 3)
    assert [change.words for change in changes(alike)] == ["one more UAV like UAV 0"]
    limited = replace(alike, endurance=[9e3, 9e3, np.inf])
    assert [change.words for change in changes(limited)] == [
        "one more UAV like UAV 0",
        "one more UAV like UAV 2",
        "one more battery for UAV 0",
    ]


def test_the_gain_is_as_sure_as_the_proofs() -> None:
    assert gain((10.0, 10.0), (7.0, 7.0)) == (3.0, 3.0)
    assert gain((10.0, 9.0), (8.0, 6.0)) == (1.0, 4.0)
    assert gain((10.0, 9.0), (9.5, 6.0)) == (0.0, 4.0)
    assert gain((10.0, None), (8.0, None)) == (0.0, 10.0)
    assert gain((None, None), (8.0, 8.0)) == (0.0, None)
