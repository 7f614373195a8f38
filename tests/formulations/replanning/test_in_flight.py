"""Re-planning in flight: endurance is never exceeded, events are lived with, and nothing is gained where nothing is."""

import numpy as np
import pytest
from shapely.geometry import box

from formulations.mapping.flight import plan_flight
from formulations.mapping.flight_check import margin
from formulations.mapping.survey import fly_survey
from formulations.replanning.in_flight import Event, drawn, fly_replanned
from formulations.replanning.spending import track_cost
from instances.environment.region import Region
from instances.environment.wind import Rotation, Uniform
from instances.errors import InputError
from instances.moving_cost import CostKind
from tests.formulations.replanning.worlds import CALM, HOMES, RADIUS, SPEED, SQUARE, aloft, field, planner, world

READ = drawn(field, 1.0, 5.0, 0)


def replanned(seed, endurance=330.0, length=2000.0, polish=False, **more):
    """Return the fleet, its flights as flown and the re-plans."""
    fleet, here = aloft(np.random.default_rng(seed), endurance), more.pop("here", world())
    flights, made = fly_replanned(fleet, drawn(field, 1.0, 5.0, seed), planner(length, polish), here, **more)
    return fleet, flights, made


@pytest.mark.parametrize(
    "seed", [0, 1, pytest.param(2, marks=pytest.mark.slow), pytest.param(3, marks=pytest.mark.slow)]
)
@pytest.mark.parametrize("wind", [CALM, Uniform((15.0, 10.0))])
def test_endurance_is_never_exceeded_and_all_come_home(seed, wind):
    here = world(wind=wind, kind=CostKind.TIME if seed % 2 else CostKind.ENERGY)
    _, flights, made = replanned(seed, here=here, every=8)
    assert any(one.accepted for one in made)
    for home, flight in zip(HOMES, flights, strict=True):
        assert track_cost(flight, here.measure) <= 330.0 + 1e-6
        assert np.allclose(flight.poses(flight.length)[0, :2], home, atol=1e-6)
        assert margin(flight, SQUARE).distance > -0.02
    for one in made:
        assert not one.accepted or one.after < one.before


@pytest.mark.slow
def test_the_survey_along_the_flights_measures_what_was_re_planned_on():
    _, flights, made = replanned(0, every=8)
    survey = fly_survey(flights, field, SQUARE.cell_centres(5, 5), model=planner().model, period=5.0, seed=0)
    last = made[-1]
    known = survey.times <= last.time + 1e-9
    assert known.sum() == last.samples
    again, same = replanned(0, every=8)[1:]
    assert [f.length for f in again] == [f.length for f in flights]
    assert [one.accepted for one in same] == [one.accepted for one in made]


def test_without_rounds_and_events_nothing_changes():
    fleet = aloft(np.random.default_rng(0), 330.0)
    before = list(fleet.flights)
    flights, made = fly_replanned(fleet, READ, planner(), world(), every=0)
    assert made == []
    assert all(a is b for a, b in zip(flights, before, strict=True))


def test_a_lost_uav_flies_no_more_and_others_take_over():
    _, flights, (one,) = replanned(1, endurance=400.0, every=0, events=[Event(50.0, "UAV 0 is lost", lost=0)])
    whole = aloft(np.random.default_rng(1), 400.0)
    assert one.accepted
    assert one.after < one.before
    assert flights[0].duration == pytest.approx(50.0)
    tasks = whole.tasks[0]
    here = flights[0].poses(np.arange(0.0, 5000.0, 5.0))[:, :2]
    left = [task for task in tasks if np.hypot(*(here - task).T).min() > 10.0]
    assert left, "the case has nothing to take over"
    assert sum(f.length for f in flights[1:]) > sum(f.length for f in whole.flights[1:])


def test_a_zone_that_appears_is_avoided_from_then_on():
    zone = box(3000, 2500, 5000, 4500)
    region = Region(SQUARE.polygon.difference(zone.buffer(-1.0)))
    event = Event(10.0, "a zone appears", world=world(Region(SQUARE.polygon.difference(zone))))
    before = aloft(np.random.default_rng(3), 400.0)
    assert min(margin(f, region).distance for f in before.flights) < 0
    _, flights, (one,) = replanned(3, endurance=400.0, every=0, events=[event])
    assert one.accepted
    assert "no more" in one.why
    assert min(margin(rest, region).distance for rest in one.new) > 0
    assert max(f.length for f in flights) <= 400.0 * SPEED


def test_where_no_way_home_is_within_endurance_the_straight_one_is_flown_and_said():
    headwind = world(wind=Rotation(1.75e-2, (4000.0, 4000.0)), kind=CostKind.TIME)
    calm = world(kind=CostKind.TIME)
    fleet = aloft(np.random.default_rng(2), 1.0)
    fleet.limits = np.array([f.duration for f in fleet.flights])
    late = 0.97 * min(f.duration for f in fleet.flights)
    _, made = fly_replanned(fleet, READ, planner(), calm, every=0, events=[Event(late, "the wind", world=headwind)])
    assert made[0].accepted
    if "straight home" in made[0].why:
        assert "beyond the endurance" in made[0].why


def test_no_safe_way_home_is_refused():
    fleet = aloft(np.random.default_rng(4), 400.0)
    x, y = fleet.flights[0].poses(30.0 * SPEED)[0, :2]
    zone = box(x - 500, y - 500, x + 500, y + 500)
    event = Event(30.0, "a zone appears", world=world(Region(SQUARE.polygon.difference(zone))))
    with pytest.raises(InputError, match=r"at 30 s \(a zone appears\) there is no safe way home"):
        fly_replanned(fleet, READ, planner(), world(), every=0, events=[event])


@pytest.mark.slow
def test_polish_promises_less_and_keeps_endurance():
    plain, polished = (replanned(0, every=20, polish=polish)[1:] for polish in (False, True))
    assert polished[1][0].after < plain[1][0].after
    assert max(f.length for f in polished[0]) <= 330.0 * SPEED + 1e-6


def test_tasks_of_laps_are_ahead_as_often_as_they_are_to_be_passed():
    fleet = aloft(np.random.default_rng(0), 330.0)
    legs = [fleet.flights[0].starts[:, :2], HOMES[:1]]
    twice = np.concatenate([*legs, legs[0][1:], HOMES[:1]])
    fleet.flights[0] = plan_flight(list(np.stack([twice[:-1], twice[1:]], axis=1)), speed=SPEED, radius=RADIUS)
    assert fleet.visits == 3 + 9
    assert len(fleet.ahead()) == 9
    fleet.time = 0.6 * fleet.flights[0].duration
    others = sum(len(fleet.tasks[k]) for k in (1, 2) if k in fleet.active)
    fleet.lose(0)
    assert fleet.visits <= others  # of the lost one all are passed
