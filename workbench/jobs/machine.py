"""The machine and the versions a run was made with, stated once per store."""

from __future__ import annotations

import hashlib
import json
import os
import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import psutil

CGROUPS = Path("/sys/fs/cgroup")
PACKAGES = ("mmmdmtsp-workbench", "numpy", "scipy", "numba", "ortools", "highspy", "pyscipopt", "cvxpy", "casadi")


@cache
def environment() -> dict[str, Any]:
    """Return machine (processor, cores, memory [bytes], system) and versions of what the solvers stand on."""
    return {
        "machine": {
            "processor": _processor(),
            "cores": available_cores(),
            "memory": psutil.virtual_memory().total,
            "system": f"{platform.system()} {platform.release()}",
        },
        "versions": {"python": platform.python_version()} | {name: _version(name) for name in PACKAGES},
    }


def environment_digest(found: dict[str, Any]) -> str:
    """Return the first 12 hexadecimal digits of the SHA-256 of an environment."""
    return hashlib.sha256(json.dumps(found, sort_keys=True).encode()).hexdigest()[:12]


def available_cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def usable_memory() -> int:
    """Return the memory runs may share [bytes]: 80 % of the machine's, or of the control group's where that is less."""
    return int(0.8 * min([psutil.virtual_memory().total, *_group_limits()]))


def _group_limits() -> list[int]:
    """Return the memory limits [bytes] of this process's control group and of those above it, of version 1 and 2."""
    groups = Path("/proc/self/cgroup")
    found = []
    for line in groups.read_text().splitlines() if groups.exists() else ():
        _, controllers, path = line.split(":", 2)
        if controllers and "memory" not in controllers.split(","):
            continue
        root = CGROUPS / "memory" if controllers else CGROUPS
        file = "memory.limit_in_bytes" if controllers else "memory.max"
        own = root / path.lstrip("/")
        for folder in (own, *own.parents):
            if folder.is_relative_to(root) and (folder / file).exists():
                text = (folder / file).read_text().strip()
                found += [int(text)] if text.isdigit() else []  # else "max"
    return found


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text(errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
