"""Rows that are not in the paper and cut off no optimum: what `milp` may add to the paper's model.

y_ik = θ_kik + Σ_j θ_jik, 1 where UAV k visits task i (``paper_model.py``).
"""

from __future__ import annotations

import numpy as np
from ortools.sat.python import cp_model
from scipy.sparse.csgraph import floyd_warshall

from formulations.routing.paper_model import PaperModel, Theta
from formulations.routing.symmetries import in_order, is_symmetric, neighbours, used_arcs
from instances import Instance, Routes
from instances.arrays import Ints


def symmetry(paper: PaperModel, instance: Instance) -> None:
    """Break the symmetry of like UAVs at one depot and of symmetric costs: only routes as `in_order` has them.

    y_ik ≤ Σ_{l<i} y_l,k−1 for neighbours k − 1, k of a group: UAV k takes task i only if its predecessor has a
    smaller one. Exchanging routes within a group changes no cost, so an optimum of this order exists.
    Σ_i i·θ_kik ≤ Σ_i i·θ_ikk where costs are symmetric: the first task is smaller than the last.
    """
    for before, k in neighbours(instance):
        for i in instance.tasks:
            paper.model.add(paper.y[i, k] <= sum(paper.y[j, before] for j in range(i)))
    if is_symmetric(instance):
        fly_one_way(paper.model, paper.theta, instance)


def fly_one_way(model: cp_model.CpModel, theta: Theta, instance: Instance) -> None:
    """Fly each tour the way in which its first task is smaller than its last."""
    for k in instance.depots:
        first = sum(i * theta[k, i, k] for i in instance.tasks)
        model.add(first <= sum(i * theta[i, k, k] for i in instance.tasks))


def shortest_ways(costs: Ints, n_tasks: int, k: int) -> tuple[Ints, Ints]:
    """Return the cheapest ways (over any tasks) from depot k to each task and back, shape (n,) each.

    Costs need not obey the triangle inequality, so the direct arc is no bound, but the cheapest way is.
    """
    nodes = [*range(n_tasks), k]
    # +1: in a dense graph csgraph reads 0 as "no arc"; at most n arcs a way, so taking n + 1 off keeps it a bound
    way = floyd_warshall(costs[np.ix_(nodes, nodes)].astype(float) + 1.0).astype(np.int64) - (n_tasks + 1)
    return np.maximum(way[n_tasks, :n_tasks], 0), np.maximum(way[:n_tasks, n_tasks], 0)


def reach(paper: PaperModel, instance: Instance) -> None:
    """Use the way out to a task and back, which its UAV flies in any case.

    C_max ≥ Σ_k (out_ki + back_ik) y_ik for every task i; θ_ijk = 0 where out_ki + c_ijk + back_jk > the incumbent or
    the endurance.
    """
    n, scaled = instance.n_tasks, paper.scaled
    ways = {k: shortest_ways(scaled.uav_cost(k - n), n, k) for k in instance.depots}
    for i in instance.tasks:
        paper.model.add(sum(int(ways[k][0][i] + ways[k][1][i]) * paper.y[i, k] for k in paper.D) <= paper.C_max)
    for (i, j, k), theta in paper.theta.items():
        out, back = ways[k]
        length = scaled.uav_cost(k - n)[i, j] + (out[i] if i != k else 0) + (back[j] if j != k else 0)
        if length > scaled.limits[k - n]:
            paper.model.add(theta == 0)


def hint(paper: PaperModel, instance: Instance, routes: Routes) -> None:
    """Tell CP-SAT to try `routes` first."""
    used = used_arcs(instance, in_order(instance, routes))
    paper.model.clear_hints()
    for key, theta in paper.theta.items():
        paper.model.add_hint(theta, key in used)
    visits = {(j, k) for _, j, k in used}
    for visit, y in paper.y.items():
        paper.model.add_hint(y, visit in visits)
    costs = {k: paper.scaled.uav_cost(k - instance.n_tasks) for k in instance.depots}
    tours = dict.fromkeys(instance.depots, 0)
    for i, j, k in used:
        tours[k] += int(costs[k][i, j])
    paper.model.add_hint(paper.C_max, min(max(tours.values()), paper.scaled.upper))
