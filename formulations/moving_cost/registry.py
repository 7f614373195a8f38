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

METHODS: MethodRegistry[MovingCostMethod] = MethodRegistry(
    "moving-cost method", BUILT_IN, group="mmmdmtsp_workbench.moving_cost_methods"
)
"""Name → method; options are the fields of its dataclass."""

DEFAULT = "refined"

make_method = METHODS.make
