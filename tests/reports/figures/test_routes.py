"""Routes on the map: where an instance was made is drawn below them, also where only its family knows."""

from dataclasses import replace

import numpy as np
import pytest

from formulations.moving_cost.families import generate
from instances import Instance
from instances.families import make_scenario
from reports.figures.routes import draw_routes, surroundings, wind_inside


def instance_of(scenario, coordinates=None, **provenance):
    """An instance on the nodes of `scenario`; its costs do not matter here."""
    points = scenario.points if coordinates is None else coordinates
    cost = np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1))
    return Instance("s", cost, scenario.n_tasks, scenario.n_depots, points, scenario.provenance | provenance)


@pytest.fixture(scope="module")
def scenario():
    return make_scenario("wind-vortices", 4, 2, 1)


def test_zones_and_wind_of_a_family_that_states_none_are_made_again(scenario):
    provenance = {key: scenario.provenance[key] for key in ("family", "parameters", "seed")}
    given = instance_of(scenario)
    region, wind = surroundings(replace(given, provenance=provenance))
    assert len(region.rings) == len(scenario.free.rings) > 1
    points = scenario.points
    np.testing.assert_array_equal(wind(points), scenario.wind(points))
    plot = draw_routes(replace(given, provenance=provenance), ((0, 1), (2, 3))).axes[0]
    assert len(plot.patches) == 1
    assert "wind, up to" in plot.get_title(loc="left")


@pytest.mark.parametrize(
    "more", [{"seed": 2}, {"seed": -1}, {"seed": "1"}, {"family": "own"}, {"parameters": {"no": 1}}, {"parameters": 3}]
)
def test_what_is_not_the_same_scenario_is_not_drawn(scenario, more):
    provenance = {key: scenario.provenance[key] for key in ("family", "parameters", "seed")} | more
    assert surroundings(replace(instance_of(scenario), provenance=provenance)) == (None, None)


def test_the_wind_is_shown_inside_the_region_only(scenario):
    points, wind = wind_inside(scenario.wind, scenario.free, scenario.points)
    assert scenario.free.contains(points).all()
    np.testing.assert_array_equal(wind, scenario.wind(points))


def test_words_beside_bars_count_tasks():
    figure = draw_routes(generate("uniform", 3, 3, 0), ((0, 1), (2,), ()))
    assert [text.get_text() for text in figure.axes[1].texts] == ["2 tasks", "1 task", "stays home"]
