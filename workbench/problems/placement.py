"""The placement problem: task locations of most information in a region (sub-problem 1 of the paper).

As everywhere, lower is better: the objective of a run is −I [nats], and its bound minus the certificate, which is
computed once for each problem. `check` computes it again: it is the claim that nothing better exists, and only its own
argument can show it. With criterion "j" both are of ½ log(J₀/J) instead (`task_location/variance_reduction.py`).

A store explains itself: the values of a map of weights at the test points are kept as the points' own, a map of prior
sd by its nodes, so that what is judged again needs no file.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from shapely.geometry import mapping

from formulations.limits import Limits
from formulations.task_location.certificate import Certificate, certificate
from formulations.task_location.criterion import Convention
from formulations.task_location.placement import (
    PlacementMethod,
    PlacementProblem,
    PlacementStatus,
    checked_points,
    place,
    share_of,
)
from formulations.task_location.registry import METHODS
from formulations.task_location.setting import goal_of, rows_of_tests, site_of, tests_of, weights_of
from formulations.task_location.variance_reduction import NAME, VarianceReduction
from instances.disk import write_aside
from instances.environment.region import Region, single_polygon
from instances.environment.site import Site
from instances.errors import naming
from instances.value_maps import read_value_map
from reports.damage import reading
from reports.record import ITEM_FILES, Run, read_json, study_title
from workbench.jobs.check import check_runs
from workbench.jobs.problem import Claim, Listener, Outputs, Problem, Published, Source
from workbench.jobs.study_table import listed
from workbench.problems.publishing import published, without
from workbench.problems.tables import PlacementTable
from workbench.summary import Summary

if TYPE_CHECKING:
    from reports.columns import Column

SETTING = ("tests", "signal_sd", "length_scale", "noise_sd", "test_noise_sd", "criterion")
"""Keys of a study that say how information is measured."""
TOLERANCE = 1e-6
"""Relative: a claim further from the recomputed information is refuted."""
LOOSER = 1e-3
"""Relative: a certificate lower by more than this than the recomputed one is not believed."""


@dataclass(frozen=True)
class PlacementItem:
    """One problem as JSON values: what the child process rebuilds it from, its name, and its certificate [nats]."""

    name: str
    polygon: dict[str, Any]
    setting: dict[str, Any]
    n_tasks: int
    certificate: float | None = None

    def __reduce__(self) -> tuple[type[PlacementItem], tuple[Any, ...]]:
        """Pickle without `problem`: its eigendecomposition belongs to the search."""
        return PlacementItem, (self.name, self.polygon, self.setting, self.n_tasks, self.certificate)

    @cached_property
    def digest(self) -> str:
        """First 12 hexadecimal digits of the SHA-256 of everything but name and certificate."""
        content = json.dumps([self.polygon, self.setting, self.n_tasks], sort_keys=True)
        return hashlib.sha256(content.encode()).hexdigest()[:12]

    @cached_property
    def problem(self) -> PlacementProblem:
        """The problem; InputError says what is wrong with it."""
        region = Region(single_polygon(self.polygon))
        return PlacementProblem(region, goal_of(region, **self.setting), self.n_tasks)

    def load(self) -> PlacementItem:
        """Return itself: nothing is left to make."""
        return self


class PlacementStudy(Problem[PlacementItem]):
    """Regions with test points, and points in them."""

    name = "placement"
    methods = METHODS
    item = "problem"
    entries = "methods"
    study = PlacementTable
    default_limit = 60.0
    product = list[tuple[float, float]]
    found = "points"
    statuses = tuple(status.value for status in PlacementStatus)
    outputs = ("figures",)

    def sources(self, study: PlacementTable, base: Path) -> Iterable[Source[PlacementItem]]:
        """Return every region with every number of tasks."""
        setting = {key: value for key in SETTING if (value := getattr(study, key)) is not None}
        setting |= {key: str(setting[key]) for key in ("tests", "length_scale") if key in setting}
        if str(setting.get("tests", "")).lower().endswith(".csv"):
            setting["tests"] = rows_of_tests(base / setting["tests"]).tolist()
        for region in listed(study.regions):
            site = site_of(None if region == "square" else base / region)
            stem = region if region == "square" else Path(region).stem
            polygon = json.loads(json.dumps(mapping(site.region.polygon)))
            mapped = setting | _of_maps(study, base, site, setting)
            for count in listed(study.tasks):
                item = PlacementItem(f"{stem}-n{count}", polygon, mapped, count)
                _ = item.problem  # refuse now what cannot be built later
                yield item

    def size(self, item: PlacementItem) -> int:
        """Return n."""
        return item.n_tasks

    def write(self, item: PlacementItem, folder: Path) -> None:
        """Keep the problem with its certificate, computed here, once."""
        path = folder / ITEM_FILES[self.name][0]
        if path.exists():
            return
        began = time.perf_counter()
        bound = _certificate(item)
        stated = {"bound": bound.bound, "kind": bound.kind, "elapsed": time.perf_counter() - began}
        content = {"name": item.name, "polygon": item.polygon, "setting": item.setting, "n_tasks": item.n_tasks}
        write_aside(path, json.dumps({"schema": 1, "problem": self.name, **content, "certificate": stated}))

    def read(self, folder: Path) -> PlacementItem:
        """Return the problem kept in `folder`."""
        path = folder / ITEM_FILES[self.name][0]
        with reading(path, "a placement problem"):
            data = read_json(path)
            bound = float(data["certificate"]["bound"])
            item = PlacementItem(str(data["name"]), data["polygon"], data["setting"], data["n_tasks"], bound)
            _ = item.problem
        return item

    def describe(self, item: PlacementItem) -> dict[str, Any]:
        """Return name, digest and size."""
        return {"name": item.name, "digest": item.digest, "n_tasks": item.n_tasks, "n_depots": 0}

    def prepare(self, method: PlacementMethod, item: PlacementItem) -> None:
        """Let the method import."""
        method.prepare(item.problem)

    def solve(
        self, method: PlacementMethod, item: PlacementItem, limits: Limits, seed: int, tell: Listener, start: Any
    ) -> Claim:
        """Search, streaming improvements."""
        problem = PlacementItem(item.name, item.polygon, item.setting, item.n_tasks).problem
        found = place(
            problem,
            method,
            type(method).__name__,
            seed=seed,
            limits=limits,
            observe=lambda elapsed, value, points: tell(Claim(points.tolist(), -value)),
        )
        return Claim(
            found.points.tolist(),
            -problem.criterion.value(found.points),
            None,
            found.status.value,
            stopped_by=found.stopped_by,
        )

    def bound(self, item: PlacementItem) -> float | None:
        """Return minus the certificate."""
        return None if item.certificate is None else -item.certificate

    def judge(self, item: PlacementItem, product: Any, claimed: float | None) -> tuple[float | None, str]:
        """Return minus what the points are worth [nats], and what is wrong with them or the claim."""
        try:
            points = checked_points(item.problem, np.array(product, dtype=float), "the method")
        except RuntimeError as error:
            return None, str(error)
        value = item.problem.criterion.value(points)
        if claimed is None or abs(-claimed - value) <= TOLERANCE * abs(value):
            return -value, ""
        return -value, f"claimed {-claimed!r} nats, but its points are worth {value!r}"

    def own_columns(self, item: PlacementItem, product: Any) -> dict[str, Any]:
        """Return the points and what they are worth under every convention and the criterion."""
        worth = {} if product is None else _worth(item, product)
        value = worth.get(_maximised(item))
        bound = item.certificate
        ratio = None if value is None or bound is None else share_of(value, bound)
        information = worth.get(Convention.BOTH_NOISY)
        about = {"points": product, "mutual_information": information, "certificate": bound, "ratio": ratio}
        return about | {"information": worth}

    def spell(self, run: Run) -> str:
        """Return what the points are worth in nats."""
        return "no placement" if run.objective is None else f"{-run.objective:.4f} nats"

    def check(self, folder: Path) -> tuple[str, list[str]]:
        """Recompute every claim from the points and the problem beside them, and every certificate."""
        from reports.placement_store import placement_contradictions, read_placements  # here: pandas takes its time

        runs, items, problems = check_runs(self, folder, _false_certificate, _false_claims)
        found = placement_contradictions(read_placements(folder)[0])
        problems += [f"{path}: {sentence}" for path, sentence in found]
        return f"{runs} placement runs on {items} problems", problems

    def columns(self) -> Sequence[Column]:
        """Return the columns of the summary."""
        from reports.columns import PLACEMENTS

        return PLACEMENTS

    def publish(self, folders: list[Path], outputs: Outputs) -> Published:
        """Put the methods side by side on each problem."""
        from reports.pages.placement import placement_frame, placement_summary, write_placement_page
        from reports.placement_store import placement_contradictions, read_placements

        runs, damaged = read_placements(*folders)
        frame, title = placement_frame(runs), f"Task locations: {study_title(folders)}"
        false = [sentence for _, sentence in placement_contradictions(runs)]
        return published(
            outputs,
            frame,
            [run["code"] for run in runs],
            lambda: [Summary(self.name, self.columns(), placement_summary(frame), 2)],
            [*false, *without("a placement", frame["mutual_information"].isna())],
            damaged,
            lambda page, figures: write_placement_page(runs, frame, page, title, figures),
        )


PLACEMENT = PlacementStudy()


def _of_maps(study: PlacementTable, base: Path, site: Site, setting: dict[str, Any]) -> dict[str, Any]:
    """Return what the study's maps say at `site`: test points with their weights, and nodes of the prior sd."""
    found: dict[str, Any] = {}
    if study.weights is not None:
        points, own = tests_of(setting.get("tests", "20x20"), site.region)
        chosen = Convention(study.criterion) if study.criterion not in (None, NAME) else Convention.BOTH_NOISY
        with naming("weights"):
            values = weights_of(chosen, points, own, read_value_map(base / study.weights, site, 1.0))
        assert values is not None  # there is a map
        found["tests"] = np.column_stack([points, values]).tolist()
    if study.prior_sd is not None:
        with naming("prior_sd"):
            prior = read_value_map(base / study.prior_sd, site, float(setting.get("signal_sd", 30.0)))
        found["prior_sd"] = {name: getattr(prior, name).tolist() for name in ("x", "y", "values")}
    return found


