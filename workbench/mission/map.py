"""Stage 6, map: every UAV measures on its way and the Gaussian process maps the field (sub-problem 4).

Products: samples.csv (time [s], uav, x, y [m], value), ticks.csv, model.json (what the last map believes, and the
likelihoods it was chosen by), maps.nc (the maps of some ticks, the last included), map.csv (the last) and, where the
mission has an origin, estimate.tif and uncertainty.tif (the last) and field.tif (what was measured). Where the field
drifts or changes, what was measured is that of the last tick.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Collection
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from msgspec import structs, to_builtins

from formulations.mapping.flight import Flight
from formulations.mapping.map_grid import MapGrid
from formulations.mapping.survey import Survey, Tick, fly_survey
from instances.disk import write_aside
from instances.environment.radio import RadioMap
from instances.environment.region import Region
from instances.formats.geotiff import write_geotiff
from instances.formats.netcdf import Variable, write_grids
from instances.geodesy import TangentPlane
from instances.scenario_folder import kept_field, kept_scenario
from workbench.mission.belief import Belief, belief_of
from workbench.mission.flight import kept_flights
from workbench.mission.redraw import Measured, measured_field
from workbench.mission.settings import Mission
from workbench.mission.stamp import referenced_files


def settings(mission: Mission) -> dict[str, Any]:
    """Return what this stage depends on."""
    origin = None if mission.origin is None else asdict(mission.origin)
    planned = {name: structs.asdict(mission.place)[name] for name in ("signal_sd", "length_scale", "prior_sd")}
    files = referenced_files([mission.place.prior_sd, mission.map.prior_sd], mission.folder)
    own = structs.asdict(mission.sensing) | structs.asdict(mission.map)
    return own | {"origin": origin, "planning": planned, "files": files} | _replanned(mission)


def _replanned(mission: Mission) -> dict[str, Any]:
    """Return what re-planning depends on beside the flights; nothing where none is wanted."""
    if not mission.replan.wanted:
        return {}
    events = [event.file for event in mission.replan.event if event.file is not None]
    parts = (mission.replan, mission.place, mission.flight)
    told: list[Any] = [to_builtins(part) for part in parts]
    files = referenced_files(events, mission.folder)
    return {"replan": [*told, mission.clearance, mission.speed, mission.table.get("crs"), files]}


def make(mission: Mission, folders: dict[str, Path], out: Path, tell: Callable[[str], None]) -> str:
    """Fly, measure and map."""
    scenario = kept_scenario(folders["environment"])
    measured = measured_field(mission, kept_field(folders["environment"]))
    flights, changed = flown_flights(mission, folders, measured, out)
    last = max(int(flight.duration / mission.sensing.period) for flight in flights)
    kept = frames(last, mission.map.frames)
    belief = belief_of(mission, folders["environment"])
    survey = survey_of(mission, belief, scenario.region, measured, flights, kept)
    x, y = survey.positions.T
    samples = pd.DataFrame({"time": survey.times, "uav": survey.uavs, "x": x, "y": y, "value": survey.values})
    write_aside(out / "samples.csv", samples.round(6).to_csv(index=False))
    write_aside(out / "ticks.csv", ticks_frame(survey).to_csv(index=False))
    write_aside(out / "model.json", json.dumps(_chosen(survey.ticks[-1]), indent=1))
    grid, landed = MapGrid.over(scenario.region, mission.map.cells), survey.ticks[-1].time
    field = measured if isinstance(measured, RadioMap) else measured.at(landed)
    _write_maps(survey, grid, field, mission.origin, out)
    if mission.origin is not None:
        _write_rasters(survey, grid, field, mission.origin, out, tell)
    end = survey.ticks[-1]
    return (
        f"{end.samples} samples, RMSE {end.score.rmse:.2f} {field.unit}, NLPD {end.score.nlpd:.2f} nats, 95 % interval "
        f"covers {end.score.coverage:.1%}; {end.fitted.model}{changed}"
    )


def flown_flights(mission: Mission, folders: dict[str, Path], field: Measured, out: Path) -> tuple[list[Flight], str]:
    """Return the flights as they are flown over `field`, and what re-planning changed; written where it is wanted."""
    if not mission.replan.wanted:
        return kept_flights(folders["flight"]), ""
    from workbench.mission.replan import Replanning  # here: most missions need none of it

    replanning = Replanning(mission, folders)
    flown = replanning.flown(field, mission.sensing.seed)
    return flown.flights, f"; {replanning.write(flown, out)}"


def frames(last: int, count: int) -> set[int]:
    """Return the ticks whose maps are kept: evenly spread, first and last included."""
    return set(np.linspace(0, last - 1, min(count, last)).round().astype(int).tolist())


def survey_of(
    mission: Mission, belief: Belief, region: Region, field: Measured, flights: list[Flight], kept: Collection[int] = ()
) -> Survey:
    """Fly, measure and map `field` under the mission's settings, keeping the maps of the ticks `kept`."""
    return fly_survey(
        flights,
        field,
        MapGrid.over(region, mission.map.cells).points,
        **belief.sensing(mission),
        refit_every=mission.map.refit_every,
        seed=mission.sensing.seed,
        keep=lambda tick, _: tick in kept,
    )


