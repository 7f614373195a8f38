"""routing-library: OR-Tools routing, what one takes off the shelf.

The library minimises sums. C_max is asked for through a "distance" dimension d, whose value at the end of UAV k's
route is C_k (scaled to whole numbers, ``scaling.py``), and the library's global span cost, as its documentation shows
for min-max:

    minimise  Σ_arcs c_ij + w · (max_k d_end(k) − min_k d_start(k)),   d_start(k) = 0.

Search: guided local search, the documentation's advice, from the greedy routes (or `start`). A search ended by
``limits.iterations`` is deterministic.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ortools.constraint_solver import pywrapcp, routing_enums_pb2

from formulations.routing.model_solver import ModelSolver
from formulations.routing.recorder import Recorder
from formulations.routing.scaling import scale_costs
from formulations.routing.solver import Result
from instances import InputError
from instances.arrays import Ints


@dataclass(frozen=True)
class RoutingLibrary(ModelSolver):
    """OR-Tools routing; ``limits.iterations`` counts the solutions its search accepts.

    span_weight : w, the price of a second of C_max against a second of the sum of all tours.
    """

    proves: ClassVar[bool] = False
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
        scaled = scale_costs(recorder.instance, recorder.objective)
        table = _table(scaled.cost, recorder)
        if table is None:
            return recorder.result("time", solutions=0)
        search = _Search(self, recorder, seed, scaled.upper, table)
        del table  # the library has its own now; this one takes several times the memory
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
        self, options: RoutingLibrary, recorder: Recorder, seed: int, longest: int, table: list[list[int]]
    ) -> None:
        self.recorder = recorder
        self.solutions = 0
        instance = recorder.instance
        depots = list(instance.depots)
        self.manager = pywrapcp.RoutingIndexManager(instance.n_nodes, len(depots), depots, depots)
        self.routing = pywrapcp.RoutingModel(self.manager)
        transit = self.routing.RegisterTransitMatrix(table)
        self.routing.SetArcCostEvaluatorOfAllVehicles(transit)
        horizon = (longest + 1) * (instance.n_tasks + 1)
        self.routing.AddDimension(transit, 0, horizon, True, "distance")
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
        first = self.routing.ReadAssignmentFromRoutes([list(route) for route in self.recorder.routes or ()], True)
        parameters.time_limit.FromMilliseconds(max(1, int(1000 * self.recorder.remaining)))
        self.routing.SolveFromAssignmentWithParameters(first, parameters)
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
