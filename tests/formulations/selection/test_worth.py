"""Worth and its overestimates, against all sets."""

import numpy as np
import pytest

from formulations.selection.overestimates import first_overestimates, tangent
from formulations.selection.worth import Worth, worth_of
from instances import InputError

N = 7
SETS = (np.arange(2**N)[:, None] >> np.arange(N)) & 1


@pytest.fixture(params=["prizes", "ig", "b", "a"])
def worth(request, problems):
    return problems(N, 2, 3, request.param).worth


def test_all_sets(worth):
    for number, value in enumerate(worth.of_all_sets()):
        assert value == pytest.approx(worth.value(np.flatnonzero(SETS[number]).tolist()), abs=1e-9)


def test_it_is_made_again_from_what_it_says(worth, problems):
    coordinates = problems(N, 2, 3).instance.coordinates
    again = worth_of(worth.about, N, coordinates)
    assert again.value(range(N)) == worth.value(range(N))


def test_no_set_exceeds_an_overestimate(worth):
    values, rng = worth.of_all_sets(), np.random.default_rng(0)
    points = [rng.uniform(0, 1, N), np.full(N, 0.5), SETS[77].astype(float), np.zeros(N), np.ones(N)]
    overestimates = [*first_overestimates(worth, np.ones(N, bool)), *(tangent(worth, y) for y in points)]
    for over in overestimates:
        assert (over.constant + SETS @ over.slope >= values).all()


def test_tangents_of_information_gain_are_exact_where_they_touch(problems):
    worth = problems(N, 2, 3, "ig").worth
    for number in (1, 77, 127):
        y = SETS[number].astype(float)
        assert tangent(worth, y).at(y) == pytest.approx(worth.value(np.flatnonzero(y).tolist()), abs=1e-6)


def test_step_of_prizes():
    assert Worth.of_prizes([10, 25, 5]).step == 5
    assert Worth.of_prizes([10, 2.5]).step == 0
    assert Worth.of_prizes([10, 25]).bound(34.9) == 30


@pytest.mark.parametrize(
    ("prizes", "sentence"),
    [([1, -2], r"prizes\[1\] must be from 0"), ([[1]], "must be a list of numbers"), ([float("nan")], r"prizes\[0\]")],
)
def test_prizes_that_cannot_be_used(prizes, sentence):
    with pytest.raises(InputError, match=sentence):
        Worth.of_prizes(prizes)


def test_sets_as_rows(worth):
    assert worth.of_sets(SETS.astype(bool)) == pytest.approx(worth.of_all_sets(), abs=1e-9)


def test_information_gain_of_a_set_is_at_most_that_of_its_parts(problems):
    worth = problems(N, 2, 3, "ig").worth
    values = worth.of_all_sets()
    numbers = np.arange(2**N)
    assert worth.subadditive
    for mask in (0b1010101, 0b0000111, 0b1100011):
        assert (values <= values[numbers & mask] + values[numbers & ~mask] + 1e-9).all()
