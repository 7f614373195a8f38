"""A study in SLURM jobs: what is submitted is what was asked; here sbatch is a stand-in that starts the jobs itself."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

pytest.importorskip("dask_jobqueue", reason="the extra 'cluster' is not installed")

from workbench.jobs.slurm import job_script, read_slurm

ASKED = """
jobs = 2
cores = 4
memory = "8GB"
walltime = "1-02:00:00"
queue = "short"
account = "uav"
directives = ["--constraint=avx2"]
prologue = ["module load python/3.12"]
python = "/opt/venv/bin/python"
"""
SBATCH = """#!/bin/bash
[ "$1" = --test-only ] && exit 0
cp "$1" "{folder}/job.$$.sh" # as sbatch does: who submits removes the script at once
echo "$(cat "$1")" >> "{folder}/submitted"
setsid bash "{folder}/job.$$.sh" > "{folder}/job.$$.out" 2>&1 &
echo "Submitted batch job $!"
"""
SCANCEL = """#!/bin/bash
for job in "$@"; do echo "$job" >> "{folder}/cancelled"; kill -- "-$job"; done
"""
STUDY = """
seeds = 2
time_limit = 5
files = ["given/*.json"]

[[solvers]]
name = "misbehaving:Honest"
"""


@pytest.fixture
def sbatch(tmp_path, monkeypatch):
    """Put a stand-in for SLURM on the path; returns a function that writes what sbatch is."""
    folder = tmp_path / "bin"
    folder.mkdir()
    monkeypatch.setenv("PATH", str(folder), prepend=os.pathsep)

    def write(text: str = SBATCH) -> Path:
        for name, program in (("sbatch", text), ("scancel", SCANCEL)):
            (folder / name).write_text(program.replace("{folder}", str(folder)))
            (folder / name).chmod(0o755)
        return folder

    return write


def test_the_script_asks_for_what_the_file_says(tmp_path):
    (tmp_path / "slurm.toml").write_text(ASKED)
    script = job_script(read_slurm(tmp_path / "slurm.toml"))
    for line in (
        "#SBATCH -p short",
        "#SBATCH -A uav",
        "#SBATCH --cpus-per-task=4",
        "#SBATCH --mem=8G",
        "#SBATCH -t 1-02:00:00",
        "#SBATCH --constraint=avx2",
        "module load python/3.12",
    ):
        assert line in script.splitlines()
    (worker,) = [line for line in script.splitlines() if "dask_worker" in line]
    assert worker.startswith("/opt/venv/bin/python -m distributed.cli.dask_worker tcp://")
    assert "--nthreads 4 " in worker  # one worker a job, so many runs at once


def test_a_study_runs_in_two_jobs_that_are_cancelled_at_its_end(cli, tmp_path, instance_folder, stored_json, sbatch):
    folder = sbatch()
    (tmp_path / "study.toml").write_text(STUDY)
    asked = 'jobs = 2\ncores = 1\nmemory = "1GB"\nwalltime = "00:10:00"\ninterface = "lo"\n'
    (tmp_path / "slurm.toml").write_text(asked)
    code, _, told = cli("compare", "study.toml", "--out", "runs", "--no-report", "--slurm", "slurm.toml")
    assert code == 0, told
    assert "waiting for the first of 2 SLURM jobs to begin" in told
    runs = stored_json(tmp_path / "runs")
    assert {run["status"] for run in runs.values()} == {"FEASIBLE"}
    assert len(runs) == 6
    assert (folder / "submitted").read_text().count("#SBATCH -J workbench") == 2
    assert len((folder / "cancelled").read_text().split()) == 2


def test_a_dry_run_shows_the_script_and_submits_nothing(cli, tmp_path, instance_folder, sbatch):
    folder = sbatch()
    (tmp_path / "slurm.toml").write_text(ASKED)
    code, told, script = cli(
        "compare", "given", "--solvers", "greedy", "--time-limit", 5, "--slurm", "slurm.toml", "--dry-run"
    )
    assert code == 0
    assert "with 8 at once" in told
    assert "#SBATCH -A uav" in script
    assert not (folder / "submitted").exists()


def test_jobs_that_cannot_be_submitted_are_told(cli, tmp_path, instance_folder, sbatch, monkeypatch):
    (tmp_path / "slurm.toml").write_text(ASKED)
    asked = ("compare", "given", "--solvers", "greedy", "--time-limit", 5, "--out", "runs", "--slurm", "slurm.toml")
    sbatch("#!/bin/bash\necho 'sbatch: error: Invalid account' >&2\nexit 1\n")
    code, _, told = cli(*asked)
    assert code == 2
    assert told == "workbench: --slurm: sbatch would not take the jobs (sbatch: error: Invalid account)\n"
    monkeypatch.setenv("PATH", str(tmp_path))
    assert cli(*asked)[2] == "workbench: --slurm: there is no sbatch here; run this where jobs are submitted from\n"
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(
    ("was", "now", "sentence"),
    [
        ("jobs = 2", "", "slurm.toml: the key 'jobs' is missing"),
        ("jobs = 2", "jobs = 0", "slurm.toml: jobs must be a whole number from 1 to 10000, got 0"),
        ("jobs = 2", "jobs = 2.5", "slurm.toml: jobs must be a whole number from 1 to 10000, got 2.5"),
        ('"8GB"', '"eight"', "slurm.toml: memory: must be a size such as 2GB"),
        ('"1-02:00:00"', '"a while"', "slurm.toml: walltime must be a time such as 04:00:00"),
        ('"uav"', '"uav\\nrm -r ~"', "slurm.toml: account must be one printable line"),
        ('["--constraint=avx2"]', '"-C x"', "slurm.toml: directives must be a list of values, each one printable line"),
        ("queue =", "que =", "slurm.toml: unknown key 'que'; did you mean 'queue'?"),
    ],
)  # fmt: skip
def test_what_cannot_be_asked_for_is_a_sentence(cli, tmp_path, instance_folder, was, now, sentence):
    (tmp_path / "slurm.toml").write_text(ASKED.replace(was, now))
    code, _, told = cli("compare", "given", "--solvers", "greedy", "--out", "runs", "--slurm", "slurm.toml")
    assert code == 2
    assert told.startswith(f"workbench: {sentence}")
    assert not (tmp_path / "runs").exists()


def test_one_scheduler_at_a_time(cli, tmp_path, instance_folder):
    (tmp_path / "slurm.toml").write_text(ASKED)
    told = cli("compare", "given", "--solvers", "greedy", "--slurm", "slurm.toml", "--scheduler", "tcp://127.0.0.1:1")[
        2
    ]
    assert told == "workbench: --slurm: starts a scheduler of its own; give it or --scheduler\n"
