"""Columns of the tables for people, each described once: name, unit, how its values are written, what it means."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import pandas as pd

from instances.errors import one_line
from reports import numbers
from reports.record import ENSEMBLE
from reports.record import described as stored

SHORT = "{:.3g}".format
LONGEST_TEXT = 1000
"""Characters of one entry of a table."""
UNITS = (numbers.PER_CENT, " MB", " GB")
"""What texts may end with that is better said once, in the heading."""


def least(values: pd.Series) -> list[str]:
    """Mark the least of `values` as the best, unless all are equal."""
    return ["best" if best and values.nunique(dropna=False) > 1 else "" for best in values == values.min()]


def most(values: pd.Series) -> list[str]:
    """Mark the greatest of `values` as the best, unless all are equal or it is 0."""
    return ["" if value == 0 else mark for value, mark in zip(values, greatest(values), strict=True)]


def greatest(values: pd.Series) -> list[str]:
    """Mark the greatest of `values` as the best, unless all are equal."""
    return least(-values)


def failed(values: pd.Series) -> list[str]:
    """Mark those of `values` that are statuses of a run that failed."""
    return ["bad" if value in ("ERROR", "KILLED") else "" for value in values]


def wrong(values: pd.Series) -> list[str]:
    """Mark those of `values` that should be 0 and are more."""
    return ["bad" if value > 0 else "" for value in values]


class Column(NamedTuple):
    """One column of a table for people.

    key : of the frame. write : a value as text. mark : a word a value for the page: best, bad.
    """

    key: str
    name: str
    unit: str = ""
    write: Callable[[Any], str] = str
    meaning: str = ""
    mark: Callable[[pd.Series], Sequence[str]] | None = None

    @property
    def heading(self) -> str:
        """What stands above the column."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name

    @property
    def is_text(self) -> bool:
        """Whether the column holds words, which stand on the left."""
        return self.write in (str, numbers.proved)

    def text(self, value: Any) -> str:
        """Return `value` as text, one printable line, a dash where it is missing."""
        return numbers.NOTHING if numbers.missing(value) else one_line(self.write(value), LONGEST_TEXT)

    def marks(self, values: pd.Series) -> list[str]:
        """Return the mark of each of `values`; what reads the same is the best together, or none is where all does."""
        if self.mark is None:
            return [""] * len(values)
        marks, words = self.mark(values), [self.text(value) for value in values]
        best = {word for word, mark in zip(words, marks, strict=True) if mark == "best"}
        alike = len(set(words)) == 1
        return [
            "best" * (not alike) if word in best else mark for word, mark in zip(words, marks, strict=True)
        ]  # fmt: skip

    def with_unit(self, words: Sequence[str]) -> tuple[Column, list[str]]:
        """Return the column and its texts `words`, the unit that all of these end with being in the heading instead."""
        held = [word for word in words if word not in (numbers.NOTHING, "∞")]
        for sign in () if self.unit or self.is_text else UNITS:
            if held and all(word.endswith(sign) for word in held):
                return self._replace(unit=sign.strip()), [word.removesuffix(sign) for word in words]
        return self, list(words)


def shown(columns: Iterable[Column], table: pd.DataFrame) -> list[Column]:
    """Return those of `columns` in which `table` has anything to show; failures only where there are any."""
    held = [c for c in columns if c.key in table and table[c.key].notna().any()]
    return [c for c in held if c.key != "failed" or table["failed"].any()]


def texts(columns: Sequence[Column], table: pd.DataFrame) -> list[list[str]]:
    """Return the texts of `table`, a list a row."""
    return [list(row) for row in zip(*([c.text(value) for value in table[c.key]] for c in columns), strict=True)]


_STORED = stored("status", "value", "bound", "elapsed", "time_limit", "stopped_by", "utilisation", "endurance_margin",
                 "promised", "turned", *ENSEMBLE)  # fmt: skip

FAILED = Column("failed", "Failed", "", numbers.count, "runs that were killed or ended in error")
COUNT = Column("runs", "Runs", "", numbers.count, "stored runs of the method")

