"""Planners of other libraries: what is made of their plans, and why they are declined. Stand-ins take their places."""

from __future__ import annotations

import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from shapely import Polygon

from formulations.kernel import SquaredExponential
from formulations.limits import Limits
from formulations.surveying import entropy_and_distance, sparse_gp
from formulations.surveying.entropy_and_distance import EntropyAndDistance
from formulations.surveying.problem import Sensor, SurveyProblem, length_of, readings
from formulations.surveying.sparse_gp import SparseGp, fitted
from formulations.surveying.verification import tour_faults
from instances.environment.region import Region

DEPOTS = np.array([[500.0, 500.0], [5500.0, 4500.0]])


def problem(length: float = 14_000.0, region: Region | None = None) -> SurveyProblem:
    """Return two UAVs over 6 by 5 km."""
    given = SquaredExponential(30.0, (2000.0, 2000.0))
    return SurveyProblem(region or Region.rectangle(6000.0, 5000.0), DEPOTS, length, 500.0, given, 1.0)


def faults(given: SurveyProblem, tours: list[np.ndarray]) -> list[str]:
    return tour_faults(given, tours, [readings(tour, given.spacing) for tour in tours])


@pytest.mark.parametrize("planner", [SparseGp(), EntropyAndDistance()])
def test_a_library_that_is_missing_or_cannot_run_is_a_reason(planner, monkeypatch):
    for module in (sparse_gp, entropy_and_distance):
        monkeypatch.setattr(module, "find_spec", lambda name: None)
    assert "is not installed" in planner.accepts(problem())
    for module in (sparse_gp, entropy_and_distance):
        monkeypatch.setattr(module, "find_spec", lambda name: name)
    if isinstance(planner, EntropyAndDistance):
        assert "needs numpy below 2" in planner.accepts(problem())
        return
    assert planner.accepts(problem()) is None
    bent = Region(Polygon([(0, 0), (6000, 0), (6000, 5000), (3000, 500), (0, 5000)]))
    assert "convex" in planner.accepts(problem(region=bent))


def test_a_plan_is_brought_inside_and_shrunk_no_more_than_it_must():
    given, depot = problem(), DEPOTS[0]
    fits = depot + np.array([[0, 0], [3000, 0], [3000, 3000], [0, 0]])
    assert fitted(given, fits) == pytest.approx(fits, abs=1e-9)
    long = depot + np.array([[0, 0], [5000, 0], [5000, 4000], [0, 4000], [0, 0]])
    assert length_of(fitted(given, long)) == pytest.approx(given.length, rel=1e-8)
    stray = depot + np.array([[0, 0], [0, 3000], [-700, 3000], [0, 0]])
    assert fitted(given, stray)[2] == pytest.approx([0.0, 3500.0])
    assert faults(given, [fitted(given, long), fitted(given, stray - depot + DEPOTS[1])]) == []


def test_sgptools_is_asked_in_quarters_of_a_length_scale(monkeypatch):
    given, asked = problem(), {}

    def run_tsp(nodes, **said):
        asked.update(said)
        corner = np.array([[12.0, 9.0]] * 3)
        return np.stack([np.concatenate([d[None], corner, d[None]]) for d in said["start_nodes"]]), None

    class Method:
        def __init__(self, count, targets, kernel, noise_variance, **said):
            asked.update(said, kernel=kernel, targets=targets)

        def optimize(self, **said):
            paths = asked["X_init"].reshape(2, -1, 2)
            return np.stack([np.concatenate([d[None], p, d[None]]) for d, p in zip(DEPOTS / 500.0, paths, strict=True)])

    library = SimpleNamespace(
        run_tsp=run_tsp,
        get_inducing_pts=lambda data, count, seed: data[:count],
        IPPTransform=lambda **said: asked.update(said),
        RBF=lambda variance, lengthscales: (variance, list(lengthscales)),
        ContinuousSGP=Method,
    )
    monkeypatch.setattr(sparse_gp, "_library", lambda: library)
    monkeypatch.setattr(sparse_gp, "closed_at", lambda transform, depots: transform)
    tours = SparseGp(waypoints=3).plan(given, Sensor(len, 1.0, 0), limits=Limits(), seed=0)
    assert asked["distance_budget"] == asked["max_dist"] == 28.0
    assert asked["kernel"] == (900.0, [4.0, 4.0])
    assert asked["targets"].max() <= 12.0
    assert faults(given, tours) == []


def test_pypolo_goes_on_while_there_is_a_way_home(monkeypatch):
    class Stand:
        """Asks a robot as PyPolo does; the score is the entropy's alone."""

        def __init__(self, extent, draws, count, robot):
            self.extent, self.draws, self.count, self.robot = extent, draws, count, robot

        def get(self, model):
            x0, x1, y0, y1 = self.extent
            places = self.draws.uniform((x0, y0), (x1, y1), (self.count, 2))
            self.robot.goal_states.append(places[np.argmax(model(places)[1])])
            while self.robot.has_goal:
                self.robot.update(*self.robot.control())
            return self.robot.commit_data()

    strategies = ModuleType("pypolo.strategies")
    strategies.MyopicPlanning = Stand
    monkeypatch.setitem(sys.modules, "pypolo", ModuleType("pypolo"))
    monkeypatch.setitem(sys.modules, "pypolo.strategies", strategies)
    given = problem()
    tours = EntropyAndDistance(candidates=50).plan(given, Sensor(len, 1.0, 0), limits=Limits(), seed=1)
    assert faults(given, tours) == []
    assert min(map(len, tours)) > 3
    assert max(map(length_of, tours)) > 0.5 * given.length
