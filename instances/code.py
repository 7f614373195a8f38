"""The code that makes a number: a digest of the sources, so that a stored number knows whether today's code made it.

It stands in the lowest room because all need it: numba's cache (`instances.kernels`) lives under the digest of the
rooms that hold kernels, every run and every mission stamp names the digest of all four, and reports count stale runs.
"""

from __future__ import annotations

import hashlib
import subprocess
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]
"""Where the four packages lie side by side: a checkout, or the folder they are installed into."""
PACKAGES = ("formulations", "instances", "reports", "workbench")
KERNEL_PACKAGES = ("formulations", "instances")
"""Where numba kernels and everything they import are: nothing in these imports from the other two."""


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
def revision() -> str:
    """Return the revision of the checkout the sources lie in, with ``-dirty`` where they differ; "" where in none."""
    if not (ROOT / ".git").exists():
        return ""
    asked = ["git", "-C", str(ROOT), "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]
    try:
        return subprocess.run(asked, capture_output=True, text=True, timeout=10, check=True).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return ""
