"""The oracle: what a command may do with a file or a value it cannot use, and what it did."""

from __future__ import annotations

import contextlib
import io
import os
import re
import resource
import signal
import sys
import traceback
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from workbench.cli import main

CODES = (0, 1, 2, 130)
LONGEST_SENTENCE = 1200
"""Characters of what is said on exit code 2: a sentence of 1,000 and a path."""
REPEATED = re.compile(r"([^\s.=─━-])\1{255}")
"""A value of thousands of characters that is repeated whole; ours are made of one character."""
CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\u202e]")
"""What could change a terminal."""
CPU_LIMIT = 10.0
"""Seconds of processor time a case may take."""
WALL_LIMIT = 120.0
"""Seconds of wall clock after which a case is ended: it is blocked, however busy the machine is."""
MEMORY_LIMIT = 1 << 30
"""Bytes a case may hold beyond what was held before."""
ROOT = str(Path(__file__).parents[2])


@dataclass(frozen=True)
class Find:
    """What was wrong: its kind, a sentence, where in our code (``file:line``) and the traceback, if any."""

    kind: str
    sentence: str
    where: str = ""
    trace: str = ""


@dataclass(frozen=True)
class Outcome:
    """What a command did: exit code, what it said, what it raised, CPU and wall [s], memory [bytes], new files."""

    code: int | None
    out: str
    err: str
    raised: Find | None
    cpu: float
    memory: int
    new: tuple[str, ...]


class TooLongError(BaseException):
    """The processor time of a case is used up; no handler of errors catches it."""


def outcome(args: list[str], outside: Path, *, limited: bool = True) -> Outcome:
    """Run the command line in this process and this folder, which lies below `outside`, and tell what it did."""
    before, held, began = files_below(outside), _memory(reset=True), _cpu()
    code, raised = None, None
    with _captured() as (out, err), _alarm() if limited else contextlib.nullcontext():
        try:
            main(args)
        except SystemExit as ended:
            code = ended.code if isinstance(ended.code, int) else 0 if ended.code is None else 1
        except TooLongError as error:
            raised = _found("slow", f"more than {CPU_LIMIT:g} s of processor time", error.__traceback__)
        except BaseException as error:
            raised = _found("traceback", f"{type(error).__name__}: {str(error)[:200]}", error.__traceback__)
    new = tuple(sorted(files_below(outside) - before))
    return Outcome(code, out.text(), err.text(), raised, _cpu() - began, _memory() - held, new)


def judged(
    found: Outcome, args: tuple[str, ...], names: tuple[str, ...], outputs: tuple[str, ...], given: int
) -> Find | None:
    """Return what is wrong with an outcome of the command line `args`, or None.

    names : what a sentence must name one of. outputs : beginnings of paths that may be new. given : bytes of the file.
    """
    if found.raised is not None:
        return found.raised
    said, typed = found.out + found.err, "".join(args)
    strange_characters = [c for c in CONTROL.findall(said) if c not in typed]  # a path typed so is printed so
    sentences = [line for line in found.err.splitlines() if line.startswith(("workbench: ", "Error: "))]
    last = sentences[-1] if sentences else ""
    strange = [path for path in found.new if path.endswith(".part") or not path.startswith(outputs)]
    checks = (
        (found.code not in CODES, "exit code", f"ended with {found.code}"),
        ("Traceback (most" in found.err, "traceback", found.err[-300:]),
        (bool(strange_characters), "control characters", repr(strange_characters[:5])),
        (bool(REPEATED.search(said)), "long value", f"{said[:200]!r}"),
        (found.memory > MEMORY_LIMIT + 20 * given, "memory", f"{found.memory >> 20} MB for {given} bytes"),
        (found.cpu > CPU_LIMIT, "slow", f"{found.cpu:.1f} s of processor time"),
        (bool(strange), "left behind", ", ".join(strange)),
        (found.code == 2 and not sentences, "no sentence", found.err[-300:]),
        (found.code == 2 and len(last) > LONGEST_SENTENCE, "long sentence", last[:300]),
        (found.code == 2 and found.err.rstrip("\n").split("\n")[-1] != last, "several lines", found.err[-300:]),
        (found.code == 2 and not any(name in last for name in names), "names nothing", last[:300]),
        (found.code == 2 and bool(found.new), "half-written", ", ".join(found.new)),
    )
    return next((Find(kind, sentence) for wrong, kind, sentence in checks if wrong), None)


def files_below(folder: Path) -> frozenset[str]:
    """Return every file below `folder`, relative to where we are; an empty folder is no harm."""
    found = set()
    for root, _, names in os.walk(folder):
        for name in names:
            found.add(os.path.relpath(os.path.join(root, name)))
    return frozenset(found)


def innermost(trace: TracebackType | None) -> str:
    """Return the innermost line of our own code, without the fuzzer's, as ``file:line``."""
    ours = [frame for frame in traceback.extract_tb(trace) if frame.filename.startswith(ROOT + os.sep)]
    ours = [frame for frame in ours if f"{os.sep}tests{os.sep}" not in frame.filename]
    return f"{os.path.relpath(ours[-1].filename, ROOT)}:{ours[-1].lineno}" if ours else ""


def _found(kind: str, sentence: str, trace: TracebackType | None) -> Find:
    lines = traceback.format_tb(trace)
    return Find(kind, sentence, innermost(trace), "".join(lines[-30:]))


class _Written:
    """A stream as a terminal's is: UTF-8, strict or with escapes, and what was written to it."""

    def __init__(self, errors: str) -> None:
        self.bytes = io.BytesIO()
        self.stream = io.TextIOWrapper(self.bytes, encoding="utf-8", errors=errors, write_through=True)

    def text(self) -> str:
        return self.bytes.getvalue().decode("utf-8", errors="replace")


@contextlib.contextmanager
def _captured() -> Iterator[tuple[_Written, _Written]]:
    out, err = _Written("strict"), _Written("backslashreplace")
    with contextlib.redirect_stdout(out.stream), contextlib.redirect_stderr(err.stream):
        yield out, err


@contextlib.contextmanager
def _alarm() -> Iterator[None]:
    """Raise TooLongError once a case has used its processor time."""

    def ring(number: int, frame: object) -> None:
        raise TooLongError

    signal.signal(signal.SIGPROF, ring)
    signal.setitimer(signal.ITIMER_PROF, CPU_LIMIT + 1)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


def _cpu() -> float:
    both = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in both)


def _memory(reset: bool = False) -> int:
    """Return the most memory held so far [bytes], or with `reset` what is held now, and count anew from there."""
    if sys.platform != "linux":
        return 0
    if reset:
        with contextlib.suppress(OSError):
            Path("/proc/self/clear_refs").write_text("5")
    text = Path("/proc/self/status").read_text()
    found = re.search(r"VmHWM:\s+(\d+)", text)
    return int(found[1]) * 1024 if found else 0
