"""Solvers that write into the pipe of their messages themselves."""

from __future__ import annotations

from dataclasses import dataclass

from tests.faults.hostile import Honest, honest, say

CLAIM = b'{"kind": "event", "claim": {"product": null, "objective": null, "bound": %s}}'
PRODUCT = b'{"kind": "event", "claim": {"product": %s, "objective": 1.0, "bound": null}}'
RESULT = (
    b'{"kind": "result", "claim": {"product": [[0, 1, 2, 3], []], "objective": 1.0, "bound": 1.0, "status": "OPTIMAL", '
    b'"stopped_by": "proof", "message": "", "tolerance": %s, "statistics": %s}}'
)
LINES = {
    "infinite bound": CLAIM % b"Infinity",
    "NaN bound": CLAIM % b"NaN",
    "bound of 400 digits": CLAIM % (b"9" * 400),
    "bound beyond floats": CLAIM % b"1e999",
    "bound of 5,000 digits": CLAIM % (b"9" * 5000),
    "infinite tolerance": RESULT % (b"Infinity", b"{}"),
    "infinite statistics": RESULT % (b"0", b'{"x": [Infinity]}'),
    "deep statistics": RESULT % (b"0", b'{"x": ' + b"[" * 10_000 + b"]" * 10_000 + b"}"),
    "infinite elapsed": b'{"kind": "event", "elapsed": Infinity, "claim": {"product": null}}',
    "infinite memory": b'{"kind": "error", "message": "x", "peak_memory": Infinity}',
    "infinite task": PRODUCT % b"[[Infinity]]",
    "huge task": PRODUCT % b"[[1e300, 1, 2, 3], []]",
    "task of 400 digits": PRODUCT % (b"[[" + b"9" * 400 + b"], []]"),
    "routes are a table": PRODUCT % b'{"0": [0, 1, 2, 3]}',
    "60,000 brackets": b"[" * 60_000,
    "nested 100,000 deep": b"[" * 100_000 + b"]" * 100_000,
    "product nested 100,000 deep": PRODUCT % (b"[" * 100_000 + b"]" * 100_000),
    "lone surrogate": rb'{"kind": "error", "message": "\ud800"}',
    "no text": b"\xff\xfe\x00\x80",
    "nothing": b"",
    "prepared again": b'{"kind": "prepared"}',
    "started again": b'{"kind": "started", "proves": true}',
    "unknown kind": b'{"kind": "banana"}',
    "no kind": b"{}",
    "claim is a list": b'{"kind": "event", "claim": []}',
    "100 MB": b"x" * 100_000_000,
    "100 MB of a message": PRODUCT % (b"[" + b"[0], " * 20_000_000 + b"[]]"),
}
"""Name → what is written beside honest routes."""


@dataclass(frozen=True)
class Says(Honest):
    """Writes one of LINES, then answers well."""

    line: str = ""

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        found = honest(instance, observe)
        say(LINES[self.line])
        return found


class EventBeforePrepared(Honest):
    def prepare(self, instance):
        say(PRODUCT % b"[[0, 1, 2, 3], []]")


class ResultWhileAsked(Honest):
    """Forges its whole answer before it is asked to solve anything."""

    def accepts(self, instance):
        say(RESULT % (b"0", b"{}"))


class ResultTwice(Honest):
    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        say(RESULT % (b"0", b"{}"))
        return honest(instance, observe)


class PreparesForEver(Honest):
    """Says again and again that it has only now prepared."""

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        while True:
            say(b'{"kind": "prepared"}')
            say(b'{"kind": "prepared", "cpu": 0.0}')
