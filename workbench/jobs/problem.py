"""The Problem protocol: what the machinery of jobs asks of a problem, and nothing more.

    study's tables → items → (fresh process) a method's claims → (parent) verified or refuted → a Run

An item is what is solved: an instance, a region with test points, a scenario in wind. A product is what solves it:
routes, points, costs with their paths; between processes and in files it is a JSON value.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from formulations.limits import Limits
from instances.errors import InputError
from instances.registry import MethodRegistry
from reports.record import Run
from workbench.jobs.study_table import StudyTable

if TYPE_CHECKING:
    from reports.columns import Column
    from workbench.summary import Summary


class Named(Protocol):
    """What every item has."""

    @property
    def name(self) -> str:
        """Short name."""
        ...

    @property
    def digest(self) -> str:
        """Digest of everything but the name."""
        ...


Item = TypeVar("Item", bound=Named)
ItemOut = TypeVar("ItemOut", bound=Named, covariant=True)


class Source(Protocol[ItemOut]):
    """Where one item of a study comes from, before it is made."""

    def load(self) -> ItemOut:
        """Read or make the item; InputError says why it cannot be."""
        ...


@dataclass(frozen=True)
class Claim:
    """What a method says, streamed or at the end: nothing of it is believed before `Problem.judge`.

    product : JSON value, or None. objective, bound, tolerance : in the problem's unit, lower being better.
    The other fields are those of the end (see `reports.record`).
    """

    product: Any = None
    objective: float | None = None
    bound: float | None = None
    status: str = ""
    stopped_by: str = ""
    message: str = ""
    tolerance: float = 0.0
    statistics: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Outputs:
    """Where what is published about runs is written, each None where it is not asked for.

    raw_table : texts in the table as they are, also those a spreadsheet takes for formulas. extra : further outputs by
    the name of their flag, which not every problem has.
    """

    page: Path | None = None
    table: Path | None = None
    extra: Mapping[str, Path] = field(default_factory=dict)
    raw_table: bool = False

    def of(self, known: tuple[str, ...], suffix: str) -> Outputs:
        """Return those a problem has, ``-suffix`` added to the names of page and table where there is one."""

        def beside(path: Path | None) -> Path | None:
            return path.with_name(f"{path.stem}-{suffix}{path.suffix}") if path and suffix else path

        extra = {flag: path for flag, path in self.extra.items() if flag in known}
        return Outputs(beside(self.page), beside(self.table), extra, self.raw_table)


@dataclass(frozen=True)
class Published:
    """What came of publishing.

    written : files. problems : what is wrong with the runs, a sentence each. damaged : how many of these are files that
    could not be read. regressed : whether any run got worse. comparable : whether there was anything to compare with.
    summaries : tables about the runs. notes : what else a reader must know, a sentence each.
    """

    written: list[Path]
    problems: list[str]
    damaged: int = 0
    regressed: bool = False
    comparable: bool = True
    summaries: list[Summary] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


Listener = Callable[[Claim], None]
"""Takes a claim while a method works."""


class Problem(Protocol[Item]):
    """One problem of the paper, as the machinery sees it. Subclass it explicitly to inherit what has a default."""

    name: str
    """As in a study's ``problem = …`` and in stored runs."""
    methods: MethodRegistry[Any]
    item: str
    """What an item is, in a sentence: instance, region, scenario."""
    entries: str
    """The study's table of methods: ``solvers`` or ``methods``."""
    study: type[StudyTable]
    """How its studies are declared."""
    limits: tuple[str, ...] = ()
    """Which of ``threads`` and ``iterations`` its methods know."""
    default_limit: float = 10.0
    """Time limit [s] where a study names none."""
    outputs: tuple[str, ...] = ()
    """Flags of `workbench report` beyond --out and --csv that it has."""
    product: Any
    """Type of a product, as msgspec decodes it from a message."""
    found: str
    """What a product is, in a sentence: routes, points, paths."""
    statuses: tuple[str, ...]
    """How a method may end on its own; the machinery adds KILLED, ERROR and NO_SOLUTION."""

    def sources(self, study: Any, base: Path) -> Iterable[Source[Item]]:
        """Return where the items of a `study`, as declared, come from, files relative to `base`."""
        ...

    def from_files(self, paths: Iterable[Path]) -> Iterable[Source[Item]]:
        """Return the items that files or folders named on the command line mean; InputError where it has no such."""
        raise InputError(f"compare: INSTANCES cannot be given with a {self.name} study")

    def size(self, item: Item) -> int:
        """Return the number of tasks, which an entry's ``max_tasks`` is compared with."""
        ...

    def write(self, item: Item, folder: Path) -> None:
        """Keep `item` in its folder of a store, with what every run on it will need."""
        ...

    def keep_beside(self, source: Source[Item], folder: Path) -> None:
        """Keep, beside an item in its folder, what lies beside its source and reports are to know."""
        return

    def read(self, folder: Path) -> Item:
        """Return the item kept in `folder`; InputError where it is missing, damaged or another."""
        ...

    def describe(self, item: Item) -> dict[str, Any]:
        """Return what a run says about its item: name, digest and more."""
        ...

    # in the child process

    def accepts(self, method: Any, item: Item) -> str | None:
        """Return why `method` does not take `item`, in a sentence, or None where it does."""
        return None

    def prepare(self, method: Any, item: Item) -> None:
        """Do what is not part of the solve: imports, compilation. Not timed."""

    def solve(self, method: Any, item: Item, limits: Limits, seed: int, tell: Listener, start: Any) -> Claim:
        """Run `method`, telling what it finds on the way, and return its last claim. start : a product, or None."""
        ...

    # in the parent

    def bound(self, item: Item) -> float | None:
        """Return a bound that is known of `item` before anything is run, or None."""
        return None

    def judge(self, item: Item, product: Any, claimed: float | None) -> tuple[float | None, str]:
        """Return the objective of `product`, re-computed, and what is wrong with the claim, a sentence or "".

        The objective is None where the product is no solution at all.
        """
        ...

    def refute_ending(self, item: Item, claim: Claim, objective: float | None) -> str:
        """Return what is wrong with the last claim beside its product, a sentence or ""; `objective` is verified.

        A bound above the objective is refuted by the machinery, whatever the problem.
        """
        return ""

    def own_columns(self, item: Item, product: Any) -> dict[str, Any]:
        """Return this problem's own columns of a run (`reports.record.OWN`) whose verified product is `product`."""
        ...

    def spell(self, run: Run) -> str:
        """Return a run's objective for people, with its unit."""
        ...

    def check(self, folder: Path) -> tuple[str, list[str]]:
        """Return what runs of a store were looked at, in words, and everything wrong with them, a sentence each."""
        ...

    def columns(self) -> Sequence[Column]:
        """Return the columns that the summary of its runs may have."""
        return ()

    def publish(self, folders: list[Path], outputs: Outputs) -> Published:
        """Summarise stored runs and write what is asked for about them."""
        ...
