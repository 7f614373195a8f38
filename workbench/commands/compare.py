"""`workbench compare`: run a study, of any problem, and report."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from instances.errors import InputError, shown, suggestion
from workbench.completing import SOLVERS, study_or_file
from workbench.options import COLUMNS, COUNT, JOBS, JSON, SECONDS, THREADS
from workbench.terminal import print_json, say

if TYPE_CHECKING:
    from workbench.jobs.execute import Plan
    from workbench.jobs.problem import Published, Source
    from workbench.jobs.slurm import Slurm
    from workbench.jobs.store import Store
    from workbench.jobs.study import Study


@click.command("compare")
@click.argument("targets", nargs=-1, metavar="[STUDY] [INSTANCES]...", shell_complete=study_or_file)
@click.option("--solvers", shell_complete=SOLVERS, help="Comma-separated names, in place of those the study runs.")
@click.option("--time-limit", type=SECONDS, help="Seconds for every run, in place of the study's.")
@click.option("--seeds", type=COUNT, help="So many seeds (0, 1, ...), in place of the study's.")
@click.option("--threads", type=THREADS, help="Threads of each solver, in place of the study's.")
@click.option("--out", type=click.Path(path_type=Path), help="Folder of the runs.  [default: runs/<study>]")
@click.option(
    "--memory-limit", help="Of each run with its processes, such as 2GB.  [default: 80 % of the machine / JOBS]"
)
@click.option(
    "--retry", help="Run again what ended so: error, killed, no_solution; or is stale: made by other code; or damaged."
)
@click.option("--jobs", type=JOBS, help="Runs at once.  [default: the cores of this machine]")
@click.option("--shard", help="Run only part i of n: i/n. The parts may share a folder.")
@click.option("--scheduler", metavar="tcp://...", help="Run on a dask.distributed cluster.")
@click.option(
    "--slurm", metavar="FILE.toml", type=click.Path(path_type=Path), help="Run in SLURM jobs (docs/clusters.md)."
)
@click.option("--report/--no-report", default=True, help="Whether to write results.csv and report.html at the end.")
@click.option("--no-plugins", is_flag=True, help="Refuse a study that names code which is not built in.")
@click.option("--dry-run", is_flag=True, help="Say what would be run and how long it would take.")
@COLUMNS
@JSON
@click.pass_context
def command(
    context: click.Context,
    /,
    targets: tuple[str, ...],
    solvers: str | None,
    out: Path | None,
    jobs: int | None,
    memory_limit: str | None,
    retry: str | None,
    shard: str | None,
    scheduler: str | None,
    slurm: Path | None,
    report: bool,
    no_plugins: bool,
    dry_run: bool,
    columns: list[str],
    as_json: bool,
    **changes: Any,
) -> None:
    """Run a study and report on it: STUDY.toml, the name of a shipped study, or INSTANCES with --solvers.

    A solver, method or family named module:Class is code: STUDY.toml can run whatever lies on Python's path, in a child
    process of each run; --no-plugins refuses it.

    Without arguments the shipped study `quick`. What is already stored is not run again. Several may work on one
    folder at once and share the runs. Exit code 1 where a run ended in ERROR, files in the folder are damaged or a
    claim in it is false.

    \b
    Examples:
      workbench compare
      workbench compare study.toml --out runs/mine --jobs 2
      workbench compare instances --solvers exact,ga --time-limit 10
      workbench compare paper --dry-run
    """
    from workbench.jobs.machine import available_cores
    from workbench.settings import memory

    queue = _slurm(slurm, scheduler)
    parallel = queue.jobs * queue.cores if queue else available_cores() if jobs is None else jobs
    limit = None if memory_limit is None else memory(memory_limit, "--memory-limit")
    study = _study(targets, solvers, {key: value for key, value in changes.items() if value is not None})
    if no_plugins and study.plugins:
        raise InputError(f"--no-plugins: the study names {', '.join(map(shown, study.plugins))}, which is not built in")
    if columns:
        _refuse_columns(study, columns)
    folder = out or Path("runs") / study.name
    if not dry_run:
        _reach(scheduler, queue)
    plan, store = _planned(study, folder, retry, shard, dry_run)
    _warn_of_crowding(study, parallel, elsewhere=bool(scheduler or queue))
    if dry_run:
        _tell_plan(plan, parallel, queue, as_json)
        return
    published = _carry_out(study, plan, store, Means(parallel, limit, scheduler, queue), report)
    about = {"study": study.name, "folder": folder, "runs": len(plan.jobs), "ran": len(plan.todo)}
    _tell(published, columns, about if as_json else None)
    context.exit(1 if published.problems else 0)


def _refuse_columns(study: Study, columns: list[str]) -> None:
    from workbench.publish import refuse_columns  # here: pandas is not needed while methods run

    refuse_columns([study.problem.name], columns)


def _carry_out(study: Study, plan: Plan, store: Store, means: Means, report: bool) -> Published:
    """Run what is to do and report on it, unless that is not wanted; return what there is to tell."""
    from workbench.jobs.execute import shortfall
    from workbench.jobs.problem import Published

    problems = _execute(study, plan, store, means)
    published = _published(store.root) if report else Published([], [])
    problems += published.problems
    problems += [sentence for sentence in plan.damaged if f"{sentence}." not in problems]  # what publishing left unsaid
    problems += shortfall(plan.jobs, store)
    return replace(published, problems=problems)


def _published(folder: Path) -> Published:
    """Write results.csv and report.html in `folder`; return what there is to tell."""
    from workbench.jobs.problem import Outputs
    from workbench.publish import publish  # here: pandas is not needed while methods run

    return publish([folder], Outputs(folder / "report.html", folder / "results.csv"))


def _tell(published: Published, columns: list[str], about: dict[str, Any] | None) -> None:
    """Print what came of the study, as one JSON object that begins with `about` where that is given."""
    from workbench.publish import tell, told

    if about is not None:
        print_json(about | told(published))
    else:
        tell(published, columns)
        for path in published.written:
            click.echo(str(path))
    for problem in published.problems:
        say(problem, err=True)


def _study(targets: tuple[str, ...], solvers: str | None, changes: dict[str, object]) -> Study:
    """Return the study that the arguments name, with the changes that the flags make to it."""
    from instances.declared.reading import read_declared
    from workbench.jobs.study import load_tables, shipped_studies, study_from
    from workbench.problems import PROBLEMS
    from workbench.settings import names

    shipped = shipped_studies()
    first = targets[0] if targets else "quick"
    if first in shipped or first.endswith(".toml"):
        path, given = shipped.get(first, Path(first)), targets[1:]
    else:
        path, given = None, targets
        if solvers is None:
            near = suggestion(first, shipped)
            raise InputError(f"compare: '{first}' is no study{near}; to run instances, name --solvers a,b")
    tables = load_tables(path) if path else {}
    name, base = (path.stem, path.parent) if path else ("compare", Path())
    try:
        problem = PROBLEMS.load(read_declared(str, tables.get("problem", "routing"), at=["problem"]))
        if solvers is not None:
            tables[problem.entries] = [{"name": name} for name in names(solvers, "--solvers")]
        study = study_from(tables, problem, name=name, base=base, changes=changes)
    except InputError as error:
        raise InputError(f"{path}: {error}" if path else str(error)) from None
    return study.with_files([Path(target) for target in given]) if given else study


def _planned(study: Study, folder: Path, retry: str | None, shard: str | None, dry_run: bool) -> tuple[Plan, Store]:
    """Make the items, state what is asked in the store (unless only a dry run), and return what is to do.

    The store is begun once every item has been made and every setting read: what cannot be run leaves nothing behind.
    """
    from workbench.jobs.execute import jobs_of, plan, statuses_to_retry
    from workbench.jobs.store import Store
    from workbench.settings import names
    from workbench.settings import shard as shard_of

    again = statuses_to_retry(study.problem, [] if retry is None else names(retry, "--retry"))
    part = (1, 1) if shard is None else shard_of(shard)
    store = Store(folder)
    sources: dict[str, Source[Any]] = {}
    jobs = jobs_of(study, keep=sources.setdefault)
    if not dry_run:
        store.create()
        store.keep_items(study.problem, sources)
        store.put_study(study.asked, [job.path for job in jobs])
    return plan(jobs, store, again).shard(*part), store


def _warn_of_crowding(study: Study, parallel: int, elsewhere: bool) -> None:
    from workbench.jobs.machine import available_cores

    threads = max(entry.threads for entry in study.entries)
    cores = available_cores()
    if threads * parallel > cores and not elsewhere:
        asked = f"{parallel} runs at once with {threads} threads each"
        say(f"warning: {asked} on {cores} cores: times will be those of a crowded machine", err=True)


def _slurm(file: Path | None, scheduler: str | None) -> Slurm | None:
    """Return what is asked of SLURM, or None."""
    if file is None:
        return None
    from workbench.jobs.slurm import read_slurm

    if scheduler is not None:
        raise InputError("--slurm: starts a scheduler of its own; give it or --scheduler")
    return read_slurm(file)


def _tell_plan(plan: Plan, parallel: int, queue: Slurm | None, as_json: bool) -> None:
    from workbench.jobs.progress import Estimate, duration

    if as_json:
        asked = {"todo": [job.path for job in plan.todo], "planned": len(plan.jobs), "jobs": parallel}
        print_json(asked | {"seconds_at_most": Estimate(plan.todo, parallel).left()})
        return
    for job in plan.todo:
        click.echo(job.path)
    longest = duration(Estimate(plan.todo, parallel).left())
    done = len(plan.jobs) - len(plan.todo)
    click.echo(
        f"{len(plan.todo)} runs to do ({done} of {len(plan.jobs)} stored), at most {longest} with {parallel} at once"
    )
    if queue:
        from workbench.jobs.slurm import job_script

        click.echo(job_script(queue), err=True)


@dataclass(frozen=True)
class Means:
    """What the runs are given: how many at once, the memory limit of each [bytes], a scheduler, or SLURM's jobs."""

    parallel: int
    memory_limit: int | None
    scheduler: str | None
    slurm: Slurm | None


