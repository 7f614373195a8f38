"""Which way round tours are flown where the field drifts."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from formulations.kernel import SquaredExponential
from formulations.mapping.directions import Directions, choose_directions
from formulations.mapping.flight import Flight, plan_flight
from formulations.mapping.gaussian_process import GaussianProcess
from formulations.mapping.map_model import MapModel

MODEL = MapModel(SquaredExponential(30.0, (1500.0, 1500.0)), tau=60.0)
WHERE = np.array([[900.0, 4600.0], [1200.0, 4800.0], [7800.0, 4700.0]])
"""Points far from the depots, beside one long side of each tour."""


def tour(x0: float) -> Flight:
    """Return a lap that visits its far corner early."""
    corners = np.array([[x0, 0.0], [x0, 5000.0], [x0 + 1500.0, 5000.0], [x0 + 2500.0, 0.0]])
    legs = [np.array([corners[k], corners[(k + 1) % 4]]) for k in range(4)]
    return plan_flight(legs)


def promised(flights: list[Flight], laps: int, directions: Directions) -> float:
    """Return √J by hand, reading by reading."""
    X, t = [], []
    for flight, turned in zip(flights, directions, strict=True):
        times, places = flight.measurements(10.0)
        for lap, turn in enumerate(turned):
            X.append(places)
            t.append(lap * flight.duration + (flight.duration - times if turn else times))
    process = GaussianProcess(MODEL, 1.0, WHERE, level=0.0)
    process.extend(np.concatenate(X), np.zeros(sum(map(len, t))), np.concatenate(t))
    end = max(laps * flight.duration for flight in flights)
    return float(np.sqrt(np.mean(process.posterior(end).sd ** 2)))


@pytest.mark.parametrize("laps", [1, 2])
def test_the_directions_chosen_are_the_best_of_all(laps: int) -> None:
    flights = [tour(0.0), tour(6000.0)]
    chosen = choose_directions(
        flights, [laps] * 2, WHERE, model=MODEL, noise_sd=1.0, period=10.0, allowed=lambda directions: True
    )
    each = [np.array(turns) for turns in itertools.product([False, True], repeat=laps)]
    best = min(promised(flights, laps, pair) for pair in itertools.product(each, repeat=2))
    assert chosen.sd == pytest.approx(best, rel=1e-3)  # what is older than 4 τ is left out
    assert chosen.unturned_sd == pytest.approx(promised(flights, laps, (each[0], each[0])), rel=1e-3)
    assert chosen.sd < chosen.unturned_sd


def test_what_is_not_free_is_not_turned() -> None:
    chosen = choose_directions(
        [tour(0.0), tour(6000.0)], [2, 2], WHERE, model=MODEL, noise_sd=1.0, period=10.0,
        allowed=lambda directions: not directions[0].any(),
    )  # fmt: skip
    assert not chosen.directions[0].any()
    assert chosen.directions[1].any()