SUMMARY = [
    Column("method", "Method", meaning="solver, with its options where they are not the defaults"),
    COUNT,
    Column("solved", "Solved", "", numbers.share, "share of runs with routes whose re-computed cost is right", most),
    Column("proved", "Proved", "", numbers.share, "share of runs that ended with a proof of optimality", most),
    Column("certified", "Certified", "", numbers.share,
           "share of runs whose routes a bound claimed by some method puts within 1 % of the optimum", most),
    Column("certified_by", "Certified by",
           meaning="whose bounds these are: a method's claim, which only its own argument shows"),
    Column("gap_known", "Gap to best known", "", numbers.gap, "mean over solved runs with a best known value", least),
    Column("gap_found", "Gap to best found", "", numbers.gap,
           "mean over solved runs; best over all runs of this report", least),
    Column("gap_bound", "Gap to best bound", "", numbers.gap, "mean over solved runs of instances with a bound", least),
    Column("time", "Time", "s", numbers.seconds,
           "shifted geometric mean of the solve; runs without routes penalised", least),
    Column("proof_time", "Time to proof", "s", numbers.seconds,
           "shifted geometric mean until optimality was proved; runs without a proof penalised", least),
    Column("target_time", f"Time to 1{numbers.PER_CENT}", "s", numbers.seconds,
           "shifted geometric mean until the routes were within 1 % of the best; runs that never were penalised",
           least),
    Column("primal_integral", "Primal integral", "", numbers.ratio,
           "mean over runs of the integral of the gap over the time limit, as a share of it: 0 perfect at once, "
           "1 nothing", least),
    Column("primal_dual_integral", "Primal-dual integral", "", numbers.ratio,
           "the same of the gap between a run's own routes and bound, for methods that give bounds", least),
    Column("memory", "Peak memory", "", numbers.memory, "greatest of a run's process"),
    FAILED,
]  # fmt: skip
"""Of `metrics.summary`, a row a method."""

AGAINST = [
    Column("method", "Method"),
    Column("measure", "Measure", meaning="quality: median cost over seeds; time to proof: its median"),
    Column("instances", "Instances", "", numbers.count, "that both stores hold"),
    Column("better", "Better", "", numbers.count, "instances on which the new store is better than the older one"),
    Column("worse", "Worse", "", numbers.count, "instances on which it is worse"),
    Column("unchanged", "Unchanged", "", numbers.count, "instances without a difference"),
    Column("change", "Mean change", "", numbers.gap, "of the measure, relative to the older store"),
    Column("verdict", "Verdict", meaning="Wilcoxon's signed-rank test over instances, corrected by Holm's method"),
]
"""Of `compare.compare_stores`, a row a method and measure."""

INSTANCES = [
    Column("instance", "Instance"),
    Column("family", "Family", meaning="generator family or set"),
    Column("n_tasks", "n", "", numbers.count, "tasks"),
    Column("n_depots", "m", "", numbers.count, "UAVs"),
    Column("asymmetry", "Asymmetry", "", numbers.gap, "mean |c_ij − c_ji| / (c_ij + c_ji)"),
    Column("best_known", "Best known", "s", numbers.cost, "value stored with the instance"),
    Column("best_found", "Best found", "s", numbers.cost, "over all runs of this report"),
    Column("best_bound", "Best bound", "s", numbers.cost, "over all runs of this report"),
    Column("bound_by", "Bound by", meaning="method that claims the best bound"),
    Column("gap", "Gap left", "", numbers.gap, "(best found − best bound) / best found"),
    Column("proved", "Proved", "", numbers.proved, "whether any run proved its routes optimal"),
    Column("best_method", "Found first by", meaning="method that had the best routes soonest"),
]
"""Of `metrics.instance_table`, a row an instance."""

RUNS = [
    Column("instance", "Instance"),
    Column("method", "Method"),
    Column("seed", "Seed", "", "{}".format),
    Column("status", "Status", meaning=_STORED["status"].meaning, mark=failed),
    Column("value", "Longest tour", "s", numbers.cost, _STORED["value"].meaning),
    Column("bound", "Bound", "s", numbers.cost, _STORED["bound"].meaning),
    Column("gap_found", "Gap to best found", "", numbers.gap, "(longest tour − best found) / best found"),
    Column("gap_bound", "Gap to best bound", "", numbers.gap, "(longest tour − best bound) / longest tour"),
    Column("elapsed", "Time", "s", numbers.seconds, _STORED["elapsed"].meaning),
    Column("time_limit", "Limit", "s", numbers.cost, _STORED["time_limit"].meaning),
    Column("stopped_by", "Stopped by", meaning=_STORED["stopped_by"].meaning),
    Column("utilisation", "Utilisation", "", numbers.gap, _STORED["utilisation"].meaning),
    Column("endurance_margin", "Endurance left", "", numbers.gap, _STORED["endurance_margin"].meaning),
    Column("promised", "At take-off's costs", "s", numbers.cost, _STORED["promised"].meaning),
    Column("turned", "Better ways round", "s", numbers.cost, _STORED["turned"].meaning),
    *(
        Column(f"ensemble_{name}", f"{heading} over members", "s", numbers.cost, _STORED[f"ensemble_{name}"].meaning)
        for name, heading in (("least", "Least"), ("mean", "Mean"), ("cvar", "CVaR"), ("worst", "Worst"))
    ),
]
"""Of `metrics.with_gaps`, a row a run, as listed on the study's page."""


