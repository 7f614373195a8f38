"""The check of a certificate: every case is gone through again, with tours listed and bounds computed here.

Let S_k be the tours that UAV k may still use in a case, of cost ≤ bound. For any prices σ ≥ 0, Σσ ≤ 1, π, ρ ≥ 0, and
r_k no more than the reduced cost of any tour in S_k, routes of these tours have

    longest tour ≥ L = Σπ − Σρ + Σ_k min(0, r_k),

because every task is visited once and of three tasks at most one tour holds two (Jepsen et al. 2008). So

* a case is at its end where L > bound;
* a tour of UAV k with reduced cost above bound − L + min(0, r_k) is in no routes as good, and is put aside;
* the two cases after a case give a task to some of the UAVs, and to the others: together they miss no routes. A UAV may
  get it in neither where one like it does, of the same legs and endurance and with the same tasks forbidden: exchanging
  their tours turns routes of the case into others as good. Tours put aside are in neither;
* or one of some arcs between tasks is flown in one of them, and none in the other. That narrows only what prices of
  arcs prove (`arcs`): all tours of the case before are looked at, which misses none.

Rounding: a reduced cost sums at most 2n + 2 numbers and the ρ, each partial sum at most U = bound + Σ|π| + Σρ in size;
`_margin` is above what that can add up to in L, and every comparison leaves it to the doubter's side.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from instances.arrays import Bools, Floats
from instances.certificate.arcs import least_of_arcs, sound_arcs
from instances.certificate.file import ArcPrices, Certificate, Crowd, Node, Prices, Step
from instances.certificate.joint import holds_no_tour, joint_row
from instances.certificate.tours import Tours, UavLegs, list_tours
from instances.errors import InputError
from instances.instance import Instance
from instances.routes import ENDURANCE_ROUNDING, check_routes, makespan

ROOM = 20_000_000
"""Paths of one list, at most, unless said otherwise."""
_SAME = 1e-9
"""Share by which the cost of the routes may differ from what is claimed."""


@dataclass(frozen=True)
class Verdict:
    """What a certificate comes to: what is wrong with it, empty where it holds, and how many cases were closed."""

    problems: tuple[str, ...]
    closed: int


@dataclass
class _Case:
    """What a case still allows: tasks forbidden (m, n); tours of the UAVs listed; for the others the prices and the
    reduced costs [s] above which tours were put aside; arcs banned, and those of which one is needed."""

    forbidden: Bools
    tours: dict[int, Tours]
    aside: list[tuple[Prices, Floats]] = field(default_factory=list)
    banned: tuple[tuple[int, int], ...] = ()
    needed: tuple[tuple[tuple[int, int], ...], ...] = ()

    def by_arcs(self, node: Node) -> _Case:
        """Return the case in which one of the node's arcs is flown, or none is."""
        if node.flown:
            return replace(self, aside=list(self.aside), needed=(*self.needed, node.arcs))
        return replace(self, aside=list(self.aside), banned=(*self.banned, *node.arcs))

    def child(self, task: int, uavs: list[int]) -> _Case:
        """Return the case in which `task` is forbidden to `uavs`."""
        forbidden, tours = self.forbidden.copy(), dict(self.tours)
        forbidden[uavs, task] = True
        for k in uavs:
            if k in tours:
                tours[k] = tours[k].only(~tours[k].holds[:, task])
        return replace(self, forbidden=forbidden, tours=tours, aside=list(self.aside))


class _RefutedError(Exception):
    """The certificate does not hold; the text says why."""


def verify(
    instance: Instance, certificate: Certificate, room: int = ROOM, watch: Callable[[int], None] = lambda _: None
) -> Verdict:
    """Go through the whole proof; `watch` is told the number of cases closed so far.

    Raises InputError where the certificate is of another instance, or of costs that change with time or state, and
    `tours.TooManyError` where a case takes more than `room` paths.
    """
    if certificate.digest != instance.digest:
        raise InputError(f"is the certificate of {certificate.digest}, not of {instance.name} ({instance.digest})")
    if {"time", "states"} & instance.axes:
        raise InputError("certificates are of instances whose costs do not change with time or state")
    if problems := _routes_problems(instance, certificate):
        return Verdict(tuple(problems), 0)
    check = _Check(instance, certificate, room, watch)
    try:
        check.run()
    except _RefutedError as why:
        problems.append(str(why))
    return Verdict(tuple(problems), check.closed)


def _routes_problems(instance: Instance, certificate: Certificate) -> list[str]:
    if not certificate.routes:
        return []
    if faults := check_routes(instance, certificate.routes):
        return [f"the routes: {faults[0]}"]
    value, claimed = makespan(instance, certificate.routes), certificate.objective
    if claimed is None or abs(value - claimed) > _SAME * value:
        return [f"the routes take {value!r} s, not {claimed!r} s"]
    return [f"the bound {certificate.bound!r} s is above the routes, {value!r} s"] if certificate.bound > value else []


