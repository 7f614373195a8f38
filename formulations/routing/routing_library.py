"""routing-library: OR-Tools routing, what one takes off the shelf.

The library minimises sums. C_max is asked for through a "distance" dimension d, whose value at the end of UAV k's
route is C_k (scaled to whole numbers, ``scaling.py``), and the library's global span cost, as its documentation shows
for min-max:

    minimise  Σ_arcs c_ij + w · (max_k d_end(k) − min_k d_start(k)),   d_start(k) = 0.

Every UAV has the transit of its class and the capacity of its endurance on that dimension. A leg that it cannot fly is
longer than any capacity.

Search: guided local search, the documentation's advice, from the greedy routes (or `start`), or from the library's own
where there are none that the UAVs can fly. A search ended by ``limits.iterations`` is deterministic.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from ortools.constraint_solver import pywrapcp, routing_enums_pb2

from formulations.routing.model_solver import ModelSolver, cutoff
from formulations.routing.recorder import Recorder
from formulations.routing.scaling import ScaledCosts, scale_costs
from formulations.routing.solver import Result
from instances import InputError
from instances.arrays import Ints
from instances.routes import ENDURANCE_ROUNDING


@dataclass(frozen=True)
class RoutingLibrary(ModelSolver):
    """OR-Tools routing; ``limits.iterations`` counts the solutions its search accepts.

    span_weight : w, the price of a second of C_max against a second of the sum of all tours (at least 1).
    """

    proves: ClassVar[bool] = False
    axes: ClassVar[frozenset[str]] = frozenset({"fleet", "endurance"})
    counters: ClassVar[tuple[str, ...]] = ("solutions",)

    span_weight: int = 100

    def __post_init__(self) -> None:
        if self.span_weight < 1:
            raise InputError(f"routing-library: span_weight must be at least 1, got {self.span_weight}")

    def improve(self, recorder: Recorder, seed: int) -> Result:
        """Search until a limit is reached."""
        asked = recorder.limits.iterations
        if asked == 0:
            return recorder.result("iterations", solutions=0)
        scaled = scale_costs(recorder.instance, cutoff(recorder))
        horizon = (scaled.upper + 1) * (recorder.instance.n_tasks + 1)
        scaled.costs[np.isinf(recorder.instance.class_costs)] = horizon + 1
        tables = [table for cost in scaled.costs if (table := _table(cost, recorder)) is not None]
        if len(tables) < len(scaled.costs):
            return recorder.result("time", solutions=0)
        search = _Search(self, recorder, seed, scaled, horizon, tables)
        del tables  # the library has its own now; these take several times the memory
        solutions = search.run()
        if asked is not None and solutions >= asked:
            return recorder.result("iterations", solutions=solutions)
        return recorder.result("finished" if recorder.remaining > 0 else "time", solutions=solutions)


def _table(cost: Ints, recorder: Recorder) -> list[list[int]] | None:
    """Return `cost` as lists, which is how the library takes it; None where too little time is left for it to do so.

    The library does not look at the clock while it builds its model: some seconds at n = 5000, about a third of what
    the lists take.
    """
    began, rows = recorder.elapsed, []
    for row in cost:
        if recorder.remaining == 0:
            return None
        rows.append(row.tolist())
    return rows if recorder.remaining > recorder.elapsed - began else None


class _Search:
    """One search of the library from the recorder's routes; every accepted solution is offered to the recorder."""

    def __init__(
        self,
        options: RoutingLibrary,
        recorder: Recorder,
        seed: int,
        scaled: ScaledCosts,
        horizon: int,
        tables: list[list[list[int]]],
    ) -> None:
        self.recorder = recorder
        self.solutions = 0
        instance = recorder.instance
        depots = list(instance.depots)
        self.manager = pywrapcp.RoutingIndexManager(instance.n_nodes, len(depots), depots, depots)
        self.routing = pywrapcp.RoutingModel(self.manager)
        of_class = [self.routing.RegisterTransitMatrix(table) for table in tables]
        transits = [of_class[g] for g in scaled.classes]
        for k, transit in enumerate(transits):
            self.routing.SetArcCostEvaluatorOfVehicle(transit, k)
        limits = np.minimum(instance.limits * (1 + ENDURANCE_ROUNDING), math.ldexp(horizon, -scaled.exponent))
        capacities = np.ldexp(limits, scaled.exponent).astype(np.int64).tolist()
        self.routing.AddDimensionWithVehicleTransitAndCapacity(transits, 0, capacities, True, "distance")
        self.routing.GetDimensionOrDie("distance").SetGlobalSpanCostCoefficient(options.span_weight)
        self.routing.AddAtSolutionCallback(self._on_solution)
        self.routing.solver().ReSeed(seed % 2**31)

    def run(self) -> int:
        """Search until a limit; return the number of accepted solutions."""
        parameters = pywrapcp.DefaultRoutingSearchParameters()
        parameters.local_search_metaheuristic = routing_enums_pb2.LocalSearchMetaheuristic.GUIDED_LOCAL_SEARCH
        if self.recorder.limits.iterations is not None:
            parameters.solution_limit = self.recorder.limits.iterations
        self.routing.CloseModelWithParameters(parameters)
        known = self.recorder.routes
        first = known and self.routing.ReadAssignmentFromRoutes([list(route) for route in known], True)
        parameters.time_limit.FromMilliseconds(max(1, int(1000 * self.recorder.remaining)))
        if first:
            self.routing.SolveFromAssignmentWithParameters(first, parameters)
        else:
            self.routing.SolveWithParameters(parameters)
        return self.solutions

    def _on_solution(self) -> None:
        self.solutions += 1
        self.recorder.incumbent(tuple(self._route(k) for k in range(self.routing.vehicles())))

    def _route(self, k: int) -> tuple[int, ...]:
        route, index = [], self.routing.NextVar(self.routing.Start(k)).Value()
        while not self.routing.IsEnd(index):
            route.append(self.manager.IndexToNode(index))
            index = self.routing.NextVar(index).Value()
        return tuple(route)
