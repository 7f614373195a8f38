"""What tours take and cost: time, energy and calm air beside each other."""

import numpy as np
import pytest

from instances.environment.wind import Uniform
from instances.paths import Paths
from instances.tour_figures import tour_figures

NODES = np.array([[3000.0, 0.0], [3000.0, 4000.0], [0.0, 0.0], [9.0, 9.0]])
STRAIGHT = Paths.of(4, [NODES[[i, j]] if i != j else np.empty((0, 2)) for i in range(4) for j in range(4)])
ROUTES = ((0, 1), ())


def test_a_tour_in_a_uniform_wind():
    flies, stays = tour_figures(STRAIGHT, ROUTES, 2, Uniform((5.0, 0.0)), 20.0)
    there = 3000 / 25 + 4000 / np.sqrt(20**2 - 5**2)
    back = 5000 / (np.sqrt(20**2 - (5 * 0.8) ** 2) - 5 * 0.6)
    assert (flies.uav, flies.tasks, flies.length, flies.calm) == (0, 2, 12_000, 600)
    assert flies.energy == pytest.approx(600)  # closed tours do not feel a potential wind
    assert flies.flight_time == pytest.approx(there + back, rel=1e-9)
    assert (stays.tasks, stays.length, stays.flight_time, stays.energy, stays.calm) == (0, 0, 0, 0, 0)


def test_calm_air_and_a_wind_that_is_too_strong():
    calm = tour_figures(STRAIGHT, ROUTES, 2, None, 20.0)[0]
    assert (calm.flight_time, calm.energy) == (600, 600)
    strong = tour_figures(STRAIGHT, ROUTES, 2, Uniform((25.0, 0.0)), 20.0)[0]
    assert (strong.flight_time, strong.energy) == (np.inf, pytest.approx(600))
