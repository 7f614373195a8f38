"""Verdicts: who wins is said from all draws, in plain words, and never with two numbers that look the same."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd
import pytest
from scipy.stats import ttest_1samp

from reports import numbers
from reports.figures.verdicts import draw_verdicts
from reports.statistics.paired import paired
from reports.verdicts import plans, sentence, verdicts

OVER = "8 noise seeds"
NOISE = np.array([0.3, -0.2, 0.1, -0.1, 0.2, -0.3, 0.05, -0.05])


def draws(other: np.ndarray, refused: str | list[str] = "", own: float = 2.0, nlpd: float = 0.0) -> pd.DataFrame:
    """Return draws in which the mission has RMSE `own` + its field's and a lawnmower that plus `other`."""
    fields = np.linspace(0.0, 5.0, len(other))  # what fields do to both is more than what plans do
    common = {"draw": range(len(other)), "nlpd": 2.0, "longest": 1e3, "outside": 0.0, "samples": 9, "count": 4}
    common |= {"information": 1.0, "coverage": 0.9, "mean_sd": 1.0, "max_sd": 2.0}
    mission = pd.DataFrame({"name": "mission", **common, "length": 1e5, "rmse": own + fields, "refused": ""})
    lawnmower = pd.DataFrame({"name": "lawnmower", **common, "length": 1.1e5, "rmse": own + fields + other})
    return pd.concat([mission, lawnmower.assign(refused=refused, nlpd=2.0 + nlpd + 0.01 * NOISE[: len(other)])])


def said(table: pd.DataFrame) -> str:
    (verdict,) = verdicts(table)
    return sentence(verdict, "dBm", OVER)


def test_the_interval_is_students() -> None:
    found, reference = paired(0.4 + NOISE), ttest_1samp(0.4 + NOISE, 0.0).confidence_interval(0.95)
    assert (found.low, found.high) == pytest.approx((reference.low, reference.high))
    assert (found.mean, found.pairs, found.negative, found.sign) == (pytest.approx(0.4), 8, 0, 1)
    assert (paired(NOISE).sign, paired(NOISE - 0.4).sign) == (0, -1)
    assert np.isnan(paired([1.0]).low)
    assert paired([1.0]).sign == 0


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (0.5, r"^The mission wins against the lawnmower over 8 noise seeds: its RMSE is 0\.50 dBm lower \(95 % "
         r"interval 0\.33 to 0\.67; lower in 8 of 8\), 4\.50 against 5\.00 dBm; its NLPD differs by .* may be "
         r"chance .*; the lawnmower takes 10% more flying\.$"),
        (-0.5, r"^The mission loses to the lawnmower over 8 noise seeds: its RMSE is 0\.50 dBm higher \(95 % interval "
         r"0\.33 to 0\.67; higher in 8 of 8\)"),
        (0.0, r"^A draw with the lawnmower over .*: its RMSE differs by [+−]0\.00 dBm, which may be chance \(95 % "
         r"interval −0\.17 to \+0\.17\)"),
    ],
)  # fmt: skip
def test_wins_losses_and_draws_are_said_in_plain_words(more: float, words: str) -> None:
    assert re.search(words, said(draws(more + NOISE)))


def test_numbers_of_which_one_is_better_never_look_the_same() -> None:
    sentence = said(draws(1e-5 + 1e-6 * NOISE))
    assert "The mission wins" in sentence
    assert re.search(r"is 0\.000010 dBm lower \(95 % interval 0\.0000098 to 0\.0000102;|is 0\.0000100 dBm", sentence)
    assert "4.50000 against 4.50001 dBm" in sentence
    assert numbers.apart(1.0, 1.0) == ("1.00", "1.00")


def test_what_nobody_may_fly_does_not_count() -> None:
    table = draws(NOISE - 1.0, "UAV 0 would come within 3.0 m of the ground")
    assert said(table).startswith(
        "Nobody may fly the lawnmower, so it does not count: UAV 0 would come within 3.0 m of the ground; the RMSE "
        "would be 4.50 against 3.50 dBm"
    )
    assert list(plans(table)["verdict"]) == ["", "not flyable"]


def test_draws_that_nobody_may_fly_are_left_out_of_their_plan() -> None:
    refused = ["UAV 0 would …"] * 2 + [""] * 6
    (verdict,) = verdicts(draws(np.r_[-9.0, -9.0, 0.5 + NOISE[2:]], refused))
    assert (verdict.outcome, verdict.rmse.pairs, verdict.dropped) == ("wins", 6, 2)
    assert ", 2 more of which nobody may fly:" in sentence(verdict, "dBm", OVER)


def test_one_draw_names_no_winner() -> None:
    assert said(draws(np.array([3.0]))).startswith("No winner is named against the lawnmower")


def test_a_row_a_plan_has_means_and_the_interval_from_the_missions_side() -> None:
    table = plans(draws(0.5 + NOISE))
    assert list(table["name"]) == ["mission", "lawnmower"]
    assert list(table["rmse"]) == pytest.approx([4.5, 5.0])
    assert table["more_rmse"][1] == pytest.approx(0.5)
    assert 0 < table["low"][1] < 0.5 < table["high"][1]


def test_the_figure_has_a_dot_a_draw_and_an_interval_a_plan_that_counts() -> None:
    table = draws(0.5 + NOISE)
    chart = draw_verdicts(table, verdicts(table), "dBm").chart
    assert chart is not None
    found, (panel,) = paired(0.5 + NOISE), chart.panels
    frame = chart.frame()
    dots, interval = frame[frame["value"] == "flown"], frame[frame["value"] == "mean and its 95 % interval"]
    assert sorted(dots[panel.x.words]) == pytest.approx(sorted(0.5 + NOISE))
    assert set(frame["plan"]) == {"the lawnmower: mission wins"}
    assert float((interval["high"] - interval["low"]).sum()) == pytest.approx(found.high - found.low)
