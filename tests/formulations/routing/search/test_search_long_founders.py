"""Long founders: where few UAVs fly long tours they get their share of the time, elsewhere none."""

import numpy as np
import pytest

from formulations.routing.search.costs import search_costs
from formulations.routing.search.endurance import Endurance
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.population import Population
from formulations.routing.search.problem_data import NeighbourhoodParameters, problem_data
from formulations.routing.search.randomness import seeded
from formulations.routing.search.strategy import SEVERAL_DEPOTS
from instances import Instance

HOW = SEVERAL_DEPOTS.long


def population(n, m, steps):
    """Return a population of two members past its founders, of an instance with m sites, planned for a limit."""
    points = np.random.default_rng(5).random((n + m, 2))
    cost = np.hypot(*(points[:, None] - points).transpose(2, 0, 1))
    instance = Instance("plane", cost, n, m)
    data = problem_data(search_costs(instance), n, NeighbourhoodParameters())
    found = Population(data, Endurance(instance, data.costs), SearchParameters(), seeded(3), None)
    found.plan(1.0 / steps)
    found.family.members, found.family.since_restart = [found.best, found.best], found.family.founders
    return found


def stages(found):
    """Return the first temperature, softness, begin and end of each stage that fills the limit."""
    now, seen = 0.0, []
    while now < 1.0 - 1e-9:
        found.begin(now)
        seen.append((found._schedule.first, found._schedule.softness, now, found.end))
        now = found.end
    return seen


def test_they_get_their_share_of_the_time_and_end_within_the_limit():
    seen = stages(population(150, 3, 4_000_000))
    long = [stage for stage in seen if stage[0] == HOW.first]
    assert sum(end - begin for *_, begin, end in long) == pytest.approx(HOW.share, abs=0.11)
    assert {softness for _, softness, *_ in long} <= set(HOW.softness)
    assert max(end - begin for *_, begin, end in long) >= HOW.depth * 150**2 / 3 / 4_000_000
    assert seen[-1][3] <= 1.0 + 1e-9


def test_a_short_limit_makes_them_shorter():
    long = [end - begin for first, _, begin, end in stages(population(150, 3, 300_000)) if first == HOW.first]
    assert len(long) >= 3
    assert max(long) <= 1.5 * HOW.longest  # stretched, so that stages fill the limit


@pytest.mark.parametrize(("n", "m"), [(149, 3), (250, 5)], ids=["tours too short", "too many UAVs"])
def test_there_are_none_elsewhere(n, m):
    assert all(first != HOW.first for first, *_ in stages(population(n, m, 1_000_000)))


def test_there_are_none_before_the_usual_founders():
    found = population(150, 3, 4_000_000)
    found.family.since_restart = 0
    found.begin(0.0)
    assert found._schedule.first != HOW.first
