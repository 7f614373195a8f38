"""A team of threads: the same comes out whatever its size, and what fails in one thread ends the others' work."""

import threading

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing.branch_and_price import BranchAndPrice
from formulations.routing.columns.labelling import make_store
from formulations.routing.columns.team import Team, one_by_one
from instances import Instance


def scattered(n: int, m: int, seed: int) -> Instance:
    """Tasks and depots in a square, legs that are not the same both ways."""
    places = np.random.default_rng(seed).uniform(0, 100, (n + m, 2))
    leg = places[None] - places[:, None]
    return Instance("scattered", np.hypot(leg[..., 0], leg[..., 1]) + 0.3 * leg[..., 0], n, m)


@pytest.mark.parametrize(("n", "m", "seed"), [(24, 3, 0), (24, 4, 1), pytest.param(30, 3, 2, marks=pytest.mark.slow)])
def test_a_proof_is_the_same_step_by_step_by_one_thread_and_by_two(n: int, m: int, seed: int) -> None:
    instance = scattered(n, m, seed)
    alone, together = (
        BranchAndPrice().solve(instance, limits=Limits(time=300.0, threads=threads), seed=3) for threads in (1, 2)
    )
    assert alone.stopped_by == together.stopped_by == "proof"
    assert alone.statistics == together.statistics
    assert (alone.routes, alone.bound) == (together.routes, together.bound)


def test_things_are_done_at_once_and_answered_in_order() -> None:
    """Either of two waits for the other: one after the other they would wait for ever."""
    meeting, team = threading.Barrier(2, timeout=30.0), Team(lambda: make_store(3, 8), 2)

    def work(number: int) -> int:
        if number < 2:
            meeting.wait()
        return 10 * number

    assert team.each(work, range(5)) == one_by_one(lambda number: 10 * number, range(5)) == [0, 10, 20, 30, 40]
    assert not team.over


def test_every_thread_has_room_of_its_own_and_keeps_it() -> None:
    meeting, team = threading.Barrier(2, timeout=30.0), Team(lambda: make_store(3, 8), 2)

    def rooms(k: int) -> tuple[int, int]:
        meeting.wait()
        return id(team.of_uav(k)), id(team.of_uav(k + 1))

    (one, again), (other, too) = team.each(rooms, range(2))
    assert one == again != other == too


def test_what_fails_in_one_thread_is_raised_and_tells_the_others_to_leave_off() -> None:
    team = Team(lambda: make_store(3, 8), 2)

    def work(number: int) -> None:
        if number == 1:
            raise MemoryError("no room")

    with pytest.raises(MemoryError, match="no room"):
        team.each(work, range(3))
    assert team.over
