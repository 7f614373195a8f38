"""Sessions at a terminal of 80 columns: what is typed and what is seen, for every command.

``sessions/*.txt`` hold them as they were recorded. They are typed again here; numbers, which times among them are, and
where lines are wrapped may differ; words, heads and the columns that are left out may not.
``python -m tests.workbench.test_sessions --record`` writes them anew, from the lines that begin with "$ ".
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import sys
import tempfile
from pathlib import Path

import pytest

from workbench.cli import COMMANDS, main

SESSIONS = sorted((Path(__file__).parent / "sessions").glob("*.txt"))
WIDTH = 80
PROMPT = "$ "
_ANY = (
    (re.compile(r"^compiling kernels, once\n", re.MULTILINE), ""),  # where they are not kept yet
    (re.compile(r"^ *\d+\.\d\d s  .*\n", re.MULTILINE), ""),  # progress of a solver: as many lines as it has time for
    (re.compile(r"\b[0-9a-f]{12}\b"), "0"),  # digests
    (re.compile(r"[<>] (?=\d)"), ""),  # as in < 0.001
    (re.compile(r"\d+(?:[.,]\d+)*(?:e-\d+)?"), "0"),
    (re.compile(r"─+"), "─"),
    (re.compile(r"\s+"), " "),
)


def typed(line: str) -> str:
    """Return everything that `workbench …` prints, on stdout and stderr."""
    told = io.StringIO()
    with contextlib.redirect_stdout(told), contextlib.redirect_stderr(told), contextlib.suppress(SystemExit):
        main(shlex.split(line)[1:])
    return told.getvalue()


def parts(session: str) -> list[tuple[str, str]]:
    """Return the lines typed in a session, each with what is seen after it."""
    found = [part.partition("\n") for part in session.split(f"\n{PROMPT}")]
    return [(line.removeprefix(PROMPT), seen) for line, _, seen in found]


def alike(text: str) -> str:
    """Return what must be the same each time."""
    for pattern, word in _ANY:
        text = pattern.sub(word, text)
    return text.strip()


@pytest.mark.parametrize("session", SESSIONS, ids=lambda path: path.stem)
def test_a_session_looks_as_it_was_recorded(session, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", str(WIDTH))
    for line, recorded in parts(session.read_text(encoding="utf-8")):
        seen = typed(line)
        assert alike(seen) == alike(recorded), line
        assert max(map(len, [line, *seen.splitlines()])) <= WIDTH, line
        assert "…" not in seen, line


def test_every_command_is_in_a_session():
    lines = [line for session in SESSIONS for line, _ in parts(session.read_text(encoding="utf-8"))]
    assert {line.split()[1] for line in lines} >= set(COMMANDS)


def record(session: Path) -> None:
    """Type the lines of a session again in an empty folder, and keep what is seen now."""
    lines = [line for line, _ in parts(session.read_text(encoding="utf-8"))]
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        os.environ["COLUMNS"] = str(WIDTH)
        seen = [f"{PROMPT}{line}\n{typed(line)}" for line in lines]
    text = "\n".join(line.rstrip() for line in "".join(seen).splitlines())
    session.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__" and "--record" in sys.argv:
    for each in SESSIONS:
        record(each)