def _maximised(item: PlacementItem) -> str:
    """Return the name of the criterion."""
    goal = item.problem.criterion
    return NAME if isinstance(goal, VarianceReduction) else str(goal.convention)


def _certificate(item: PlacementItem) -> Certificate:
    """Return what no n points of the region are worth more than."""
    goal = item.problem.criterion
    if isinstance(goal, VarianceReduction):
        return Certificate(goal.upper_bound(item.n_tasks), "average variance, weak duality")
    return certificate(goal, item.problem.region, item.n_tasks)


def _worth(item: PlacementItem, points: Any) -> dict[str, float]:
    p, goal = np.array(points, dtype=float), item.problem.criterion
    worth = {str(c): goal.under(c).value(p) for c in Convention}
    return worth | {NAME: goal.value(p)} if isinstance(goal, VarianceReduction) else worth


def _false_certificate(item: PlacementItem) -> list[str]:
    actual = _certificate(item).bound
    if item.certificate is not None and item.certificate >= actual * (1 - LOOSER):
        return []
    return [f"states a certificate of {item.certificate!r} nats, but recomputed it is {actual!r}"]


def _false_claims(item: PlacementItem, run: Run) -> list[str]:
    own, bound, found = run.own, item.certificate or 0.0, []
    if not _close(own["certificate"], bound) or not _close(run.bound, -bound):
        found.append(f"states a certificate of {own['certificate']!r} nats, but its problem's is {bound!r}")
    if own["mutual_information"] is None:
        return found if own["points"] is None else [*found, "has points, but does not say what they are worth"]
    try:
        checked_points(item.problem, np.array(own["points"], dtype=float), run.label)
        worth = _worth(item, own["points"])
    except (RuntimeError, TypeError, ValueError, np.linalg.LinAlgError) as error:
        return [*found, str(error)]
    value = worth[_maximised(item)]
    claims = {"mutual_information": (own["mutual_information"], worth[Convention.BOTH_NOISY])}
    claims["minus objective"] = (None if run.objective is None else -run.objective, value)
    claims |= {f"information ({name})": (own["information"].get(name), worth[name]) for name in worth}
    found += [
        f"claims {what} = {claim!r} nats, but its points are worth {actual!r}"
        for what, (claim, actual) in claims.items()
        if not _close(claim, actual)
    ]
    highest = max((-objective for _, objective, _ in run.trace if objective is not None), default=value)
    if highest > value and not _close(highest, value):
        found.append(f"its trace claims {highest!r} nats, but its points are worth {value!r}")
    return found


def _close(claim: Any, actual: float) -> bool:
    if not isinstance(claim, (int, float)) or isinstance(claim, bool):
        return False
    return bool(abs(claim - actual) <= TOLERANCE * abs(actual))