def _execute(study: Study, plan: Plan, store: Store, means: Means) -> list[str]:
    """Run what is to do; return what could not be, a sentence each."""
    from workbench.jobs.backlog import Backlog
    from workbench.jobs.execute import run_locally
    from workbench.jobs.progress import StudyProgress

    if len(plan.todo) < len(plan.jobs):
        say(f"{len(plan.jobs) - len(plan.todo)} of {len(plan.jobs)} runs are stored already", err=True)
    if plan.stale:
        say(f"{plan.stale} stored runs are stale: other code made them (--retry stale runs them again)", err=True)
    if not plan.todo:
        return []
    with (
        StudyProgress(plan.todo, means.parallel, study.problem.spell) as progress,
        Backlog(plan.todo, store, plan.seen) as backlog,
    ):
        if means.scheduler is None and means.slurm is None:
            return run_locally(backlog, study.problem, means.parallel, progress, means.memory_limit)
        from workbench.jobs.cluster import run_on_cluster  # here: an extra

        with _scheduler(means) as address:
            return run_on_cluster(backlog, study.problem, address, progress, means.memory_limit)


@contextlib.contextmanager
def _scheduler(means: Means) -> Iterator[str]:
    """Give the address of the cluster's scheduler: the one that is named, or one of SLURM's jobs."""
    if means.slurm is None:
        yield means.scheduler or ""
        return
    from workbench.jobs.slurm import launched

    with launched(means.slurm) as address:
        yield address


def _reach(scheduler: str | None, queue: Slurm | None) -> None:
    """Refuse a cluster that is not there before anything is stored."""
    if queue is not None:
        from workbench.jobs.slurm import try_slurm

        try_slurm(queue)
    if scheduler is not None:
        from workbench.jobs.cluster import connected, threads_of  # here: an extra

        with connected(scheduler) as client:
            threads_of(client, scheduler)
