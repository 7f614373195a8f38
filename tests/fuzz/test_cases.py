"""What was ever found, by the fuzzer or by people, stays found: every named case of `named`, in one process."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.fuzz import corpus
from tests.fuzz.case import Change, Room
from tests.fuzz.named import CASES, Named
from tests.fuzz.oracle import Find
from tests.fuzz.targets import TARGETS


@pytest.fixture(scope="module")
def rooms(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Room]]:
    """A room for each target that a case has."""
    here, below = Path.cwd(), tmp_path_factory.mktemp("fuzz")
    corpus.make_files(below / "corpus")
    yield {name: Room(TARGETS[name], below / "corpus", below / "rooms") for name in {case.target for case in CASES}}
    os.chdir(here)


def find(case: Named, room: Room) -> Find | None:
    if case.prepare:
        return room.find(Change(case.args), case.prepare)
    if not case.file:
        return room.find(Change(case.args))
    (path,) = room.inside.glob(case.file)
    assert case.content is not None
    return room.find(Change(case.args, path.relative_to(room.inside).as_posix(), case.content(path.read_bytes())))


def test_names_are_distinct() -> None:
    assert len({case.name for case in CASES}) == len(CASES)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_named_case(case: Named, rooms: dict[str, Room]) -> None:
    found = find(case, rooms[case.target])
    assert found is None, f"{found.kind}: {found.sentence} {found.where}"
