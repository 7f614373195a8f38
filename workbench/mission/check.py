"""`workbench check` of a mission's folder: are its products as they were written, and do its routes cost what they say?

Of every stage there is: each product against its digest in the stamp, and what it was made from against the products
that are there now. Of the routes: whether the UAVs can fly them, their longest tour computed again, and that no bound
is above it; where headings were planned with the routes (`workbench.mission.coupled`) tours cost more than legs, and
only the former is asked. Paths are checked by giving their file.
"""

from __future__ import annotations

from pathlib import Path

from instances import check_routes, makespan
from instances.disk import read_json
from instances.errors import InputError, naming
from reports.tolerances import RELATIVE_ROUNDING
from workbench.mission.costs import kept_costs
from workbench.mission.pipeline import FOLDERS
from workbench.mission.routes import SELECTION_FILE, kept_routes
from workbench.mission.stamp import FILE, Stamp, products_of, read_stamp
from workbench.problems.routing import refute_cost


def is_mission(folder: Path) -> bool:
    """Say whether `folder` holds a stage of a mission."""
    return any((folder / name / FILE).is_file() for name in FOLDERS.values())


def check_products(folder: Path) -> tuple[str, list[str]]:
    """Return in words what was looked at in a mission's folder, and what is wrong there, a sentence each."""
    there = {name: folder / kept for name, kept in FOLDERS.items() if (folder / kept).is_dir()}
    stamps = {name: stamp for name, kept in there.items() if (stamp := read_stamp(kept)) is not None}
    problems = [f"{kept / FILE}: is missing or cannot be read" for name, kept in there.items() if name not in stamps]
    for name, stamp in stamps.items():
        problems += _changed(there[name], stamp, stamps)
    count = sum(len(stamp.products) for stamp in stamps.values())
    words = f"{count} products of {len(stamps)} of the {len(FOLDERS)} stages of a mission"
    if not {"costs", "routes"} <= stamps.keys() or problems:
        return words, problems
    said, wrong = _routes(there["costs"], there["routes"])
    return f"{words}, {said}", wrong


def _changed(folder: Path, stamp: Stamp, stamps: dict[str, Stamp]) -> list[str]:
    """Return which products of a stage are not as it wrote them, and what it was made from that is not there now."""
    now = products_of(folder)
    faults = [
        f"{folder / name}: {'was changed' if name in now else 'is missing'} since stage '{stamp.stage}' wrote it"
        for name, digest in stamp.products.items()
        if now.get(name) != digest
    ]
    older = [name for name, digest in stamp.inputs.items() if name in stamps and stamps[name].digest != digest]
    return faults + [f"{folder}: was made from other products of stage '{name}' than those there" for name in older]


def _routes(costs: Path, folder: Path) -> tuple[str, list[str]]:
    """Return in words what the routes are, and what is wrong with them and their bound."""
    from workbench.mission.coupled import HEADINGS_FILE  # here: it takes its time

    instance, _ = kept_costs(costs)
    routes, chosen = kept_routes(folder, instance), (folder / SELECTION_FILE).exists()
    faults = check_routes(instance, routes, all_tasks=not chosen)
    said = f"routes of {sum(map(len, routes))} tasks"
    if faults or (folder / HEADINGS_FILE).exists():
        return said, [f"{folder}: {fault}" for fault in faults]
    actual, bound_file = makespan(instance, routes), folder / "bound.json"
    with naming(bound_file):
        claimed = read_json(bound_file)
        if not isinstance(claimed, dict) or not {"objective", "bound"} <= claimed.keys():
            raise InputError("must hold objective and bound")
        wrong = refute_cost(claimed["objective"], actual)
        if not wrong and not claimed["bound"] <= actual * (1 + RELATIVE_ROUNDING):
            wrong = f"claims that no tours are below {claimed['bound']!r} s, but {actual!r} s are flown"
    return f"{said}, longest tour {actual!r} s", [f"{bound_file}: {wrong}"] if wrong else []
