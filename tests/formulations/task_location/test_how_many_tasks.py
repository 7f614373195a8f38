"""How many tasks: the study's numbers from their definitions, and the fewest tasks proved to keep a limit."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shapely.geometry import Polygon

from formulations.kernel import SquaredExponential
from formulations.mapping.lawnmower import lanes
from formulations.task_location.criterion import Criterion
from formulations.task_location.fewest import _Spread, fewest_tasks, tasks_needed, watch_points, worst_sd
from formulations.task_location.how_many import Trial, lawnmower_tracks, planning_noise, recommend, trials
from formulations.task_location.registry import make_method
from formulations.task_location.tour import along, tour_length
from formulations.task_location.uncertainty import information_gain, posterior_sd
from instances.environment.region import Region
from instances.errors import InputError

SQUARE = Region.rectangle(20_000, 20_000)
KERNEL = SquaredExponential(30.0, (4000.0, 4000.0))
LONG = SquaredExponential(30.0, (9000.0, 9000.0))


def test_places_along_a_square_tour():
    corners = np.array([[0, 0], [4000, 0], [4000, 4000], [0, 4000]], float)
    assert tour_length(corners, [0, 1, 2, 3]) == 16_000
    places = along(corners, [0, 1, 2, 3], 1000.0)
    assert len(places) == 16
    assert places[:6].tolist() == [[0, 0], [1000, 0], [2000, 0], [3000, 0], [4000, 0], [4000, 1000]]


def test_planning_noise_closes_the_gap():
    points = SQUARE.sample(12, np.random.default_rng(0))
    criterion = Criterion(KERNEL, SQUARE.cell_centres(4, 4))
    noise = planning_noise(criterion, points, 60.0)
    assert information_gain(KERNEL, noise, points) == pytest.approx(60.0, abs=1e-6)
    assert planning_noise(criterion, points, 1e6) is None
    # one task: ½ ln(1 + σ_f²/σ_T²) = I
    alone = planning_noise(criterion, points[:1], 3.0)
    assert alone == pytest.approx(30 / math.sqrt(math.exp(6.0) - 1), rel=1e-9)


def test_trials_say_what_their_points_are_worth():
    criterion = Criterion(LONG, SQUARE.cell_centres(8, 8))
    done = trials(SQUARE, criterion, [6, 3, 6], make_method("greedy"), "greedy")
    assert [trial.n for trial in done] == [3, 6]
    for trial in done:
        assert sorted(trial.order) == list(range(trial.n))
        assert trial.mutual_information == pytest.approx(criterion.value(trial.points), abs=1e-9)
        assert trial.mi1 == pytest.approx(information_gain(LONG, 1.0, trial.points))
        assert trial.mi2 > trial.mi1
        assert trial.uncovered <= trial.uncovered_tasks
        assert trial.lawnmower is None or trial.lawnmower > 0
    first, second = done
    assert second.per_km == pytest.approx((second.mi2 - first.mi2) / ((second.length - first.length) / 1000))


def test_lawnmower_of_two_lanes():
    criterion = Criterion(LONG, SQUARE.cell_centres(4, 4))
    tracks = lawnmower_tracks(SQUARE, criterion, 1000.0, most=2)
    # one lane is flown there and back; two lanes, half a spacing inside, make a rectangle
    assert tracks[1, 0] == pytest.approx(tour_length(lanes(SQUARE, 2, 0), [0, 1, 2, 3]))
    corners = lanes(SQUARE, 2, 0)
    assert tracks[1, 1] == pytest.approx(information_gain(LONG, 1.0, along(corners, [0, 1, 2, 3], 1000.0)))


def trial(n: int, km: float, mi2: float, uncovered: float) -> Trial:
    return Trial(np.zeros((n, 2)), list(range(n)), 1000 * km, 0, 0, mi2, None, uncovered, uncovered, 1.0, 1.0)


def test_the_recommended_number_is_the_first_that_covers_for_good():
    done = [trial(5, 50, 60, 0.8), trial(10, 80, 90, 0.009), trial(20, 100, 110, 0.1), trial(30, 120, 125, 0.0)]
    done += [trial(40, 140, 130, 0.0), trial(60, 180, 135, 0.0), trial(80, 220, 137, 0.0)]
    advice = recommend(done)
    assert (advice.n, advice.underfitted_below) == (30, 30)
    assert "20 leave 10.0%" in advice.reason
    # 1 nat a km at n = 5; from 30 to 40 it is 0.25, under a third of that
    assert advice.overfitted_above == 30
    assert "try more" in recommend(done[:3]).reason
    with pytest.raises(InputError, match="no trial"):
        recommend([])


@pytest.mark.parametrize(
    "region",
    [
        pytest.param(SQUARE, id="square", marks=pytest.mark.slow),
        pytest.param(Region(Polygon([(0, 0), (20e3, 0), (8e3, 15e3)])), id="triangle"),
    ],
)
def test_fewest_tasks_keep_the_limit_everywhere(region):
    found = fewest_tasks(region, LONG, 1.0, 6.0)
    eye = region.sample(20_000, np.random.default_rng(1))
    seen = posterior_sd(LONG, 1.0, found.points, eye).max()
    assert seen <= found.worst_sd <= 6.0
    assert found.worst_sd <= 1.05 * seen
    assert 1 <= found.at_least <= len(found.points) <= found.greedy
    assert (region.signed_distance(found.points) >= -1e-6).all()


def test_worst_sd_of_one_task_is_at_the_far_corner():
    small = Region.rectangle(4000, 3000)
    far = math.sqrt(900 - (900 * math.exp(-0.5 * (1 + 9 / 16))) ** 2 / 901)
    assert worst_sd(small, KERNEL, 1.0, np.array([[0.0, 0.0]])) == pytest.approx(far, rel=1e-3)
    assert worst_sd(small, KERNEL, 1.0, np.array([[0.0, 0.0]])) >= far


def test_the_lower_bound_on_tasks_never_passes_what_suffices():
    # one central task in a region much smaller than the length scale keeps the sd low everywhere
    tiny = Region.rectangle(400, 400)
    assert tasks_needed(tiny, KERNEL, 1.0, 5.0, known=1) == 1
    assert tasks_needed(SQUARE, KERNEL, 1.0, 3.0, known=16) > 5


def test_gradient_of_the_smooth_maximum():
    spread = _Spread(SQUARE, LONG, 1.0, watch_points(SQUARE, LONG)[::7])
    z = np.random.default_rng(0).uniform(0, 2, 8)
    _, gradient = spread.norm(z, 8.0)
    for i in range(8):
        step = 1e-6 * np.eye(8)[i]
        slope = (spread.norm(z + step, 8.0)[0] - spread.norm(z - step, 8.0)[0]) / 2e-6
        assert gradient[i] == pytest.approx(slope, abs=1e-7)


@pytest.mark.parametrize("max_sd", [0.0, -1.0, 30.0, math.nan])
def test_limits_that_make_no_sense_are_refused(max_sd):
    with pytest.raises(InputError, match="max-sd"):
        fewest_tasks(SQUARE, KERNEL, 1.0, max_sd)


def test_a_limit_that_needs_too_many_tasks_is_refused():
    with pytest.raises(InputError, match="more than 400"):
        fewest_tasks(SQUARE, SquaredExponential(30.0, (300.0, 300.0)), 1.0, 0.5)
