"""The registry of placement methods (`instances.registry` says how third parties add to it)."""

from __future__ import annotations

from formulations.task_location.placement import PlacementMethod
from instances.registry import MethodRegistry

BUILT_IN = {
    "nlp": ("formulations.task_location.nlp:Nlp", "casadi and IPOPT, closed-form gradient and Hessian, multi-start"),
    "l-bfgs-b": ("formulations.task_location.ascent:LBfgsB", "bounded quasi-Newton, closed-form gradient"),
    "slsqp": ("formulations.task_location.ascent:Slsqp", "sequential quadratic programming, closed-form gradient"),
    "greedy-swap": ("formulations.task_location.greedy_swap:GreedySwap", "greedy, then best exchanges"),
    "greedy": ("formulations.task_location.greedy:Greedy", "largest gain first, over candidate sites"),
    "nelder-mead": ("formulations.task_location.nelder_mead:NelderMead", "the paper's fminsearch, in two forms"),
    "grid": ("formulations.task_location.grid:Grid", "a regular lattice"),
    "random": ("formulations.task_location.random_points:Random", "uniform random points"),
}

SOURCES = {
    "nlp": ("wachter2006implementation", "andersson2019casadi", "wales1997global"),
    "l-bfgs-b": ("byrd1995limited",),
    "slsqp": ("kraft1988software",),
    "greedy-swap": ("fedorov1972theory", "krause2008near"),
    "greedy": ("krause2008near",),
    "nelder-mead": ("cho2018informative", "nelder1965simplex", "lagarias1998convergence"),
    "grid": ("workbench",),
    "random": ("cho2018informative",),
}
"""What to cite for each, keys of reports/data/references.bib."""

METHODS: MethodRegistry[PlacementMethod] = MethodRegistry(
    "placement method", BUILT_IN, group="mmmdmtsp_workbench.placement_methods", at_least=0.0, sources=SOURCES
)
"""Name → method; options are the fields of its dataclass."""

make_method = METHODS.make
