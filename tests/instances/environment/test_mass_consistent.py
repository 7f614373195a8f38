"""Mass-consistent flow: flat ground, the hemisphere's closed form, no divergence, bad input."""

from pathlib import Path

import numpy as np
import pytest

from instances import InputError
from instances.environment.mass_consistent import Inflow, solve_flow
from instances.environment.terrain import Terrain, mountains
from instances.environment.wind_table import wind_from_toml
from instances.environment.wind_terrain import TerrainWind


@pytest.mark.parametrize("profile", ["uniform", "log", "power"])
def test_flat_ground_returns_the_inflow(profile: str) -> None:
    flat = Terrain((0.0, 0.0), (100.0, 120.0), np.full((16, 21), 250.0))
    inflow = Inflow((-7.0, 3.0), profile)
    wind = solve_flow(flat, inflow, layers=8).slice(900.0)
    factor = float(inflow.factor(np.array(650.0)))
    np.testing.assert_allclose(wind.u, -7.0 * factor, rtol=1e-12)
    np.testing.assert_allclose(wind.v, 3.0 * factor, rtol=1e-12)


def test_over_a_hemisphere() -> None:
    """On the axis u = U (1 + a³/(2 z³)): potential flow around a sphere, cut in half by the ground."""
    a, side, n = 1000.0, 12_000.0, 120
    x = np.linspace(-side / 2, side / 2, n + 1)
    h = np.sqrt(np.maximum(a**2 - x[:, None] ** 2 - x[None, :] ** 2, 0.0))
    flow = solve_flow(
        Terrain((-side / 2, -side / 2), (side / n, side / n), h), Inflow((10.0, 0.0), "uniform"), layers=24, top=8000.0
    )
    for z in (1200.0, 1500.0, 2000.0, 3000.0):
        u, v = flow.slice(z)([[0.0, 0.0]])[0]
        assert u == pytest.approx(10 * (1 + a**3 / (2 * z**3)), rel=5e-3)
        assert v == pytest.approx(0.0, abs=1e-3)


def test_uniform_inflow_makes_slices_without_vorticity_and_a_profile_does_not() -> None:
    ground = mountains(cells=60, relief=1200.0, seed=2)
    curls = []
    for profile in ("uniform", "log"):
        wind = solve_flow(ground, Inflow((-7.0, -7.0), profile), layers=12).slice(1500.0)
        d = wind.spacing[0]
        curl = np.gradient(wind.v, d, axis=1) - np.gradient(wind.u, d, axis=0)
        curls.append(float(np.sqrt((curl[2:-2, 2:-2] ** 2).mean())))
    assert curls[0] < 1e-10
    assert curls[1] > 1e-4


def test_the_wind_table_of_terrain_round_trips() -> None:
    table = {"kind": "terrain", "mountains": {"seed": 4, "relief": 900.0}, "velocity": [-7.0, -7.0], "altitude": 1200.0}
    wind = wind_from_toml({**table, "cells": 24, "layers": 6})
    assert isinstance(wind, TerrainWind)
    again = wind_from_toml(wind.to_toml())
    points = np.random.default_rng(0).uniform(0, 20_000, (20, 2))
    np.testing.assert_array_equal(wind(points), again(points))
    assert wind.bounds == (0.0, 0.0, 20_000.0, 20_000.0)


MADE = {"kind": "terrain", "mountains": {"seed": 4}, "velocity": [1.0, 2.0], "altitude": 3000.0}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"dem": "a.tif"}, "either 'dem'"),
        ({"mountains": {"sed": 1}}, "did you mean 'seed'"),
        ({"mountains": 3}, "must be a table"),
        ({"profile": "logg"}, "did you mean 'log'"),
        ({"altitude": None}, "altitude"),
        ({"velocity": [1.0]}, "velocity"),
        ({"cells": 1.5}, "cells"),
        ({"roughness": 0.0}, "roughness"),
        ({"hight": 2}, "unknown key 'hight'"),
    ],
)
def test_bad_tables_are_named(change: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        wind_from_toml({**MADE, **change}, Path())


def test_an_altitude_inside_the_ground_is_named_with_its_place() -> None:
    flow = solve_flow(mountains(cells=12, relief=800.0), Inflow((1.0, 0.0)), layers=4)
    with pytest.raises(InputError, match=r"highest ground, 800 m at \(\d+, \d+\) m"):
        flow.slice(700.0)
    with pytest.raises(InputError, match="lid"):
        flow.slice(1e5)
    with pytest.raises(InputError, match="above the highest ground"):
        solve_flow(mountains(cells=12, relief=800.0), Inflow((1.0, 0.0)), top=500.0)