class _Check:
    """One run over the cases of a certificate, depth first: a case's lists are gone before the next one's are made."""

    def __init__(self, instance: Instance, certificate: Certificate, room: int, watch: Callable[[int], None]) -> None:
        self.certificate, self.room, self.watch = certificate, room, watch
        self.n, self.m, self.bound, self.closed = instance.n_tasks, instance.n_depots, certificate.bound, 0
        costs, depots, n = instance.class_costs[instance.classes], np.array(instance.depots), self.n
        self.legs = [
            UavLegs(costs[k, depots[k], :n], _without_loops(costs[k, :n, :n]), costs[k, :n, depots[k]])
            for k in range(self.m)
        ]
        self.caps = np.minimum(self.bound, instance.limits * (1 + ENDURANCE_ROUNDING))
        self.kinds = [next(j for j in range(k + 1) if self._built_alike(j, k)) for k in range(self.m)]
        self.steps: dict[int, list[Step]] = {}
        for cut in certificate.cuts:
            if not {cut.visited} <= {*cut.tasks} <= {*range(self.n)} or not 0 <= cut.uav < self.m:
                raise InputError("a cut must be of one of the UAVs, and of tasks, one of which is visited")
        self.joint = [joint_row(cut, self.n) for cut in certificate.joint]
        for step in certificate.steps:
            self._sound(step)
            self.steps.setdefault(step.node, []).append(step)
        self.children: dict[int | None, list[int]] = {}
        for number, node in enumerate(certificate.nodes):
            if node.parent is not None and not 0 <= node.parent < number:
                raise InputError(f"node {number}: its parent must come before it, got {node.parent}")
            self.children.setdefault(node.parent, []).append(number)

    def run(self) -> None:
        """Close every case from the first on."""
        if self.children.get(None) != [0]:
            raise _RefutedError("the first node alone must have no parent")
        for number, cut in enumerate(self.certificate.joint):
            if isinstance(cut, Crowd) and not holds_no_tour(cut, self.legs, self.caps):
                raise _RefutedError(f"cut {number} of all UAVs: that its tasks are too many for one is not proved")
        open_cases = [(0, _Case(np.zeros((self.m, self.n), np.bool_), {}))]
        while open_cases:
            number, case = open_cases.pop()
            if self._closes(number, case):
                self.closed += 1
                self.watch(self.closed)
                continue
            open_cases += [(child, self._case(child, case)) for child in self._split(number, case)]

    def _sound(self, step: Step) -> None:
        """Refuse prices of other sizes or signs than they must have."""
        at, prices = f"node {step.node}", step.prices
        if isinstance(prices, ArcPrices):
            sound_arcs(at, prices, self.n, self.m, len(self.certificate.cuts), len(self.joint))
            return
        numbers = np.array([*prices.task, *prices.uav, *prices.least, *prices.rho])
        sizes = len(prices.task), len(prices.uav), len(prices.least), len(prices.rho)
        if sizes != (self.n, self.m, self.m, len(prices.sets)) or not np.isfinite(numbers).all():
            raise InputError(f"{at}: prices of {self.n} tasks, {self.m} UAVs and each set must be finite numbers")
        if min(prices.uav) < 0 or min(prices.rho, default=0.0) < 0 or max(prices.least) > 0:
            raise InputError(f"{at}: prices of UAVs and sets must not be negative, least reduced costs not positive")
        if any(len({*s} & {*range(self.n)}) < 3 for s in prices.sets):
            raise InputError(f"{at}: a set must be of three different tasks")

    def _built_alike(self, j: int, k: int) -> bool:
        pairs = zip(vars(self.legs[j]).values(), vars(self.legs[k]).values(), strict=True)
        return bool(self.caps[j] == self.caps[k]) and all(np.array_equal(one, other) for one, other in pairs)

    def _alike(self, case: _Case, j: int, k: int) -> bool:
        """Say whether exchanging the tours of two UAVs turns any routes of a case into routes of it as good."""
        return self.kinds[j] == self.kinds[k] and np.array_equal(case.forbidden[j], case.forbidden[k])

    def _split(self, number: int, case: _Case) -> list[int]:
        """Return the two cases after one; refute it where they are not all there is."""
        nodes, children = self.certificate.nodes, self.children.get(number, [])
        tasks, arcs = {nodes[child].task for child in children}, {nodes[child].arcs for child in children}
        if len(children) == 2 and len(arcs) == 1 and arcs != {()}:
            if {nodes[child].flown for child in children} == {False, True}:
                return children
        elif len(children) == 2 and len(tasks) == 1 and None not in tasks:
            lost = set(nodes[children[0]].forbidden) & set(nodes[children[1]].forbidden)
            kept = [k for k in range(self.m) if k not in lost]
            if all(any(self._alike(case, j, k) for j in kept) for k in lost):
                return children
        raise _RefutedError(f"node {number} is neither closed nor split into two cases that miss no routes")

    def _case(self, number: int, parent: _Case) -> _Case:
        node = self.certificate.nodes[number]
        if node.arcs:
            if not {i for arc in node.arcs for i in arc} <= {*range(self.n)}:
                raise _RefutedError(f"node {number}: arcs are between tasks, 0..{self.n - 1}, got {node.arcs}")
            return parent.by_arcs(node)
        if node.task is None or not 0 <= node.task < self.n:
            raise _RefutedError(f"node {number}: there is no task {node.task}")
        if not {*node.forbidden} <= {*range(self.m)}:
            raise _RefutedError(f"node {number}: UAVs are 0..{self.m - 1}, got {node.forbidden}")
        return parent.child(node.task, list(node.forbidden))

    def _closes(self, number: int, case: _Case) -> bool:
        """Take the steps of a case; say whether one of them closes it."""
        for step in self.steps.get(number, []):
            prices = step.prices
            if isinstance(prices, ArcPrices):
                return self._closes_by_arcs(number, case, prices)
            margin = self._margin(prices)
            least = np.zeros(self.m)
            for k, twin in enumerate(self._twins(case, prices)):
                least[k] = least[twin] if twin < k else self._least(case, prices, k, margin)
            total = float(np.sum(prices.task)) - float(np.sum(prices.rho)) + float(np.minimum(least, 0.0).sum())
            total -= max(0.0, float(np.sum(prices.uav)) - 1.0) * self.bound + margin
            if step.closes and not total > self.bound:
                raise _RefutedError(
                    f"node {number} is not closed: its bound is {total!r} s, not above {self.bound!r} s"
                )
            if step.closes:
                return True
            self._put_aside(case, prices, step.listed, self.bound - total + np.minimum(least, 0.0), margin)
        return False

    def _closes_by_arcs(self, number: int, case: _Case, prices: ArcPrices) -> bool:
        """Close a case at prices of arcs, or refute it."""
        if len(prices.rho) != len(case.needed):
            raise InputError(f"node {number}: must have {len(case.needed)} prices rho, got {len(prices.rho)}")
        cuts, of_case = self.certificate.cuts, (case.forbidden, case.banned, case.needed)
        beyond = least_of_arcs(self.legs, self.caps, prices, cuts, self.joint, *of_case)
        if not beyond > 0:
            raise _RefutedError(f"node {number} is not closed: its bound is {-beyond!r} s below {self.bound!r} s")
        return True

    def _twins(self, case: _Case, prices: Prices) -> list[int]:
        """Return for every UAV the first that has the same tours left, at the same prices."""

        def twins(j: int, k: int) -> bool:
            all_prices = [prices, *(earlier for earlier, _ in case.aside)]
            same = all(p.uav[j] == p.uav[k] and p.least[j] == p.least[k] for p in all_prices)
            same = same and all(allowed[j] == allowed[k] for _, allowed in case.aside)
            return same and (j in case.tours) == (k in case.tours) and self._alike(case, j, k)

        return [next(j for j in range(k + 1) if twins(j, k)) for k in range(self.m)]

    def _least(self, case: _Case, prices: Prices, k: int, margin: float) -> float:
        """Return no more than the least reduced cost of the tours left to UAV k [s]."""
        if k in case.tours:
            return float(case.tours[k].reduced(prices, k).min(initial=0.0)) - margin
        below = self._list(case, prices, k, prices.least[k])
        return float(below.reduced(prices, k).min(initial=prices.least[k])) - margin

    def _list(self, case: _Case, prices: Prices, k: int, threshold: float) -> Tours:
        """Return the tours left to UAV k of reduced cost at most `threshold` [s]."""
        legs = self.legs[k].without(case.forbidden[k])
        tours = list_tours(legs, float(self.caps[k]), prices, k, threshold, self.room)
        for earlier, allowed in case.aside:
            tours = tours.only(tours.reduced(earlier, k) <= allowed[k])
        return tours

    def _put_aside(self, case: _Case, prices: Prices, listed: tuple[int, ...], allowed: Floats, margin: float) -> None:
        """Leave only the tours that routes as good as the bound can still use; list those of the UAVs named."""
        allowed = allowed + 2 * margin
        twins = self._twins(case, prices)
        for k in sorted({*listed} - case.tours.keys()):
            known = case.tours.get(twins[k])
            case.tours[k] = known or self._list(case, prices, k, float(allowed[k]))
        for k, tours in case.tours.items():
            case.tours[k] = tours.only(tours.reduced(prices, k) <= allowed[k])
        case.aside.append((prices, allowed))

    def _margin(self, prices: Prices) -> float:
        """Return more than rounding can add up to in a bound at these prices [s]."""
        size = self.bound + float(np.abs(prices.task).sum() + np.sum(prices.rho))
        return 8 * (self.m + 1) * (self.n + 2 + len(prices.rho)) * 2.0**-53 * size


def _without_loops(between: Floats) -> Floats:
    legs = between.copy()
    np.fill_diagonal(legs, np.inf)
    return legs
