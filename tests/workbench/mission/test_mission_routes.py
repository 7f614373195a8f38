"""The routes of a mission carry a bound and a gap."""

from __future__ import annotations

from dataclasses import MISSING, fields
from typing import Any

import pytest

from instances.errors import InputError
from reports.record import Run
from workbench.mission.routes import certificate


def found(objective: float, bound: float | None = None) -> Run:
    named: dict[str, Any] = dict.fromkeys(column.name for column in fields(Run) if column.default is MISSING)
    del named["trace"], named["statistics"], named["own"]
    return Run(**named | {"label": "memetic", "objective": objective, "bound": bound})


def test_the_best_bound_makes_the_gap() -> None:
    assert certificate(found(100.0), {"a": 80.0, "b": 90.0}) == {
        "objective": 100.0, "bound": 90.0, "by": "b", "gap": pytest.approx(0.1), "bounds": {"a": 80.0, "b": 90.0},
    }  # fmt: skip
    assert certificate(found(100.0, 100.0), {"a": 80.0})["by"] == "memetic"
    assert certificate(found(100.0), {"a": 100.0 * (1 + 1e-12)})["gap"] == 0.0


def test_a_bound_above_the_routes_is_an_error() -> None:
    with pytest.raises(InputError, match=r"routes: a claims that no tours are below 101\.0 s, but 100\.0 s were flown"):
        certificate(found(100.0), {"a": 101.0})
