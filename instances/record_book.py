"""Record book: the best values known of instances and the routes that show them, in which no value ever gets worse.

A book is a folder with `best_known.csv` and `tours.json`, in the form of those that come along (best_known.py). Routes
are offered with their instance and costed here; what is no shorter than the value in the book by more than its rounding
changes nothing. A bound above a value is a contradiction and changes nothing either.
"""

from __future__ import annotations

import csv
import io
import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from instances.best_known import BestKnown, entry
from instances.disk import read_json, read_text, write_aside
from instances.errors import InputError
from instances.instance import Instance
from instances.routes import Routes, check_routes, makespan

TABLE, TOURS = "best_known.csv", "tours.json"
SHIPPED = Path(__file__).parent / "data"
"""The book that comes along; `workbench bound` and the pages of studies know its values."""
COLUMNS = tuple(BestKnown.__dataclass_fields__)
PROVED = 1e-6
"""Value and bound that differ by no more than this share meet."""


@dataclass
class RecordBook:
    """entries: what is known, by digest; tours: name → digest, value and routes, of values that were found here."""

    entries: dict[str, BestKnown]
    tours: dict[str, dict[str, Any]]

    def offer(self, instance: Instance, routes: Routes, source: str, *, add: bool = False) -> str:
        """Take `routes` where they beat the book; return what changed, empty where nothing did.

        add: also where the book does not have the instance. InputError where they are no routes of it, or beat the
        bound in the book.
        """
        if faults := check_routes(instance, routes):
            raise InputError(f"{instance.name}: {faults[0]}")
        value, known = makespan(instance, routes), self.entries.get(instance.digest)
        if known is None and not add:
            return ""
        if known is None:
            size = instance.n_tasks, instance.n_depots
            now = BestKnown(self._free(instance), instance.digest, *size, value, False, None, source)
            said = f"{now.instance}: new, {value!r} s"
        elif value >= known.best_known - known.rounding:
            return ""
        else:
            now = replace(known, best_known=value, source=source)
            said = f"{now.instance}: {value!r} s, was {known.best_known!r} s"
        self._enter(now)
        self.tours[now.instance] = {"digest": now.digest, "value": value, "routes": [list(route) for route in routes]}
        return said

    def raise_bound(self, digest: str, bound: float) -> str:
        """Take a proved `bound` [s] above the book's; return what changed, empty where nothing did.

        Raises InputError where it is above the value.
        """
        known = self.entries.get(digest)
        if known is None or (known.bound is not None and bound <= known.bound * (1 + PROVED)):
            return ""
        was = "none" if known.bound is None else f"{known.bound!r} s"
        self._enter(replace(known, bound=bound))
        proved = ", which proves the value" if self.entries[digest].proven else ""
        return f"{known.instance}: bound {bound!r} s, was {was}{proved}"

    def _enter(self, known: BestKnown) -> None:
        """Enter what is known, and whether value and bound meet; InputError where the bound is above the value."""
        value, bound = known.best_known, known.bound
        if bound is not None and bound > value + known.rounding:
            raise InputError(f"{known.instance}: a bound of {bound!r} s contradicts routes of {value!r} s")
        met = bound is not None and bound >= value * (1 - PROVED)
        self.entries[known.digest] = replace(known, proven=met)

    def _free(self, instance: Instance) -> str:
        """Return a name that no other instance of the book has."""
        taken = {known.instance for known in self.entries.values()}
        return f"{instance.name}-{instance.digest}" if instance.name in taken else instance.name

    def write(self, folder: Path) -> None:
        """Write the book to `folder`, each file aside and renamed."""
        text = io.StringIO()
        writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(_row(known) for known in self.entries.values())
        tours = ",\n".join(f"{json.dumps(name)}: {json.dumps(about)}" for name, about in self.tours.items())
        write_aside(folder / TOURS, f"{{{tours}}}\n")  # first: a value without its routes would be a claim
        write_aside(folder / TABLE, text.getvalue())


def read_book(folder: Path) -> RecordBook:
    """Return the book in `folder`, an empty one where it holds none; InputError names file, line and what is wrong."""
    entries: dict[str, BestKnown] = {}
    tours: dict[str, dict[str, Any]] = {}
    if (folder / TABLE).exists():
        rows = csv.DictReader(read_text(folder / TABLE).splitlines())
        if tuple(rows.fieldnames or ()) != COLUMNS:
            raise InputError(f"{folder / TABLE}: line 1 must name the columns {', '.join(COLUMNS)}")
        for row in rows:
            line = f"{folder / TABLE}: line {rows.line_num}"
            try:
                known = entry(row)
            except (TypeError, ValueError, AttributeError):
                raise InputError(f"{line} is no entry: {list(row.values())!r}") from None
            if known.digest in entries:
                raise InputError(f"{line} has the digest of {entries[known.digest].instance}")
            if known.bound is not None and known.bound > known.best_known + known.rounding:
                raise InputError(f"{line} has a bound above its value: {known.bound!r}")
            entries[known.digest] = known
    if (folder / TOURS).exists():
        tours = read_json(folder / TOURS)
        if not isinstance(tours, dict):
            raise InputError(f"{folder / TOURS}: must be an object, name → digest, value and routes")
    return RecordBook(entries, tours)


def _row(known: BestKnown) -> dict[str, object]:
    shown = {"proven": "true" if known.proven else "false", "bound": "" if known.bound is None else known.bound}
    return {**asdict(known), **shown}
