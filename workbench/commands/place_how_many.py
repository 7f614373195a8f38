"""`workbench place --study` and `--max-sd`: how many tasks."""

from __future__ import annotations

import csv
import io
import json
import re
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

import click
import numpy as np

from formulations.task_location.criterion import Convention
from formulations.task_location.fewest import fewest_tasks
from formulations.task_location.how_many import Recommendation, Trial, recommend, trials
from formulations.task_location.placement import Placement, PlacementMethod, PlacementProblem, PlacementStatus
from formulations.task_location.placement_files import write_placement
from formulations.task_location.tour import along
from formulations.task_location.uncertainty import sd_map
from formulations.task_location.variance_reduction import Goal
from instances.disk import write_aside
from instances.environment.region import Region
from instances.errors import InputError, shown
from instances.geodesy import TangentPlane
from reports.numbers import NOTHING, fixed, missing
from workbench.settings import check_target, make_folder
from workbench.terminal import TextTable, print_table, refuse_unknown_columns, say, say_lines

COLUMNS: dict[str, tuple[str, Callable[[Any], str]]] = {
    "n": ("n", str),
    "length": ("Tour [km]", fixed(1, 1e-3)),
    "mutual_information": ("Information (b) [nats]", fixed(1)),
    "mi1": ("MI1 [nats]", fixed(1)),
    "mi2": ("MI2 [nats]", fixed(1)),
    "lawnmower": ("Lawnmower [nats]", fixed(1)),
    "per_km": ("More [nats/km]", fixed(2)),
    "planning_noise": ("σ_T", fixed(3)),
    "uncovered": ("Uncovered [%]", fixed(1, 100)),
    "uncovered_tasks": ("Uncovered by tasks [%]", fixed(1, 100)),
    "mean_sd": ("Mean sd", fixed(2)),
    "highest_sd": ("Highest sd", fixed(2)),
}
"""Columns of a study: as people see them, heading and how a value is written; in files in SI units."""
FIRST = ("length", "mi1", "mi2", "uncovered", "highest_sd", "per_km", "lawnmower", "planning_noise")
"""Those that are left out last."""


class Asked(NamedTuple):
    """What is asked for in every case: the seed, the answer as JSON or text, a file and a picture of it.

    plane : where on Earth the region is, where its file says so. columns : those of the printed table, [] where none
    are asked for.
    """

    seed: int
    as_json: bool
    out: Path | None
    plot: Path | None
    plane: TangentPlane | None = None
    columns: Sequence[str] = ()


def numbers_from(text: str) -> list[int]:
    """Return the numbers of ``n=5..80``, ``5..80:5`` or ``5,40,200``; InputError where it says something else."""
    body = text.removeprefix("n=").strip()
    number = r"(\d{1,5})"  # no more digits: every number of the span is tried
    span = re.fullmatch(rf"{number}\.\.{number}(?::{number})?", body)
    if span:
        first, last, step = int(span[1]), int(span[2]), int(span[3] or 1)
        found = list(range(first, last + 1, step)) if step else []
    else:
        parts = body.split(",")
        found = [int(part) for part in parts] if all(re.fullmatch(number, part.strip()) for part in parts) else []
    if not found or min(found) < 1:
        raise InputError(
            f"--study: must be n=A..B, n=A..B:STEP or a list such as 5,40,200 of numbers ≥ 1, got {shown(text)}"
        )
    return found


def run_study(
    region: Region, criterion: Goal, text: str, name: str, method: PlacementMethod, sd_limit: float, asked: Asked
) -> None:
    """Try every n, tell each on stderr, recommend one, and write what was asked for."""
    numbers = numbers_from(text)
    refuse_unknown_columns(asked.columns, list(COLUMNS))
    PlacementProblem(region, criterion, max(numbers))  # refuse a number that does not fit before the first is placed
    tables, pictures = study_files(asked.out, asked.plot)
    spacing = min(criterion.kernel.length_scales) / 4
    given: dict[str, Any] = {"seed": asked.seed, "sd_limit": sd_limit, "spacing": spacing}
    done = trials(region, criterion, numbers, method, name, observe=_tell, **given)
    advice = recommend(done)
    answer = _answer(done, advice, sd_limit, spacing)
    for path in tables:
        write_aside(path, _csv(done) if path.suffix == ".csv" else json.dumps(answer))
    for path in pictures:
        _draw_trials(region, criterion, done, advice, spacing, path)
    if asked.as_json:
        click.echo(json.dumps(answer))
    else:
        _print(done, advice, asked.columns)


def study_files(out: Path | None, plot: Path | None) -> tuple[list[Path], list[Path]]:
    """Return the tables and pictures to write: a name without an ending is a folder, made here, that gets one of each.

    InputError where one of them could not be written.
    """
    tables, pictures = ([] if path is None else [path] for path in (out, plot))
    if out is not None and not out.suffix:
        make_folder(out)
        tables, pictures = [out / "study.csv", out / "study.json"], [*pictures, out / "study.svg"]
    for path in (*tables, *pictures):
        check_target(path, (".json", ".csv") if path in tables else (".svg",))
    return tables, pictures


