"""Claims: who is at work on a file, so that several processes on one store run each job once.

A claim is a hidden file beside the file it is about, made by exclusive creation (O_EXCL), which says who made it. It is
removed when the work is stored. The claim of a process that has ended is stale, and is taken over: at once where the
process was on this machine, after SILENT seconds without a sign of life where it was on another. Clocks are never
compared: a sign of life is that the file's time changes at all while we watch.
"""

from __future__ import annotations

import contextlib
import os
import platform
import secrets
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from types import TracebackType

import msgspec
import psutil

from instances.declared.prepared import prepared
from instances.errors import InputError

BEAT = 20.0
"""Seconds between two signs of life of a claim's holder."""
SILENT = 120.0
"""Seconds without one, after which a holder that cannot be looked at (it is on another machine) is taken for ended."""
MOMENT = 0.02
"""Seconds between two tries for a claim that is held only for a moment."""
ENDING = ".claim"
LONGEST = 4096
"""Bytes read of a claim."""


@dataclass(frozen=True)
class Holder:
    """Who made a claim: the machine, its boot, the process and when in that boot it began; `token` is the claim's own.

    created : for people, ISO time, UTC.
    """

    machine: str
    boot: str
    pid: int
    began: str
    created: str
    token: str

    @classmethod
    def this_process(cls) -> Holder:
        """Return a new claim of this process."""
        now = datetime.now(UTC).isoformat(timespec="seconds")
        return cls(*_here(), os.getpid(), _began(os.getpid()) or "", now, secrets.token_hex(8))

    def ended(self) -> bool | None:
        """Return whether the process has ended; None where that cannot be seen from here."""
        machine, boot = _here()
        if self.machine != machine:
            return None
        try:
            os.kill(self.pid, 0)
        except PermissionError:  # another user's, whose processes may be hidden from us
            return None
        except (ProcessLookupError, OverflowError):
            return True
        return self.boot != boot or _began(self.pid) != self.began


class Claims:
    """What this process has claimed; a context manager that shows signs of life and lets go of everything at its end.

    A claim that cannot be made (its folder is gone, nothing can be written there) counts as taken: whoever does the
    work learns that when storing it, and what cannot be shared needs no claim.
    """

    def __init__(self) -> None:
        self._held: dict[Path, bytes] = {}
        self._watched: dict[Path, tuple[tuple[bytes, int], float]] = {}
        self._over = threading.Event()

    def __enter__(self) -> Claims:
        threading.Thread(target=self._beat, name="claims", daemon=True).start()
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self._over.set()
        for claim in list(self._held):
            self._drop(claim)

    def take(self, path: Path) -> bool:
        """Claim the file at `path` and return True; False where another process holds it."""
        return self._take(_claim_of(path))

    def release(self, path: Path) -> None:
        """Let go of the file at `path`."""
        self._drop(_claim_of(path))

    def held(self, folder: Path) -> list[str]:
        """Return the names of the files in `folder` that a process is at work on, as far as can be seen from here."""
        try:
            names = [name for name in os.listdir(folder) if name.startswith(".") and name.endswith(ENDING)]
        except (OSError, ValueError):
            return []
        found = {name[1 : -len(ENDING)]: _read(folder / name) for name in sorted(names)}
        return [
            name
            for name, claim in found.items()
            if claim is not None and not self._stale(_claim_of(folder / name), *claim)
        ]

    @contextlib.contextmanager
    def holding(self, path: Path) -> Iterator[None]:
        """Hold the file at `path` for a moment, once nobody else does; InputError where that takes too long."""
        until = time.monotonic() + 1.25 * SILENT
        while not self.take(path):
            if time.monotonic() > until:
                raise InputError(f"{path}: another process has been writing it for {1.25 * SILENT:.0f} s")
            time.sleep(MOMENT)
        try:
            yield
        finally:
            self.release(path)

    def _take(self, claim: Path) -> bool:
        content = msgspec.json.encode(Holder.this_process())
        try:
            _create(claim, content)
        except FileExistsError:
            return self._take_over(claim, content)
        except OSError:
            return True
        self._held[claim] = content
        return True

    def _take_over(self, claim: Path, content: bytes) -> bool:
        """Replace a stale claim. Of several that find it stale one does: it needs a claim on the claim for it."""
        found = _read(claim)
        if found is None or not self._stale(claim, *found):
            return False
        turn = claim.with_name(f"{claim.name}+")
        if not self._take(turn):
            return False
        try:
            now = _read(claim)
            if now is None or now[0] != found[0]:
                return False
            aside = claim.with_name(f"{claim.name}.{secrets.token_hex(4)}")
            _create(aside, content)
            aside.replace(claim)
        except OSError:
            return True
        finally:
            self._drop(turn)
        self._held[claim] = content
        return True

    def _stale(self, claim: Path, content: bytes, changed: int) -> bool:
        holder = _holder(content)
        ended = None if holder is None else holder.ended()
        if ended is not None:
            return ended
        seen, now = (content, changed), time.monotonic()
        if self._watched.get(claim, (None,))[0] != seen:
            self._watched[claim] = seen, now
        return now - self._watched[claim][1] > SILENT

    def _drop(self, claim: Path) -> None:
        content = self._held.pop(claim, None)
        found = _read(claim) if content else None
        if found is not None and found[0] == content:  # not another's, who took ours for stale
            with contextlib.suppress(OSError):
                claim.unlink()

    def _beat(self) -> None:
        while not self._over.wait(BEAT):
            for claim in list(self._held):
                with contextlib.suppress(OSError):
                    os.utime(claim)


