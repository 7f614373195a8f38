"""Team-orienteering files: what is read, and the sentence for what cannot be."""

import numpy as np
import pytest

from instances import InputError, tour_costs
from instances.files import read_instance, write_instance

FILE = "n 4\nm 2\ntmax 12.5\n0\t0\t0\n3\t4\t10\n3.0\t0.000\t5\n0\t8\t0\n"


def read(tmp_path, text, name="p9.2.a.txt"):
    (tmp_path / name).write_text(text)
    return read_instance(tmp_path / name)


def test_start_end_prizes_and_endurance(tmp_path):
    instance = read(tmp_path, FILE)
    assert (instance.name, instance.n_tasks, instance.n_depots) == ("p9.2.a", 2, 2)
    assert instance.endurance.tolist() == [12.5, 12.5]
    assert instance.provenance["prizes"] == [10, 5]
    # start (0,0) → (3,4) → end (0,8), and start → (3,0) → end
    assert tour_costs(instance, [(0,), (1,)]) == pytest.approx([10, 3 + np.sqrt(73)])


def test_it_survives_conversion(tmp_path):
    instance = read(tmp_path, FILE)
    write_instance(instance, tmp_path / "a.json")
    again = read_instance(tmp_path / "a.json")
    assert again.digest == instance.digest
    assert again.provenance == instance.provenance


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("n 4", "n 5", "has 4 lines 'x y score', must have n = 5"),
        ("n 4", "n four", "line 1: n must be a number, got 'four'"),
        ("n 4", "n 4.5", "n must be a whole number of at least 1, got 4.5"),
        ("m 2", "m 0", "m must be a whole number of at least 1, got 0"),
        ("m 2", "vehicles 2", "line 2 must read 'm NUMBER', got 'vehicles 2'"),
        ("12.5", "-1", "endurance[0] must be positive [s], got -1.0"),
        ("0\t0\t0\n", "0\t0\t7\n", "the start scores 7, must score 0"),
        ("\t10", "\t-10", "line 5: score must not be negative, got -10"),
        ("\t10", "", "line 5 must read 'x y score', got '3 4'"),
        ("3.0", "nan", "line 6: x must be a number, got 'nan'"),
        ("m 2", "m 99999", "more than the 20000 nodes"),
    ],
)
def test_what_cannot_be_used_is_named(tmp_path, old, new, sentence):
    with pytest.raises(InputError) as error:
        read(tmp_path, FILE.replace(old, new, 1))
    assert str(error.value).startswith(str(tmp_path / "p9.2.a.txt"))
    assert sentence in str(error.value)


def test_a_file_of_other_text_is_refused(tmp_path):
    with pytest.raises(InputError, match="must begin with the lines"):
        read(tmp_path, "hello\n")
