"""The registry of selection methods (`instances.registry` says how third parties add to it)."""

from __future__ import annotations

from formulations.selection.selection import SelectionMethod
from instances.registry import MethodRegistry

BUILT_IN = {
    "exact": ("formulations.selection.exact:Exact", "the portfolio: all sets to n = 18, else search, then columns"),
    "subset-dp": ("formulations.selection.subset_dp:SubsetDp", "Held-Karp over all sets of tasks, n <= 18"),
    "branch-and-price": ("formulations.selection.branch_and_price:BranchAndPrice", "columns with prizes, proves"),
    "ruin-recreate": ("formulations.selection.ruin_recreate:RuinRecreate", "search for any size, a simple bound"),
}

SOURCES = {
    "exact": ("workbench", "held1962dynamic", "boussier2007exact"),
    "subset-dp": ("held1962dynamic",),
    "branch-and-price": ("boussier2007exact", "baldacci2011new", "jepsen2008subset"),
    "ruin-recreate": ("schrimpf2000record", "tsiligirides1984heuristic"),
}
"""What to cite for each, keys of reports/data/references.bib."""

METHODS: MethodRegistry[SelectionMethod] = MethodRegistry(
    "selection method", BUILT_IN, group="mmmdmtsp_workbench.selection_methods", at_least=0.0, sources=SOURCES
)
"""Name → method; options are the fields of its dataclass."""

make_method = METHODS.make
