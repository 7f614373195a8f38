"""Families of others in a study: imported and run in a child process, which leaves the scenario in a folder.

The costs of its legs are computed here, as for every family. The child is that of a run (`workbench.jobs.runner`):
whatever the family does in it, to itself or for ever, ends in a sentence.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from formulations.limits import Limits
from instances.errors import InputError
from instances.families import FAMILIES, Family, Legs
from instances.instance import check_size
from instances.registry import MethodRegistry
from instances.scenario import Scenario
from instances.scenario_folder import keep_scenario, kept_scenario
from workbench.jobs.job import Job
from workbench.jobs.problem import Claim, Listener, Problem
from workbench.jobs.runner import run

LONGEST = 60.0
"""Seconds a family may take for one scenario."""


def make_elsewhere(
    family: str, n_tasks: int, n_depots: int, seed: int, parameters: Mapping[str, Any]
) -> tuple[Scenario, Legs]:
    """Return the scenario that a family which is not built in makes, and what its legs are; InputError where none."""
    check_size(n_tasks, n_depots)
    with TemporaryDirectory() as folder:
        job = Job("", family, parameters, seed, LONGEST)
        found = run(MAKING, job, _Wanted(family, n_tasks, n_depots, Path(folder)))
        if found.own["legs"] is None:
            raise InputError(f"family {family} made no scenario ({found.status}: {found.message})")
        scenario = kept_scenario(Path(folder))
    if (scenario.n_tasks, scenario.n_depots) != (n_tasks, n_depots):
        raise InputError(f"family {family} made {scenario.n_tasks} tasks and {scenario.n_depots} depots, not as asked")
    return scenario, Legs[found.own["legs"]]


@dataclass(frozen=True)
class _Wanted:
    """What the child is asked for, and the folder it writes into."""

    name: str
    n_tasks: int
    n_depots: int
    folder: Path
    digest: str = ""


class _Families(MethodRegistry[Any]):
    """The registry as the child sees it: a method is a family with its parameters."""

    def make(self, name: str, options: Mapping[str, Any] | None = None) -> Any:
        """Return the family and its parameters."""
        return FAMILIES.load(name), options or {}


class _Making(Problem[_Wanted]):
    """As much of a problem as one run needs; its product is the name of the legs."""

    name = "family"
    methods = _Families("family", FAMILIES.built_in)
    item = "scenario"
    product = str
    found = "legs"
    statuses = ("FEASIBLE",)

    def solve(
        self, method: tuple[Family, Any], item: _Wanted, limits: Limits, seed: int, tell: Listener, start: Any
    ) -> Claim:
        """Make the scenario and leave it in the folder."""
        family, parameters = method
        keep_scenario(family.scenario(item.n_tasks, item.n_depots, seed, parameters), item.folder)
        return Claim(Legs(family.legs).name, status="FEASIBLE", stopped_by="finished")

    def judge(self, item: _Wanted, product: Any, claimed: float | None) -> tuple[float | None, str]:
        """Take legs that are known here."""
        return (0.0, "") if product in Legs.__members__ else (None, "made legs that are unknown here")

    def describe(self, item: _Wanted) -> dict[str, Any]:
        """Return the name."""
        return {"name": item.name}

    def own_columns(self, item: _Wanted, product: Any) -> dict[str, Any]:
        """Return the name of the legs."""
        return {"legs": product}


MAKING = _Making()  # type: ignore[abstract] # no study asks for it: nothing is read, kept or published
