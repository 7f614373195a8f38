"""The paper's Figs. 1 and 2: paths through too many, enough and too few tasks, and what sensing makes known."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes

from instances.arrays import Floats
from reports.figures.style import COLOURS, FAINT, INK, PAPER, RC, WIDTH, new_figure
from reports.figures.svg import Drawn


class Path(NamedTuple):
    """Tasks (n, 2) and the order in which a path visits them."""

    points: Floats
    order: Sequence[int]


class Band(NamedTuple):
    """What is believed of a field over a line: mean and sd, shape (p,), and some fields drawn from it, shape (k, p)."""

    mean: Floats
    sd: Floats
    draws: Floats


@rc_context(RC)
def draw_paths_of_random_tasks(paths: Sequence[Path], words: Sequence[str], side: float) -> Drawn:
    """Return Fig. 1: a path through each set of random tasks in [0, `side`]², titled with its number and `words`."""
    figure = new_figure(WIDTH, 2.9)
    for axes, path, word in zip(figure.subplots(1, len(paths), sharey=True), paths, words, strict=True):
        axes.plot(*path.points[list(path.order)].T, color=COLOURS[1], linewidth=1.0, zorder=2)
        size = float(np.clip(700 / len(path.points), 9, 30))
        axes.scatter(
            *path.points.T, s=size, color=COLOURS[0], edgecolors=PAPER, linewidths=0.5, zorder=3, clip_on=False
        )
        axes.set_title(f"{len(path.points)} tasks: {word}")
        axes.set(aspect="equal", xlim=(0, side), ylim=(0, side), xlabel="x")
        axes.grid(visible=False)
    figure.axes[0].set_ylabel("y")
    caption = (
        "Random tasks (dots) and the shortest path found that visits each once (a Hamiltonian path). Too many tasks: "
        "the path senses again what is known already, overfitted; too few: it leaves most of the region unseen, "
        "underfitted."
    )
    return Drawn("fig1", "Paths through random tasks", caption, figure)


@rc_context(RC)
def draw_sensing(x: Floats, before: Band, after: Band, tasks: Floats, readings: Floats, information: float) -> Drawn:
    """Return Fig. 2: beliefs over the line `x` before and after `readings` at `tasks`, worth `information` [nats]."""
    figure = new_figure(WIDTH, 3.0)
    left, right = figure.subplots(1, 2, sharey=True)
    _band(left, x, before, COLOURS[0], "before: mean ± 2 sd")
    left.plot(tasks, np.zeros(len(tasks)), "o", color=PAPER, markeredgecolor=COLOURS[0], markersize=5, label="tasks")
    for side in (-1, 1):
        ends = [band.mean + 2 * side * band.sd for band in (after, before)]
        label = "what sensing took away" if side > 0 else None
        right.fill_between(x, *ends, color=FAINT, alpha=0.4, linewidth=0, label=label)
    _band(right, x, after, COLOURS[0], "after: mean ± 2 sd")
    right.plot(
        tasks, readings, "o", color=COLOURS[0], markeredgecolor=PAPER, markersize=5.5, label="readings", zorder=5
    )
    left.set_title("before sensing: where to read?")
    right.set_title(f"after sensing: {information:.1f} nats gained")
    highest = 2 * float(before.sd.max())
    for axes in (left, right):
        axes.set(xlabel="position, in length scales", xlim=(x[0], x[-1]), ylim=(-1.35 * highest, 1.75 * highest))
        axes.legend(loc="upper center", ncols=2, fontsize=7, borderpad=0.2)
    left.set_ylabel("field, in σ_f")
    caption = (
        "A Gaussian process over a line. Left: before sensing every value within the band is as likely anywhere; thin "
        "lines are fields that may be. Right: after readings of 0 at equally spaced tasks (dots) the band is narrow at "
        "and between them. The grey field is the difference of a-priori and posterior uncertainty, which mutual "
        "information measures."
    )
    return Drawn("fig2", "Uncertainty before and after sensing", caption, figure)


def _band(axes: Axes, x: Floats, band: Band, colour: str, label: str) -> None:
    low, high = band.mean - 2 * band.sd, band.mean + 2 * band.sd
    axes.fill_between(x, low, high, color=colour, alpha=0.3, linewidth=0, label=label)
    axes.plot(x, band.mean, color=INK, linewidth=1.2)
    axes.plot(x, band.draws.T, color=colour, linewidth=0.6, alpha=0.8)
