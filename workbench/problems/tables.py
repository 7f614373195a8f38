"""The study files of each problem as they are declared: their items, and their methods."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import field

from instances.declared.types import FileName, NotNegative, Text, Whole, about
from workbench.jobs.study_table import (
    Counts,
    FamilyTable,
    Iterations,
    MethodTable,
    SolverTable,
    StudyTable,
    Texts,
    Threads,
)

Amount = Whole | NotNegative
"""A whole number stays one: it enters the digest of a problem as it is written."""
AMOUNT = "a number of at least 0"
FILES = "a file, folder or pattern, or a list of them"


class RoutingTable(StudyTable, frozen=True, kw_only=True):
    """A study of routing: instances from files and families, and solvers."""

    problem: Annotated[Literal["routing"], about("what is studied", example="routing")] = "routing"
    threads: Threads = None
    iterations: Iterations = None
    files: Annotated[
        FileName | list[FileName],
        about("instances, relative to the study", example=["sets/*.json"], words=FILES),
    ] = field(default_factory=list)
    families: Annotated[
        list[FamilyTable],
        about("instances that are generated", example=[{"family": "uniform", "tasks": [10, 20], "depots": 3}]),
    ] = field(default_factory=list)
    solvers: Annotated[list[SolverTable], about("who solves them, at least one", example=[{"name": "greedy"}])] = field(
        default_factory=list
    )


class PlacementTable(StudyTable, frozen=True, kw_only=True):
    """A study of placement: regions with numbers of tasks, a setting, and methods."""

    problem: Annotated[Literal["placement"], about("what is studied", example="placement")] = "placement"
    regions: Annotated[
        Texts, about("files relative to the study, or square, the paper's of 20 km", example=["square", "a.geojson"])
    ] = field(default_factory=lambda: ["square"])
    tasks: Annotated[Counts, about("number of tasks n", example=[10, 20, 40])] = field(default_factory=lambda: [40])
    tests: Annotated[
        Text | None, about("test points: cells such as 20x20 unless given, or a .csv of x, y, weight", example="20x20")
    ] = None
    signal_sd: Annotated[Amount | None, about("σ_f of the kernel, 30 unless given", example=30.0, words=AMOUNT)] = None
    length_scale: Annotated[
        Amount | Text | None,
        about(
            "of the kernel, 4000 m unless given", "m", example=4000.0, words="a number of at least 0, or a text lx,ly"
        ),
    ] = None
    noise_sd: Annotated[
        Amount | None, about("σ_n of a reading at a task, 1 unless given", example=1.0, words=AMOUNT)
    ] = None
    test_noise_sd: Annotated[
        Amount | None, about("of a reading at a test point, noise_sd unless given", example=1.0, words=AMOUNT)
    ] = None
    methods: Annotated[list[MethodTable], about("who places them, at least one", example=[{"name": "nlp"}])] = field(
        default_factory=list
    )


class MovingCostTable(StudyTable, frozen=True, kw_only=True):
    """A study of moving costs: scenarios from files and families, and methods."""

    problem: Annotated[Literal["moving-cost"], about("what is studied", example="moving-cost")] = "moving-cost"
    scenarios: Annotated[
        FileName | list[FileName], about("relative to the study", example=["survey.toml"], words="a file, or a list")
    ] = field(default_factory=list)
    families: Annotated[
        list[FamilyTable],
        about("scenarios that are generated", example=[{"family": "wind-vortices", "tasks": 12, "depots": 3}]),
    ] = field(default_factory=list)
    starts: Annotated[Counts, about("only the first so many nodes, all unless given", example=[10, 20])] = field(
        default_factory=list
    )
    methods: Annotated[list[MethodTable], about("who plans them, at least one", example=[{"name": "refined"}])] = field(
        default_factory=list
    )
