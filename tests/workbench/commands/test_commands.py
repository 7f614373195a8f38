"""The commands on small things: what they print, write and return."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from instances import Instance, makespan, tour_costs
from instances.environment.wind_forecast import Forecast
from instances.files import endings, read_instance, read_routes, write_instance, write_routes
from instances.scenario import read_scenario
from workbench.cli import main

KEYS = (
    "instance",
    "solver",
    "status",
    "objective",
    "bound",
    "gap",
    "elapsed",
    "routes",
    "stopped_by",
    "message",
    "trace",
)


def test_solve_prints_one_object(cli, instance, instance_file, tmp_path):
    code, out, err = cli("solve", instance_file, "--solver", "greedy", "--json", "--out", "r.sol", "--plot", "r.svg")
    found = json.loads(out)
    assert code == 0
    assert set(KEYS) <= set(found)
    assert (found["instance"], found["solver"], found["status"]) == (instance.name, "greedy", "FEASIBLE")
    assert found["objective"] == makespan(instance, found["routes"])
    assert "longest tour" in err
    assert makespan(instance, read_routes(tmp_path / "r.sol", instance)) == found["objective"]
    assert "<svg" in (tmp_path / "r.svg").read_text()


def test_solve_begins_from_given_routes(cli, instance, instance_file, tmp_path):
    """A method that may do no iteration ends no worse than its start."""
    best = json.loads(cli("solve", instance_file, "--solver", "subset-dp", "--json")[1])
    write_routes(best["routes"], instance, tmp_path / "best.sol")
    args = ["--solver", "ga", "--iterations", 0, "--option", "population=2", "--start", "best.sol", "--json"]
    assert json.loads(cli("solve", instance_file, *args)[1])["objective"] == best["objective"]


def test_solve_without_json_is_for_people(cli, instance_file):
    code, out, _ = cli("solve", instance_file, "--solver", "greedy")
    assert code == 0
    assert out.startswith("FEASIBLE: longest tour")
    assert "UAV 1:" in out


def test_solve_counts_the_uavs_that_a_makespan_takes(cli, instance, instance_file, tmp_path):
    alone = [float(tour_costs(instance, routes).max()) for routes in (((0, 1, 2, 3), ()), ((), (3, 2, 1, 0)))]
    args = ["solve", instance_file, "--fewest", "--solver", "subset-dp", "--limit"]
    code, out, err = cli(*args, max(alone), "--json", "--out", "few.sol")
    found = json.loads(out)
    assert (code, found["status"], found["fewest"], found["at_least"]) == (0, "OPTIMAL", 1, 1)
    assert len(found["uavs"]) == 1
    assert "suffice" in err
    assert cli("check", instance_file, "few.sol")[0] == 0
    assert "1 UAV can fly all tasks within" in cli(*args, max(alone))[1]
    code, out, _ = cli(*args, 1e-3)
    assert (code, out.startswith("INFEASIBLE: not even all UAVs")) == (1, True)
    assert "--fewest needs --limit" in cli("solve", instance_file, "--fewest")[2]


def test_solve_says_what_each_uav_uses(cli, instance, instance_file, tmp_path):
    limited = replace(instance, endurance=[1e6, np.inf])
    write_instance(limited, tmp_path / "limited.json")
    args = ["solve", "limited.json", "--solver", "subset-dp"]
    found = json.loads(cli(*args, "--json")[1])
    assert max(found["utilisation"]) == 1
    assert found["endurance_margins"] == [pytest.approx(1 - found["tour_costs"][0] / 1e6), 1]
    assert "% of its endurance left), tasks" in cli(*args)[1]
    assert json.loads(cli("solve", instance_file, "--solver", "greedy", "--json")[1])["endurance_margins"] is None


def test_solve_tells_what_another_uav_or_battery_is_worth(cli, instance, tmp_path):
    alone = makespan(instance, ((0, 1, 2, 3), ()))
    limited = replace(instance, endurance=[0.3 * alone, np.inf])
    write_instance(limited, tmp_path / "limited.json")
    args = ["solve", "limited.json", "--what-if", "--solver", "subset-dp"]
    code, out, err = cli(*args, "--json")
    told = json.loads(out)
    assert code == 0
    assert [(row["change"], row["uav"]) for row in told["changes"]] == [
        ("one more UAV like UAV 0", 0),
        ("one more UAV like UAV 1", 1),
        ("one more battery for UAV 0", 0),
    ]
    for row in told["changes"]:
        gain = told["objective"] - row["objective"]
        assert row["gain_least"] <= gain <= row["gain_most"]
        assert row["gain_least"] == pytest.approx(gain, abs=1e-6 * alone)
    assert "one more battery for UAV 0: longest tour" in err
    assert "--what-if goes without" in cli(*args, "--out", "r.sol")[2]


def test_a_failed_solve_is_a_problem(cli, instance_file, tmp_path):
    code, out, _ = cli("solve", instance_file, "--solver", "misbehaving:Declines", "--out", "r.sol")
    assert code == 1
    assert "prime numbers" in out
    assert not (tmp_path / "r.sol").exists()


def test_check_of_routes(cli, instance, instance_file, tmp_path):
    cli("solve", instance_file, "--solver", "greedy", "--out", "r.sol")
    code, out, _ = cli("check", instance_file, "r.sol")
    assert (code, out.startswith("feasible, longest tour")) == (0, True)
    text = (tmp_path / "r.sol").read_text()
    (tmp_path / "lie.sol").write_text(text.replace("Cost ", "Cost 1"))
    code, out, _ = cli("check", instance_file, "lie.sol")
    assert (code, "but its routes cost" in out) == (1, True)
    (tmp_path / "short.sol").write_text("Route #1: 0 1 1\n")
    code, _, err = cli("check", instance_file, "short.sol")
    assert code == 2
    assert "short.sol" in err
    assert "more faults" in err


@pytest.fixture(scope="session")
def finished_runs(tmp_path_factory):
    """A store of two solvers on three instances, made once."""
    folder = tmp_path_factory.mktemp("finished")
    for seed in range(3):
        assert (
            called("generate", "uniform", "--tasks", 4, "--depots", 2, "--seed", seed, "--out", folder / "given") == 0
        )
    args = ["--solvers", "greedy,subset-dp", "--out", folder / "runs", "--no-report"]
    assert called("compare", folder / "given", *args) == 0
    return folder / "runs"


def called(*args: object) -> int:
    with pytest.raises(SystemExit) as ended:
        main([str(arg) for arg in args])
    return int(ended.value.code or 0)


@pytest.fixture
def runs(finished_runs, tmp_path):
    return shutil.copytree(finished_runs, tmp_path / "runs")


def test_compare_then_status_check_and_report(cli, runs, stored_json, tmp_path):
    assert cli("check", runs)[:2] == (0, "6 runs on 3 instances, 3 lower bounds claimed by subset-dp: all right\n")
    code, out, _ = cli("status", runs)
    assert (code, out.splitlines()[-1]) == (0, "6 of 6 runs stored, 0 missing")
    assert "3 stored: 3 OPTIMAL" in out
    tables = ["--csv", "r.csv", "--latex", "r.tex", "--markdown", "r.md"]
    code, out, _ = cli("report", runs, "--out", "r.html", *tables, "--against", runs, "--fail-on-regression")
    assert code == 0
    assert re.search(r"^subset-dp +quality ", out, re.MULTILINE)
    assert all((tmp_path / f"r.{ending}").stat().st_size > 100 for ending in ("html", "csv", "tex", "md"))

    # what is missing, damaged or false is counted, named and shown
    first, *others = sorted(runs.glob("u*/greedy*.json"))
    first.unlink()
    code, out, _ = cli("status", runs)
    assert (code, out.splitlines()[-1]) == (0, "5 of 6 runs stored, 1 missing")
    others[0].write_text("{")
    code, out, err = cli("status", runs)
    assert (code, out.splitlines()[-1]) == (1, "4 of 6 runs stored, 1 damaged, 1 missing")
    assert others[0].name in err
    lie = json.loads(others[1].read_text())
    others[1].write_text(json.dumps(lie | {"bound": 2 * lie["objective"]}))
    code, out, _ = cli("check", runs)
    assert code == 1
    assert others[0].name in out
    assert others[1].name in out


def test_a_regression_can_fail(cli, runs, tmp_path):
    """A newer store in which a bound contradicts routes is worse than the old one."""
    new = shutil.copytree(runs, tmp_path / "new")
    path = next(new.glob("u*/greedy*.json"))
    run = json.loads(path.read_text())
    path.write_text(json.dumps(run | {"bound": 2 * run["objective"]}))
    code, out, _ = cli("report", "new", "--against", runs, "--fail-on-regression")
    assert (code, "contradiction" in out) == (1, True)


def test_generate_is_reproducible(cli, tmp_path):
    args = [
        "generate",
        "uniform",
        "--tasks",
        5,
        "--depots",
        2,
        "--count",
        2,
        "--seed",
        3,
        "--set",
        "wind=shear",
        "--out",
    ]
    code, out, _ = cli(*args, "one")
    paths = out.split()
    assert (code, len(paths)) == (0, 2)
    cli(*args, "two")
    for path in map(tmp_path.__truediv__, paths):
        assert path.read_bytes() == (tmp_path / "two" / path.name).read_bytes()
        drawn = read_instance(path)
        assert (drawn.n_tasks, drawn.n_depots) == (5, 2)
        assert drawn.asymmetry > 0


def test_generate_writes_a_changing_wind_as_a_forecast(cli, tmp_path):
    pytest.importorskip("xarray")
    asked = ("--tasks", 4, "--depots", 2, "--forecast", 600, "--out", "given")
    assert cli("generate", "wind-front", *asked)[0] == 0
    wind = read_scenario(tmp_path / "given" / "wind-front-n4-m2-s0" / "scenario.toml").wind
    assert isinstance(wind, Forecast)
    assert wind.times[1] == 600.0
    code, _, err = cli("generate", "uniform", *asked)
    assert (code, "does not change with time" in err) == (2, True)


def test_convert_there_and_back(cli, instance, instance_file, tmp_path):
    assert cli("convert", instance_file, "a.json.gz")[0] == 0
    assert cli("convert", "a.json.gz", "b.json")[0] == 0
    assert read_instance(tmp_path / "b.json").digest == instance.digest


def test_convert_says_what_it_reads_and_writes(cli):
    rows = [
        re.split("  +", line.strip()) for line in cli("convert", "--help")[1].splitlines() if line.startswith("  .")
    ]
    said = {ending: (row[-2], row[-1]) for row in rows for ending in row[0].split()}
    read_too = {ending: ("yes", "yes" if ending in endings(written=True) else "no") for ending in endings()}
    assert said == read_too


def test_what_convert_leaves_out_is_said(cli, tmp_path, caplog):
    rows = "".join(f"{k} {k * k} 0\n" for k in range(1, 4))
    text = f"DIMENSION: 3\nCAPACITY: 1\nEDGE_WEIGHT_TYPE: EUC_2D\nNODE_COORD_SECTION\n{rows}"
    (tmp_path / "a.vrp").write_text(f"{text}DEMAND_SECTION\n1 0\n2 1\n3 1\nDEPOT_SECTION\n1\n-1\nEOF\n")
    code, out, _ = cli("convert", "a.vrp", "b.json")
    assert (code, out) == (0, "")
    # pytest takes what is logged; outside it goes to stderr
    assert caplog.messages == ["a.vrp: left out, as the min-max problem has no place for it: CAPACITY, DEMAND_SECTION"]
    assert read_instance(tmp_path / "b.json").provenance["ignored"] == ["CAPACITY", "DEMAND_SECTION"]


def test_routes_as_a_tour_of_tsplib(cli, instance_file, tmp_path):
    assert cli("solve", instance_file, "--solver", "greedy", "--out", "r.tour")[0] == 0
    assert cli("solve", instance_file, "--solver", "greedy", "--out", "r.sol")[0] == 0
    told = [cli("check", instance_file, name) for name in ("r.tour", "r.sol")]
    assert told[0] == told[1]
    assert told[0][0] == 0


def test_lists_of_solvers_and_families(cli):
    solvers = json.loads(cli("solvers", "--json")[1])
    assert solvers["ga"]["options"]["population"] == 400
    assert (solvers["greedy"]["proves"], solvers["milp"]["proves"]) == (False, True)
    assert "population = 400" in cli("solvers")[1]
    families = json.loads(cli("families", "--json")[1])
    assert "shear" in families["uniform"]["parameters"]["wind"]["choices"]
    assert "uniform: " in cli("families")[1]


def test_help_of_every_command(cli):
    code, out, _ = cli("--help")
    assert code == 0
    for name in ("generate", "solve", "check", "compare", "report", "convert", "status", "solvers", "families"):
        assert f"  {name} " in out
        assert cli(name, "--help")[0] == 0


@pytest.mark.parametrize("size", [1e-6, 1e9])
def test_extreme_costs_go_through(cli, tmp_path, size):
    rng = np.random.default_rng(1)
    cost = size * rng.uniform(1, 2, (5, 5))
    np.fill_diagonal(cost, 0)
    write_instance(Instance("extreme", cost, 3, 2), tmp_path / "extreme.json")
    assert cli("compare", "extreme.json", "--solvers", "greedy,subset-dp", "--out", "runs", "--no-report")[0] == 0
    assert cli("check", "runs")[0] == 0


def test_libraries_start_one_thread_unless_the_user_says_otherwise():
    code = "import os; from workbench.cli import main\ntry: main(['solvers'])\nexcept SystemExit: pass\n"
    code += "print(os.environ['OPENBLAS_NUM_THREADS'], os.environ['OMP_NUM_THREADS'])"
    own = {key: value for key, value in os.environ.items() if not key.endswith("_NUM_THREADS")}
    done = subprocess.run(
        [sys.executable, "-c", code], env={**own, "OMP_NUM_THREADS": "3"}, capture_output=True, text=True, check=True
    )
    assert done.stdout.split()[-2:] == ["1", "3"]
