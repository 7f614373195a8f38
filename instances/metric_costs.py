"""Costs that are computed where they are asked for, from coordinates, where (n+m)² numbers would fill the memory.

They are read as a matrix is: ``cost[i, j]``, ``cost[i]``, ``cost[:, j]``, with numbers, lists of nodes or slices.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, NoReturn

import numpy as np

from instances.arrays import Floats, Ints
from instances.errors import InputError, shown

MATRIX_NODES = 20_000
"""Most nodes n + m of which there is a matrix: it fills 3.2 GB."""


class MetricCosts:
    """What legs cost [s] by a metric (`instances.metrics`) on coordinates (N, 2) [m], one leg at a time.

    metric : as it stands in an instance file. said : the same as declared.
    symmetric : whether a leg costs the same both ways.

    Raises InputError for a metric that is not known or only gives a matrix, and, in a wind, where legs may meet one
    as strong as the ground speed or have no arc.
    """

    def __init__(self, metric: Mapping[str, Any], coordinates: Floats) -> None:
        from instances.declared.instance import WindMetricTable  # here: few instances need it, and it takes its time
        from instances.metrics import declared_metric, pairs_by
        from instances.wind_metric import check_wind

        self.metric, self.coordinates = dict(metric), coordinates
        self.said = declared_metric(metric)
        between = pairs_by(self.said)
        if between is None:
            raise InputError(
                f"cost: of more than {MATRIX_NODES} nodes the metric {shown(metric['metric'])} gives no costs that can "
                "be computed leg by leg"
            )
        self._between: Callable[[Floats, Floats], Floats] = between
        self.symmetric = self.wind is None
        if isinstance(self.said, WindMetricTable):
            corners = np.array([coordinates.min(axis=0), coordinates.max(axis=0)])
            check_wind(corners, self.said.airspeed, self.wind)
            between(*corners)  # where there is an arc across, there is one between any two

    def __reduce__(self) -> tuple[type[MetricCosts], tuple[Any, ...]]:
        """Pickle through the constructor."""
        return MetricCosts, (self.metric, self.coordinates)

    @cached_property
    def wind(self) -> Any:
        """The WindField of the metric, None where it has none."""
        from pathlib import Path

        from instances.environment.wind_table import wind_of

        said = getattr(self.said, "wind", None)
        return None if said is None else wind_of(said, Path())

    @property
    def shape(self) -> tuple[int, int]:
        """(N, N), that of the matrix this stands for."""
        return len(self.coordinates), len(self.coordinates)

    def __len__(self) -> int:
        return len(self.coordinates)

    def __getitem__(self, key: Any) -> Any:
        """Return costs [s] as a matrix would; of a pair with a slice every row meets every column."""
        i, j = key if isinstance(key, tuple) else (key, slice(None))
        if i is None or j is None:  # whoever wants more axes wants the matrix
            self.__array__()
        nodes = np.arange(len(self))
        rows, columns = nodes[i], nodes[j]
        if np.ndim(rows) and np.ndim(columns) and (isinstance(i, slice) or isinstance(j, slice)):
            rows = rows[:, None]
        return self.legs(rows, columns)

    def legs(self, i: Ints, j: Ints) -> Floats:
        """Return c_ij [s] of nodes that broadcast."""
        return self._between(self.coordinates[i], self.coordinates[j])

    def __array__(self, *args: Any, **options: Any) -> NoReturn:
        """Refuse to become a matrix."""
        raise InputError(
            f"the costs of {len(self)} nodes by the metric {shown(self.metric['metric'])} are computed leg by leg: a "
            f"matrix is made of at most {MATRIX_NODES} nodes, and this asks for one"
        )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, MetricCosts) or self.described != other.described:
            return False
        return np.array_equal(self.coordinates, other.coordinates)

    __hash__ = None  # type: ignore[assignment]  # as an array

    @property
    def described(self) -> str:
        """The metric as text, the same for the same metric."""
        return json.dumps(self.metric, sort_keys=True)
