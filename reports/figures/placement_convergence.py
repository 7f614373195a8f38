"""Convergence of placement methods to the certificate: the gap that is left against time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib import rc_context

from reports.figures.style import RC, legend_below, new_figure, plain, styles
from reports.figures.svg import Drawn


@rc_context(RC)
def draw_placement_convergence(
    traces: Mapping[str, Sequence[tuple[float, float]]], bound: float, title: str
) -> Drawn | None:
    """Return gap to `bound` [nats] against elapsed [s], one line a method; None where no method has a trace.

    traces : method → (elapsed [s], mutual information [nats]), improvements in order.
    """
    drawn = {name: np.array(trace, dtype=float) for name, trace in traces.items() if len(trace)}
    if not drawn:
        return None
    last = 1.4 * max(float(trace[-1, 0]) for trace in drawn.values())
    first = min(float(trace[0, 0]) for trace in drawn.values())
    figure = new_figure(7.2, 3.6)
    axes = figure.subplots()
    for name, style in styles(drawn).items():
        elapsed, value = drawn[name].T
        gap = 100 * (1 - value / bound)
        axes.step([*elapsed, last], [*gap, gap[-1]], where="post", color=style.colour, linestyle=style.dash, label=name)
        axes.plot(elapsed[-1], gap[-1], marker=style.marker, color=style.colour, markersize=5)
    axes.set_xscale("log")
    axes.set_xlim(left=0.7 * max(first, 1e-4), right=last)
    axes.set_ylim(bottom=0)
    plain(axes.xaxis)
    axes.set_xlabel("wall clock [s]")
    axes.set_ylabel("gap to the certificate [%]")
    axes.set_title(title, fontsize=9.5)
    legend_below(figure, axes)
    return Drawn(
        "placement-convergence",
        "Convergence to the certificate",
        "How far each method's best placement so far lies under the certificate, which no placement can pass. The mark "
        "is the last improvement. Part of the gap that all share is the certificate's own: under criterion (b) it "
        "bounds the information gain, of which the noisy test points see only a part.",
        figure,
    )
