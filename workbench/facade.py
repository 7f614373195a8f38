"""Facade: what ``import workbench as wb`` offers, each in one call."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from formulations.limits import Limits
from instances import InputError, Instance, Routes
from workbench.inputs import Source, instance
from workbench.result import Result

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from formulations.selection.selection import Selection
    from formulations.task_location.placement import Placement
    from instances.environment.region import Region
    from instances.scenario import Scenario

__all__ = ["compare", "costs", "generate", "instance", "load", "mission", "place", "plot", "select", "solve"]


def solve(
    problem: Source,
    *,
    depots: int | Sequence[Any] | None = None,
    solver: str = "exact",
    time_limit: float = 60.0,
    seed: int = 0,
    threads: int = 1,
    start: Routes | None = None,
    **options: Any,
) -> Result:
    """Solve one instance here and now, and check what the solver says.

    problem, depots : as `instance` takes them.
    solver : a name of ``workbench solvers``; `options` are that solver's.
    time_limit [s] : of the solve alone; kernels are compiled before.
    start : routes to begin from.

    Raises InputError for what cannot be used, RuntimeError where the independent check refutes the solver.
    """
    from formulations.routing.registry import make_solver
    from formulations.routing.solver import refusal

    item = instance(problem, depots=depots)
    method = make_solver(solver, options)
    if reason := refusal(method, item):
        raise InputError(f"solver {solver}: {reason}")
    method.prepare(item)
    claim = method.solve(item, limits=Limits(time=time_limit, threads=threads), seed=seed, start=start)
    from workbench.problems.routing import refute

    if wrong := refute(item, claim):
        raise RuntimeError(f"the independent check refutes {solver}: {wrong}")
    return Result.of(claim, item, solver)


def compare(
    problems: Iterable[Source] | Source,
    solvers: Sequence[str | Mapping[str, Any]] = ("exact", "memetic", "ga"),
    *,
    time_limit: float = 10.0,
    seeds: int = 1,
    out: Path | str | None = None,
    jobs: int | None = None,
) -> pd.DataFrame:
    """Run every solver on every instance, each run in a process of its own, and return the runs as `load` does.

    solvers : names, or tables as a study's ``[[solvers]]`` has them: ``{"name": "ga", "options": {...}}``.
    seeds : so many a solver. jobs : runs at once, by default the cores of this machine.
    out : folder that keeps the runs; what is stored there is not run again. By default nothing is kept.
    """
    from instances.files import write_instance
    from workbench.jobs.backlog import Backlog
    from workbench.jobs.execute import jobs_of, plan, run_locally
    from workbench.jobs.machine import available_cores
    from workbench.jobs.progress import StudyProgress
    from workbench.jobs.store import Store
    from workbench.jobs.study import study_from
    from workbench.problems.routing import ROUTING

    several = [problems] if isinstance(problems, (Instance, str, Path)) else list(problems)
    entries = [{"name": each} if isinstance(each, str) else dict(each) for each in solvers]
    tables = {"solvers": entries, "time_limit": time_limit, "seeds": seeds}
    parallel = available_cores() if jobs is None else jobs
    with TemporaryDirectory() as aside:
        files = []
        for number, each in enumerate(several):
            folder = Path(aside, str(number))
            folder.mkdir()
            item = instance(each)
            files.append(folder / f"{item.name}.json")
            write_instance(item, files[-1])
        study = study_from(tables, ROUTING, name="compare", base=Path()).with_files(files)
        store = Store(Path(aside, "runs") if out is None else Path(out))
        sources: dict[str, Any] = {}
        asked = jobs_of(study, keep=sources.setdefault)
        store.create()
        store.keep_items(ROUTING, sources)
        store.put_study(study.asked, [job.path for job in asked])
        todo = plan(asked, store)
        with StudyProgress(todo.todo, parallel, ROUTING.spell) as progress, Backlog(todo.todo, store) as backlog:
            run_locally(backlog, ROUTING, parallel, progress)
        return load(store.root)


def generate(family: str, tasks: int = 20, depots: int = 3, seed: int = 0, **parameters: Any) -> Instance:
    """Return the instance of a family (``workbench families``) of this size and seed."""
    from formulations.moving_cost.families import generate as made
    from instances.families import check_family

    check_family(family, parameters)
    return made(family, tasks, depots, seed, **parameters)


def place(
    region: Region | Path | str | None = None,
    tasks: int = 40,
    *,
    method: str = "nlp",
    tests: str = "20x20",
    signal_sd: float = 30.0,
    length_scale: float | tuple[float, float] = 4000.0,
    noise_sd: float = 1.0,
    criterion: str = "b",
    seed: int = 0,
    time_limit: float = float("inf"),
    certificate: bool = True,
    **options: Any,
) -> Placement:
    """Choose the task locations of most information in a region, by default the paper's 20 km square.

    region : or its file. tests : test points, the centres of so many cells, or a CSV file of them.
    signal_sd, noise_sd in the unit of the signal, length_scale [m]: the planning kernel and the noise of a reading.
    certificate : whether to compute the upper bound too. `options` are the method's.
    """
    from formulations.task_location import certificate as certificates
    from formulations.task_location.criterion import Convention
    from formulations.task_location.placement import PlacementProblem
    from formulations.task_location.placement import place as placed
    from formulations.task_location.registry import make_method
    from formulations.task_location.setting import criterion_of, region_of
    from instances.environment.region import Region

    area = region if isinstance(region, Region) else region_of(None if region is None else Path(region))
    scales = ",".join(map(str, length_scale)) if isinstance(length_scale, tuple) else str(length_scale)
    worth = criterion_of(
        area,
        tests=tests,
        signal_sd=signal_sd,
        length_scale=scales,
        noise_sd=noise_sd,
        test_noise_sd=None,
        criterion=criterion,
    )
    bound = certificates.certificate(worth.under(Convention.BOTH_NOISY), area, tasks).bound if certificate else None
    limits = Limits(time=time_limit)
    problem = PlacementProblem(area, worth, tasks)
    return placed(problem, make_method(method, options), method, seed=seed, limits=limits, certificate=bound)


def costs(scenario: Scenario | Path | str, method: str = "refined", **options: Any) -> Instance:
    """Return the instance a scenario becomes: a cost and a confirmed path between every two nodes."""
    from instances.scenario import Scenario, read_scenario
    from workbench.planning import plan

    return plan(scenario if isinstance(scenario, Scenario) else read_scenario(scenario), method, options)[0]


def select(
    problem: Source,
    *,
    depots: int | Sequence[Any] | None = None,
    endurance: float | Sequence[float] | None = None,
    prizes: Sequence[float] | None = None,
    criterion: str = "ig",
    signal_sd: float = 30.0,
    length_scale: float = 4000.0,
    noise_sd: float = 1.0,
    method: str = "exact",
    time_limit: float = 60.0,
    seed: int = 0,
    **options: Any,
) -> Selection:
    """Choose the tasks that fit within the UAVs' endurance and are worth most, routed, with an upper bound.

    problem, depots : as `instance` takes them. endurance [s] : of all UAVs or each, by default the instance's own.
    prizes : what each task is worth, shape (n,); without them, what readings at the tasks tell of a field, in nats,
        under `criterion` and the planning kernel. `options` are the method's.
    """
    import numpy as np

    from formulations.selection.registry import make_method
    from formulations.selection.selection import SelectionProblem
    from formulations.selection.selection import select as selected
    from formulations.selection.selection_files import limited, own_prizes
    from formulations.selection.worth import Worth, worth_of
    from formulations.task_location.setting import criterion_of, region_of

    item = instance(problem, depots=depots)
    if endurance is not None:
        item = limited(item, np.broadcast_to(np.asarray(endurance, dtype=float), item.n_depots))
    given = own_prizes(item) if prizes is None else list(prizes)
    if given is not None:
        worth = worth_of({"prizes": given}, item.n_tasks, item.coordinates)
    elif item.coordinates is None:
        raise InputError(f"{item.name} has no coordinates, so information cannot be told: give prizes")
    else:
        setting: dict[str, Any] = {
            "signal_sd": signal_sd,
            "length_scale": str(length_scale),
            "noise_sd": noise_sd,
            "test_noise_sd": None,
        }
        about = criterion_of(region_of(None), tests="20x20", criterion=criterion, **setting)
        worth = Worth.of_information(about, item.coordinates[: item.n_tasks])
    asked = SelectionProblem(item, worth)
    return selected(asked, make_method(method, options), method, seed=seed, limits=Limits(time=time_limit))


def mission(file: Path | str = "paper", out: Path | str = "mission") -> Path:
    """Run a whole mission and return its page; products lie beside it.

    file : a mission file, or the name of one that comes along: paper, the paper's numerical example, or lee.
    """
    from workbench.mission.file import read_mission, shipped_missions
    from workbench.mission.pipeline import run_mission

    run_mission(read_mission(shipped_missions().get(str(file), Path(file))), Path(out))
    return Path(out) / "report.html"


def load(*folders: Path | str) -> pd.DataFrame:
    """Return stored runs as a frame, a row a run (`reports.stores.COLUMNS`), with gaps, routes and options.

    Beside those columns: best_found [s], best_bound [s], gap_found and gap_bound of each run on its instance, and a
    column ``option.<name>`` for each option that some method was given.
    """
    import json

    import pandas as pd

    from reports.metrics.gaps import with_gaps
    from reports.stores import read_stores

    runs = read_stores(*folders).runs
    if runs.empty:
        return runs
    options = pd.DataFrame([json.loads(text) for text in runs["options"]], index=runs.index)
    return with_gaps(runs).join(options.add_prefix("option."))


def plot(thing: Result | Instance | Placement | Scenario, routes: Routes | None = None) -> Figure:
    """Draw a result, an instance with its routes, or an instance alone."""
    from reports.figures.routes import draw_routes

    if isinstance(thing, Result):
        return thing.plot()
    if isinstance(thing, Instance):
        return draw_routes(thing, routes or tuple(() for _ in thing.depots))
    raise InputError(f"plot: draws a Result or an Instance, not a {type(thing).__name__}")
