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

    from formulations.task_location.placement import Placement
    from instances.scenario import Scenario

__all__ = ["compare", "costs", "generate", "instance", "load", "mission", "plot", "solve"]


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

    Parameters
    ----------
    problem
        What `instance` takes: costs (N, N) [s], points (N, 2) [m], a table, a graph, a file, an Instance.
    depots
        As `instance` takes them; not beside an Instance, which has its own.
    solver
        A name of ``workbench solvers``, or ``module:Class``.
    time_limit
        Wall clock of the solve alone [s]; kernels are compiled before.
    seed
        Of the solver. A solve ended by the clock may still differ from run to run.
    threads
        Worker threads of the solver.
    start
        Feasible routes to begin from.
    **options
        The solver's own options.

    Returns
    -------
    Result
        Status, routes, objective and bound [s], all checked.

    Raises
    ------
    InputError
        Where problem, depots, solver or an option cannot be used, or the solver does not take this instance.
    RuntimeError
        Where the independent check refutes the solver.
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

    Parameters
    ----------
    problems
        Instances or files, one or several.
    solvers
        Names, or tables as a study's ``[[solvers]]`` has them: ``{"name": "ga", "options": {...}}``.
    time_limit
        Wall clock of each run [s], after which it is killed.
    seeds
        How many seeds (0, 1, …) each solver is run with.
    out
        Folder that keeps the runs; what is stored there is not run again. By default nothing is kept.
    jobs
        Runs at once, by default the cores of this machine.

    Returns
    -------
    pandas.DataFrame
        A row a run, as of `load`.

    Raises
    ------
    InputError
        Where an instance, a solver or an option cannot be used, or `out` cannot be written.
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
    """Return the instance of a family of this size and seed.

    Parameters
    ----------
    family
        A name of ``workbench families``.
    tasks
        Number of tasks n, at least 1.
    depots
        Number of depots m, at least 1, one UAV at each.
    seed
        The same seed makes the same instance.
    **parameters
        The family's own, in SI units.

    Returns
    -------
    Instance
        With coordinates [m]; costs [s] are planned where they have no closed form.

    Raises
    ------
    InputError
        For an unknown family or parameter, or a value out of range.
    """
    from formulations.moving_cost.families import generate as made
    from instances.families import check_family

    check_family(family, parameters)
    return made(family, tasks, depots, seed, **parameters)


def costs(scenario: Scenario | Path | str, method: str = "refined", **options: Any) -> Instance:
    """Return the instance a scenario becomes: a cost and a confirmed path between every two nodes.

    Parameters
    ----------
    scenario
        A Scenario or its file (``.toml``).
    method
        ``"refined"``, ``"closed-form"``, ``"fmt-star"`` or ``"dijkstra"``.
    **options
        The method's own options.

    Returns
    -------
    Instance
        Costs [s], (n+m, n+m), of every ordered pair of nodes.

    Raises
    ------
    InputError
        For a scenario that cannot be used, a node that no path leads to, or a wind too strong for the speed.
    """
    from instances.scenario import Scenario, read_scenario
    from workbench.planning import plan

    return plan(scenario if isinstance(scenario, Scenario) else read_scenario(scenario), method, options)[0]


def mission(file: Path | str = "paper", out: Path | str = "mission") -> Path:
    """Run a whole mission and return its page; products lie beside it.

    Parameters
    ----------
    file
        A mission file, or the name of one that comes along: ``"paper"``, the paper's numerical example, or ``"lee"``.
    out
        Folder of the products; stages that are up to date there are not run again.

    Returns
    -------
    pathlib.Path
        ``out/report.html``.

    Raises
    ------
    InputError
        For a file that cannot be used, and where a flight would leave the region, enter a no-fly zone or come too
        near to the ground.
    """
    from workbench.mission.file import read_mission, shipped_missions
    from workbench.mission.pipeline import run_mission

    run_mission(read_mission(shipped_missions().get(str(file), Path(file))), Path(out))
    return Path(out) / "report.html"


def load(*folders: Path | str) -> pd.DataFrame:
    """Return stored runs as a frame, a row a run.

    Parameters
    ----------
    *folders
        Stores: folders that `compare` wrote; several are merged.

    Returns
    -------
    pandas.DataFrame
        Columns as stored (instance, method, seed, status, objective [s], bound [s], elapsed [s], routes, …), and
        best_found [s], best_bound [s], gap_found and gap_bound of each run on its instance (shares, not per cent), and
        a column ``option.<name>`` for each option that some method was given.

    Raises
    ------
    InputError
        Where a folder does not exist.
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
    """Draw a result, an instance with its routes, or an instance alone.

    Parameters
    ----------
    thing
        A Result with routes, or an Instance.
    routes
        Of the Instance: for each depot its tasks in flying order; tasks on no route are drawn too.

    Returns
    -------
    matplotlib.figure.Figure
        The tours on the map beside bars of their costs [s].

    Raises
    ------
    InputError
        For anything else.
    ValueError
        For a Result without routes.
    """
    from reports.figures.routes import draw_routes

    if isinstance(thing, Result):
        return thing.plot()
    if isinstance(thing, Instance):
        return draw_routes(thing, routes or tuple(() for _ in thing.depots))
    raise InputError(f"plot: draws a Result or an Instance, not a {type(thing).__name__}")
