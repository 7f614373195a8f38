"""`workbench solve --risk`: of several seeds the routes that are best over an ensemble, and what a search finds on."""

from __future__ import annotations

import json
from types import SimpleNamespace

import pytest

from instances import tour_costs, wind_ensemble
from instances.wind_ensemble import Ensemble, Spread
from reports.record import Run
from workbench import risk as by_risk
from workbench.commands import solve_risk
from workbench.jobs.job import Job

FOUND = {7: (5.0, 5.0), 8: (1.0, 6.0), 9: (4.0, 4.0)}
"""Seed → makespans in two members."""
ROUTES = {7: ((0, 1), (2, 3)), 8: ((1, 0), (2, 3)), 9: ((0, 1), (3, 2))}
BETTER, WORSE = ((0,), (1, 2, 3)), ((), (0, 1, 2, 3))


@pytest.fixture
def searched(monkeypatch, instance, tmp_path, capsys):
    """Return what `--risk` prints where the search finds `candidates`."""

    def solved(problem, job, given):
        routes = ROUTES.get(job.seed)
        own = problem.own_columns(given, routes)
        return Run(problem="routing", instance=problem.describe(given), solver="x", options={}, label="x",
                   seed=job.seed, time_limit=job.time_limit, threads=1, iterations=None, proves=False,
                   status="OPTIMAL", objective=3.0, bound=1.0, elapsed=0.0, stopped_by="proof", message="",
                   tolerance=0.0, claimed_objective=None, prepare_elapsed=None, wall_elapsed=None, cpu_seconds=None,
                   peak_memory=None, environment="", code="", revision="", created="", own=own)  # fmt: skip

    def judged(paths, routes, *others):
        routes = tuple(map(tuple, routes))
        known = {ROUTES[seed]: members for seed, members in FOUND.items()} | {BETTER: (0.5, 0.5), WORSE: (9.0, 9.0)}
        return Spread(3.0, known[routes])

    def call(risk, candidates):
        monkeypatch.setattr(by_risk, "SEEDS", 4)
        monkeypatch.setattr(by_risk, "run", solved)
        monkeypatch.setattr(solve_risk, "_ensemble", lambda given, beside: Ensemble(None, None, 20.0))
        monkeypatch.setattr(by_risk, "member_costs", lambda *given: (None, None))
        monkeypatch.setattr(by_risk, "routes_of_less_risk", lambda *given, **how: candidates)
        monkeypatch.setattr(wind_ensemble, "spread", judged)
        job, out = Job("", "greedy", {}, 7, 10.0, 1), tmp_path / "r.sol"
        assert solve_risk.run_by_risk(instance, job, risk, as_json=True, out=out, beside=tmp_path / "a.json")
        assert out.exists()
        return SimpleNamespace(**json.loads(capsys.readouterr().out))

    return call


@pytest.mark.parametrize(("risk", "seed"), [("mean", 8), ("worst", 9), ("cvar", 9)])
def test_the_routes_of_least_risk_are_taken(searched, risk, seed):
    told = searched(risk, [WORSE])
    assert (told.seed, told.status) == (seed, "OPTIMAL")
    assert told.ensemble == told.chosen, "what the search found is more by the spread"


def test_what_the_search_finds_is_judged_anew_and_proved_no_more(searched, instance):
    told = searched("worst", [WORSE, BETTER, ((0, 0), (1, 2, 3))])
    assert told.routes == [[0], [1, 2, 3]]
    assert (told.status, told.ensemble["worst"], told.chosen["worst"]) == ("FEASIBLE", 0.5, 4.0)
    assert told.objective == pytest.approx(tour_costs(instance, BETTER).max())


def test_without_an_ensemble_or_with_other_tasks_it_is_refused(cli, instance_file):
    code, _, err = cli("solve", instance_file, "--risk", "mean", "--what-if")
    assert (code, "--risk goes without" in err) == (2, True)
    code, _, err = cli("solve", instance_file, "--solver", "greedy", "--risk", "mean")
    assert (code, "--risk needs an ensemble" in err) == (2, True)