def run_fewest(region: Region, criterion: Goal, max_sd: float, asked: Asked) -> None:
    """Find few tasks that keep the posterior sd under `max_sd` everywhere, and write what was asked for."""
    began = time.perf_counter()
    found = fewest_tasks(region, criterion.kernel, criterion.noise_sd, max_sd, seed=asked.seed)
    worth = {str(c): criterion.under(c).value(found.points) for c in Convention}
    placement = Placement(
        points=found.points,
        mutual_information=worth[Convention.BOTH_NOISY],
        method="fewest",
        status=PlacementStatus.HEURISTIC,
        seed=asked.seed,
        elapsed=time.perf_counter() - began,
        information=worth,
    )
    n = len(found.points)
    write_and_draw(PlacementProblem(region, criterion, n), placement, asked)
    if asked.as_json:
        more = {name: getattr(found, name) for name in ("worst_sd", "at_least", "greedy")}
        click.echo(json.dumps({**placement.as_dict(), "n": n, "max_sd": max_sd, **more}))
    else:
        say_lines(
            f"{n} tasks keep the posterior sd at most {found.worst_sd:.4g} everywhere (asked: {max_sd:g}), "
            f"{placement.elapsed:.2f} s\nat least {found.at_least} are needed; greedy takes {found.greedy}"
        )


def _tell(trial: Trial) -> None:
    say(
        f"n = {trial.n:3d}  {trial.length / 1000:6.1f} km  MI1 {trial.mi1:6.1f}  MI2 {trial.mi2:6.1f}  "
        f"uncovered {trial.uncovered:6.1%}",
        err=True,
    )


def _row(trial: Trial) -> dict[str, Any]:
    return {name: getattr(trial, name) for name in COLUMNS}


def _answer(done: list[Trial], advice: Recommendation, sd_limit: float, spacing: float) -> dict[str, Any]:
    told = asdict(advice)
    found = [{**_row(t), "points": t.points.tolist(), "order": t.order} for t in done]
    return {"recommended": told.pop("n"), **told, "sd_limit": sd_limit, "spacing": spacing, "trials": found}


def _csv(done: list[Trial]) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(_row(trial) for trial in done)
    return text.getvalue()


def _print(done: list[Trial], advice: Recommendation, names: Sequence[str]) -> None:
    rows = [
        [NOTHING if missing(value) else COLUMNS[key][1](value) for key, value in _row(trial).items()] for trial in done
    ]
    headings = [heading for heading, _ in COLUMNS.values()]
    print_table(TextTable(list(COLUMNS), headings, rows, first=FIRST), names)
    say(f"recommended: {advice.n} tasks, {advice.reason}")
    say(f"underfitted below {advice.underfitted_below}, overfitted above {advice.overfitted_above}")


def write_and_draw(problem: PlacementProblem, placement: Placement, asked: Asked) -> None:
    """Write a placement, and draw it over its uncertainty map, where asked for."""
    if asked.out is not None:
        write_placement(placement, asked.out, asked.plane)
        if asked.out.suffix == ".geojson" and asked.plane is None:
            say(f"{asked.out}: in local metres, as the region: nothing says where on Earth it is", err=True)
    if asked.plot is None:
        return
    from reports.figures.placement import draw_placement  # here: matplotlib takes its time
    from reports.figures.svg import save_figure

    region, criterion, points = problem.region, problem.criterion, placement.points
    left = sd_map(region, criterion, points)
    drawn = draw_placement(region, points, criterion.tests, left, criterion.kernel.signal_sd, placement.summary())
    save_figure(drawn.figure, asked.plot)


def _draw_trials(
    region: Region, criterion: Goal, done: list[Trial], advice: Recommendation, spacing: float, path: Path
) -> None:
    """Draw a study: tours of the fewest, the recommended and the most tasks, and the curves."""
    from reports.figures.placement_study import Curves, Tour, draw_study  # here: matplotlib takes its time
    from reports.figures.svg import save_figure

    chosen = {trial.n: trial for trial in done}
    numbers = sorted({done[0].n, advice.n, done[-1].n})
    verdict = {done[0].n: "few", done[-1].n: "many", advice.n: "recommended"}
    tours = [
        Tour(
            (t := chosen[n]).points,
            t.order,
            sd_map(region, criterion, along(t.points, t.order, spacing)),
            f"{n} tasks ({verdict[n]}), {t.length / 1000:.0f} km",
        )
        for n in numbers
    ]
    rows = [(t.n, t.mi1, t.mi2, t.lawnmower, t.length / 1000, t.uncovered, t.planning_noise) for t in done]
    curves = Curves(*np.array(rows, dtype=float).T)  # None becomes NaN
    drawn = draw_study(region, tours, curves, advice.n, criterion.kernel.signal_sd)
    save_figure(drawn.figure, path)
