"""The registry of moving-cost methods (`instances.registry` says how third parties add to it)."""

from __future__ import annotations

from formulations.moving_cost.method import MovingCostMethod
from instances.registry import MethodRegistry

BUILT_IN = {
    "refined": ("formulations.moving_cost.refined:Refined", "lattice search and Newton polish: locally optimal"),
    "closed-form": ("formulations.moving_cost.closed_form:ClosedForm", "arcs, where the vorticity is constant"),
    "fmt-star": ("formulations.moving_cost.fmt_star:FmtStar", "the paper's modified Fast Marching Tree"),
    "dijkstra": ("formulations.moving_cost.dijkstra:Dijkstra", "shortest paths on the graph of fmt-star"),
}

SOURCES = {
    "refined": ("workbench", "dijkstra1959note"),
    "closed-form": ("workbench",),
    "fmt-star": ("cho2018informative", "janson2015fast"),
    "dijkstra": ("dijkstra1959note",),
}
"""What to cite for each, keys of reports/data/references.bib."""

METHODS: MethodRegistry[MovingCostMethod] = MethodRegistry(
    "moving-cost method", BUILT_IN, group="mmmdmtsp_workbench.moving_cost_methods", sources=SOURCES
)
"""Name → method; options are the fields of its dataclass."""

DEFAULT = "refined"

make_method = METHODS.make
