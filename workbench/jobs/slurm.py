"""SLURM: a dask.distributed cluster of SLURM jobs for one study (extra `cluster`, dask-jobqueue).

    jobs = 4                       # SLURM jobs, each one dask worker
    cores = 8                      # of each: so many runs at once
    memory = "32GB"                # of each, shared by its runs
    walltime = "04:00:00"          # of each; a job that ends before the study does is submitted again
    queue = "short"                # partition
    account = "uav"
    interface = "ib0"              # network interface of scheduler and workers
    directives = ["--constraint=avx2"]                      # more lines for #SBATCH
    prologue = ["module load python/3.12"]                  # lines of the script before the worker starts
    python = "/home/me/workbench/.venv/bin/python"          # by default the one that runs `compare`

The scheduler runs in the process of `compare`, which submits the jobs, and cancels them at its end however it ends.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import click
from msgspec import Meta, field

from instances.declared.reading import read_declared
from instances.declared.types import Table, Text, about
from instances.disk import read_toml
from instances.errors import InputError, naming, one_line
from workbench.options import MOST_JOBS
from workbench.settings import memory

PATIENCE = 60
"""Seconds that sbatch is given to say whether it would take a job."""
LONGEST_REASON = 300
"""Characters repeated of what sbatch says."""


LONGEST_LINE = 200
Line = Annotated[
    str,
    Meta(
        max_length=LONGEST_LINE,
        pattern=r"^[^\x00-\x1f\x7f]*[^\s\x00-\x1f\x7f][^\x00-\x1f\x7f]*$",
        extra={"words": f"one printable line of at most {LONGEST_LINE} characters"},
    ),
]
Jobs = Annotated[int, Meta(ge=1, le=MOST_JOBS)]


class Slurm(Table, frozen=True, kw_only=True):
    """What is asked of SLURM: `jobs` of `cores` cores and `memory` each; the rest as sbatch takes it."""

    jobs: Annotated[Jobs, about("SLURM jobs, each one dask worker", example=4)]
    cores: Annotated[Jobs, about("of each: so many runs at once", example=8)]
    memory: Annotated[Text, about("of each, shared by its runs", example="32GB")]
    walltime: Annotated[
        Annotated[str, Meta(pattern=r"^(\d{1,3}-)?\d{1,4}(:\d{1,2}){0,2}$")],
        about("of each, as sbatch takes it", example="04:00:00", words="a time such as 04:00:00 or 1-02:00:00"),
    ]
    queue: Annotated[Line | None, about("partition", example="short")] = None
    account: Annotated[Line | None, about("that pays", example="uav")] = None
    interface: Annotated[Line | None, about("network interface of scheduler and workers", example="ib0")] = None
    python: Annotated[Line, about("by default the one that runs `compare`", example="/opt/venv/bin/python")] = (
        sys.executable
    )
    directives: Annotated[list[Line], about("more lines for #SBATCH", example=["--constraint=avx2"])] = field(
        default_factory=list
    )
    prologue: Annotated[
        list[Line], about("lines of the script before the worker starts", example=["module load python/3.12"])
    ] = field(default_factory=list)

    @property
    def asked(self) -> dict[str, Any]:
        """What dask-jobqueue is told; a job is one worker, so that its runs share the job's memory."""
        return {
            "cores": self.cores,
            "processes": 1,
            "memory": self.memory,
            "walltime": self.walltime,
            "queue": self.queue,
            "account": self.account,
            "interface": self.interface,
            "python": self.python,
            "job_extra_directives": self.directives,
            "job_script_prologue": self.prologue,
            "job_name": "workbench",
        }


def read_slurm(path: Path) -> Slurm:
    """Return what the file asks for; InputError names file, key and value of what cannot be."""
    table = read_toml(path)
    with naming(path):
        slurm = read_declared(Slurm, table)
        memory(slurm.memory, "memory")
        return slurm


def job_script(slurm: Slurm, scheduler: str = "tcp://SCHEDULER:PORT") -> str:
    """Return the script that is submitted for each job."""
    script: str = _library().slurm.SLURMJob(scheduler=scheduler, name="workbench", **slurm.asked).job_script()
    return script


def try_slurm(slurm: Slurm) -> None:
    """Ask sbatch whether it would take the jobs, submitting none; InputError says why not."""
    script = job_script(slurm)
    with tempfile.NamedTemporaryFile("w", suffix=".sh") as file:
        file.write(script)
        file.flush()
        try:
            asked = ["sbatch", "--test-only", file.name]
            done = subprocess.run(asked, capture_output=True, text=True, timeout=PATIENCE, check=False)
        except FileNotFoundError:
            raise InputError("--slurm: there is no sbatch here; run this where jobs are submitted from") from None
        except subprocess.TimeoutExpired:
            raise InputError(f"--slurm: sbatch has said nothing for {PATIENCE} s") from None
    if done.returncode:
        reason = one_line(done.stderr.strip() or f"exit code {done.returncode}", LONGEST_REASON)
        raise InputError(f"--slurm: sbatch would not take the jobs ({reason})")


@contextmanager
def launched(slurm: Slurm) -> Iterator[str]:
    """Submit the jobs and give the address of their scheduler once the first has begun; cancel them at the end."""
    options = {"dashboard_address": None}
    with _library().SLURMCluster(n_workers=slurm.jobs, scheduler_options=options, **slurm.asked) as cluster:
        cluster.adapt(minimum_jobs=slurm.jobs, maximum_jobs=slurm.jobs)  # what ends before us is submitted again
        click.echo(f"waiting for the first of {slurm.jobs} SLURM jobs to begin", err=True)
        cluster.wait_for_workers(1)
        yield cluster.scheduler_address


def _library() -> Any:
    """Return dask-jobqueue; InputError where it is not installed."""
    try:
        import dask_jobqueue.slurm
    except ImportError:
        raise InputError("--slurm: needs dask-jobqueue, of the extra 'cluster', which is not installed") from None
    return dask_jobqueue
