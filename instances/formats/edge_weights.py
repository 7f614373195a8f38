"""TSPLIB edge weights: the matrix from an EDGE_WEIGHT_SECTION, or the metric an EDGE_WEIGHT_TYPE names.

Source: G. Reinelt, TSPLIB 95, 1995, §1.2 and §2. EUC_2D_FLOAT (unrounded) is an addition in use for min-max mTSP.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from instances.arrays import Floats
from instances.errors import InputError, shown, suggestion
from instances.instance import Instance
from instances.metrics import metric_cost

METRIC_OF: dict[str, dict[str, Any]] = {
    "EUC_2D": {"metric": "euclidean", "rounding": "nearest"},
    "CEIL_2D": {"metric": "euclidean", "rounding": "up"},
    "FLOOR_2D": {"metric": "euclidean", "rounding": "down"},
    "EUC_2D_FLOAT": {"metric": "euclidean"},
    "EUC_3D": {"metric": "euclidean", "rounding": "nearest"},
    "MAN_2D": {"metric": "manhattan", "rounding": "nearest"},
    "MAN_3D": {"metric": "manhattan", "rounding": "nearest"},
    "MAX_2D": {"metric": "maximum", "rounding": "nearest"},
    "MAX_3D": {"metric": "maximum", "rounding": "nearest"},
    "ATT": {"metric": "att"},
    "GEO": {"metric": "geo"},
}
"""EDGE_WEIGHT_TYPE → its metric (`instances.metrics`); those that end in 3D take three coordinates."""

WRITTEN = ("EUC_2D", "CEIL_2D", "MAN_2D", "MAX_2D", "ATT", "GEO")
"""EDGE_WEIGHT_TYPEs of TSPLIB that our costs can be written as: all of them whole numbers."""

FORMATS = (
    "FULL_MATRIX",
    *(
        f"{half}_{diagonal}{order}"
        for order in ("ROW", "COL")
        for diagonal in ("", "DIAG_")
        for half in ("UPPER", "LOWER")
    ),
)
"""EDGE_WEIGHT_FORMAT of explicit weights."""


def metric_of(edge_weight_type: str) -> dict[str, Any]:
    """Return the metric of an EDGE_WEIGHT_TYPE; InputError where it is none we know."""
    if edge_weight_type not in METRIC_OF:
        known = ("EXPLICIT", *METRIC_OF)
        raise InputError(
            f"EDGE_WEIGHT_TYPE {shown(edge_weight_type)} is not supported{suggestion(edge_weight_type, known)} "
            f"(supported: {', '.join(known)})"
        )
    return METRIC_OF[edge_weight_type]


def type_of(instance: Instance) -> str | None:
    """Return the EDGE_WEIGHT_TYPE in WRITTEN that gives the costs of `instance` exactly; None where none does."""
    metric = instance.provenance.get("metric") if instance.by_metric is None else instance.by_metric.metric
    kind = next((each for each in WRITTEN if METRIC_OF[each] == metric), None)
    if kind is None or instance.coordinates is None:
        return None
    if instance.by_metric is not None:
        return kind
    return kind if np.array_equal(metric_cost(METRIC_OF[kind], instance.coordinates), instance.cost) else None


def explicit_weights(lines: list[str], edge_weight_format: str, size: int) -> Floats:
    """Return the (size, size) matrix in the `lines` of an EDGE_WEIGHT_SECTION; line breaks mean nothing in TSPLIB."""
    if edge_weight_format not in FORMATS:
        raise InputError(
            f"EDGE_WEIGHT_FORMAT {shown(edge_weight_format)} is not supported"
            f"{suggestion(edge_weight_format, FORMATS)} (supported: {', '.join(FORMATS)})"
        )
    words = " ".join(lines).split()
    try:
        weights = np.array(words, dtype=np.float64)
    except ValueError:
        bad = next(word for word in words if not _is_number(word))
        raise InputError(f"EDGE_WEIGHT_SECTION holds {shown(bad)}, which is not a number") from None
    full = edge_weight_format == "FULL_MATRIX"
    diagonal = "DIAG" in edge_weight_format
    expected = size * size if full else size * (size + (1 if diagonal else -1)) // 2
    if weights.size != expected:
        raise InputError(
            f"EDGE_WEIGHT_SECTION holds {weights.size} numbers, must hold {expected} "
            f"({edge_weight_format} of DIMENSION {size})"
        )
    if full:
        return weights.reshape(size, size)
    # the columns of one triangle are the rows of the other
    upper = edge_weight_format.startswith("UPPER") == edge_weight_format.endswith("ROW")
    matrix = np.zeros((size, size))
    matrix[np.triu_indices(size, 0 if diagonal else 1) if upper else np.tril_indices(size, 0 if diagonal else -1)] = (
        weights
    )
    return np.maximum(matrix, matrix.T) if (weights >= 0).all() else matrix + matrix.T - np.diag(np.diagonal(matrix))


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
