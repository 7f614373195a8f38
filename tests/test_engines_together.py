"""The engines work together in one process, whichever is imported first (see the comment in pyproject.toml)."""

from __future__ import annotations

import itertools
import subprocess
import sys

import pytest

# Each snippet imports one engine, solves a model of known optimum in it and stops with an assertion otherwise.
ENGINES = {
    "cvxpy": """
import cvxpy as cp
x = cp.Variable(2)
lp = cp.Problem(cp.Maximize(x[0] + 2 * x[1]), [x >= 0, x[0] + x[1] <= 4, x[1] <= 3])
assert abs(lp.solve(solver="HIGHS") - 7) < 1e-6, lp.value
y = cp.Variable(2)
qp = cp.Problem(cp.Minimize(cp.sum_squares(y - [1, 2])), [cp.sum(y) == 1])
assert abs(qp.solve(solver="CLARABEL") - 2) < 1e-6, qp.value
""",
    "ortools": """
from ortools.sat.python import cp_model
model = cp_model.CpModel()
a, b = model.new_int_var(0, 9, "a"), model.new_int_var(0, 9, "b")
model.add(2 * a + 3 * b <= 12)
model.maximize(3 * a + 4 * b)
solver = cp_model.CpSolver()
assert solver.solve(model) == cp_model.OPTIMAL and solver.objective_value == 18, solver.objective_value
""",
    "casadi": """
import casadi
z = casadi.SX.sym("z", 2)
rosenbrock = (1 - z[0]) ** 2 + 100 * (z[1] - z[0] ** 2) ** 2
nlp = casadi.nlpsol("nlp", "ipopt", {"x": z, "f": rosenbrock}, {"print_time": False, "ipopt.print_level": 0})
assert abs(nlp(x0=[-1.2, 1])["x"].full() - 1).max() < 1e-6
""",
    "highspy": """
import highspy
h = highspy.Highs()
h.silent()
i, j = h.addIntegral(lb=0, ub=10), h.addIntegral(lb=0, ub=10)
h.addConstr(2 * i + 2 * j <= 21)
h.maximize(i + j)
assert abs(h.getObjectiveValue() - 10) < 1e-9, h.getObjectiveValue()
""",
    "pyscipopt": """
from pyscipopt import Model
scip = Model()
scip.hideOutput()
u, v = scip.addVar(vtype="I", ub=10), scip.addVar(vtype="I", ub=10)
scip.addCons(2 * u + 2 * v <= 21)
scip.setObjective(u + v, "maximize")
scip.optimize()
assert scip.getStatus() == "optimal" and abs(scip.getObjVal() - 10) < 1e-9
""",
}


@pytest.mark.parametrize("order", ["forwards", "backwards"])
def test_all_engines_solve_in_one_process(order: str) -> None:
    names = list(ENGINES) if order == "forwards" else list(ENGINES)[::-1]
    _run("\n".join(ENGINES[name] for name in names))


@pytest.mark.slow
@pytest.mark.parametrize("pair", list(itertools.permutations(ENGINES, 2)), ids="-".join)
def test_each_ordered_pair_solves_in_one_process(pair: tuple[str, str]) -> None:
    _run("\n".join(ENGINES[name] for name in pair))


@pytest.mark.parametrize("pair", [("cvxpy", "ortools"), ("ortools", "cvxpy"), ("ortools", "highspy")], ids="-".join)
def test_the_pairs_known_to_clash_solve_in_one_process(pair: tuple[str, str]) -> None:
    _run("\n".join(ENGINES[name] for name in pair))


def _run(code: str) -> None:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