def listed_runs(runs: pd.DataFrame) -> list[Column]:
    """Return the columns of a list of `runs`: of endurance, clocks and ensembles only where any run has figures."""
    rare = {"endurance_margin", "promised", "turned", *ENSEMBLE}
    return [column for column in RUNS if column.key not in rare or runs[column.key].notna().any()]


PLACEMENTS = [
    Column("instance", "Problem"),
    Column("method", "Method"),
    COUNT,
    FAILED,
    Column("best", "Best", "nats", numbers.fixed(4),
           "most that points of any run are worth: mutual information, or what the study maximises instead"),
    Column("mean", "Mean", "nats", numbers.fixed(4), "the same, mean over runs"),
    Column("gap_found", "Mean gap to best found", "", numbers.fixed(3, 100, numbers.PER_CENT),
           "1 − worth / greatest worth found on the same problem by any run, mean over runs"),
    Column("ratio", "Best / certificate", "", numbers.fixed(2, 100, numbers.PER_CENT),
           "share of the bound that no placement can pass"),
    Column("elapsed", "Time", "s", SHORT, "wall clock of the method, median over runs"),
    Column("cpu_seconds", "CPU", "s", SHORT, "processor time, median over runs"),
]  # fmt: skip
"""Of a placement study, a row a problem and method."""

EXCESS = [
    Column("method", "Method"),
    Column("options", "Options"),
    Column("cpu", "CPU", "s", SHORT, "processor time for all pairs"),
    Column("mean", "Mean excess", "", SHORT, "over the best known path, relative, mean over all pairs"),
    Column("p95", "95 % quantile", "", SHORT, "of the same"),
    Column("largest", "Largest", "", SHORT, "of the same"),
]
"""Of moving-cost methods compared, a row a variant."""

MOVING_COSTS = [
    Column("instance", "Scenario"),
    Column("method", "Method"),
    COUNT,
    Column("mean_cost", "Mean cost", "s", numbers.fixed(4), "over all ordered pairs of nodes"),
    *(column for column in EXCESS if column.key in ("mean", "p95", "largest")),
    Column("cpu_seconds", "CPU", "s", SHORT, "processor time, least of the runs"),
]
"""Of a moving-cost study, a row a scenario and method."""

SCALING = [
    Column("starts", "Starts", "", numbers.count, "number of starts n"),
    Column("one query a pair", "One query a pair", "s", SHORT, "FMT*, extrapolated from one pair"),
    Column("one tree a start", "One tree a start", "s", SHORT, "FMT*, nothing shared between trees"),
    Column("shared edges", "Shared edges", "s", SHORT, "FMT*, what is known about edges is shared"),
    Column("refined", "Refined", "s", SHORT, "every pair polished"),
]
"""Of the paper's scaling claim, a row a number of starts: CPU times."""

SURVEYS = [
    Column("family", "Field"),
    Column("endurance", "Endurance", "s", SHORT, "longest flight of a UAV"),
    Column("method", "Plan"),
    Column("rmse", "RMSE", "", SHORT, "of the map in the field's unit, mean over fields and noise"),
    Column("more", "RMSE less the reference's", "", str, "paired over fields and noise, with its 95 % interval"),
    Column("verdict", "Reference", "", str, "wins or loses where the whole interval lies on one side of 0"),
    COUNT,
    FAILED,
    Column("nlpd", "NLPD", "nats", numbers.fixed(3), "negative log predictive density of a new measurement"),
    Column("coverage", "Covered", "", numbers.fixed(1, 100, numbers.PER_CENT), "by the 95 % interval"),
    Column("promised_sd", "Promised sd", "", SHORT, "√J, root mean square sd left under what the plan believed"),
    Column("information", "Information", "nats", numbers.fixed(1), "gained by the readings under the same"),
    Column("length", "Flown", "km", numbers.fixed(1, 1e-3), "by all UAVs"),
    Column("longest", "Longest", "km", numbers.fixed(1, 1e-3), "of any UAV in any run"),
    Column("cpu_seconds", "CPU", "s", SHORT, "processor time of the planning, median over runs"),
]
"""Of a study of surveys, a row a field, endurance and plan; the reference is the plan that others are paired with."""

EVIDENCE = [
    Column("kernel", "Kernel"),
    Column("mean", "Mean"),
    Column("log_likelihood", "Log-likelihood", "nats", numbers.fixed(1), "restricted, of all samples", greatest),
    Column("behind", "Behind the best", "nats", numbers.fixed(1)),
]
"""Of what a map's model was chosen from, a row a kernel and mean."""


