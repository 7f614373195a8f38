"""Run the blocks of docs/gallery.md and keep their figures: `python -m tests.gallery` after a figure has changed."""

from __future__ import annotations

import os
import re
import shlex
import shutil
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from workbench.cli import main

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "gallery.md"
PICTURES = ROOT / "docs" / "pictures"
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.M | re.S)
PICTURE = re.compile(r"\(pictures/([\w-]+\.svg)\)")


def blocks() -> list[tuple[str, str, list[str]]]:
    """Return kind and text of each block of the gallery, and the figures between it and the next."""
    parts = BLOCK.split(PAGE.read_text(encoding="utf-8"))[1:]
    return [(parts[i], parts[i + 1], PICTURE.findall(parts[i + 2])) for i in range(0, len(parts), 3)]


def run(kind: str, text: str) -> None:
    """Run one block in the folder stood in; AssertionError where a command ends with a problem."""
    if kind == "python":
        exec(compile(text, str(PAGE), "exec"), {"__name__": "__main__"})
        return
    for line in text.splitlines():
        program, *words = shlex.split(line, comments=True)
        assert program == "workbench", line
        assert _code(words) in (0, None), line


def _code(words: list[str]) -> Any:
    """Return the exit code of a command."""
    try:
        main(words)
    except SystemExit as ended:
        return ended.code


def made(name: str) -> Path | None:
    """Return the figure `name` made in the folder stood in: there, or in the report of a mission."""
    return next((path for path in (Path(name), *Path().glob(f"*/8-report/{name}")) if path.is_file()), None)


def keep() -> None:
    """Run every block and keep its figures in docs/pictures."""
    PICTURES.mkdir(exist_ok=True)
    with TemporaryDirectory() as folder:
        os.chdir(folder)
        for kind, text, names in blocks():
            run(kind, text)
            for name in names:
                found = made(name)
                assert found is not None, f"{name} is not made by the block above it"
                shutil.copyfile(found, PICTURES / name)
        os.chdir(ROOT)


if __name__ == "__main__":
    keep()
