"""Critical-difference diagram: average ranks on a line, methods that do not differ significantly joined by a bar.

Source: J. Demšar, J. Mach. Learn. Res. 7 (2006) 1–30, section 3.2.2 and figure 1.
"""

from __future__ import annotations

import numpy as np
from matplotlib import rc_context

from reports.figures.style import INK, RC, Style, new_figure
from reports.figures.svg import Drawn
from reports.statistics.friedman import Friedman, cliques


@rc_context(RC)
def critical_difference_diagram(test: Friedman, style: dict[str, Style], key: str, about: str) -> Drawn:
    """Draw the average ranks of `test`; `about` names the measure, as in "gap to the best"."""
    ranks = test.ranks
    k = len(ranks)
    bars = cliques(ranks, test.critical_difference)
    left = (k + 1) // 2
    height = 0.95 + 0.24 * (left + len(bars))
    figure = new_figure(height=height)
    axes = figure.add_subplot()
    axes.axis("off")
    low, high = 1.0, float(k)
    bar_rows = 0.62 * len(bars)
    axes.set(xlim=(low - 0.42 * (high - low), high + 0.42 * (high - low)), ylim=(-(left + bar_rows + 0.9), 2.1))
    axes.plot([low, high], [0, 0], color=INK, linewidth=1.1)
    for tick in range(1, k + 1):
        axes.plot([tick, tick], [0, 0.18], color=INK, linewidth=1.1)
        axes.text(tick, 0.3, str(tick), ha="center", va="bottom", fontsize=8)
    axes.plot([low, low + test.critical_difference], [1.55, 1.55], color=INK, linewidth=2.4, solid_capstyle="butt")
    words = f"critical difference {test.critical_difference:.2f}"
    axes.text(low + test.critical_difference + 0.02 * (high - low), 1.55, words, va="center", fontsize=8)
    for i, (first, last) in enumerate(bars):
        y = -0.4 - 0.62 * i
        ends = np.array([ranks.iloc[first], ranks.iloc[last]]) + np.array([-1, 1]) * 0.008 * (high - low)
        axes.plot(ends, [y, y], color=INK, linewidth=3.4, solid_capstyle="butt")
    for i, (method, rank) in enumerate(ranks.items()):
        on_left = i < left
        y = -(bar_rows + 0.75 + (i if on_left else k - 1 - i))
        end = low - 0.05 * (high - low) if on_left else high + 0.05 * (high - low)
        look = style[str(method)]
        axes.plot([rank, rank, end], [0, y, y], color=look.colour, linewidth=1.3)
        label = f"{method}  {rank:.2f}" if on_left else f"{rank:.2f}  {method}"
        gap = (-0.012 if on_left else 0.012) * (high - low)
        axes.text(end + gap, y, label, ha="right" if on_left else "left", va="center", fontsize=8.5)
    caption = (
        f"Average rank of each method by {about} over {test.instances} instances (1 is best; medians over seeds). "
        "Methods joined by a bar do not differ significantly at the 5 % level (Nemenyi). Friedman test: χ² = "
        f"{test.chi_square:.2f}, F = {test.f_statistic:.2f}, p {'< 0.001' if test.p < 0.001 else f'= {test.p:.3f}'}."
    )
    return Drawn(key, f"Average ranks by {about}", caption, figure)
