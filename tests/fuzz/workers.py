"""Workers: processes that run cases until the time is up; one that dies or hangs is a find, and another goes on."""

from __future__ import annotations

import contextlib
import faulthandler
import json
import os
import resource
import selectors
import signal
import sys
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from random import Random
from typing import Any

from instances import registry
from tests.fuzz.case import Room, keep
from tests.fuzz.oracle import MEMORY_LIMIT, WALL_LIMIT, Find
from tests.fuzz.targets import TARGETS, Target

SLICE = 0.3
"""Seconds of one target before the next has its turn: quick ones get many cases, slow ones at least one."""
SLOW_START = 1.0
"""Seconds of a first run that are worth a line."""


@dataclass(frozen=True)
class Plan:
    """What to do: the corpus, a folder for work and one for finds, targets, seed, workers, and when to stop."""

    corpus: Path
    work: Path
    finds: Path
    targets: tuple[str, ...]
    seed: int
    workers: int
    until: float
    cases: int


@dataclass
class Tally:
    """What has been run and found so far: target → cases, and finds."""

    cases: Counter[str] = field(default_factory=Counter)
    finds: list[dict[str, Any]] = field(default_factory=list)


@dataclass
class _Worker:
    number: int
    pid: int
    pipe: int
    unread: bytes = b""


def warm_up(plan: Plan, tell: Callable[[str], None]) -> None:
    """Run every target as the corpus has it, so that workers start with all imported; RuntimeError where one fails."""
    registry.entry_points = cache(entry_points)  # type: ignore[assignment]  # to look for packages takes most of a case
    for name in plan.targets:
        began = time.monotonic()
        wrong = Room(TARGETS[name], plan.corpus, plan.work / "warm").fault_of_itself()
        if wrong:
            raise RuntimeError(f"the corpus is no good for {name}: {wrong.kind} {wrong.sentence} {wrong.where}")
        if time.monotonic() - began > SLOW_START:
            tell(f"{name}: {time.monotonic() - began:.1f} s")


def fuzz(plan: Plan) -> Tally:
    """Run cases in `plan.workers` processes until the time or the number of cases is reached."""
    tally = Tally()
    # where each worker goes on: worker w runs the cases w, w + workers, …
    following = {(w, name): w for w in range(plan.workers) for name in plan.targets}
    selector = selectors.DefaultSelector()

    def start(number: int) -> None:
        worker = _fork(plan, number, {name: following[number, name] for name in plan.targets})
        selector.register(worker.pipe, selectors.EVENT_READ, worker)

    for number in range(plan.workers):
        start(number)
    while selector.get_map():
        for key, _ in selector.select(1.0):
            worker: _Worker = key.data
            data = os.read(worker.pipe, 1 << 16)
            for message in _messages(worker, data):
                tally.cases[message["target"]] += 1
                following[worker.number, message["target"]] = message["case"] + plan.workers
                tally.finds += [message] if "kind" in message else []
            if not data:
                selector.unregister(worker.pipe)
                os.close(worker.pipe)
                lost = _ended(plan, worker)
                if lost is None:
                    continue
                tally.cases[lost["target"]] += 1
                tally.finds.append(lost)
                following[worker.number, lost["target"]] = lost["case"] + plan.workers
                if not _over(plan, sum(tally.cases.values())):
                    start(worker.number)
    return tally


def _over(plan: Plan, cases: int) -> bool:
    return time.monotonic() > plan.until or cases >= plan.cases


def _messages(worker: _Worker, data: bytes) -> Iterator[dict[str, Any]]:
    *lines, worker.unread = (worker.unread + data).split(b"\n")
    return (json.loads(line) for line in lines)


def _fork(plan: Plan, number: int, following: dict[str, int]) -> _Worker:
    pipe, ours = os.pipe()
    pid = os.fork()
    if pid:
        os.close(ours)
        return _Worker(number, pid, pipe)
    code = 1
    try:
        os.close(pipe)
        os.setsid()
        _work(plan, number, following, ours)
        code = 0
    except BaseException:
        traceback.print_exc()  # into the file of last words
    finally:
        os._exit(code)


