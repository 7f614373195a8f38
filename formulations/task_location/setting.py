"""From what is typed (region file, test points, kernel) to a criterion."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from formulations.kernel import SquaredExponential
from formulations.task_location.criterion import Convention, Criterion, convention
from formulations.task_location.variance_reduction import NAME, Goal, VarianceReduction
from instances.arrays import Floats
from instances.disk import read_text
from instances.environment.region import Region
from instances.environment.site import Site
from instances.environment.value_map import ValueMap
from instances.errors import InputError, shown
from instances.extent import FARTHEST, LARGEST
from instances.places import read_region

DEFAULT_SIDE = 20_000.0
"""Side [m] of the square that stands for a region that is not given (paper, Numerical Example)."""
MOST_CELLS = 1_000_000


def site_of(path: Path | None) -> Site:
    """Return the region in a file (`instances.places`) and where on Earth it is, or the paper's 20 km square."""
    if path is None:
        return Site(Region.rectangle(DEFAULT_SIDE, DEFAULT_SIDE))
    region, reference = read_region(path)
    return Site(region, reference.plane)


def region_of(path: Path | None) -> Region:
    """Return the region in a file [m], or the paper's 20 km square."""
    return site_of(path).region


def criterion_of(
    region: Region,
    *,
    tests: str | list[list[float]] = "20x20",
    signal_sd: float = 30.0,
    length_scale: str = "4000",
    noise_sd: float = 1.0,
    test_noise_sd: float | None = None,
    criterion: str = "b",
    weights: ValueMap | None = None,
    prior_sd: ValueMap | Mapping[str, Any] | None = None,
) -> Criterion:
    """Return the criterion that the settings describe; InputError names the one that cannot be used.

    weights : a map whose values multiply the tests' own. prior_sd : a map in place of `signal_sd`, or its x, y, values.
    """
    chosen = convention(criterion)
    points, own = tests_of(tests, region)
    kernel = kernel_of(signal_sd, length_scales_of(length_scale), prior_sd)
    return Criterion(kernel, points, weights_of(chosen, points, own, weights), noise_sd, test_noise_sd, chosen)


def goal_of(region: Region, *, criterion: str = "b", **setting: Any) -> Goal:
    """Return what placing maximises: as `criterion_of`, and criterion "j" (variance_reduction.py)."""
    if criterion == NAME:
        return VarianceReduction(criterion_of(region, **setting))
    convention(criterion, NAME)
    return criterion_of(region, criterion=criterion, **setting)


def kernel_of(
    signal_sd: float, length_scales: tuple[float, float], prior_sd: ValueMap | Mapping[str, Any] | None
) -> SquaredExponential:
    """Return the planning kernel: σ_f is `signal_sd`, or the map `prior_sd` where there is one."""
    if prior_sd is None:
        return SquaredExponential(signal_sd, length_scales)
    mapped = prior_sd if isinstance(prior_sd, ValueMap) else ValueMap(**prior_sd)
    return SquaredExponential.of_prior(mapped, length_scales)


def weights_of(chosen: Convention, points: Floats, own: Floats | None, weights: ValueMap | None) -> Floats | None:
    """Return the weights of test `points` (m, 2) [m]: their own times those of a map; None for 1 each."""
    if weights is None:
        return own
    if chosen is Convention.INFORMATION_GAIN:
        raise InputError("weights: criterion ig looks at no test points, so weights say nothing; take j, b or a")
    return weights(points) * (1.0 if own is None else own)


def length_scales_of(text: str) -> tuple[float, float]:
    """Return (l_x, l_y) [m] of ``l`` or ``lx,ly``."""
    try:
        scales = [float(part) for part in str(text).split(",")]
    except ValueError:
        scales = []
    if len(scales) not in (1, 2):
        raise InputError(f"--length-scale: must be one length or two, lx,ly [m], got {text[:80]!r}")
    return scales[0], scales[-1]


def tests_of(text: str | list[list[float]], region: Region) -> tuple[Floats, Floats | None]:
    """Return test points inside `region` and their weights: ``COLUMNSxROWS`` cell centres, a CSV file, or its rows.

    The file has columns x, y [m] and, where not all points count alike, weight.
    """
    if not isinstance(text, str):
        return _inside(np.array(text, dtype=float), region, "tests")
    shape = re.fullmatch(r"(\d{1,9})[x×](\d{1,9})", text)
    if shape:
        columns, rows = int(shape[1]), int(shape[2])
        if columns < 1 or rows < 1:
            raise InputError(f"--tests: needs at least one column and one row, got {text[:80]!r}")
        if columns * rows > MOST_CELLS:
            raise InputError(f"--tests: {text} are too many cells; at most {MOST_CELLS} can be looked at")
        points = region.cell_centres(columns, rows)
        if not len(points):
            raise InputError(f"--tests: none of the {text} cell centres lies inside the region; ask for more")
        return points, None
    if not text.lower().endswith(".csv"):
        raise InputError(f"--tests: must be COLUMNSxROWS such as 20x20, or a .csv with columns x, y, got {text[:80]!r}")
    return _inside(rows_of_tests(Path(text)), region, text)


def _inside(rows: Floats, region: Region, where: str) -> tuple[Floats, Floats | None]:
    points = rows[:, :2]
    inside = region.contains(points) if len(points) else np.zeros(0, dtype=bool)
    if not inside.any():
        raise InputError(f"{where}: none of its {len(points)} test points lies inside the region")
    return points[inside], rows[inside, 2] if rows.shape[1] == 3 else None


def rows_of_tests(path: Path) -> Floats:
    """Return x, y [m] and, where given, weight of a CSV file, (m, 2) or (m, 3); InputError names a line."""
    rows = csv.DictReader(io.StringIO(read_text(path), newline=""))
    try:
        return _rows(rows, path)
    except csv.Error as error:
        raise InputError(f"{path}: line {rows.line_num}: {error}") from None


def _rows(rows: csv.DictReader[str], path: Path) -> Floats:
    columns = set(rows.fieldnames or ())
    if not {"x", "y"} <= columns:
        raise InputError(f"{path}: must have columns 'x' and 'y' [m]")
    names = ("x", "y", "weight") if "weight" in columns else ("x", "y")
    table = []
    for number, row in enumerate(rows, 2):
        for name in names:
            try:
                value = float(row[name])
            except (TypeError, ValueError):
                raise InputError(f"{path}: line {number}: {name} must be a number, got {shown(row[name])}") from None
            if not abs(value) <= (LARGEST if name == "weight" else FARTHEST) or (name == "weight" and value < 0):
                raise InputError(f"{path}: line {number}: {name} is out of range, got {shown(row[name])}")
        table.append([float(row[name]) for name in names])
    return np.array(table, dtype=float).reshape(-1, len(names))