def _claim_of(path: Path) -> Path:
    return path.with_name(f".{path.name}{ENDING}")


def _create(path: Path, content: bytes) -> None:
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644)
    try:
        os.write(descriptor, content)
    except OSError:  # the disk is full: an empty claim would keep others waiting
        path.unlink(missing_ok=True)
        raise
    finally:
        os.close(descriptor)


def _read(claim: Path) -> tuple[bytes, int] | None:
    """Return content (empty where it cannot be read) and time of last change [ns] of a claim; None where there is none.

    It is opened, because a network file system then looks again; without waiting, should it be no regular file.
    """
    try:
        with open(claim, "rb", 0, opener=lambda path, flags: os.open(path, flags | os.O_NONBLOCK)) as file:
            return file.read(LONGEST) or b"", os.fstat(file.fileno()).st_mtime_ns
    except FileNotFoundError:
        return None
    except OSError:
        return b"", 0


def _holder(content: bytes) -> Holder | None:
    """Return who made a claim; None where it is not (yet) whole."""
    try:
        return msgspec.json.decode(content, type=prepared(Holder))
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError):
        return None


@cache
def _here() -> tuple[str, str]:
    """Return the machine as seen by its processes (name, identity, process namespace), and its boot."""

    def said(file: str) -> str:
        with contextlib.suppress(OSError):
            return Path(file).read_text(errors="replace").strip()
        return ""

    namespace = ""
    with contextlib.suppress(OSError):
        namespace = os.readlink("/proc/self/ns/pid")
    boot = said("/proc/sys/kernel/random/boot_id") or f"{psutil.boot_time():.0f}"
    return f"{platform.node()} {said('/etc/machine-id')} {namespace}", boot


def _began(pid: int) -> str | None:
    """Return when the process began, in a clock that nobody sets where there is one; None where it has ended."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_bytes()
        state, *fields = stat[stat.rindex(b")") + 2 :].split()
        return None if state in b"ZX" else fields[18].decode()
    except (OSError, ValueError):
        if Path("/proc/self/stat").exists():
            return None
    try:
        process = psutil.Process(pid)
        return None if process.status() == psutil.STATUS_ZOMBIE else f"{process.create_time():.0f}"
    except psutil.Error:
        return None
