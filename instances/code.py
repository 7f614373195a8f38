"""The code that makes a number: a digest of the sources, so that a stored number knows whether today's code made it.

It stands in the lowest room because all need it: numba's cache (`instances.kernels`) lives under the digest of what a
kernel's module can see, every run and every mission stamp names the digest of all four rooms, and reports count stale
runs.
"""

from __future__ import annotations

import hashlib
import re
import subprocess
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]
"""Where the four packages lie side by side: a checkout, or the folder they are installed into."""
PACKAGES = ("formulations", "instances", "reports", "workbench")
KERNEL_PACKAGES = ("formulations", "instances")
"""Where numba kernels and everything they import are: nothing in these imports from the other two."""
_IMPORT = re.compile(
    r"^[ \t]*(?:from[ \t]+([\w.]+)[ \t]+import[ \t]+(\([^)]*\)|[^\n#]*)|import[ \t]+([\w., \t]+))", re.M
)


@cache
def code_digest(packages: tuple[str, ...] = PACKAGES) -> str:
    """Return the first 12 hexadecimal digits of the SHA-256 of the Python sources of `packages`, names included."""
    found = hashlib.sha256()
    for package in packages:
        for path in sorted((ROOT / package).rglob("*.py")):
            content = path.read_bytes()
            found.update(f"{path.relative_to(ROOT).as_posix()} {len(content)}\n".encode() + content)
    return found.hexdigest()[:12]


@cache
def closure_digest(source: Path) -> str:
    """Return 12 hexadecimal digits of the SHA-256 of `source`, relative to `ROOT`, and its `closure`."""
    parts = [f"{path} {_digest(path)}" for path in sorted(closure(source.as_posix()))]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:12]


def closure(source: str) -> set[str]:
    """Return `source`, relative to `ROOT`, and the sources of ours that it imports, directly or not.

    Imports are read off the text, those inside functions and those of other imports' packages included: a source too
    many costs a compilation, one too few would keep machine code that is wrong.
    """
    seen, waiting = {source}, [source]
    while waiting:
        new = _imported(waiting.pop()) - seen
        seen |= new
        waiting += new
    return seen


@cache
def _digest(source: str) -> str:
    return hashlib.sha256((ROOT / source).read_bytes()).hexdigest()


@cache
def _sources() -> frozenset[str]:
    """Return the sources that kernels may see, relative to `ROOT`: looking them up in a set is quicker than on disk."""
    found = (path for package in KERNEL_PACKAGES for path in (ROOT / package).rglob("*.py"))
    return frozenset(path.relative_to(ROOT).as_posix() for path in found)


@cache
def _imported(source: str) -> frozenset[str]:
    """Return the sources of ours that the text of `source` imports, with the ``__init__`` of each package passed."""
    modules = set()
    for package, names, plain in _IMPORT.findall((ROOT / source).read_text(encoding="utf-8")):
        modules |= {package, *(f"{package}.{name}" for name in re.findall(r"\w+", names))} if package else set()
        modules |= set(re.findall(r"[\w.]+", plain))
    found: set[str] = set()
    for module in modules:
        parts = module.split(".")
        for end in range(1, len(parts) + 1) if parts[0] in KERNEL_PACKAGES else ():
            stem = "/".join(parts[:end])
            found |= {f"{stem}.py", f"{stem}/__init__.py"}
    return frozenset(found & _sources())


@cache
def revision() -> str:
    """Return the revision of the checkout the sources lie in, with ``-dirty`` where they differ; "" where in none."""
    if not (ROOT / ".git").exists():
        return ""
    asked = ["git", "-C", str(ROOT), "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]
    try:
        return subprocess.run(asked, capture_output=True, text=True, timeout=10, check=True).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return ""