def ticks_frame(survey: Survey) -> pd.DataFrame:
    """Return a row a tick: time [s], samples, information and entropy [nats], scores, the model and its parameters.

    direction [°] and tau [s] are among these where any tick's model has one.
    """
    frame = pd.DataFrame([_row(tick) for tick in survey.ticks])
    models = [tick.fitted.model for tick in survey.ticks]
    if any(model.kernel.direction for model in models):
        frame = frame.assign(direction=[math.degrees(model.kernel.direction) for model in models])
    taus = [model.tau for model in models]
    return frame if all(map(math.isinf, taus)) else frame.assign(tau=taus)


def _chosen(tick: Tick) -> dict[str, Any]:
    """Return the model of a tick, its coefficients, and the log-likelihood [nats] of every kernel and mean offered.

    direction [°] where length scales hold along one; tau [s] of one that drifts; drift [nats]: how far such models were
    ahead, where both kinds were tried; contrast [dB] and in_sight of a mean that predicts shadows.
    """
    model = tick.fitted.model
    evidence = [
        {"kernel": kernel, "mean": mean, "log_likelihood": value}
        for (kernel, mean), value in tick.fitted.evidence.items()
    ]
    assert tick.posterior is not None  # the last tick's is kept
    return {
        "kernel": model.kernel.name,
        "mean": model.trend.name,
        "signal_sd": model.kernel.signal_sd,
        "length_scales": model.kernel.length_scales,
        **({"direction": math.degrees(model.kernel.direction)} if model.kernel.direction else {}),
        "nugget_sd": model.nugget_sd,
        "coefficients": tick.posterior.coefficients.tolist(),
        "evidence": evidence,
        **({"tau": model.tau} if model.tau < math.inf else {}),
        **(asdict(model.shadows) if model.shadows else {}),
        **({"drift": tick.fitted.drift} if tick.fitted.drift is not None else {}),
    }


def _row(tick: Tick) -> dict[str, Any]:
    model = tick.fitted.model
    lx, ly = model.kernel.length_scales
    row = {name: getattr(tick, name) for name in ("time", "samples", "information", "entropy")}
    fitted = {"signal_sd": model.kernel.signal_sd, "length_x": lx, "length_y": ly}
    chosen = {"nugget_sd": model.nugget_sd, "kernel": model.kernel.name, "mean_model": model.trend.name}
    return row | asdict(tick.score) | fitted | chosen


def _write_rasters(
    survey: Survey, grid: MapGrid, field: RadioMap, plane: TangentPlane, out: Path, tell: Callable[[str], None]
) -> None:
    """Write the last map and the field for geographic information systems."""
    if find_spec("rasterio") is None:
        tell("no GeoTIFFs: they need the extra 'geo'")
        return
    last = survey.ticks[-1].posterior
    assert last is not None
    rasters = (
        ("estimate", "posterior mean", last.mean),
        ("uncertainty", "posterior standard deviation", last.sd),
        ("field", "the field that was measured", field(grid.points)),
    )
    for file, name, values in rasters:
        place = (grid.x, grid.y, plane)
        write_geotiff(out / f"{file}.tif", grid.raster(values), *place, name=name, unit=field.unit)


def _write_maps(survey: Survey, grid: MapGrid, field: RadioMap, plane: TangentPlane | None, out: Path) -> None:
    kept = [tick for tick in survey.ticks if tick.posterior is not None]
    mean = np.array([grid.raster(tick.posterior.mean) for tick in kept if tick.posterior])
    sd = np.array([grid.raster(tick.posterior.sd) for tick in kept if tick.posterior])
    truth = grid.raster(field(grid.points))
    axes = ("time", "y", "x")
    write_grids(
        out / "maps.nc",
        {"time": np.array([tick.time for tick in kept]), "y": grid.y, "x": grid.x},
        {
            "mean": Variable(axes, mean, {"long_name": "posterior mean", "units": field.unit}),
            "sd": Variable(axes, sd, {"long_name": "posterior standard deviation", "units": field.unit}),
            "truth": Variable(("y", "x"), truth, {"long_name": "the field that was measured", "units": field.unit}),
        },
        plane,
    )
    x, y = grid.points.T
    last = pd.DataFrame({"x": x, "y": y, "mean": mean[-1][grid.inside], "sd": sd[-1][grid.inside]})
    write_aside(out / "map.csv", last.round(6).to_csv(index=False))
