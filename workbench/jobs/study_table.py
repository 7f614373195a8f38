"""A study file as it is declared: what every study has, and its methods; each problem adds keys of its own."""

from __future__ import annotations

from typing import Annotated, Any, TypeVar

from msgspec import Meta, field

from formulations.limits import LARGEST_SEED, LONGEST, MOST_THREADS
from instances.declared.types import Name, Natural, Table, Text, Whole, about
from workbench.jobs.tables import MOST_RUNS

T = TypeVar("T")

TimeLimit = Annotated[float, Meta(gt=0, le=LONGEST)]
Seeds = Annotated[int, Meta(ge=1, le=MOST_RUNS)] | list[Annotated[int, Meta(ge=0, le=LARGEST_SEED)]]
Threads = Annotated[Annotated[int, Meta(ge=1, le=MOST_THREADS)] | None, about("of each run, 1 unless given", example=1)]
Iterations = Annotated[Whole | None, about("limit on a method's own iterations", example=1000)]
Counts = Natural | list[Natural]
Texts = Text | list[Text]
SEEDS = "how many, from 1 to 1000000, or a list of whole numbers from 0 to 2147483647"


class Limited(Table, frozen=True, kw_only=True):
    """What a study and each of its methods may say."""

    seeds: Annotated[Seeds | None, about("so many (0, 1, 2 …), or those listed", example=3, words=SEEDS)] = None
    time_limit: Annotated[
        TimeLimit | list[TimeLimit] | None, about("wall clock of each run, or several to try", "s", example=10.0)
    ] = None


class MethodTable(Limited, frozen=True, kw_only=True):
    """One method; what it says of seeds and limits goes before the study's."""

    name: Annotated[Text, about("of a registered one, or module:Class", example="greedy")]
    options: Annotated[
        dict[str, Any], about("its options; every list is tried in every combination", example={"starts": [4, 8]})
    ] = field(default_factory=dict)
    max_tasks: Annotated[Whole | None, about("larger items are not given to it", example=200)] = None


class SolverTable(MethodTable, frozen=True, kw_only=True):
    """One solver; what it says of seeds and limits goes before the study's."""

    threads: Threads = None
    iterations: Iterations = None


class FamilyTable(Table, frozen=True, kw_only=True):
    """Generated instances: every combination of what is listed is made."""

    family: Annotated[Texts, about("of workbench families, or module:NAME", example="uniform")]
    tasks: Annotated[Counts, about("number of tasks n", example=[10, 20])]
    depots: Annotated[Counts, about("number of depots m", example=3)]
    seeds: Annotated[Seeds, about("of the generator: so many, or those listed", example=[1, 2], words=SEEDS)] = 1
    parameters: Annotated[
        dict[str, Any], about("of the family; every list is tried", example={"wind": ["none", "shear"]})
    ] = field(default_factory=dict)


class Changes(Limited, frozen=True, kw_only=True):
    """What stands in place of what a study and its methods say."""

    threads: Threads = None
    iterations: Iterations = None


class StudyTable(Limited, frozen=True, kw_only=True):
    """What every study may say; a problem's own adds ``problem``, its items, and its methods."""

    name: Annotated[Name | None, about("of the study; the file's unless given", example="mine")] = None
    description: Annotated[str, about("for people", example="exact against searches")] = ""


def listed(value: T | list[T] | None) -> list[T]:
    """Return `value` as a list: itself, or the only thing in it."""
    return value if isinstance(value, list) else [] if value is None else [value]


def seeds_of(seeds: int | list[int]) -> tuple[int, ...]:
    """Return seeds: so many from 0, or those listed."""
    return tuple(range(seeds)) if isinstance(seeds, int) else tuple(seeds)
