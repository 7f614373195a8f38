"""Kills: ``python -m tests.faults.kills --kills 100``: kill −9 at random moments over studies and missions.

Parent, child or whole group of a command is killed and the command started again until all is done. Then: every run is
stored once, no file that was there has changed, nothing was executed again after it had been stored, no run is stored
as KILLED but where the child alone was hit, and five seconds after a kill of parent or group nothing runs.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import uuid
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

import psutil

from tests.faults.remains import TOKEN, left_after

ROOT = Path(__file__).parents[2]
LOG = "WORKBENCH_EXECUTED"
"""Variable of the environment that names the file to which every execution of a method adds a line."""
SCENARIO = "airspeed = 20.0\nsize = [1000, 1000]\ndepots = [[10, 10], [990, 10]]\ntasks = [[500, 900]]\n"
PROGRAM = "import sys; from workbench.cli import main; main(sys.argv[1:])"
SEEDS = 6
"""Runs of each study."""
ORPHAN_LIMIT = 5.0
"""Seconds after a kill in which everything it left must have ended."""
MISSION = """airspeed = 50.0
size = [6000, 5000]
depots = [[500, 500], [5500, 500]]
tasks = 3
[wind]
kind = "uniform"
velocity = [1, 2]
[radio]
position = [3000, 2500]
[field]
model = "free-space"
cells = 10
[place]
method = "greedy"
tests = [3, 3]
certificate = false
[costs]
method = "closed-form"
[routes]
solver = "tests.faults.logged:Routes"
time_limit = 5.0
[map]
refit_every = 0
cells = 6
frames = 2
[compare]
baselines = ["random"]
time_limit = 5.0
"""


@dataclass(frozen=True)
class Kind:
    """One kind of work: the files it needs, its command line, what it leaves (a pattern) and how often.

    executions: of methods, where nothing is killed; lost: of them by one kill, at most.
    """

    name: str
    files: dict[str, str]
    args: tuple[str, ...]
    done: str
    count: int
    executions: int
    lost: int


def _study(problem: str, items: str, entries: str, method: str) -> Kind:
    text = f'problem = "{problem}"\nseeds = {SEEDS}\ntime_limit = 5\n{items}\n'
    text += f'[[{entries}]]\nname = "tests.faults.logged:{method}"\n'
    files = {"study.toml": text, "a.toml": SCENARIO}
    args = ("compare", "study.toml", "--out", "runs", "--jobs", "2", "--no-report")
    return Kind(problem, files, args, "*/*-s*-t*.json", SEEDS, SEEDS, lost=2)  # two at once


FAMILY = '[[families]]\nfamily = "uniform"\ntasks = 4\ndepots = 2'
KINDS = (
    _study("routing", FAMILY, "solvers", "Routes"),
    _study("placement", 'tasks = [2]\ntests = "4x4"', "methods", "Points"),
    _study("moving-cost", 'scenarios = ["a.toml"]', "methods", "Costs"),
    _study("survey", 'endurance = 80\n[[fields]]\nkind = "gp"', "methods", "Tours"),
    # its comparison, 15 executions, is one stage: after a kill it begins anew
    Kind("mission", {"m.toml": MISSION}, ("mission", "m.toml", "--out", "runs"), "*/stamp.json", 8, 16, lost=15),
)


@dataclass
class Tally:
    """What came of the kills: how many of each, everything that should not be, and files left aside."""

    kills: Counter[str] = field(default_factory=Counter)
    wrong: list[str] = field(default_factory=list)
    killed_rows: int = 0
    litter: int = 0


class Trial:
    """One piece of work in a folder of its own, killed at random and started again until it is done."""

    def __init__(self, kind: Kind, folder: Path, rng: Random, tally: Tally, most: int) -> None:
        self.kind, self.folder, self.rng, self.tally, self.most = kind, folder, rng, tally, most
        self.token = uuid.uuid4().hex
        self.executed = folder / "executed.txt"
        self.kept: dict[str, str] = {}
        self.hit = False
        for name, text in kind.files.items():
            (folder / name).write_text(text)

    def run(self) -> int:
        """Kill up to `most` times, at moments within the time the work takes; return how often."""
        kills = 0
        for _ in range(self.most + 5):
            ended = self._once(kills < self.most)
            if ended is None:
                kills += 1
                continue
            if ended:
                self._wrong(f"ended with {ended}: {(self.folder / 'said.txt').read_text()[-300:]}")
            break
        else:
            self._wrong("was never done")
        self._look()
        return kills

    def _once(self, kill: bool) -> int | None:
        """Run the command to its end and return its exit code, or None where parent, child or group was killed."""
        self.hit = False
        with self._started() as process:
            if not kill:
                return process.wait()
            whom = self.rng.choice(("parent", "group", "child"))
            self._wait_for_a_moment(process)
            while process.poll() is None and not self._kill(process, whom):
                time.sleep(0.02)
            if process.poll() is not None and process.returncode != -signal.SIGKILL and whom != "child":
                return process.returncode
            process.wait()
            if whom == "child" and not self.hit:
                return process.returncode
            self.tally.kills[f"{self.kind.name} {whom}"] += 1
            if whom == "child":
                self._forget_killed_rows()
            self._orphans(f"after {whom} was killed")
            self._files_stay()
        return None

    def _wait_for_a_moment(self, process: subprocess.Popen[bytes]) -> None:
        """Wait until one more run or some more are stored, or not even that, and then a little."""
        enough = len(self._stored()) + self.rng.choice((0, 0, 1, 1, 2, 3))
        while process.poll() is None and len(self._stored()) < min(enough, self.kind.count):
            time.sleep(0.02)
        until = time.monotonic() + self.rng.uniform(0.0, 3.0)
        while process.poll() is None and time.monotonic() < until:
            time.sleep(0.02)

    def _kill(self, process: subprocess.Popen[bytes], whom: str) -> bool:
        parent = psutil.Process(process.pid)
        try:
            if whom == "child":
                workers = parent.children(recursive=True)
                if not workers:
                    return False
                self.rng.choice(workers).kill()
                self.hit = True
            elif whom == "group":
                all_of_it = [parent, *parent.children(recursive=True)]
                self.rng.shuffle(all_of_it)  # one after the other, as a batch system does
                for each in all_of_it:
                    with contextlib.suppress(psutil.NoSuchProcess):
                        each.kill()
            else:
                parent.kill()
        except psutil.NoSuchProcess:
            return whom != "child"
        return True

    @contextlib.contextmanager
    def _started(self) -> Iterator[subprocess.Popen[bytes]]:
        env = os.environ | {TOKEN: self.token, LOG: str(self.executed), "PYTHONPATH": str(ROOT)}
        with (self.folder / "said.txt").open("wb") as said:
            process = subprocess.Popen(
                [sys.executable, "-P", "-c", PROGRAM, *self.kind.args],
                cwd=self.folder,
                env=env,
                stdout=said,
                stderr=said,
                start_new_session=True,
            )
            try:
                yield process
            finally:
                if process.poll() is None:
                    process.kill()
                    process.wait()

    def _stored(self) -> dict[str, Path]:
        """Return what is done: the file of each run, the stamp of each stage of a mission."""
        found = (self.folder / "runs").glob(self.kind.done)
        return {path.relative_to(self.folder).as_posix(): path for path in found}

    def _files_stay(self) -> None:
        """Remember what is stored; what was is still there and the same."""
        now = {name: hashlib.sha256(path.read_bytes()).hexdigest() for name, path in self._stored().items()}
        for name, digest in self.kept.items():
            if now.get(name) != digest:
                self._wrong(f"{name} was {'lost' if name not in now else 'written again'}")
        self.kept = now

    def _forget_killed_rows(self) -> None:
        """A child killed alone may be a KILLED row: run again, as a user would, by removing it."""
        found = {name: json.loads(path.read_bytes()) for name, path in self._stored().items()}
        killed = [name for name, run in found.items() if run.get("status") in ("KILLED", "ERROR")]
        if len(killed) > 1:
            self._wrong(f"one child was killed, {len(killed)} rows are KILLED")
        for name in killed:
            self.tally.killed_rows += 1
            self._stored()[name].unlink()
            self.kept.pop(name, None)

    def _orphans(self, when: str) -> None:
        for process in left_after(self.token, ORPHAN_LIMIT):
            self._wrong(f"left running {when}: {process}")

    def _look(self) -> None:
        """Look at the end: every run stored once, none KILLED, none executed again once it was stored."""
        self._orphans("at the end")
        self._files_stay()
        self.tally.litter += len(list(self.folder.rglob("*.part")))  # kill −9 amid a write: under no file's own name
        stored = self._stored()
        if len(stored) != self.kind.count:
            self._wrong(f"{len(stored)} of {self.kind.count} are stored")
        began = [line.split() for line in self.executed.read_text().splitlines()]
        if len(began) > self.kind.executions + self.kind.lost * self.most:
            self._wrong(f"{len(began)} executions instead of {self.kind.executions}, and {self.most} kills")
        for name, path in stored.items():
            run = json.loads(path.read_bytes())
            if run.get("status") in ("KILLED", "ERROR"):
                self._wrong(f"{name} is stored as {run['status']}: {run['message']}")
            ended = path.stat().st_mtime
            if any(int(seed) == run.get("seed") and float(moment) > ended for seed, moment in began):
                self._wrong(f"{name} was executed again after it had been stored")

    def _wrong(self, sentence: str) -> None:
        self.tally.wrong.append(f"{self.kind.name} in {self.folder.name}: {sentence}")
        print(self.tally.wrong[-1], file=sys.stderr, flush=True)


def kill(kills: int, seed: int, below: Path, kinds: tuple[Kind, ...] = KINDS, each: int = 5) -> Tally:
    """Kill at least `kills` times over `kinds` in turn, at most `each` times a piece of work."""
    rng, tally = Random(seed), Tally()
    for number in range(10 * kills):
        if sum(tally.kills.values()) >= kills:
            break
        kind = kinds[number % len(kinds)]
        folder = below / f"{number}-{kind.name}"
        folder.mkdir()
        most = min(each, kills - sum(tally.kills.values()))
        Trial(kind, folder, rng, tally, most).run()
        print(
            f"{folder.name}: {sum(tally.kills.values())} kills, {len(tally.wrong)} wrong", file=sys.stderr, flush=True
        )
    return tally


def main() -> int:
    """Kill, and tell what came of it."""
    parser = argparse.ArgumentParser(prog="python -m tests.faults.kills", description=__doc__)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kind", action="append", choices=[kind.name for kind in KINDS])
    asked = parser.parse_args()
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as below:
        kinds = tuple(kind for kind in KINDS if not asked.kind or kind.name in asked.kind)
        tally = kill(asked.kills, asked.seed, Path(below), kinds)
    for what, count in sorted(tally.kills.items()):
        print(f"{what:20} {count:4d} kills")
    print(
        f"{sum(tally.kills.values())} kills in {time.monotonic() - began:.0f} s; {tally.killed_rows} runs hit alone; "
        f"{tally.litter} files aside left"
    )
    return 1 if tally.wrong else 0


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)
    sys.exit(main())
