"""Claims: one holder at a time, whoever takes, dies or comes back; clocks do not matter."""

from __future__ import annotations

import os
import subprocess
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import msgspec
import pytest

from workbench.jobs import claims
from workbench.jobs.claims import Claims, Holder

HERE = Holder.this_process()


@pytest.fixture
def path(tmp_path) -> Path:
    return tmp_path / "run.json"


@pytest.fixture
def left_behind(path):
    """Leave a claim as another holder would, whose differences from this process are given."""

    def leave(**different: object) -> Path:
        claim = path.with_name(".run.json.claim")
        claim.write_bytes(msgspec.json.encode(replace(HERE, token="other", **different)))
        return claim

    return leave


def ended_pid() -> int:
    process = subprocess.Popen(["true"])
    process.wait()
    return process.pid


def test_a_file_has_one_holder_until_it_is_released(path):
    one, other = Claims(), Claims()
    assert one.take(path)
    assert not other.take(path)
    other.release(path)  # not its own
    assert not other.take(path)
    one.release(path)
    assert other.take(path)
    other.release(path)
    assert list(path.parent.iterdir()) == []


def test_what_is_held_is_let_go_of_at_the_end(path):
    with Claims() as held:
        assert held.take(path)
    assert Claims().take(path)


@pytest.mark.parametrize(
    "different",
    [{"pid": None}, {"pid": 2**62}, {"began": "1"}, {"boot": "an earlier one"}],
    ids=["ended", "no such number", "its number is another's now", "before the machine was started"],
)
def test_the_claim_of_a_process_that_ended_is_taken_over(path, left_behind, different):
    left_behind(**{name: ended_pid() if value is None else value for name, value in different.items()})
    first, second = Claims(), Claims()
    assert first.take(path)
    assert not second.take(path)
    first.release(path)
    assert list(path.parent.iterdir()) == []


def test_a_killed_process_nobody_has_waited_for_has_ended(path, left_behind):
    zombie = subprocess.Popen(["cat"], stdin=subprocess.PIPE)
    began = claims._began(zombie.pid)
    zombie.stdin.close()
    os.waitid(os.P_PID, zombie.pid, os.WEXITED | os.WNOWAIT)
    left_behind(pid=zombie.pid, began=began)
    assert Claims().take(path)
    zombie.wait()


def test_the_claim_of_a_living_process_is_left_alone(path, left_behind, monkeypatch):
    monkeypatch.setattr(claims, "SILENT", 0.0)
    left_behind()  # of this very process
    assert not Claims().take(path)
    time.sleep(0.01)
    assert not Claims().take(path)


@pytest.mark.parametrize("content", [None, b"", b"[[[", b'{"pid": "x"}'], ids=["whole", "empty", "cut", "foreign"])
@pytest.mark.parametrize("year", [1971, 2037], ids=["clock set back", "clock ahead"])
def test_on_another_machine_only_silence_tells(path, left_behind, monkeypatch, content, year):
    monkeypatch.setattr(claims, "SILENT", 0.05)
    claim = left_behind(machine="elsewhere", pid=ended_pid())
    if content is not None:
        claim.write_bytes(content)
    mine = Claims()
    for beat in range(4):  # longer than SILENT in all
        os.utime(claim, (0, (year - 1970) * 31_556_952 + beat))
        assert not mine.take(path)
        time.sleep(0.02)
    time.sleep(0.06)
    assert mine.take(path)


def test_a_holder_shows_signs_of_life(path, monkeypatch):
    monkeypatch.setattr(claims, "BEAT", 0.01)
    with Claims() as held:
        held.take(path)
        claim = path.with_name(".run.json.claim")
        os.utime(claim, (0, 0))
        until = time.monotonic() + 5
        while claim.stat().st_mtime == 0 and time.monotonic() < until:
            time.sleep(0.01)
        assert claim.stat().st_mtime > 0


def at_once(takers: int, path: Path) -> int:
    """Return how many of so many Claims get the file at `path`, all trying at the same moment."""
    gate = threading.Barrier(takers)

    def one(_: int) -> bool:
        mine = Claims()
        gate.wait()
        return mine.take(path)

    with ThreadPoolExecutor(takers) as pool:
        return sum(pool.map(one, range(takers)))


def test_of_many_takers_one_wins(tmp_path):
    assert [at_once(8, tmp_path / f"{number}.json") for number in range(40)] == [1] * 40


def test_of_many_who_find_a_claim_stale_one_wins(path, left_behind):
    gone = ended_pid()
    for _ in range(40):
        claim = left_behind(pid=gone)
        assert at_once(8, path) == 1
        claim.unlink()
    assert list(path.parent.iterdir()) == []


def test_a_taker_killed_while_taking_over_is_taken_over_too(path, left_behind):
    claim = left_behind(pid=ended_pid())
    claim.with_name(".run.json.claim+").write_bytes(claim.read_bytes())
    assert at_once(8, path) == 1
    assert [entry.name for entry in path.parent.iterdir()] == [".run.json.claim"]


def test_a_claim_taken_over_is_not_removed_by_its_former_holder(path, left_behind):
    former = Claims()
    former.take(path)
    left_behind(pid=ended_pid())  # as if the former holder had been silent for too long
    new = Claims()
    assert new.take(path)
    former.release(path)
    assert not Claims().take(path)


def test_what_cannot_be_claimed_is_not_kept_from_being_done(tmp_path):
    mine = Claims()
    assert mine.take(tmp_path / "no such folder" / "run.json")
    mine.release(tmp_path / "no such folder" / "run.json")


def test_a_pipe_or_folder_in_place_of_a_claim_holds_nobody_up(path, monkeypatch):
    monkeypatch.setattr(claims, "SILENT", 0.0)
    claim = path.with_name(".run.json.claim")
    os.mkfifo(claim)
    mine = Claims()
    assert not mine.take(path)
    assert mine.take(path)
    claim.unlink()
    claim.mkdir()
    other = Claims()
    assert not other.take(path)
    assert other.take(path)


def test_holding_waits_for_the_other(path):
    one, other = Claims(), Claims()
    one.take(path)
    threading.Timer(0.05, one.release, [path]).start()
    with other.holding(path):
        assert not one.take(path)
    assert one.take(path)
