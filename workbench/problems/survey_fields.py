"""Fields of a survey study: drawn from a Gaussian process, computed as in missions, or read from a raster."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from formulations.kernel import KERNELS
from formulations.surveying.gaussian_field import gaussian_field
from instances.environment.propagation import radio_map
from instances.environment.radio import RadioMap, RadioSource
from instances.environment.radio_files import read_field
from instances.environment.site import Site
from instances.environment.terrain import Terrain, mountains
from instances.errors import InputError
from workbench.jobs.study_table import seeds_of
from workbench.problems.tables import FieldTable

NODES = 100
"""Cells along the longer side of a field that is drawn or computed."""
MAST = 30.0
"""Height [m] of the transmitter in the middle of the region."""
ROUGHNESS = 12_000.0
"""Length scale [m] of the synthetic mountains, as in the paper's mission."""


def fields_of(table: FieldTable, base: Path, site: Site) -> Iterator[tuple[str, int, RadioMap]]:
    """Yield name, seed and field for each seed of `table`, files relative to `base`; InputError where it is wrong."""
    if (table.kind == "file") != (table.file is not None):
        raise InputError(f"[[fields]]: kind = {table.kind!r} " + ("takes no file" if table.file else "needs a file"))
    if table.kind != "file" and table.unit is not None:
        raise InputError("[[fields]]: unit is that of a file's values: give file, or leave it out")
    made = {"gp": f"gp-{table.kernel}", "radio": f"radio-{table.model}", "file": Path(table.file or "").stem}
    kept = _read(table, base, site) if table.kind == "file" else None
    for seed in seeds_of(table.seeds):
        yield table.name or made[table.kind], seed, kept or _made(table, site, seed)


def _made(table: FieldTable, site: Site, seed: int) -> RadioMap:
    bounds = site.region.bounds
    if table.kind == "gp":
        kernel = KERNELS[table.kernel](table.signal_sd, (table.length_scale, table.length_scale))
        return gaussian_field(kernel, bounds, NODES, seed)
    x0, y0, x1, y1 = bounds
    return radio_map(
        RadioSource((0.5 * (x0 + x1), 0.5 * (y0 + y1)), MAST),
        bounds,
        _ground(table, bounds),
        altitude=table.altitude,
        model=table.model,
        shadowing_sd=table.shadowing_sd,
        decorrelation=table.decorrelation,
        seed=seed,
        cells=NODES,
    )


def _ground(table: FieldTable, bounds: tuple[float, float, float, float]) -> Terrain | None:
    if table.relief == 0.0:
        return None
    x0, y0, x1, y1 = bounds
    made = mountains(max(x1 - x0, y1 - y0), relief=table.relief, length_scale=ROUGHNESS)
    return Terrain((x0, y0), made.spacing, made.height, made.source)


def _read(table: FieldTable, base: Path, site: Site) -> RadioMap:
    field = read_field(base / str(table.file), site, table.unit)
    (x0, y0, x1, y1), (a0, b0, a1, b1) = site.region.bounds, field.bounds
    dx, dy = field.x[1] - field.x[0], field.y[1] - field.y[0]  # nodes may be cell centres
    if x0 < a0 - dx or y0 < b0 - dy or x1 > a1 + dx or y1 > b1 + dy:
        raise InputError(
            f"[[fields]] file: {table.file} covers ({a0:g}, {b0:g}) to ({a1:g}, {b1:g}) m and not all of the region, "
            f"({x0:g}, {y0:g}) to ({x1:g}, {y1:g}) m"
        )
    return field
