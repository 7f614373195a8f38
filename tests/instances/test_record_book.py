"""The record book: what is better is entered with its routes, what is worse or contradicts changes nothing."""

import json

import numpy as np
import pytest

from instances import InputError, Instance, makespan
from instances.best_known import table
from instances.record_book import COLUMNS, RecordBook, read_book

GOOD, BAD = ((0, 1), (2,)), ((0, 1, 2), ())


@pytest.fixture
def instance():
    rng = np.random.default_rng(3)
    points = np.vstack([rng.uniform(0, 4, (2, 2)), rng.uniform(9, 10, (1, 2)), [[2, 2], [9, 9]]])
    cost = np.linalg.norm(points[:, None] - points[None], axis=2)
    return Instance("near", cost, n_tasks=3, n_depots=2)


@pytest.fixture
def book(instance):
    made = RecordBook({}, {})
    assert made.offer(instance, BAD, "first", add=True)
    return made


def test_better_routes_are_entered_and_worse_ones_never(book, instance, tmp_path):
    assert "was" in book.offer(instance, GOOD, "second")
    assert book.offer(instance, BAD, "third") == ""
    known = book.entries[instance.digest]
    assert (known.best_known, known.source, known.proven) == (makespan(instance, GOOD), "second", False)
    book.write(tmp_path)
    again = read_book(tmp_path)
    assert again.entries == book.entries
    assert json.loads((tmp_path / "tours.json").read_text())["near"]["routes"] == [[0, 1], [2]]


def test_an_instance_that_is_not_in_the_book_is_added_only_where_asked(instance):
    book = RecordBook({}, {})
    assert book.offer(instance, GOOD, "") == ""
    assert not book.entries


def test_bounds_rise_and_prove(book, instance):
    book.offer(instance, GOOD, "")
    value = makespan(instance, GOOD)
    assert "was none" in book.raise_bound(instance.digest, 0.5 * value)
    assert book.raise_bound(instance.digest, 0.4 * value) == ""
    assert "proves" in book.raise_bound(instance.digest, value)
    assert book.entries[instance.digest].proven


def test_contradictions_change_nothing(book, instance):
    before = dict(book.entries)
    with pytest.raises(InputError, match=r"near: a bound of .* contradicts routes of"):
        book.raise_bound(instance.digest, 1.1 * makespan(instance, BAD))
    assert book.entries == before
    book.raise_bound(instance.digest, 0.99 * makespan(instance, BAD))  # false, as the next routes show
    before = dict(book.entries)
    with pytest.raises(InputError, match="contradicts"):
        book.offer(instance, GOOD, "")
    assert (book.entries, book.tours["near"]["routes"]) == (before, [[0, 1, 2], []])
    with pytest.raises(InputError, match="near: "):
        book.offer(instance, ((0,), (2,)), "a task is missing")


def test_the_book_that_comes_along_is_read_and_written_alike(tmp_path):
    from instances import record_book

    shipped = read_book(record_book.SHIPPED)
    assert shipped.entries == dict(table())
    shipped.write(tmp_path)
    assert read_book(tmp_path) == shipped


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a,b\n", "line 1 must name the columns instance, digest"),
        (",".join(COLUMNS) + "\nmd1,00,ten,3,1.0,true,,x\n", "line 2 is no entry"),
        (",".join(COLUMNS) + "\nmd1,00,10\n", "line 2 is no entry"),
        (",".join(COLUMNS) + 2 * "\nmd1,00,10,3,1.0,true,,x" + "\n", "line 3 has the digest of md1"),
        (",".join(COLUMNS) + "\nmd1,00,10,3,1.0,true,2.0,x\n", "line 2 has a bound above its value: 2.0"),
    ],
)
def test_a_damaged_book_is_told_by_file_and_line(tmp_path, text, said):
    (tmp_path / "best_known.csv").write_text(text)
    with pytest.raises(InputError, match=r"best_known\.csv: ") as caught:
        read_book(tmp_path)
    assert said in str(caught.value)
