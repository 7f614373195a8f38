"""What is drawn again for a comparison, and which plans nobody may fly."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from formulations.mapping.flight import Flight, plan_flight
from instances.environment.drift import DriftingField
from instances.environment.propagation import radio_map
from instances.environment.radio import RadioMap, RadioSource
from instances.environment.terrain import Terrain
from workbench.mission import baselines
from workbench.mission.baselines import Baselines, unflyable
from workbench.mission.file import mission_of
from workbench.mission.redraw import conditions, redrawn_words
from workbench.mission.settings import Mission

TABLE: dict[str, Any] = {
    "airspeed": 50.0,
    "size": [4000, 3000],
    "depots": [[500, 500]],
    "tasks": [[2000, 2500], [3000, 1000]],
    "radio": {"position": [2000, 1500]},
    "field": {"shadowing_sd": 3.0, "decorrelation": 500.0, "cells": 40, "model": "free-space"},
    "compare": {"seeds": 3},
}


def mission_with(**changes: Any) -> Mission:
    return mission_of(TABLE | changes, Path(), "m")


def field(shadowing_sd: float = 3.0, seed: int = 0) -> RadioMap:
    return radio_map(
        RadioSource((2000.0, 1500.0)), (0.0, 0.0, 4000.0, 3000.0), model="free-space", cells=40, seed=seed,
        shadowing_sd=shadowing_sd, decorrelation=500.0,
    )  # fmt: skip


def test_shadowing_is_drawn_again_and_the_rest_of_the_field_stays() -> None:
    own, *others = conditions(mission_with(), field())
    np.testing.assert_array_equal(own[0].values, field().values)
    bare = field(0.0).values
    drawn = [redrawn.values - bare for redrawn, _ in others]
    assert len({seed for _, seed in (own, *others)}) == 3
    for shadows in drawn:
        assert shadows.std() == pytest.approx(3.0, rel=0.3)
        assert abs(np.corrcoef(shadows.ravel(), (field().values - bare).ravel())[0, 1]) < 0.5
    again = [redrawn.values for redrawn, _ in conditions(mission_with(), field())]
    np.testing.assert_array_equal(again[2], others[1][0].values)


def test_shadowing_that_drifts_begins_as_drawn_and_every_draw_drifts_on_its_own() -> None:
    drifting = mission_with(field={**TABLE["field"], "tau": 100.0})
    fields = [each for each, _ in conditions(drifting, field())]
    assert all(isinstance(each, DriftingField) for each in fields)
    still = [each for each, _ in conditions(mission_with(), field())]
    for moving, fixed in zip(fields, still, strict=True):
        assert isinstance(moving, DriftingField)
        np.testing.assert_allclose(moving.at(0.0).values, fixed.values, atol=1e-9)
    bare = field(0.0).values
    later = [each.at(300.0).values - bare for each in fields if isinstance(each, DriftingField)]
    assert all(shadows.std() == pytest.approx(3.0, rel=0.3) for shadows in later)
    assert np.abs(np.corrcoef([shadows.ravel() for shadows in later])[np.triu_indices(3, 1)]).max() < 0.5


def test_a_field_without_chance_stays_and_the_words_say_so(tmp_path: Path) -> None:
    still = mission_with(field={"shadowing_sd": 0.0})
    assert all(kept.values is given.values for given in [field(0.0)] for kept, _ in conditions(still, given))
    assert redrawn_words(still) == "3 noise seeds (the field has no shadowing and is not drawn again)"
    assert redrawn_words(mission_with()) == "3 noise seeds, each with shadowing of its own"
    (tmp_path / "field.csv").write_text("")
    given = mission_of(TABLE | {"field": {"file": "field.csv"}}, tmp_path, "m")
    assert redrawn_words(given) == "3 noise seeds (the field is a file and is not drawn again)"


def ring(reach: float) -> list[Flight]:
    """Return a flight whose corners lie `reach` beyond the middle of the region."""
    corners = [[2000 - reach, 1000], [2000 + reach, 1000], [2000 + reach, 2000], [2000 - reach, 2000]]
    legs = [np.array([corners[k], corners[(k + 1) % 4]], dtype=float) for k in range(4)]
    return [plan_flight(legs, speed=50.0, radius=50.0)]


RIDGE = Terrain((0.0, 0.0), (1000.0, 1000.0), np.full((4, 5), 2970.0))


@pytest.mark.parametrize(
    ("reach", "changes", "ground", "words"),
    [
        (1000.0, {}, None, r"^$"),
        (2100.0, {}, None, r"^UAV 0 would be up to 1\d\d\.\d m outside the region or in a no-fly zone$"),
        (
            1000.0,
            {"flight": {"border_clearance": 1100.0}},
            None,
            r"^UAV 0 would come within 9\d\d\.\d m of the region's",
        ),
        (1000.0, {}, RIDGE, r"^UAV 0 would come within 30\.0 m of the ground$"),
    ],
)
def test_what_nobody_may_fly(reach: float, changes: dict[str, Any], ground: Terrain | None, words: str) -> None:
    mission = mission_with(**changes)
    assert re.search(words, unflyable(mission, mission.scenario, ground, ring(reach)))


def test_of_lawnmowers_one_that_may_be_flown_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    mission, asked = mission_with(), list[str]()

    def best(*given: Any, **more: Any) -> tuple[int, list[Flight]]:
        tried = [ring(2100.0), ring(1000.0), ring(900.0)]
        asked.extend("flyable" if not given[3](flights)[0] else "not" for flights in tried)
        return 3, min(tried, key=given[3])

    monkeypatch.setattr(baselines, "best_lawnmower", best)
    (plan,) = Baselines(mission, mission.scenario, None, 1e4).lawnmower()
    assert asked == ["not", "flyable", "flyable"]
    assert plan.refused == ""


def test_random_tours_are_drawn_as_often_as_asked_and_long_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tours here are 100 m a task and 2 km, one of them a little less and drawn again."""
    mission, sought = mission_with(compare={"seeds": 5, "draws": 3}), list[int]()

    def routed(self: Baselines, pool: Any, points: np.ndarray) -> Any:
        sought.append(len(points))
        reach = 25.0 * len(points) * (0.9 if len(sought) == 4 else 1.0)
        return lambda: ring(reach)

    monkeypatch.setattr(Baselines, "routed", routed)
    monkeypatch.setattr(baselines, "unflyable", lambda *given: "")
    plans = Baselines(mission, mission.scenario, None, 2600.0).random()
    assert len(plans) == 3
    assert all(plan.length >= 2600.0 for plan in plans)
    assert sought[0] == 4
    assert len(sought) > 3
