"""Sources: where the instances of a study come from, before they are made: a file, or a family with its parameters."""

from __future__ import annotations

import glob
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from formulations.moving_cost.families import generate
from instances import InputError, Instance
from instances.files import read_instance

ENDINGS = (".json", ".json.gz", ".mdm", ".mtsp", ".tsp", ".atsp", ".vrp")
"""Endings by which instance files are found in a folder."""


@dataclass(frozen=True)
class FileSource:
    """An instance file."""

    path: Path

    def load(self) -> Instance:
        """Read the file."""
        return read_instance(self.path)


@dataclass(frozen=True)
class FamilySource:
    """One instance of a generator family."""

    family: str
    n_tasks: int
    n_depots: int
    seed: int
    parameters: dict[str, Any] = field(default_factory=dict)

    def load(self) -> Instance:
        """Generate the instance."""
        return generate(self.family, self.n_tasks, self.n_depots, self.seed, **self.parameters)


def instance_files(given: Path) -> list[Path]:
    """Return the instance files meant by a file, a folder (searched through) or a pattern; InputError if none.

    JSON files without the field n_tasks at their head, as others keep beside instances, are left out of a search.
    """
    if given.is_dir():
        found = sorted(path for path in given.rglob("*") if path.name.endswith(ENDINGS) and _may_be_instance(path))
    elif any(sign in str(given) for sign in "*?["):
        found = sorted(Path(path) for path in glob.glob(str(given), recursive=True))
    else:
        found = [given] if given.is_file() else []
    if not found:
        raise InputError(f"{given}: there is no instance file ({', '.join(ENDINGS)})")
    return found


def _may_be_instance(path: Path) -> bool:
    if path.suffix != ".json":
        return path.is_file()
    try:
        with path.open("rb") as file:
            return b'"n_tasks"' in file.read(4096)
    except OSError:
        return False
