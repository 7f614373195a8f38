"""`workbench solve --risk`: of several seeds the routes that are best over an ensemble."""

from __future__ import annotations

import json
from types import SimpleNamespace

import pytest

from instances.wind_ensemble import Spread
from workbench.commands import solve_risk
from workbench.jobs.job import Job


@pytest.mark.parametrize(("risk", "seed"), [("mean", 1), ("worst", 2), ("cvar", 2)])
def test_the_routes_of_least_risk_are_taken(monkeypatch, instance, tmp_path, capsys, risk, seed):
    spreads = {7: (5.0, 5.0), 8: (1.0, 6.0), 9: (4.0, 4.0)}
    seen = []

    def solved(problem, job, given):
        seen.append(job.seed)
        routes = ((0, 1), (2, 3)) if job.seed in spreads else None
        return SimpleNamespace(own={"routes": routes}, objective=3.0, seed=job.seed)

    monkeypatch.setattr(solve_risk, "SEEDS", 4)
    monkeypatch.setattr(solve_risk, "run", solved)
    monkeypatch.setattr(solve_risk, "spread_beside", lambda beside, given, routes: Spread(3.0, spreads[seen[-1]]))
    monkeypatch.setattr(solve_risk, "as_object", lambda result, given: {"seed": result.seed})
    job = Job("", "greedy", {}, 7, 1.0, 1)
    assert solve_risk.run_by_risk(instance, job, risk, as_json=True, out=tmp_path / "r.sol", beside=tmp_path / "a.json")
    assert seen == [7, 8, 9, 10]
    assert json.loads(capsys.readouterr().out)["seed"] == 7 + seed
    assert (tmp_path / "r.sol").exists()


def test_without_an_ensemble_or_with_other_tasks_it_is_refused(cli, instance_file):
    code, _, err = cli("solve", instance_file, "--risk", "mean", "--what-if")
    assert (code, "--risk goes without" in err) == (2, True)
    code, _, err = cli("solve", instance_file, "--solver", "greedy", "--risk", "mean")
    assert (code, "--risk needs an ensemble" in err) == (2, True)
