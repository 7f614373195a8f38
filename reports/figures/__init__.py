"""Figures: draw frames. Each returns a matplotlib figure with its caption in words, or None with nothing to draw."""

from __future__ import annotations

import pandas as pd

from reports.figures.ablation import ablated_solvers, ablation
from reports.figures.convergence import convergence, convergence_panels
from reports.figures.profiles import proof_profile, quality_profile, time_profile
from reports.figures.svg import Drawn
from reports.figures.targets import runtime_distribution, time_to_target_plot
from reports.figures.tradeoff import gap_against_n, tradeoff
from reports.figures.turns import loss_against_spacing

__all__ = ["Drawn", "study_figures"]


def study_figures(runs: pd.DataFrame) -> list[Drawn]:
    """Return every figure that `runs` (with gaps) have something to show in, in reading order."""
    drawn = [
        convergence(runs),
        convergence_panels(runs),
        quality_profile(runs),
        time_profile(runs),
        proof_profile(runs),
        time_to_target_plot(runs),
        runtime_distribution(runs),
        gap_against_n(runs),
        loss_against_spacing(runs),
        tradeoff(runs),
        *(ablation(runs, solver) for solver in ablated_solvers(runs)),
    ]
    return [figure for figure in drawn if figure is not None]
