"""What to fly when endurance does not suffice: the tasks that fit and tell most, routed by the mission's solver.

The tasks are worth what the mission's planning criterion ([place]) says of them. Selection knows mutual information;
where "j" is asked for, what it chose under (b) is exchanged task by task for less mean variance, and the file keeps
worth and bound under (b), which hold for any selection. The solver is given the instance of
the chosen tasks alone, with the selection's routes to begin from, and may only shorten the longest tour.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from formulations.limits import Limits
from formulations.routing.solver import Status
from formulations.selection.exchange import exchanged
from formulations.selection.part import only
from formulations.selection.registry import make_method
from formulations.selection.selection import Selection, SelectionProblem, select
from formulations.selection.worth import Worth
from formulations.task_location.variance_reduction import VarianceReduction, information_of
from instances import InputError, Instance, check_routes
from instances.arrays import Floats
from reports.numbers import counted
from reports.record import Run
from workbench.mission.place import criterion_of
from workbench.mission.routes import attempt
from workbench.mission.settings import Mission

METHOD = "exact"


@dataclass(frozen=True)
class Chosen:
    """A selection as the mission keeps it: its file's `text`, and a sentence of what was left out."""

    text: str
    said: str


def route_what_fits(
    mission: Mission, instance: Instance, limits: Floats, tell: Callable[[str], None]
) -> tuple[Run, Chosen]:
    """Return a run over the tasks that fit within `limits` (m,) [s] and tell most; InputError where none does."""
    if instance.coordinates is None:
        raise InputError("flight.endurance: the costs have no coordinates, so what tasks tell is not known")
    goal = criterion_of(mission, mission.scenario.region)
    tell(f"endurance does not suffice for all {instance.n_tasks} tasks: selecting")
    tasks = instance.coordinates[: instance.n_tasks]
    worth = Worth.of_information(information_of(goal), tasks)
    problem = SelectionProblem(replace(instance, endurance=limits), worth)
    found = select(problem, make_method(METHOD), METHOD, limits=Limits(time=mission.routes.time_limit))
    if not found.tasks:
        raise InputError("flight.endurance: no task can be flown within the endurance")
    said = ""
    if isinstance(goal, VarianceReduction):
        found, said = by_variance(found, goal, tasks, mission.routes.time_limit)
    return _routed(mission, instance, found), Chosen(json.dumps(found.as_dict()) + "\n", _said(found) + said)


def by_variance(found: Selection, goal: VarianceReduction, tasks: Floats, seconds: float) -> tuple[Selection, str]:
    """Return a selection of no more mean variance than `found` has, and a sentence of it."""

    def worth(chosen: Sequence[int]) -> float:
        return goal.value(tasks[list(chosen)])

    routes, count = exchanged(found.problem.instance, found.routes, worth, seconds)
    better = tuple(sorted(task for route in routes for task in route))
    said = (
        f"; chosen under {found.problem.worth.about['criterion']}, then {counted(count, 'exchange')} by criterion j: "
        f"{worth(better):.3f} nats after {worth(found.tasks):.3f}"
    )
    status = Status.FEASIBLE if count else found.status
    value = found.problem.worth.value(better)
    return replace(found, tasks=better, routes=routes, worth=value, status=status), said


def _said(found: Selection) -> str:
    left = ", ".join(map(str, found.left_out))
    criterion = found.problem.worth.about["criterion"]
    return (
        f"endurance leaves out {len(found.left_out)} of {found.problem.instance.n_tasks} tasks ({left}), which would "
        f"have told {found.everything - found.worth:.3f} of {found.everything:.3f} nats (criterion {criterion}); no "
        f"selection tells more than {found.bound:.3f} of them, this one {found.worth:.3f}"
    )


def _routed(mission: Mission, instance: Instance, found: Selection) -> Run:
    """Return a run of the mission's solver over the chosen tasks, its routes in the instance's own numbers."""
    place = {task: number for number, task in enumerate(found.tasks)}
    start = tuple(tuple(place[task] for task in route) for route in found.routes)
    wanted = mission.routes
    run = attempt(mission, only(instance, found.tasks), wanted.time_limit, wanted.seed, start)
    if run.own["routes"] is None:
        raise InputError(f"routes.solver: {wanted.solver} found no routes ({run.status}: {run.message})")
    routes = [[found.tasks[number] for number in route] for route in run.own["routes"]]
    if faults := check_routes(found.problem.instance, routes, all_tasks=False):
        raise InputError(f"routes.solver: {wanted.solver} ended worse than it began ({faults[0].rstrip('.')})")
    return replace(run, own={**run.own, "routes": routes})
