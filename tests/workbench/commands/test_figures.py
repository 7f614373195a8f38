"""The paper's explaining figures: paths through random tasks, and a field over a line before and after sensing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.collections import PolyCollection

from formulations.task_location.tour import open_path
from workbench.commands import figures


def test_an_open_path_visits_every_point_once_and_does_not_come_back() -> None:
    points = np.array([[0.0, 0.0], [30.0, 0.0], [10.0, 0.0], [20.0, 0.0], [40.0, 0.0]])
    assert open_path(points) in ([0, 2, 3, 1, 4], [4, 1, 3, 2, 0])
    assert open_path(points[:1]) == [0]


def test_fig_1_has_a_path_through_all_tasks_of_each_set() -> None:
    drawn = figures.random_paths(1, {12: "normal", 3: "underfitted"})
    for axes, n in zip(drawn.figure.axes, (12, 3), strict=True):
        ((line,), (dots,)) = axes.lines, axes.collections
        tasks = np.asarray(dots.get_offsets())
        assert axes.get_title().startswith(f"{n} tasks")
        assert axes.get_xlim() == (0.0, 100.0)
        assert ((tasks >= 0) & (tasks <= 100)).all()
        assert sorted(map(tuple, line.get_xydata())) == sorted(map(tuple, tasks))
        assert len(line.get_xydata()) == n


def test_fig_2_narrows_the_band_at_the_readings() -> None:
    left, right = figures.sensing(0).figure.axes

    def half_width(axes: object, x: float) -> float:
        *_, band = [c for c in axes.collections if isinstance(c, PolyCollection)]  # type: ignore[attr-defined]
        corners = band.get_paths()[0].vertices
        return float(np.ptp(corners[np.isclose(corners[:, 0], x, atol=0.02), 1]) / 2)

    task = 0.5 * figures.LINE / figures.READINGS
    between = figures.LINE / figures.READINGS
    assert half_width(left, 2.0) == pytest.approx(2.0)
    assert half_width(right, round(task, 1)) < 0.25
    assert half_width(right, round(task, 1)) < half_width(right, round(between, 1)) < 2.0
    assert "nats gained" in right.get_title()


def test_both_are_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(figures, "random_paths", lambda seed: figures.sensing(seed))
    done = CliRunner().invoke(figures.command, ["--out", str(tmp_path / "made"), "--format", "png"])
    assert done.exit_code == 0
    assert (tmp_path / "made" / "fig2.png").read_bytes().startswith(b"\x89PNG")
    assert "Uncertainty before and after sensing" in done.output
