"""The Irregular Terrain Model: free space over smooth ground in sight, laws, and the model's own anchors.

Agreement with NTIA's published vectors is measured by tests/benchmarks/irregular_terrain.py, given their files.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from instances import InputError
from instances.environment.itm.loss import Propagation, path_loss
from instances.environment.itm.profile import horizons, irregularity, line_fit, roughness
from instances.environment.itm.variability import deviate
from instances.environment.propagation import radio_map
from instances.environment.radio import RadioSource
from instances.environment.terrain import mountains

EARTH = 8.5e6


def test_horizons_of_a_single_hill() -> None:
    heights = np.zeros(101)
    heights[30] = 200.0
    t1, t2, d1, d2 = horizons(heights, 100.0, EARTH, 10.0, 20.0)
    assert (d1, d2) == (3000.0, 7000.0)
    assert t1 == pytest.approx(190.0 / 3000.0 - 3000.0 / (2 * EARTH))
    assert t2 == pytest.approx(180.0 / 7000.0 - 7000.0 / (2 * EARTH))


def test_in_plain_sight_the_horizon_is_the_other_terminal() -> None:
    _, _, d1, d2 = horizons(np.zeros(50), 100.0, EARTH, 500.0, 500.0)
    assert (d1, d2) == (4900.0, 4900.0)


def test_the_line_through_a_slope_is_the_slope() -> None:
    heights = 50.0 + 0.02 * 90.0 * np.arange(200)
    first, last = line_fit(heights, 90.0, 500.0, 15_000.0)
    # The formula's denominator is that of whole trapezia: a slope over k steps comes out (k² + 2)/k² too small at most
    assert first == pytest.approx(heights[0], abs=0.2)
    assert last == pytest.approx(heights[-1], abs=0.2)


def test_irregularity_of_a_plane_is_zero_and_of_noise_its_interdecile_range() -> None:
    plane = 100.0 + 0.5 * np.arange(400.0)
    assert irregularity(plane, 100.0, 0.0, 39_900.0) == pytest.approx(0.0, abs=0.1)
    noise = np.random.default_rng(1).normal(0, 50, 4000)
    spread = irregularity(noise, 25.0, 0.0, 99_975.0) * (1 - 0.8 * math.exp(-99_975 / 50e3))
    assert spread == pytest.approx(2 * 1.2816 * 50, rel=0.15)


@given(st.floats(0.001, 0.999))
def test_deviate_is_the_normal_quantile_within_the_formulas_error(share: float) -> None:
    z = deviate(share)
    assert 0.5 * math.erfc(z / math.sqrt(2)) == pytest.approx(share, abs=2e-4)


def test_roughness_grows_to_the_whole() -> None:
    assert roughness(0.0, 100.0) == pytest.approx(20.0)
    assert roughness(1e7, 100.0) == pytest.approx(100.0)


profile = st.builds(
    lambda seed, count, rough: np.abs(np.cumsum(np.random.default_rng(seed).normal(0, rough, count))),
    st.integers(0, 10_000),
    st.integers(30, 200),
    st.floats(0.1, 20.0),
)


@settings(deadline=None, max_examples=60)
@given(
    profile, st.floats(30.0, 200.0), st.floats(2.0, 100.0), st.floats(2.0, 2500.0), st.sampled_from([50e6, 146e6, 2e9])
)
def test_loss_is_finite_and_what_holds_for_more_of_the_time_is_more(
    heights: np.ndarray, step: float, transmitter: float, receiver: float, frequency: float
) -> None:
    losses = [
        path_loss(heights, step, transmitter, receiver, frequency, Propagation(time=share)) for share in (0.1, 0.5, 0.9)
    ]
    assert all(math.isfinite(loss) for loss in losses)
    assert losses == sorted(losses)


def test_a_ridge_in_the_way_costs_tens_of_decibels() -> None:
    flat = np.zeros(300)
    ridge = flat.copy()
    ridge[140:160] = 400.0
    clear, hidden = (path_loss(h, 100.0, 10.0, 10.0, 146e6) for h in (flat, ridge))
    assert hidden - clear > 20.0


def test_far_above_the_ground_it_is_nearly_free_space() -> None:
    source = RadioSource((10e3, 10e3), height=30.0)
    bounds = (0.0, 0.0, 20e3, 20e3)
    itm, free = (
        radio_map(source, bounds, mountains(relief=50.0), model=m, shadowing_sd=0.0, cells=40)
        for m in ("itm", "free-space")
    )
    assert np.abs(itm.values - free.values).mean() < 3.0


def test_bad_values_are_said() -> None:
    with pytest.raises(InputError, match="did you mean 'desert'"):
        Propagation(climate="dessert")
    with pytest.raises(InputError, match="time must lie between 0 and 1"):
        Propagation(time=50.0)
    with pytest.raises(InputError, match="at least 3 finite heights"):
        path_loss([1.0, 2.0], 100.0, 10.0, 10.0, 146e6)
    with pytest.raises(InputError, match="20 MHz to 20 GHz"):
        path_loss(np.zeros(10), 100.0, 10.0, 10.0, 146.0)
    with pytest.raises(InputError, match="above ground"):
        path_loss(np.zeros(10), 100.0, 10.0, 0.0, 146e6)
