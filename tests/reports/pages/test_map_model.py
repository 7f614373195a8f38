"""What the page says of the last map's model: its length scales, and how fast it takes the field to drift."""

from __future__ import annotations

from typing import Any

import pytest

from reports.pages.map_model import map_model

SAID: dict[str, Any] = {
    "kernel": "se", "mean": "constant", "signal_sd": 5.0, "length_scales": [4000.0, 4000.0], "nugget_sd": 0.0,
    "coefficients": [-80.0], "evidence": [],
}  # fmt: skip


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({}, "l = 4.0 km. It is"),
        ({"length_scales": [4000.0, 2500.0]}, "l = 4.0 km along x and 2.5 km along y."),
        (
            {"length_scales": [4000.0, 2500.0], "direction": -63.0},
            "l = 4.0 km along -63° (counter-clockwise from the x axis) and 2.5 km across.",
        ),
        (
            {"kernel": "matern12", "length_scales": [50_000.0, 25_000.0], "direction": 12.0},
            "= 0.5 dBm² a kilometre along 12° (counter-clockwise from the x axis) and 1 dBm² a kilometre across.",
        ),
    ],
)
def test_length_scales_are_told_with_their_directions(more: dict[str, Any], words: str) -> None:
    assert words in str(map_model(SAID | more, "dBm")[0])


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"tau": 600.0}, "The field drifts: what a reading tells falls to 1/e in τ = 600 s. It is"),
        ({"tau": 600.0, "drift": 12.3}, "τ = 600 s; a field that drifts was 12.3 nats likelier than one that stays."),
        ({"drift": 0.4}, "taken to stay; a field that drifts was 0.4 nats likelier than one that stays, and τ is a"),
        ({"drift": -0.1}, "taken to stay; a field that drifts was 0.1 nats less likely than one that stays"),
    ],
)
def test_drift_is_told_where_it_was_asked_for(more: dict[str, float], words: str) -> None:
    assert words in str(map_model(SAID | more, "dBm")[0])
    assert "drift" not in str(map_model(SAID, "dBm")[0])


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"contrast": 21.44}, "Where the predicted signal differs by 21.4 dBm, readings tell 1/e"),
        ({"contrast": 21.44, "in_sight": 0.3}, "in sight the signal is off its prediction by 0.30 times as much"),
    ],
    ids=["as kept before", "shadows"],
)
def test_shadows_are_told_where_the_mean_predicts_them(more: dict[str, float], words: str) -> None:
    assert words in str(map_model(SAID | more, "dBm")[0])
    assert "predicted" not in str(map_model(SAID, "dBm")[0])


EVIDENCE = [
    {"kernel": kernel, "mean": "constant", "log_likelihood": value}
    for kernel, value in (("se", -330.0), ("matern32", -316.0), ("matern12", -320.5))
]


@pytest.mark.parametrize(
    ("kernel", "words"),
    [
        ("matern32", "chosen by restricted likelihood, 4.5 nats ahead of Matérn 1/2 about a constant level."),
        ("matern12", "likelihood, 4.5 nats behind Matérn 3/2 about a constant level, as rough ground asks for it"),
        ("se", "in two directions; with one it is 14.0 nats behind Matérn 3/2 about a constant level."),
    ],
)
def test_a_choice_says_how_far_it_was_ahead_or_behind(kernel: str, words: str) -> None:
    assert words in str(map_model(SAID | {"kernel": kernel, "evidence": EVIDENCE}, "dBm")[0])


def test_a_mean_that_divides_the_field_is_told() -> None:
    told = str(map_model(SAID | {"contrast": 12.34}, "dBm")[0])
    assert "Where the predicted signal differs by 12.3 dBm, readings tell 1/e as much of one another." in told
