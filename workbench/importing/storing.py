"""Storing: foreign runs go into a store all together or not at all."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

from instances import InputError, Instance
from instances.errors import shown, suggestion
from instances.files import endings, read_instance
from reports.record import ITEM_FILES, Run
from workbench.importing.judging import foreign_run, machine_of
from workbench.importing.rows import Row
from workbench.jobs.job import Job, file_safe, folder_of
from workbench.jobs.store import Store
from workbench.problems.routing import ROUTING


class Known:
    """The instances that rows may name: those of the store, and files."""

    def __init__(self, store: Store, base: Path) -> None:
        self._root, self._base = store.root, base
        kept = sorted(store.root.iterdir()) if store.root.is_dir() else []
        names = ITEM_FILES[ROUTING.name]
        self._folders = [folder.name for folder in kept if any((folder / name).is_file() for name in names)]
        self._read = lru_cache(maxsize=64)(self._find)

    def instance(self, row: Row) -> tuple[str, Instance]:
        """Return folder and instance that `row` is about; InputError where it names none, or several."""
        try:
            return self._read(row.instance)
        except InputError as error:
            raise InputError(f"{row.where}: {error}") from None

    def _find(self, named: str) -> tuple[str, Instance]:
        parts = {folder: folder.rpartition("-") for folder in self._folders}
        meant = [f for f, (name, _, digest) in parts.items() if named in (f, digest) or file_safe(named) == name]
        if len(meant) > 1:
            raise InputError(f"instance {shown(named)} is {' or '.join(meant)}: give the digest")
        if meant:
            return meant[0], ROUTING.read(self._root / meant[0])
        if (self._base / named).is_file():
            instance = read_instance(self._base / named)
            same = [folder for folder, (_, _, digest) in parts.items() if digest == instance.digest]
            return (same[0], ROUTING.read(self._root / same[0])) if same else (folder_of(instance), instance)
        kind = "no such file" if named.lower().endswith(endings()) else f"not one of {self._root}, and no file"
        near = suggestion(named, [name for name, _, _ in parts.values()])
        raise InputError(f"instance {shown(named)} is {kind}{near}")


def judged(rows: Sequence[Row], store: Store, base: Path, first_task: int) -> dict[str, tuple[Row, Run, Instance]]:
    """Return the run of each row by its path in `store`; InputError for what cannot be used or is there already."""
    known = Known(store, base)
    found: dict[str, tuple[Row, Run, Instance]] = {}
    for row in rows:
        folder, instance = known.instance(row)
        run = foreign_run(row, instance, base, first_task)
        path = Job(folder, run.solver, {}, run.seed, run.time_limit, 1 if run.threads is None else run.threads).path
        if path in found:
            again = f"solver {run.solver}, seed {run.seed}, limit {run.time_limit:g} s on {run.instance['name']}"
            raise InputError(f"{row.where}: {again} is stated before, in {found[path][0].where}")
        found[path] = row, run, instance
    return found


def put_all(store: Store, found: dict[str, tuple[Row, Run, Instance]]) -> int:
    """Store the runs, in place of those imported before; return how many are replaced.

    Where one cannot be written all is as it was, and an InputError says why.
    """
    made: list[Path] = []
    replaced = sum(store.version(path) is not None for path in found)
    before: dict[Path, bytes | None] = {}
    fresh = not store.root.exists()
    try:
        store.create()
        for path, (row, run, instance) in found.items():
            folder = (store.root / path).parent
            if not folder.exists():
                made.append(folder)
                store.put_item(ROUTING, instance)
            machine = machine_of(row)
            for target in (store.root / path, store.root / "environments" / f"{run.environment}.json"):
                before.setdefault(target, target.read_bytes() if target.is_file() else None)
            store.put_environment(run.environment, machine)
            store.put(path, run)
    except BaseException:
        for target, content in before.items():
            _put_back(target, content)
        for folder in [store.root] if fresh else made:
            shutil.rmtree(folder, ignore_errors=True)
        raise
    return replaced


def _put_back(target: Path, content: bytes | None) -> None:
    if content is None:
        target.unlink(missing_ok=True)
    else:
        target.write_bytes(content)
