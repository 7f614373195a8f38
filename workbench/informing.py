"""Facade, where information counts: `place` chooses where to measure, `select` what to fly where not all fits."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from formulations.limits import Limits
from instances import InputError
from workbench.inputs import Source, instance

if TYPE_CHECKING:
    from formulations.selection.selection import Selection
    from formulations.task_location.placement import Placement
    from instances.environment.region import Region

__all__ = ["place", "select"]


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
    weights: Path | str | None = None,
    prior_sd: Path | str | None = None,
    seed: int = 0,
    time_limit: float = float("inf"),
    certificate: bool = True,
    **options: Any,
) -> Placement:
    """Choose the task locations of most information in a region.

    Parameters
    ----------
    region
        A Region or its file; by default the paper's 20 km square.
    tasks
        How many places n to choose.
    method
        A name of ``workbench methods``.
    tests
        Where the field is to be known: ``"20x20"``, the centres of so many cells inside the region, or a CSV file with
        columns x, y [m] and perhaps weight.
    signal_sd
        σ_f of the planning kernel, in the unit of the signal.
    length_scale
        Of the planning kernel [m], or two, along x and y.
    noise_sd
        σ_n of a reading, in the unit of the signal.
    criterion
        ``"b"`` both readings and tests noisy, ``"a"`` latent tests, ``"ig"`` information gain, ``"j"`` how far the
        weighted mean variance at the tests falls.
    weights
        A file of how much places count: GeoTIFF, NetCDF, polygons with a property ``value``, or CSV x, y, value.
    prior_sd
        A file, as that of weights, of σ_f where it is not the same everywhere.
    seed
        Of the method.
    time_limit
        Wall clock of the search [s].
    certificate
        Whether to compute the upper bound too.
    **options
        The method's own options.

    Returns
    -------
    Placement
        Points (n, 2) [m], what they tell and the upper bound [nats].

    Raises
    ------
    InputError
        For a file, number, method or option that cannot be used.
    """
    from formulations.task_location import certificate as certificates
    from formulations.task_location.criterion import Convention
    from formulations.task_location.placement import PlacementProblem
    from formulations.task_location.placement import place as placed
    from formulations.task_location.registry import make_method
    from formulations.task_location.setting import goal_of, site_of
    from instances.environment.region import Region
    from instances.environment.site import Site
    from instances.value_maps import read_value_map

    site = Site(region) if isinstance(region, Region) else site_of(None if region is None else Path(region))
    area = site.region
    scales = ",".join(map(str, length_scale)) if isinstance(length_scale, tuple) else str(length_scale)
    worth = goal_of(
        area,
        tests=tests,
        signal_sd=signal_sd,
        length_scale=scales,
        noise_sd=noise_sd,
        test_noise_sd=None,
        criterion=criterion,
        weights=None if weights is None else read_value_map(Path(weights), site, 1.0),
        prior_sd=None if prior_sd is None else read_value_map(Path(prior_sd), site, signal_sd),
    )
    bound = certificates.certificate(worth.under(Convention.BOTH_NOISY), area, tasks).bound if certificate else None
    limits = Limits(time=time_limit)
    problem = PlacementProblem(area, worth, tasks)
    return placed(problem, make_method(method, options), method, seed=seed, limits=limits, certificate=bound)


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

    Parameters
    ----------
    problem, depots
        As `instance` takes them.
    endurance
        Of all UAVs or of each, shape (m,) [s]; by default the instance's own.
    prizes
        What each task is worth, shape (n,), non-negative; without them what readings at the tasks tell of a field
        [nats], which needs coordinates.
    criterion
        Of the information: ``"ig"``, ``"b"`` or ``"a"``, as in `place`.
    signal_sd, noise_sd
        Of the planning kernel and of a reading, in the unit of the signal.
    length_scale
        Of the planning kernel [m].
    method
        ``"exact"``, ``"subset-dp"``, ``"branch-and-price"`` or ``"ruin-recreate"``.
    time_limit
        Wall clock [s].
    seed
        Of the method.
    **options
        The method's own options.

    Returns
    -------
    Selection
        Routes, what they are worth and a bound that no selection exceeds.

    Raises
    ------
    InputError
        For what cannot be used; also where there are neither prizes nor coordinates.
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
