"""A case: one target with one change, run in a folder of its own and judged."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from random import Random

from tests.fuzz.corpus import traps
from tests.fuzz.mutations import mutated
from tests.fuzz.nasty import FILES
from tests.fuzz.oracle import Find, judged, outcome
from tests.fuzz.targets import Target, retyped
from workbench.mission.stamp import FILE, products_of


@dataclass(frozen=True)
class Change:
    """What is changed: the command line, or the file `name` (relative to the folder of the case) to `content`."""

    args: tuple[str, ...]
    name: str = ""
    content: bytes = b""


class Room:
    """The folder in which the cases of one target run, as the corpus has it before each; paths that climb stay near."""

    def __init__(self, target: Target, corpus: Path, below: Path) -> None:
        self.target = target
        self.outside = below / "".join(c if c.isalnum() else "-" for c in target.name)
        self.inside = self.outside / "a" / "b" / "c"
        self.inside.mkdir(parents=True)
        for pattern in (*target.files, *target.beside):
            for path in corpus.glob(pattern):
                place = self.inside / path.relative_to(corpus)
                place.parent.mkdir(parents=True, exist_ok=True)
                if path.is_file() and not place.exists():
                    shutil.copyfile(path, place)
        traps(self.inside)
        found = [path for path in sorted(self.inside.rglob("*")) if path.is_file() and not path.is_symlink()]
        self.kept = {path: path.read_bytes() for path in found}
        changed = {path for pattern in target.files for path in self.inside.glob(pattern)}
        self.changeable = [path for path in found if path in changed]
        self._seen: dict[str, tuple[int, ...]] = {}
        self._look()

    def change(self, rng: Random) -> Change:
        """Draw one change."""
        if not self.target.files:
            return Change(tuple(retyped(rng, self.target.args)))
        path = rng.choice(self.changeable)
        content = mutated(rng, path.name, self.kept[path])
        return Change(self.target.args, path.relative_to(self.inside).as_posix(), content)

    def find(self, change: Change, prepare: Callable[[Path], None] = lambda folder: None) -> Find | None:
        """Run a change and return what was wrong; `prepare` may change the folder, which is restored afterwards."""
        os.chdir(self.inside)
        prepare(self.inside)
        names: tuple[str, ...] = ("",)
        if change.name:
            path = self.inside / change.name
            path.write_bytes(change.content)
            if self.target.sealed:
                _seal(path.parent)
            words = [word for word in change.args if not word.startswith("-") and "." in word]
            names = (
                *Path(change.name).parts,
                path.name.split(".")[0],
                *words,
                *FILES,
                "passwd",
            )  # or what the file itself names
        try:
            found = outcome(list(change.args), self.outside)
            return judged(found, change.args, names, self.target.outputs, len(change.content))
        finally:
            self._restore()

    def fault_of_itself(self) -> Find | None:
        """Return what is wrong where nothing is changed, which would make every find worthless."""
        os.chdir(self.inside)
        try:
            found = outcome(list(self.target.args), self.outside, limited=False)
            wrong = judged(found, self.target.args, ("",), self.target.outputs, 0)
            wrong = None if wrong and wrong.kind in ("slow", "memory") else wrong  # imports and compilation
            return wrong or (Find("corpus", found.err[-500:]) if found.code not in (0, 1) else None)
        finally:
            self._restore()

    def _look(self) -> None:
        self._seen = {entry: _signature(entry) for entry in self._entries()}

    def _entries(self) -> list[str]:
        walk = os.walk(self.outside)
        return [os.path.join(root, name) for root, folders, names in walk for name in (*folders, *names)]

    def _restore(self) -> None:
        now = {entry: _signature(entry) for entry in self._entries()}
        if now == self._seen:
            return
        for entry in sorted(now.keys() - self._seen.keys(), reverse=True):
            if os.path.isdir(entry) and not os.path.islink(entry):
                shutil.rmtree(entry, ignore_errors=True)
            elif os.path.lexists(entry):
                os.unlink(entry)
        for path, content in self.kept.items():
            if now.get(str(path)) != self._seen[str(path)]:
                path.parent.mkdir(parents=True, exist_ok=True)
                path.unlink(missing_ok=True)  # it may be a link or a FIFO by now
                path.write_bytes(content)
        for trap in ("zero", "self", "fifo", "folder"):
            if str(self.inside / trap) not in now:
                raise RuntimeError(f"a case of {self.target.name} removed {trap}")
        self._look()


def keep(folder: Path, target: Target, number: int, seed: int, change: Change, find: Find) -> Path:
    """Write a find with all it takes to replay it and return its folder."""
    place = folder / f"{''.join(c if c.isalnum() else '-' for c in target.name)}-{number}"
    place.mkdir(parents=True, exist_ok=True)
    about = {"target": target.name, "case": number, "seed": seed, "args": change.args, "name": change.name}
    (place / "find.json").write_text(json.dumps(about | asdict(find), indent=1))
    if change.name:
        (place / "content").write_bytes(change.content)
    return place


def kept_change(place: Path) -> tuple[str, Change]:
    """Return target and change of a kept find."""
    about = json.loads((place / "find.json").read_text())
    content = (place / "content").read_bytes() if about["name"] else b""
    return about["target"], Change(tuple(about["args"]), about["name"], content)


def _signature(path: str) -> tuple[int, ...]:
    found = os.lstat(path)
    return (found.st_ino, found.st_size, found.st_mtime_ns) if not os.path.isdir(path) else (found.st_ino,)


def _seal(folder: Path) -> None:
    stamp = folder / FILE
    told = json.loads(stamp.read_bytes())
    stamp.write_text(json.dumps(told | {"products": products_of(folder)}))
