"""The registry of survey planners (`instances.registry` says how third parties add to it)."""

from __future__ import annotations

from formulations.surveying.problem import SurveyPlanner
from instances.registry import MethodRegistry

BUILT_IN = {
    "workbench": ("formulations.surveying.placed:Workbench", "tasks of most information, as many as fit, routed"),
    "polished": ("formulations.surveying.polished:Polished", "the same, waypoints moved for what is sensed on the way"),
    "adaptive": ("formulations.surveying.adaptive:Adaptive", "the workbench's, re-planned in flight by what was read"),
    "greedy": ("formulations.surveying.placed:Greedy", "tasks placed one after the other, as many as fit, routed"),
    "random": ("formulations.surveying.placed:RandomTasks", "uniform random tasks, as many as fit, routed"),
    "lawnmower": ("formulations.surveying.lanes:Lawnmower", "parallel lanes, the most that fit"),
    "myopic": ("formulations.surveying.myopic:Myopic", "each UAV on to what it knows least about, way home kept"),
    "sgptools": ("formulations.surveying.sparse_gp:SparseGp", "sgptools: inducing points of a sparse process; extra"),
    "pypolo": (
        "formulations.surveying.entropy_and_distance:EntropyAndDistance",
        "PyPolo: each UAV on by entropy and distance, way home kept; numpy below 2 only",
    ),
}

SOURCES = {
    "workbench": ("workbench",),
    "polished": ("workbench",),
    "adaptive": ("workbench",),
    "greedy": ("krause2008near",),
}
"""What to cite for each, keys of reports/data/references.bib."""

PLANNERS: MethodRegistry[SurveyPlanner] = MethodRegistry(
    "survey planner", BUILT_IN, group="mmmdmtsp_workbench.survey_planners", at_least=0.0, sources=SOURCES
)
"""Name → planner; options are the fields of its dataclass."""
