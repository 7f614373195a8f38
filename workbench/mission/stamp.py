"""Stamp: what a stage was made from, kept beside its products; a stage whose stamp still holds is not made again.

It holds digests of the stage's settings, of the code that made it, of what it started from and of its products.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from instances.declared.prepared import prepared
from instances.disk import read_bytes, read_json, write_aside
from instances.errors import InputError
from instances.formats.layers import BESIDE, LAYER

FILE = "stamp.json"


@dataclass(frozen=True)
class Stamp:
    """What a stage's folder was made from.

    settings : digest of the stage's settings. inputs : stage → digest of the products it started from.
    code, revision : of the workbench's sources (`instances.code`); "" in stamps of older versions.
    products : file → digest. elapsed [s].
    """

    stage: str
    settings: str
    inputs: dict[str, str]
    code: str = ""
    revision: str = ""
    products: dict[str, str] = field(default_factory=dict)
    elapsed: float = 0.0

    def made_like(self, wanted: Stamp) -> bool:
        """Return whether settings, inputs and code are those of `wanted`."""
        return (self.settings, self.inputs, self.code) == (wanted.settings, wanted.inputs, wanted.code)

    @property
    def digest(self) -> str:
        """Digest of the products."""
        return digest_of(self.products)

    def write(self, folder: Path) -> None:
        """Write the stamp into `folder`."""
        write_aside(folder / FILE, json.dumps(asdict(self), indent=1))


def read_stamp(folder: Path) -> Stamp | None:
    """Return the stamp in `folder`, or None where there is none that can be read."""
    try:
        return msgspec.convert(read_json(folder / FILE), prepared(Stamp))
    except (InputError, msgspec.ValidationError):
        return None


def intact(stamp: Stamp, folder: Path) -> bool:
    """Return whether the products in `folder` are those the stamp names."""
    try:
        return all(file_digest(folder / name) == digest for name, digest in stamp.products.items())
    except InputError:
        return False


def products_of(folder: Path) -> dict[str, str]:
    """Return the digest of every file in `folder`."""
    found = sorted(path for path in folder.rglob("*") if path.is_file() and path.name != FILE)
    return {path.relative_to(folder).as_posix(): file_digest(path) for path in found}


def file_digest(path: Path) -> str:
    """Return the first 16 hexadecimal digits of the SHA-256 of a file."""
    return hashlib.sha256(read_bytes(path)).hexdigest()[:16]


def digest_of(value: Any) -> str:
    """Return a digest of JSON values."""
    return hashlib.sha256(json.dumps(value, sort_keys=True, default=str).encode()).hexdigest()[:16]


def referenced_files(value: Any, folder: Path) -> dict[str, str]:
    """Return the digest of every file that a text in `value` names, relative to `folder`."""
    if isinstance(value, Mapping):
        value = list(value.values())
    if isinstance(value, list):
        return {name: digest for item in value for name, digest in referenced_files(item, folder).items()}
    if not isinstance(value, str) or len(value) > 500 or not value.strip():
        return {}
    path = folder / value.partition(LAYER)[0]
    # a WindNinja speed grid has its directions and projection beside it, a Shapefile what BESIDE says
    beside = [path, *(path.with_name(path.name.replace("_vel.asc", end)) for end in ("_ang.asc", "_vel.prj"))]
    beside += [path.with_suffix(ending) for ending in BESIDE if path.suffix.lower() == ".shp"]
    return {f"{value} {p.name}": file_digest(p) for p in dict.fromkeys(beside) if os.path.isfile(p)}
