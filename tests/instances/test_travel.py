"""Travel: one array for fleets, clocks and states; its evaluation, its validation, its file."""

from __future__ import annotations

import json
import pickle
from itertools import pairwise, product

import numpy as np
import pytest

from instances import InputError, Instance, Travel, check_routes, objective, tour_costs
from instances.arrays import Floats
from instances.formats.native import document_text, instance_of

INF = np.inf


def distances(seed: int, nodes: int) -> Floats:
    places = np.random.default_rng(seed).uniform(0, 20000, (nodes, 2))
    return np.hypot(*(places[:, None] - places).transpose(2, 0, 1))


def fleet() -> Instance:
    d = distances(0, 5)
    slow = d / 20
    slow[1, :] = slow[:, 1] = INF
    slow[1, 1] = 0.0
    return Instance.of_travel("fleet", Travel.of_uavs([slow, d / 30]), 3, endurance=[2000.0, INF])


def test_each_uav_pays_its_own_costs() -> None:
    d, routes = distances(0, 5), ((0,), (1, 2))
    own = [2 * d[3, 0] / 20, (d[4, 1] + d[1, 2] + d[2, 4]) / 30]
    assert tour_costs(fleet(), routes) == pytest.approx(own, rel=1e-15)
    assert check_routes(fleet(), routes) == []


def test_what_cannot_be_flown_is_a_fault() -> None:
    assert check_routes(fleet(), ((1,), (0, 2))) == ["UAV 0 has a leg that it cannot fly."]
    short = Instance.of_travel("short", fleet().travel, 3, endurance=[10.0, 1e5])  # type: ignore[arg-type]
    assert "more than its endurance of 10 s" in check_routes(short, ((0,), (1, 2)))[0]
    assert objective(short, ((0,), (1, 2))) == INF
    assert objective(short, ((), (0, 1, 2))) < INF


def test_the_matrix_is_the_least_of_all_classes() -> None:
    least = fleet().cost
    assert np.array_equal(least, distances(0, 5) / 30)


def test_legs_that_nobody_flies_have_a_finite_place_holder() -> None:
    cost = np.array([[0, INF, 1.0], [INF, 0, 2.0], [3.0, 4.0, 0]])
    instance = Instance.of_travel("cut", Travel.of_uavs([cost]), 2)
    assert instance.cost[0, 1] == 4.0
    assert instance.axes == {"fleet"}
    assert check_routes(instance, ((0, 1),)) == ["UAV 0 has a leg that it cannot fly."]


def test_equal_classes_are_one_and_a_fleet_of_one_class_is_none() -> None:
    d = distances(1, 4)
    assert Travel.of_uavs([d, d / 2, d]).classes.tolist() == [0, 1, 0]
    alike = Instance.of_travel("alike", Travel.of_uavs([d, d]), 2)
    assert alike.travel is None
    assert alike.digest == Instance("plain", d, 2, 2).digest


def test_digest_tells_fleets_apart() -> None:
    one = fleet()
    other = Instance("one", one.cost, 3, 2)
    longer = Instance.of_travel("longer", one.travel, 3, endurance=[2001.0, INF])  # type: ignore[arg-type]
    assert len({one.digest, other.digest, longer.digest}) == 3


def test_written_and_pickled_it_is_the_same() -> None:
    for instance in (fleet(), clocked()):
        assert instance_of(json.loads(document_text(instance))).digest == instance.digest
        copy = pickle.loads(pickle.dumps(instance))
        assert copy.digest == instance.digest
        assert copy.travel is not None
        assert not copy.travel.cost.flags.writeable


def clocked() -> Instance:
    first = distances(2, 4) / 20
    cost = np.stack([first, 1.5 * first, 1.2 * first])[None]
    return Instance.of_travel("clock", Travel(cost, np.array([0]), np.array([0.0, 1000.0, 3000.0])), 3)


def test_clocks_interpolate_between_knots_and_hold_the_last() -> None:
    instance, base = clocked(), distances(2, 4) / 20
    time = 0.0
    for i, j in [(3, 0), (0, 1), (1, 2), (2, 3)]:
        time += float(np.interp(time, [0, 1000, 3000], [1, 1.5, 1.2])) * base[i, j]
    assert tour_costs(instance, ((0, 1, 2),))[0] == pytest.approx(time, rel=1e-12)


def test_states_are_chosen_for_the_tour() -> None:
    rng = np.random.default_rng(3)
    nodes = np.array([0, 0, 1, 1, 1, 2, 2])
    cost = rng.uniform(1, 2, (1, 1, 7, 7))
    instance = Instance.of_travel("states", Travel(cost, np.array([0]), nodes=nodes), 2)
    chains = product([5, 6], [0, 1], [2, 3, 4], [5, 6])
    least = min(sum(cost[0, 0, a, b] for a, b in pairwise(c)) for c in chains)
    assert tour_costs(instance, ((0, 1),))[0] == pytest.approx(least, rel=1e-15)
    assert instance.axes == {"states"}


def test_who_departs_later_may_not_arrive_earlier() -> None:
    cost = np.zeros((1, 2, 2, 2))
    cost[0, :, 0, 1] = 100.0, 30.0
    with pytest.raises(InputError, match=r"from state 0 to state 1 takes 100.0 s at knot 0 and 30.0 s at knot 1"):
        Travel(cost, np.array([0]), np.array([0.0, 60.0]))
    Travel(cost, np.array([0]), np.array([0.0, 70.0]))


BAD = {
    "a class": ({"classes": [0, 2]}, "travel.classes must be numbers from 0 to 1"),
    "classes": ({"classes": "ab"}, "travel.classes must be a list"),
    "negative": ({"cost": [[[[0, -1.0], [1.0, 0]]]], "classes": [0]}, r"travel.cost\[0\]\[0\]\[0\]\[1\] is negative"),
    "ragged": ({"cost": [[[[0, 1.0], [1.0]]]]}, r"travel.cost\[0\]\[0\]\[1\] has 1 entries"),
    "departures": ({"departures": [1.0]}, "travel.departures must be 1 increasing times"),
    "nodes": ({"nodes": [0, 0, 0, 1, 3]}, "travel.nodes must name the node"),
    "unknown": ({"speed": 3}, "travel: unknown key "),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_files_are_told_by_field_and_value(case: str) -> None:
    change, sentence = BAD[case]
    document = json.loads(document_text(fleet()))
    document["travel"] |= change
    with pytest.raises(InputError, match=sentence):
        instance_of(document)


@pytest.mark.parametrize("endurance", [[1.0], [0.0, 1.0], ["a", 1.0], 3.0])
def test_endurance_is_a_positive_number_a_uav(endurance: object) -> None:
    document = json.loads(document_text(fleet())) | {"endurance": endurance}
    with pytest.raises(InputError, match="endurance"):
        instance_of(document)


def test_costs_that_are_not_the_least_are_refused() -> None:
    document = json.loads(document_text(fleet()))
    document["cost"][0][1] += 1.0
    with pytest.raises(InputError, match=r"cost\[0\]\[1\] is .* but the least"):
        instance_of(document)
