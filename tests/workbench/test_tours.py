"""Figures of tours beside an instance: each UAV at its own speed, along its own paths."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from instances.environment.region import Region
from instances.fleet import Fleet, Return
from instances.scenario import Scenario, write_scenario
from workbench.planning import plan, write_plan
from workbench.tours import tours_beside

SCENARIO = Scenario(
    "s",
    Region.rectangle(9000, 9000),
    np.array([[0.0, 0.0], [9000.0, 0.0]]),
    20.0,
    tasks=np.array([[3000.0, 4000.0], [6000.0, 4000.0]]),
    fleet=Fleet(speeds=np.array([20.0, 25.0]), service=30.0),
)


def kept(scenario: Scenario, folder: Path) -> Path:
    write_scenario(scenario, folder / "s.toml")
    instance, paths = plan(scenario, "closed-form")
    write_plan(instance, paths, folder / "s.json", folder / "s.toml")
    return folder / "s.json"


def test_each_tour_is_told_at_its_own_speed(tmp_path: Path) -> None:
    instance, _ = plan(SCENARIO, "closed-form")
    first, second = tours_beside(kept(SCENARIO, tmp_path), instance, ((0,), (1,)))
    assert (first.length, second.length) == (pytest.approx(10_000), pytest.approx(10_000))
    assert (first.flight_time, second.flight_time) == (pytest.approx(500), pytest.approx(400))


def test_tours_that_end_elsewhere_are_not_told(tmp_path: Path) -> None:
    scenario = replace(SCENARIO, fleet=Fleet(returns=Return.NONE))
    instance, _ = plan(scenario, "closed-form")
    assert tours_beside(kept(scenario, tmp_path), instance, ((0,), (1,))) == []
