import numpy as np
import pytest

from instances import InputError, Instance

GOOD = np.array([[0.0, 1, 2], [3, 0, 4], [5, 6, 0]])


def with_entry(i, j, value):
    cost = GOOD.copy()
    cost[i, j] = value
    return cost


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"cost": GOOD[:2]}, r"shape \(3, 3\)"),
        ({"cost": GOOD[:, :2]}, r"shape \(3, 3\)"),
        ({"cost": [[0, 1], [1]]}, "square matrix of numbers"),
        ({"cost": "abc"}, "square matrix of numbers"),
        ({"cost": with_entry(0, 2, np.nan)}, r"cost\[0\]\[2\] is not a number"),
        ({"cost": with_entry(1, 0, np.inf)}, r"cost\[1\]\[0\] is infinite"),
        ({"cost": with_entry(2, 1, -1e-9)}, r"cost\[2\]\[1\] is negative"),
        ({"cost": with_entry(1, 1, 7)}, r"cost\[1\]\[1\] must be 0"),
        ({"cost": np.full((3, 3), 10**400, dtype=object)}, "square matrix of numbers"),
        ({"n_tasks": 0}, "n_tasks must be a whole number of at least 1, got 0"),
        ({"n_depots": 0}, "n_depots must be a whole number of at least 1, got 0"),
        ({"n_tasks": 2.0}, "n_tasks must be a whole number"),
        ({"n_depots": True}, "n_depots must be a whole number"),
        ({"n_tasks": 10**30}, "0000000 tasks and 1 depots are more than the 20000 nodes"),
        ({"n_tasks": 5}, r"shape \(6, 6\)"),
        ({"name": "  "}, "name must be a non-empty text"),
        ({"name": 3}, "name must be a non-empty text"),
        ({"name": "../up"}, "name is used in file names"),
        ({"name": "two\nlines"}, "name is used in file names"),
        ({"coordinates": [[0, 0], [1, 1]]}, r"coordinates must have shape \(3, 2\)"),
        ({"coordinates": [[0, 0], [1, 1], [np.nan, 0]]}, r"coordinates\[2\] is not finite"),
        ({"coordinates": [["a", 0], [1, 1], [2, 0]]}, "coordinates must be pairs of numbers"),
    ],
)
def test_one_sentence_names_what_is_wrong(changes, sentence):
    with pytest.raises(InputError, match=sentence) as caught:
        Instance(**{"name": "x", "cost": GOOD, "n_tasks": 2, "n_depots": 1, **changes})
    assert "\n" not in str(caught.value)


def test_arrays_are_copied_and_frozen():
    cost = GOOD.copy()
    instance = Instance("x", cost, 2, 1)
    cost[0, 1] = 99
    assert instance.cost[0, 1] == 1
    with pytest.raises(ValueError, match="read-only"):
        instance.cost[0, 1] = 99


def test_digest_is_of_the_arrays_alone():
    a = Instance("x", GOOD, 2, 1)
    assert a.digest == Instance("y", GOOD.tolist(), 2, 1, provenance={"seed": 1}).digest
    assert a.digest != Instance("x", GOOD, 1, 2).digest
    assert a.digest != Instance("x", with_entry(0, 1, np.nextafter(1, 2)), 2, 1).digest
    assert a.digest != Instance("x", GOOD, 2, 1, coordinates=np.zeros((3, 2))).digest
    # the order of the memory does not count
    assert a.digest == Instance("x", np.asfortranarray(GOOD), 2, 1).digest


def test_asymmetry_by_hand():
    # edges in use: (0,1) |1−3|/4 both ways, (0,2) |2−5|/7, (1,2) |4−6|/10; task–task pairs count in both directions
    expected = (2 * 2 / 4 + 3 / 7 + 2 / 10) / 4
    assert Instance("x", GOOD, 2, 1).asymmetry == pytest.approx(expected)
    assert Instance("x", GOOD + GOOD.T, 2, 1).asymmetry == 0
    assert Instance("x", np.zeros((3, 3)), 2, 1).asymmetry == 0


def test_nodes_are_tasks_then_depots():
    instance = Instance("x", np.zeros((5, 5)), 2, 3)
    assert (list(instance.tasks), list(instance.depots), instance.n_nodes) == ([0, 1], [2, 3, 4], 5)
    assert "2 tasks, 3 depots" in instance.summary()
