r"""The paper's MILP of the MMMDMTSP on CP-SAT, equation by equation.

Source: ``ipp_wind.tex``, §Mathematical Formulation (after Kivelevitch et al. 2014). T are the tasks, D the depots, one
UAV at each, E = (V × V) \ (D × D); θ_ijk = 1 where UAV k flies the arc (i, j). Nodes are numbered from 0 here.

    costsum   C_k = Σ_j θ_kjk c_kj + Σ_i Σ_j θ_ijk c_ij + Σ_i θ_ikk c_ik
    c_max     minimise C_max
    const1    Σ_k θ_kik + Σ_j Σ_k θ_jik = 1                                 every i ∈ T
    const2    θ_kik + Σ_j θ_jik − (θ_ikk + Σ_j θ_ijk) = 0                   every i ∈ T, k ∈ D
    const3    Σ_i θ_kik ≤ 1                                                 every k ∈ D
    const4    Σ_i θ_kik − Σ_i θ_ikk = 0                                     every k ∈ D
    const5    C_k ≤ C_max                                                   every k ∈ D
    const6    Σ_{i∈S} Σ_{j∈S} θ_ijk ≤ |S| − 1                               every k ∈ D, S ⊆ T, |S| ≥ 2

and, for short, y_ik = θ_kik + Σ_j θ_jik, which is 1 where UAV k visits task i.

Two remarks. The paper lets |S| run to n − 1; |S| = n is needed too, or a cycle through all tasks and no depot passes
const1–const5. A UAV never uses another one's depot, so θ_ijk with i or j in D \ {k} is not made, and neither is θ_iik,
which the paper sets to zero.

Where UAVs differ, costsum has the c_ijk of UAV k; const5 forbids legs it cannot fly, which are scaled to more than
C_max can be. Where endurance is limited, there is one row more:

    endurance   C_k ≤ L_k                                                   every k ∈ D
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from ortools.sat.python import cp_model
from ortools.sat.python.cp_model import LinearExpr

from formulations.routing.scaling import ScaledCosts
from formulations.routing.subtours import Arc
from instances import Instance

Theta = dict[tuple[int, int, int], cp_model.IntVar]
"""``theta[i, j, k]``, the paper's θ_ijk; i, j and k are node numbers, k ∈ D."""


class PaperModel:
    """θ, C_max and eqs. const1–const5 of one instance; const6 is added when a set S is found.

    model : the CP-SAT model.
    y : ``y[i, k]``, the y_ik above. The rows that are not the paper's are written in it: they are shorter, and CP-SAT
        has something to branch on that settles many θ at once.
    C_max : the integer objective, the longest scaled tour, between 0 and the incumbent.
    """

    def __init__(self, instance: Instance, scaled: ScaledCosts) -> None:
        self.T, self.D = instance.tasks, instance.depots
        self.scaled = scaled
        self.model = cp_model.CpModel()
        self.theta: Theta = {
            (i, j, k): self.model.new_bool_var(f"theta[{i},{j},{k}]") for k in self.D for i, j in self.edges(k)
        }
        self.y = {(i, k): self.model.new_bool_var(f"y[{i},{k}]") for i in self.T for k in self.D}
        self.C_max = self.model.new_int_var(0, scaled.upper, "C_max")
        self.model.minimize(self.C_max)  # c_max
        for i, k in self.y:
            self.model.add(self.entering(i, k) == self.y[i, k])
        for i in self.T:
            self.model.add(LinearExpr.sum(*(self.entering(i, k) for k in self.D)) == 1)  # const1
        for i, k in self.y:
            self.model.add(self.entering(i, k) - self.leaving(i, k) == 0)  # const2
        out = [LinearExpr.sum(*(self.theta[k, i, k] for i in self.T)) for k in self.D]
        back = [LinearExpr.sum(*(self.theta[i, k, k] for i in self.T)) for k in self.D]
        for leaves in out:
            self.model.add(leaves <= 1)  # const3
        for leaves, returns in zip(out, back, strict=True):
            self.model.add(leaves - returns == 0)  # const4
        for k, limit in zip(self.D, scaled.limits.tolist(), strict=True):
            self.model.add(self.costsum(k) <= self.C_max)  # const5
            if limit < scaled.upper:
                self.model.add(self.costsum(k) <= limit)  # endurance

    def edges(self, k: int) -> list[Arc]:
        """Return the arcs of E that UAV k can use."""
        inner = [(i, j) for i in self.T for j in self.T if i != j]
        return [(k, i) for i in self.T] + inner + [(i, k) for i in self.T]

    def entering(self, i: int, k: int) -> LinearExpr:
        """Return θ_kik + Σ_j θ_jik."""
        return LinearExpr.sum(self.theta[k, i, k], *(self.theta[j, i, k] for j in self.T if j != i))

    def leaving(self, i: int, k: int) -> LinearExpr:
        """Return θ_ikk + Σ_j θ_ijk."""
        return LinearExpr.sum(self.theta[i, k, k], *(self.theta[i, j, k] for j in self.T if j != i))

    def costsum(self, k: int) -> LinearExpr:
        """Eq. costsum: the scaled C_k."""
        arcs, cost = self.edges(k), self.scaled.uav_cost(self.D.index(k))
        return LinearExpr.weighted_sum([self.theta[i, j, k] for i, j in arcs], [int(cost[i, j]) for i, j in arcs])

    def const6(self, S: Sequence[int]) -> None:
        """Eq. const6 for the set S and every UAV: no subtour within S."""
        for k in self.D:
            self.model.add(self.within(S, k) <= len(S) - 1)

    def const6_depot_linked(self, S: Sequence[int]) -> None:
        """The stronger form of const6 for S, every UAV and every v ∈ S: Σ_{i,j∈S} θ_ijk ≤ Σ_{i∈S} y_ik − y_vk.

        Equivalently Σ_{i∉S, j∈S} θ_ijk ≥ y_vk: a UAV that visits v must come into S from outside, in the end from its
        depot. It implies const6, because Σ_{i∈S} y_ik − y_vk ≤ |S| − 1.
        """
        for k in self.D:
            for v in S:
                self.model.add(self.within(S, k) <= LinearExpr.sum(*(self.y[i, k] for i in S if i != v)))

    def never(self, k: int, tour: Sequence[int]) -> None:
        """Cut off this tour of UAV k: not all of its arcs at once."""
        arcs = list(pairwise([k, *tour, k]))
        self.model.add(LinearExpr.sum(*(self.theta[i, j, k] for i, j in arcs)) <= len(arcs) - 1)

    def within(self, S: Sequence[int], k: int) -> LinearExpr:
        """Return Σ_{i∈S} Σ_{j∈S} θ_ijk."""
        return LinearExpr.sum(*(self.theta[i, j, k] for i in S for j in S if i != j))
