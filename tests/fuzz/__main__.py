"""``python -m tests.fuzz --seconds 60 --seed 0``: fuzz every reader and every command; exit code 1 on finds."""

from __future__ import annotations

import argparse
import os
import shutil
import sys
import tempfile
import time
from collections import Counter
from dataclasses import replace
from pathlib import Path

from tests.fuzz import corpus
from tests.fuzz.case import Room, kept_change
from tests.fuzz.targets import TARGETS
from tests.fuzz.workers import Plan, Tally, distinct, fuzz, warm_up

MEMORY = Path("/dev/shm")
"""Where there is one, files that are made and thrown away by the thousand never reach a disk."""
LEAST = 0.25
"""Share of the time asked for that is left for cases."""


def main() -> int:
    """Make the corpus, run the cases, print the table, and say how to replay what was found."""
    asked = _asked()
    began = time.monotonic()
    work = Path(tempfile.mkdtemp(prefix="fuzz-", dir=MEMORY if MEMORY.is_dir() else None))
    here = Path.cwd()
    try:
        made = asked.corpus.resolve() if asked.corpus else work / "corpus"
        if not made.exists():
            corpus.make(made, lambda words: print(f"corpus: {words}", file=sys.stderr, flush=True))
        if asked.replay:
            return _replay([place.resolve() for place in asked.replay], made, work)
        finds = (here / asked.finds).resolve()
        names = tuple(name for name in TARGETS if not asked.reader or any(part in name for part in asked.reader))
        cases = asked.cases or sys.maxsize
        plan = Plan(made, work, finds, names, asked.seed, asked.workers, float("inf"), cases)
        warm_up(plan, lambda words: print(f"first run: {words}", file=sys.stderr, flush=True))
        print(f"ready after {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)
        fuzzing = time.monotonic()
        if asked.seconds:  # some cases however long the start has taken
            plan = replace(plan, until=max(began + asked.seconds, fuzzing + LEAST * asked.seconds))
        tally = fuzz(plan)
        return _told(tally, time.monotonic() - fuzzing)
    finally:
        os.chdir(here)
        shutil.rmtree(work, ignore_errors=True)


def _asked() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("--seconds", type=float, help="wall clock for all of it, making the corpus included")
    parser.add_argument("--cases", type=int, help="so many cases in all")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--reader", action="append", help="only targets with this in their name; repeatable")
    parser.add_argument("--workers", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--corpus", type=Path, help="a corpus to use, made there if it is not there")
    parser.add_argument("--finds", type=Path, default=Path("runs/fuzz"), help="folder of what is found")
    parser.add_argument("--replay", type=Path, nargs="+", help="folders of finds to run again")
    asked = parser.parse_args()
    if not (asked.seconds or asked.cases):
        asked.seconds = 60.0
    return asked


def _told(tally: Tally, elapsed: float) -> int:
    found = Counter(find["target"] for find in tally.finds)
    width = max(map(len, tally.cases), default=0)
    print(f"{'target':{width}}  {'cases':>7}  {'finds':>6}")
    for name in TARGETS:
        if name in tally.cases:
            print(f"{name:{width}}  {tally.cases[name]:7d}  {found[name]:6d}")
    total = sum(tally.cases.values())
    print(f"{total} cases in {elapsed:.0f} s, {len(tally.finds)} finds")
    for number, find in distinct(tally.finds):
        print(f"{number:6d} × {find['target']}: {find['kind']} {find['where']} {find['sentence'][:160]!r}")
        print(f"         python -m tests.fuzz --replay {find['kept']}")
    return 1 if tally.finds else 0


def _replay(places: list[Path], made: Path, work: Path) -> int:
    """Run kept finds again in this process, without limits: a debugger can look at them."""
    wrong = 0
    for number, place in enumerate(places):
        name, change = kept_change(place)
        found = Room(TARGETS[name], made, work / f"replay-{number}").find(change)
        wrong += found is not None
        print(f"{place}: " + (f"{found.kind}: {found.sentence}\n{found.trace}" if found else "all right"))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
