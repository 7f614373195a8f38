"""Names are sorted by the numbers in them."""

import pytest

from instances.natural import natural


@pytest.mark.parametrize(
    "ordered",
    [
        ["n5", "n10", "n40"],
        ["uniform-n5-m10-s2", "uniform-n5-m10-s10", "uniform-n10-m2-s0"],
        ["ga (elite=0.05)", "ga (elite=0.5)", "ga (population=50)", "ga (population=400)"],
        ["b @ 2 s", "b @ 10 s", "b @ 10.5 s"],
        ["a", "a1", "b"],
    ],
)
def test_numbers_count_as_numbers(ordered):
    mixed = [*ordered[1:], ordered[0]]
    assert sorted(mixed, key=natural) == ordered