def replans(unit: str) -> list[Column]:
    """Columns of a table with a row a re-plan in flight, of a field in `unit`."""
    return [
        Column("time", "At", "s", numbers.fixed(0), "after take-off"),
        Column("reason", "Because of"),
        Column("samples", "Samples", "", numbers.count, "known by then"),
        Column("length_scale", "Length scale", "km", str, "of the squared exponential that is planned by: as "
               "believed at take-off until samples refute it, then fitted to them"),
        Column("before", "Promised before", unit, str, "root mean square sd at the test points after landing, by the "
               "plan in the air; – where it may be flown no more"),
        Column("after", "Promised after", unit, str, "by the best other plan; – where none is within endurance"),
        Column("decided", "Decided"),
    ]  # fmt: skip


TOURS = [
    Column("uav", "UAV"),
    Column("tasks", "Tasks", "", numbers.count),
    Column("length", "Reference path", "km", numbers.fixed(2, 1e-3)),
    Column("flight_time", "Flight time", "s", numbers.cost, "at constant airspeed, by the wind triangle"),
    Column("energy", "Energy cost", "s", numbers.cost, "drag energy at the same ground speed, as calm-air seconds"),
    Column("calm", "In calm air", "s", numbers.cost, "time and energy cost without wind"),
]
"""Chosen tours of a mission, time and energy beside each other."""

FLIGHT = [
    Column("uav", "UAV"),
    Column("length", "Flown", "km", numbers.fixed(2, 1e-3)),
    Column("duration", "In", "s", numbers.cost, "at constant airspeed where planned by time, else over ground"),
    Column("reference_length", "Reference path", "km", numbers.fixed(2, 1e-3), "path of the moving costs"),
    Column("task_distance", "Nearest to its tasks within", "m", numbers.fixed(3)),
    Column("least_radius", "Least radius", "m", numbers.fixed(2), "of any turn"),
    Column("deviation", "Off the reference at most", "m", numbers.fixed(0)),
    Column("closure", "End to start", "m", numbers.fixed(3)),
    Column("in_no_fly", "Inside no-fly zones", "m", numbers.fixed(0), "must be 0", wrong),
    Column("outside", "Outside the region", "m", numbers.fixed(0), "must be 0", wrong),
    Column("margin", "Nearest to border or zones", "m", numbers.fixed(1), "at least flight.border_clearance"),
    Column("clearance", "Least height above the ground", "m", numbers.fixed(0), "at least flight.clearance"),
    Column("home", "Ground at the depot", "m", numbers.fixed(0), "above mean sea level, for take-off and landing"),
    Column("lowest", "Track from", "m", numbers.fixed(0), "above mean sea level"),
    Column("highest", "to", "m", numbers.fixed(0), "above mean sea level"),
]
"""Of a mission's ``flight-check.csv``, a row a UAV."""


def survey(unit: str) -> list[Column]:
    """Return the columns of a mission's ``compare.csv``, a row a plan, for a field measured in `unit`."""
    return [
        Column("name", "Plan"),
        Column("count", "Tasks or lanes", "", numbers.count),
        Column("length", "Flown", "km", numbers.fixed(1, 1e-3), "by all UAVs"),
        Column("longest", "Longest tour", "km", numbers.fixed(1, 1e-3)),
        Column("outside", "Outside or in no-fly zones", "km", numbers.fixed(2, 1e-3)),
        Column("samples", "Samples", "", numbers.count, "measurements"),
        Column("information", "Information", "nats", numbers.fixed(1),
               "½ log det(I + K/σ_n²) of all measurements under the planning kernel ([place]), the same for all plans",
               most),
        Column("rmse", "RMSE", unit, numbers.fixed(3),
               "root mean square of estimate − truth over the map's cells; only the judge sees the truth", least),
        Column("more", "RMSE above the mission's", unit, str,
               "mean over the same draws of field and noise, with its 95 % interval (Student's t, paired)"),
        Column("verdict", "The mission", "", str,
               "wins or loses where the whole interval lies on one side of 0; what nobody may fly does not count"),
        Column("nlpd", "NLPD", "nats", numbers.fixed(3),
               "mean negative log density that the map gave to a new noisy measurement at each cell; smaller is "
               "better, and false certainty costs much", least),
        Column("coverage", "Covered by the 95 % interval", "%", numbers.fixed(1, 100),
               "share of the cells whose truth lies within estimate ± 1.96 posterior sd"),
        Column("mean_sd", "Mean sd", unit, numbers.fixed(2), "posterior, over the map's cells", least),
        Column("max_sd", "Greatest sd", unit, numbers.fixed(2), "posterior, over the map's cells", least),
    ]  # fmt: skip
