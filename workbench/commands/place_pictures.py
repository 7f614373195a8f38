"""From placements to pictures: evaluates what is drawn, and hands it to reports."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from formulations.task_location.criterion import Criterion
from formulations.task_location.how_many import Recommendation, Trial
from formulations.task_location.placement import Placement, PlacementProblem
from formulations.task_location.tour import along
from formulations.task_location.uncertainty import posterior_sd
from instances.arrays import Floats
from instances.environment.region import Region
from reports.figures.placement import draw_placement
from reports.figures.placement_study import Curves, Tour, draw_study
from reports.figures.svg import save_figure

PIXELS = 161


def draw(problem: PlacementProblem, placement: Placement, path: Path) -> None:
    """Draw a placement over its uncertainty map."""
    criterion = problem.criterion
    drawn = draw_placement(
        problem.region,
        placement.points,
        criterion.tests,
        sd_map(problem.region, criterion, placement.points),
        criterion.kernel.signal_sd,
        placement.summary(),
    )
    save_figure(drawn.figure, path)


def draw_trials(
    region: Region, criterion: Criterion, done: list[Trial], advice: Recommendation, spacing: float, path: Path
) -> None:
    """Draw a study: tours of the fewest, the recommended and the most tasks, and the curves."""
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
    curves = Curves(
        *(
            np.array([np.nan if value is None else value for value in column], dtype=float)
            for column in zip(
                *((t.n, t.mi1, t.mi2, t.lawnmower, t.length / 1000, t.uncovered, t.planning_noise) for t in done),
                strict=True,
            )
        )
    )
    drawn = draw_study(region, tours, curves, advice.n, criterion.kernel.signal_sd)
    save_figure(drawn.figure, path)


def sd_map(region: Region, criterion: Criterion, readings: Floats) -> tuple[Floats, Floats, Floats]:
    """Return x (p,), y (q,) [m] and the posterior sd (q, p) over the region's bounding box, NaN outside the region."""
    x0, y0, x1, y1 = region.bounds
    pixel = max(x1 - x0, y1 - y0) / (PIXELS - 1)
    xs = np.linspace(x0, x1, max(2, round((x1 - x0) / pixel) + 1))
    ys = np.linspace(y0, y1, max(2, round((y1 - y0) / pixel) + 1))
    places = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
    sd = np.full(len(places), np.nan)
    inside = region.contains(places)
    sd[inside] = posterior_sd(criterion.kernel, criterion.noise_sd, readings, places[inside])
    return xs, ys, sd.reshape(len(ys), len(xs))
