"""Instance: the data of one min-max multi-depot multiple TSP (paper, §Mathematical Formulation)."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from instances.arrays import Floats, Ints
from instances.errors import InputError, naming, shown
from instances.metric_costs import MATRIX_NODES, MetricCosts
from instances.travel import AXES, Travel

MAX_NODES = 100_000
"""Most nodes n + m of an instance; of more than MATRIX_NODES its costs have to be named by a metric."""
ROWS_LOOKED_AT = 500
"""Tasks whose legs tell how asymmetric costs are that are computed leg by leg."""

LARGEST_SUM = 1e150
"""Most [s] that n + m times the largest cost may be: products of two sums of costs stay finite."""
LARGEST_COORDINATE = 1e15
"""Greatest coordinate [m]: its square is finite, and float64 still tells places a metre apart."""


@dataclass(frozen=True, eq=False)
class Instance:
    """One MMMDMTSP: moving costs between n tasks and m depots, one UAV at each depot.

    Nodes are numbered as in the paper, from 0: tasks ``0..n-1``, then depots ``n..n+m-1``. Several UAVs at
    one place are several depots at that place.

    Parameters
    ----------
    name
        Short name, used in file and report names.
    cost
        ``cost[i, j]`` [s] of flying from node i to node j, shape (n+m, n+m), finite, non-negative, zero diagonal, in
        general asymmetric (paper: c_ij differs from c_ji because of the wind). Entries between two depots are carried
        but never used: E excludes D × D. n+m times the largest is at most LARGEST_SUM. Or MetricCosts, which are read
        alike and refuse to become a matrix (`of_metric`).
    n_tasks
        n ≥ 1.
    n_depots
        m ≥ 1.
    coordinates
        Positions [m], shape (n+m, 2), or None where only costs are known.
    provenance
        Where the numbers come from: family, parameters, seed, source file.
    travel
        What a leg costs each class of UAV, at each time, between states of nodes; None where `cost` says it all.
        `cost` is then the least of it (`Travel.least`), a valid bound for everything that reads one matrix.
    endurance
        L_k [s] of each UAV, shape (m,), positive, +inf where unlimited: C_k ≤ L_k. None where all are.

    Raises
    ------
    InputError
        With one sentence that names the offending entry.
    """

    name: str
    cost: Floats
    n_tasks: int
    n_depots: int
    coordinates: Floats | None = None
    provenance: Mapping[str, Any] = field(default_factory=dict)
    travel: Travel | None = None
    endurance: Floats | None = None

    def __post_init__(self) -> None:
        with naming("instance"):
            check_name(self.name)
        for label in ("n_tasks", "n_depots"):
            value = getattr(self, label)
            if not isinstance(value, (int, np.integer)) or isinstance(value, bool) or value < 1:
                raise InputError(
                    f"instance {self.name}: {label} must be a whole number of at least 1, got {shown(value)}"
                )
        check_size(self.n_tasks, self.n_depots, MATRIX_NODES if self.by_metric is None else MAX_NODES)
        if self.coordinates is not None:
            object.__setattr__(self, "coordinates", _checked_coordinates(self.coordinates, self.n_nodes, self.name))
        if self.by_metric is None:
            object.__setattr__(self, "cost", _checked_cost(self.cost, self.n_nodes, self.name))
        else:
            _check_by_metric(self.by_metric, self)
        object.__setattr__(self, "provenance", dict(self.provenance))
        object.__setattr__(self, "travel", _checked_travel(self.travel, self.cost, self.n_depots, self.name))
        object.__setattr__(self, "endurance", _checked_endurance(self.endurance, self.n_depots, self.name))

    @classmethod
    def of_travel(cls, name: str, travel: Travel, n_tasks: int, **more: Any) -> Instance:
        """Return the instance whose costs are the least of `travel`; `more` are its other fields."""
        return cls(name, travel.least(), n_tasks, len(travel.classes), travel=travel, **more)

    @classmethod
    def of_metric(
        cls, name: str, metric: Mapping[str, Any], coordinates: ArrayLike, n_tasks: int, n_depots: int, **more: Any
    ) -> Instance:
        """Return the instance without a matrix: its costs are computed from coordinates where they are asked for.

        metric : as in an instance file (`instances.metrics`). `more` are the instance's other fields.
        """
        xy = _checked_coordinates(coordinates, n_tasks + n_depots, name)
        return cls(name, cast(Floats, MetricCosts(metric, xy)), n_tasks, n_depots, xy, **more)

    @property
    def by_metric(self) -> MetricCosts | None:
        """The costs where they are computed leg by leg, None where they are a matrix."""
        cost: object = self.cost
        return cost if isinstance(cost, MetricCosts) else None

    def __reduce__(self) -> tuple[type[Instance], tuple[Any, ...]]:
        """Pickle through the constructor: arrays are read-only again on the other side, which kernels mind."""
        return Instance, tuple(getattr(self, each.name) for each in fields(self))

    @property
    def n_nodes(self) -> int:
        """Number of nodes, n + m."""
        return int(self.n_tasks) + int(self.n_depots)

    @property
    def tasks(self) -> range:
        """The paper's T: node numbers of the tasks."""
        return range(self.n_tasks)

    @property
    def depots(self) -> range:
        """The paper's D: node numbers of the depots, one UAV at each."""
        return range(self.n_tasks, self.n_nodes)

    @property
    def axes(self) -> frozenset[str]:
        """What this instance has beyond one matrix of costs: names of `instances.travel.AXES`."""
        limited = frozenset() if self.endurance is None else frozenset({"endurance"})
        if self.by_metric is not None:
            return limited | {"metric"}
        if self.travel is None:
            return limited
        waits = limited and self.travel.window > 0 and "time" in self.travel.axes  # else waiting is of no use
        return limited | self.travel.axes | (frozenset({"window"}) if waits else frozenset())

    @property
    def restricted(self) -> bool:
        """Whether there may be no routes at all: legs that some UAV cannot fly, or limited endurance."""
        return self.endurance is not None or (self.travel is not None and not np.isfinite(self.travel.cost).all())

    @property
    def classes(self) -> Ints:
        """The class of each UAV, (m,): all 0 where the UAVs are alike."""
        return np.zeros(self.n_depots, dtype=np.int64) if self.travel is None else self.travel.classes

    @property
    def class_costs(self) -> Floats:
        """Costs of each class of UAV, (G, N, N) [s], +inf where it cannot fly; ValueError where time or state count."""
        if self.travel is None:
            return np.asarray(self.cost)[None]
        if self.travel.axes & {"time", "states"}:
            raise ValueError(f"instance {self.name}: costs depend on more than the class of the UAV")
        return self.travel.cost[:, 0]

    def uav_cost(self, k: int) -> Floats:
        """Return the costs (N, N) [s] of UAV k, +inf where it cannot fly; ValueError as `class_costs`."""
        return self.class_costs[self.classes[k]]

    @cached_property
    def limits(self) -> Floats:
        """L_k [s] of each UAV, (m,): +inf where its endurance is unlimited."""
        return np.full(self.n_depots, np.inf) if self.endurance is None else self.endurance

    @cached_property
    def digest(self) -> str:
        """First 12 hexadecimal digits of the SHA-256 of the arrays (name and provenance left out).

        In place of a matrix of costs that there is not, the metric as text.
        """
        h = hashlib.sha256(f"{self.n_tasks} {self.n_depots} ".encode())
        arrays = [("", self.cost), ("", self.coordinates), ("endurance", self.endurance)]
        if self.by_metric is not None:
            h.update(self.by_metric.described.encode())
            del arrays[0]
        if self.travel is not None:
            arrays += [(name, getattr(self.travel, name)) for name in ("cost", "classes", "departures", "nodes")]
            arrays += [("closed", np.ones(1))] if self.travel.closed else []
            arrays += [("window", np.array([self.travel.window]))] if self.travel.window else []
        for label, array in arrays:
            if array is not None:
                h.update(label.encode())
                h.update(np.ascontiguousarray(array, dtype="<f8").reshape(-1).view(np.uint8).data)
        return h.hexdigest()[:12]

    @cached_property
    def asymmetry(self) -> float:
        """Mean of |c_ij − c_ji| / (c_ij + c_ji) over the edges in use (dimensionless, 0 where symmetric).

        Without a matrix over those of some 500 tasks, spread evenly.
        """
        if self.by_metric is not None and self.by_metric.symmetric:
            return 0.0
        ratios, step = 0.0, 1 if self.by_metric is None else -(-self.n_tasks // ROWS_LOOKED_AT)
        for i in self.tasks[::step]:  # a row at a time: no second matrix in memory
            there, back = self.cost[i], self.cost[:, i]
            total = there + back
            ratios += float(np.divide(np.abs(there - back), total, out=np.zeros_like(total), where=total > 0).sum())
        return ratios / (len(self.tasks[::step]) * (self.n_nodes - 1))

    def about(self) -> dict[str, Any]:
        """What programs are told of it: its name as `instance`, digest and size."""
        return {"instance": self.name, "digest": self.digest, "n_tasks": self.n_tasks, "n_depots": self.n_depots}

    def summary(self) -> str:
        """One line for people: name, size, asymmetry, digest."""
        more = "".join(f"{AXES[axis]}, " for axis in AXES if axis in self.axes)
        return (
            f"{self.name}: {self.n_tasks} tasks, {self.n_depots} depots, {more}"
            f"cost asymmetry {self.asymmetry:.1%}, digest {self.digest}"
        )


def check_name(name: object) -> None:
    """Raise InputError where `name` is no text that can stand in the name of a file."""
    if not isinstance(name, str) or not name.strip():
        raise InputError(f"name must be a non-empty text, got {shown(name)}")
    if not name.isprintable() or set(name) & set("/\\") or name[0] == "." or len(name) > 120:
        raise InputError(
            "name is used in file names, so it must be printable, without slashes or a leading dot, "
            f"and of at most 120 characters, got {shown(name)}"
        )


def check_size(n_tasks: int, n_depots: int, most: int = MATRIX_NODES) -> None:
    """Raise InputError where an instance of this size could not be held; to be asked before its arrays are made.

    most : nodes it can have, MAX_NODES where a metric names its costs.
    """
    if n_tasks + n_depots > most:
        has = "an instance can have" if most == MAX_NODES else "an instance can have whose costs no metric names"
        raise InputError(f"{shown(n_tasks)} tasks and {shown(n_depots)} depots are more than the {most} nodes {has}")


def _check_by_metric(costs: MetricCosts, instance: Instance) -> None:
    """Raise InputError where costs by a metric are not those of the coordinates."""
    if instance.coordinates is None or not np.array_equal(costs.coordinates, instance.coordinates):
        raise InputError(f"instance {instance.name}: its costs by a metric must be those of its coordinates")
    if instance.travel is not None:
        raise InputError(f"instance {instance.name}: travel needs a matrix of costs, which a metric does not give here")


def _checked_cost(cost: ArrayLike, size: int, name: str) -> Floats:
    try:
        c = np.array(cost, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"instance {name}: cost must be a square matrix of numbers") from None
    if c.shape != (size, size):
        raise InputError(
            f"instance {name}: cost must have shape ({size}, {size}) for n_tasks + n_depots = {size}, got {c.shape}"
        )
    for bad, what in ((np.isnan(c), "not a number"), (np.isinf(c), "infinite"), (c < 0, "negative")):
        if bad.any():
            i, j = np.argwhere(bad)[0]
            raise InputError(f"instance {name}: cost[{i}][{j}] is {what} ({c[i, j]})")
    if np.diagonal(c).any():
        i = int(np.flatnonzero(np.diagonal(c))[0])
        raise InputError(f"instance {name}: cost[{i}][{i}] must be 0 (the diagonal), got {c[i, i]}")
    if c.max() > LARGEST_SUM / size:
        i, j = np.unravel_index(np.argmax(c), c.shape)
        raise InputError(
            f"instance {name}: cost[{i}][{j}] is too large ({c[i, j]}): {size} such costs must add up to at most "
            f"{LARGEST_SUM:g} s"
        )
    c.setflags(write=False)
    return c


def _checked_coordinates(coordinates: ArrayLike, size: int, name: str) -> Floats:
    try:
        xy = np.array(coordinates, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"instance {name}: coordinates must be pairs of numbers [m]") from None
    if xy.shape != (size, 2):
        raise InputError(f"instance {name}: coordinates must have shape ({size}, 2), got {xy.shape}")
    if not np.isfinite(xy).all():
        i = int(np.argwhere(~np.isfinite(xy))[0][0])
        raise InputError(f"instance {name}: coordinates[{i}] is not finite ({xy[i].tolist()})")
    if np.abs(xy).max() > LARGEST_COORDINATE:
        i = int(np.argmax(np.abs(xy).max(axis=1)))
        raise InputError(
            f"instance {name}: coordinates[{i}] is more than {LARGEST_COORDINATE:g} m away ({xy[i].tolist()})"
        )
    xy.setflags(write=False)
    return xy


def _checked_travel(travel: Travel | None, cost: Floats, n_depots: int, name: str) -> Travel | None:
    """Return `travel` where it says more than `cost` does."""
    if travel is None:
        return None
    if not isinstance(travel, Travel):
        raise InputError(f"instance {name}: travel must be a Travel, got {shown(travel)}")
    if travel.n_nodes != len(cost):
        raise InputError(f"instance {name}: travel has {travel.n_nodes} nodes, must have {len(cost)}")
    if len(travel.classes) != n_depots:
        raise InputError(f"instance {name}: travel.classes has {len(travel.classes)} UAVs for {n_depots} depots")
    finite = travel.cost[np.isfinite(travel.cost)]
    if finite.max(initial=0.0) > LARGEST_SUM / len(cost):
        raise InputError(f"instance {name}: travel.cost holds {finite.max()}, too large to add up {len(cost)} of it")
    least = travel.least()
    if not np.array_equal(least, cost):
        i, j = np.argwhere(least != cost)[0]
        raise InputError(
            f"instance {name}: cost[{i}][{j}] is {cost[i, j]}, but the least of that leg's travel.cost is {least[i, j]}"
        )
    return travel if travel.axes else None


def _checked_endurance(endurance: ArrayLike | None, n_depots: int, name: str) -> Floats | None:
    if endurance is None:
        return None
    try:
        limits = np.array(endurance, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"instance {name}: endurance must be a list of numbers [s]") from None
    if limits.shape != (n_depots,):
        raise InputError(f"instance {name}: endurance must be {n_depots} numbers [s], got shape {limits.shape}")
    for k in np.flatnonzero(~(limits > 0)).tolist():
        raise InputError(f"instance {name}: endurance[{k}] must be positive [s], got {limits[k]}")
    limits.setflags(write=False)
    return None if np.isinf(limits).all() else limits