def _work(plan: Plan, number: int, following: dict[str, int], pipe: int) -> None:
    place = plan.work / f"{number}-{os.getpid()}"
    place.mkdir()
    last_words = (plan.work / f"{number}.trace").open("w")
    sys.stderr = last_words
    current = os.open(plan.work / f"{number}.current", os.O_RDWR | os.O_CREAT | os.O_TRUNC)
    faulthandler.enable(last_words)
    os.dup2(last_words.fileno(), 2)
    rooms: dict[str, Room] = {}
    done = 0
    order = list(plan.targets)
    Random(number).shuffle(order)
    while True:
        for name in order:
            turn_ends = time.monotonic() + SLICE
            while True:
                if _over(plan, plan.workers * done):
                    return
                case, following[name] = following[name], following[name] + plan.workers
                os.ftruncate(current, 0)
                os.pwrite(current, json.dumps([name, case]).encode(), 0)
                message = _case(plan, rooms, place, TARGETS[name], case, last_words.fileno())
                os.write(pipe, json.dumps(message).encode() + b"\n")
                done += 1
                if time.monotonic() > turn_ends:
                    break


def _case(plan: Plan, rooms: dict[str, Room], place: Path, target: Target, case: int, trace: int) -> dict[str, Any]:
    message: dict[str, Any] = {"target": target.name, "case": case}
    me = os.getpid()
    if target.name not in rooms:
        rooms[target.name] = Room(target, plan.corpus, place)
    room = rooms[target.name]
    change = room.change(Random(f"{plan.seed} {target.name} {case}"))
    faulthandler.dump_traceback_later(WALL_LIMIT, exit=True, file=trace)
    _limit_memory()
    find = room.find(change)
    faulthandler.cancel_dump_traceback_later()
    if os.getpid() != me:  # the case forked, and this is the copy
        os._exit(0)
    if find is None:
        return message
    kept = keep(plan.finds, target, case, plan.seed, change, find)
    return message | asdict(find) | {"kept": str(kept)}


def _limit_memory() -> None:
    """Let the process grow by twice what a case may hold: beyond, memory runs out for it alone."""
    size = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    resource.setrlimit(resource.RLIMIT_AS, (size + 2 * MEMORY_LIMIT, resource.RLIM_INFINITY))


def _ended(plan: Plan, worker: _Worker) -> dict[str, Any] | None:
    """Wait for a worker; return the find where a case ended or hung it, or None where it was done."""
    _, status = os.waitpid(worker.pid, 0)
    code = os.waitstatus_to_exitcode(status)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(worker.pid, signal.SIGKILL)  # whatever its cases left
    if code == 0:
        return None
    name, case = json.loads((plan.work / f"{worker.number}.current").read_text())
    trace = (plan.work / f"{worker.number}.trace").read_text(errors="replace")
    hung = "Timeout" in trace
    find = Find("hang" if hung else "crash", f"ended the process with {code}", _own_line(trace), trace[-4000:])
    room = Room(TARGETS[name], plan.corpus, plan.work / f"lost-{name.replace(' ', '-')}-{case}")
    change = room.change(Random(f"{plan.seed} {name} {case}"))
    kept = keep(plan.finds, TARGETS[name], case, plan.seed, change, find)
    return {"target": name, "case": case} | asdict(find) | {"kept": str(kept)}


def _own_line(trace: str) -> str:
    """Return the innermost line of ours in a trace of faulthandler, as ``file:line``."""
    for line in trace.splitlines():
        if 'File "' in line and f"{os.sep}tests{os.sep}" not in line and "site-packages" not in line:
            for room in ("workbench", "formulations", "instances", "reports"):
                if f"{os.sep}{room}{os.sep}" in line:
                    path, _, rest = line.partition('File "')[2].partition('"')
                    return f"{room}{path.rpartition(os.sep + room)[2]}:{rest.split()[2]}"
    return ""


def distinct(finds: Sequence[dict[str, Any]]) -> list[tuple[int, dict[str, Any]]]:
    """Return finds that differ in kind, place and first words, with how often each was met, the most frequent first."""
    first: dict[tuple[str, ...], dict[str, Any]] = {}
    count: Counter[tuple[str, ...]] = Counter()
    for find in finds:
        key = (find["kind"], find["where"] or find["target"], find["sentence"].split(":")[0][:40])
        first.setdefault(key, find)
        count[key] += 1
    return [(number, first[key]) for key, number in count.most_common()]
