"""Sources: where the instances of a study come from, before they are made: a file, or a family with its parameters."""

from __future__ import annotations

import glob
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from instances import InputError, Instance
from instances.files import FORMATS, read_instance
from instances.natural import natural

ENDINGS = (".json", ".json.gz", ".mdm", ".mtsp", ".tsp", ".atsp", ".vrp")
"""Endings by which instance files are found in a folder."""
PATHS = ".paths.json.gz"
"""Ending of the paths that are kept beside an instance; `instances.paths`, which has it too, takes long to import."""


@dataclass(frozen=True)
class FileSource:
    """An instance file."""

    path: Path

    @property
    def plugin(self) -> str:
        """The ending, where no built-in format reads it, else ""."""
        return "" if self.path.name.lower().endswith(tuple(FORMATS.built_in)) else self.path.suffix

    @property
    def has_paths(self) -> bool:
        """Whether the paths behind its costs lie beside it."""
        stem = self.path.name.removesuffix(".gz").removesuffix(".json").removesuffix(".atsp")
        return self.path.with_name(stem + PATHS).is_file()

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

    @property
    def plugin(self) -> str:
        """The family, where it is not built in, else ""."""
        return plugin_family(self.family)

    def load(self) -> Instance:
        """Generate the instance."""
        from formulations.moving_cost.families import costed, generate  # here: every run imports this file

        made = (self.family, self.n_tasks, self.n_depots, self.seed)
        if self.plugin:
            from workbench.making import make_elsewhere

            return costed(*make_elsewhere(*made, self.parameters))[0]
        return generate(*made, **self.parameters)


def plugin_family(name: str) -> str:
    """Return `name` where it is no built-in family, else "": what `Study.plugins` asks of a source."""
    from instances.families import FAMILIES  # here: as above

    return "" if name in FAMILIES.built_in else name


def instance_files(given: Path) -> list[Path]:
    """Return the instance files meant by a file, a folder (searched through) or a pattern; InputError if none.

    Paths behind costs are left out, and in a search through a folder JSON files without the field n_tasks at their
    head, as others keep beside instances.
    """
    try:
        found = _found(given)
    except (OSError, ValueError) as error:  # no file can have this name: too long, a zero byte
        raise InputError(f"{given}: cannot be looked for ({getattr(error, 'strerror', None) or error})") from None
    if not found:
        raise InputError(f"{given}: there is no instance file ({', '.join(ENDINGS)})")
    return found


def _found(given: Path) -> list[Path]:
    if given.is_dir():
        found = (path for path in given.rglob("*") if path.name.endswith(ENDINGS) and _may_be_instance(path))
        return sorted(found, key=natural)
    if any(sign in str(given) for sign in "*?["):
        named = (Path(path) for path in glob.glob(str(given), recursive=True))
        return sorted((path for path in named if not path.name.endswith(PATHS)), key=natural)
    return [given] if given.is_file() else []


def _may_be_instance(path: Path) -> bool:
    if path.name.endswith(PATHS):
        return False
    if path.suffix != ".json" or not path.is_file():  # a pipe would be waited for
        return path.is_file()
    try:
        with path.open("rb") as file:
            return b'"n_tasks"' in file.read(4096)
    except OSError:
        return False
