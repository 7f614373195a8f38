"""`workbench figures`: the figures of the paper that explain and report no result."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from workbench.options import JSON, SEED
from workbench.terminal import print_json, say

if TYPE_CHECKING:
    from formulations.kernel import SquaredExponential
    from instances.arrays import Floats
    from reports.figures.svg import Drawn

SIDE = 100.0
"""Tasks of Fig. 1 lie in [0, SIDE]²."""
NUMBERS = {200: "overfitted", 40: "normal", 5: "underfitted"}
"""Tasks of Fig. 1, and what the paper calls a path through so many."""
LINE, READINGS, NOISE = 8.0, 7, 0.1
"""Fig. 2: length of the line [length scales], readings on it, and their noise [σ_f]."""


@click.command("figures")
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder of the figures.")
@click.option("--seed", type=SEED, default=0, show_default=True)
@click.option("--format", "ending", type=click.Choice(["svg", "png", "pdf"]), default="svg", show_default=True)
@JSON
def command(out: Path, seed: int, ending: str, as_json: bool) -> None:
    """Draw the paper's Fig. 1 (paths through random tasks) and Fig. 2 (uncertainty before and after sensing).

    The other figures are those of what is computed: place --plot and --study, costs --plot, mission.

    \b
    Examples:
      workbench figures --out figures --format pdf
    """
    from reports.figures.svg import save_figure
    from workbench.settings import make_folder

    make_folder(out)
    made = []
    for drawn in (random_paths(seed), sensing(seed)):
        path = out / f"{drawn.key}.{ending}"
        save_figure(drawn.figure, path)
        made.append({"key": drawn.key, "file": path, "title": drawn.title, "caption": drawn.caption})
        if not as_json:
            say(f"{path}: {drawn.title}. {drawn.caption}")
    if as_json:
        print_json({"figures": made})


def random_paths(seed: int, numbers: dict[int, str] = NUMBERS) -> Drawn:
    """Return Fig. 1, a panel for each of `numbers`."""
    import numpy as np

    from formulations.task_location.tour import open_path
    from reports.figures.paper import Path as TaskPath
    from reports.figures.paper import draw_paths_of_random_tasks

    points = [np.random.default_rng([seed, n]).uniform(0.0, SIDE, (n, 2)) for n in numbers]
    paths = [TaskPath(p, open_path(p, seed=seed)) for p in points]
    return draw_paths_of_random_tasks(paths, list(numbers.values()), SIDE)


def sensing(seed: int) -> Drawn:
    """Return Fig. 2: a Gaussian process over a line, read at equally spaced tasks."""
    import numpy as np

    from formulations.kernel import SquaredExponential
    from formulations.mapping.gaussian_process import GaussianProcess
    from reports.figures.paper import Band, draw_sensing

    kernel = SquaredExponential(1.0, (1.0, 1.0))
    x = np.linspace(0.0, LINE, 321)
    tasks = (np.arange(READINGS) + 0.5) * LINE / READINGS
    readings = np.zeros(READINGS)
    process = GaussianProcess(kernel, NOISE, _on_line(x), level=0.0)
    before = process.posterior()
    process.extend(_on_line(tasks), readings)
    after = process.posterior()
    drawn = _drawn(kernel, x, tasks, seed)
    first, then = (Band(known.mean, known.sd, draws) for known, draws in zip((before, after), drawn, strict=True))
    return draw_sensing(x, first, then, tasks, readings, process.information())


def _drawn(kernel: SquaredExponential, x: Floats, tasks: Floats, seed: int) -> tuple[Floats, Floats]:
    """Return three fields over `x` drawn from what is believed before and after readings of 0, (3, p) each.

    A draw f before becomes one after by Matheron's rule: f − K_xT (K_TT + σ_n² I)⁻¹ (f_T + noise).
    """
    import numpy as np

    places, p = _on_line(np.concatenate([x, tasks])), len(x)
    K = kernel(places, places)
    rng = np.random.default_rng(seed)
    f = np.linalg.cholesky(K + 1e-9 * np.eye(len(K))) @ rng.normal(size=(len(K), 3))
    read = f[p:] + NOISE * rng.normal(size=(len(tasks), 3))
    gain = K[:p, p:] @ np.linalg.inv(K[p:, p:] + NOISE**2 * np.eye(len(tasks)))
    return f[:p].T, (f[:p] - gain @ read).T


def _on_line(x: Floats) -> Floats:
    """Return places x (k,) on a line as points of the plane, (k, 2)."""
    import numpy as np

    return np.column_stack([x, np.zeros(len(x))])
