"""The registry of solvers.

Third parties add solvers through the entry-point group ``mmmdmtsp_workbench.solvers``, or name the target itself,
``"module:Class"``, wherever a solver's name is asked for.
"""

from __future__ import annotations

from formulations.routing.solver import Solver
from instances.registry import MethodRegistry

BUILT_IN = {
    "milp": ("formulations.routing.milp:Milp", "the paper's MILP on CP-SAT, subtour cuts added lazily"),
    "circuit": ("formulations.routing.circuit:Circuit", "CP-SAT circuit constraints, one giant circuit"),
    "exact": ("formulations.routing.exact:Exact", "the portfolio to try first: columns, cuts, subsets, side by side"),
    "subset-dp": ("formulations.routing.subset_dp:SubsetDp", "Held–Karp over all subsets, then a min-max partition"),
    "branch-and-cut": (
        "formulations.routing.branch_and_cut:BranchAndCut",
        "the paper's MILP on SCIP, subtour cuts inside the tree",
    ),
    "arc-tree": (
        "formulations.routing.arc_tree:ArcTree",
        "the paper's MILP cut and branched here, bounds computed anew; strongest where tours are long",
    ),
    "branch-and-price": (
        "formulations.routing.branch_and_price:BranchAndPrice",
        "set partitioning by columns, ng-route pricing; strongest where tours are short",
    ),
    "ga": ("formulations.routing.ga:GeneticAlgorithm", "the paper's genetic algorithm (Ombuki-Berman & Hanshar 2009)"),
    "routing-library": (
        "formulations.routing.routing_library:RoutingLibrary",
        "OR-Tools routing, the off-the-shelf choice",
    ),
    "memetic": ("formulations.routing.search.memetic:Memetic", "state-of-the-art min-max search, for the best routes"),
    "ruin-recreate": (
        "formulations.routing.search.ruin_recreate:RuinRecreate",
        "annealed ruin-and-recreate with p-norm insertion, one trajectory",
    ),
    "greedy": ("formulations.routing.greedy:Greedy", "greedy construction in four variants, the floor"),
}

SOURCES = {
    "milp": ("cho2018informative", "ortools"),
    "circuit": ("workbench", "ortools"),
    "exact": ("workbench", "held1962dynamic", "baldacci2011new", "contardo2014new", "applegate2002solution"),
    "subset-dp": ("held1962dynamic",),
    "branch-and-cut": ("cho2018informative", "applegate2002solution", "achterberg2009scip"),
    "arc-tree": ("cho2018informative", "applegate2002solution", "huangfu2018parallelizing"),
    "branch-and-price": ("baldacci2011new", "contardo2014new", "jepsen2008subset", "huangfu2018parallelizing"),
    "ga": ("ombuki2009using", "cho2018informative"),
    "routing-library": ("ortools",),
    "memetic": ("workbench", "schrimpf2000record", "christiaens2020slack", "ombuki2009using"),
    "ruin-recreate": ("schrimpf2000record", "christiaens2020slack"),
    "greedy": ("potvin1993parallel", "rosenkrantz1977analysis"),
}
"""What to cite for each, keys of reports/data/references.bib."""

SOLVERS: MethodRegistry[Solver] = MethodRegistry(
    "solver", BUILT_IN, group="mmmdmtsp_workbench.solvers", listing="workbench solvers", sources=SOURCES
)
"""Name → solver; options are the fields of its dataclass."""

make_solver = SOLVERS.make
