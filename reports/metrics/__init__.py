"""Metrics: frames of runs in, frames of figures of merit out. Every gap is dimensionless, every time in seconds."""

from reports.metrics.contradictions import contradictions
from reports.metrics.gaps import references, with_gaps
from reports.metrics.integrals import with_integrals
from reports.metrics.means import penalised, shifted_geometric_mean
from reports.metrics.scores import instance_table, scores, summary
from reports.metrics.targets import time_to_proof, time_to_target
from reports.metrics.virtual_best import contributions, virtual_best

__all__ = [
    "contradictions",
    "contributions",
    "instance_table",
    "penalised",
    "references",
    "scores",
    "shifted_geometric_mean",
    "summary",
    "time_to_proof",
    "time_to_target",
    "virtual_best",
    "with_gaps",
    "with_integrals",
]
