"""What a mission's map believes before take-off, and what its fits choose from: kernels, and means from physics."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import structs

from formulations.kernel import KERNELS, Kernel, SquaredExponential
from formulations.mapping.heights import Frame
from formulations.mapping.map_model import MapModel, Offered
from formulations.mapping.trend import CONSTANT, Trend, path_loss
from formulations.task_location.setting import kernel_of
from instances.arrays import Floats
from instances.environment.propagation import Model
from instances.environment.radio import RadioMap, RadioSource
from instances.environment.terrain import Terrain
from instances.scenario import Scenario
from instances.scenario_folder import kept_scenario, kept_terrain
from workbench.mission.environment import signal_of
from workbench.mission.place import scales_of, value_map, value_maps
from workbench.mission.settings import Mission

MEANS = ("constant", "path-loss", "propagation")
"""What [map] mean = "auto" offers."""


@dataclass(frozen=True)
class Belief:
    """Model at take-off, what fits choose from, and the planning kernel, under which information is stated."""

    model: MapModel
    offered: Offered
    planning: Kernel

    def sensing(self, mission: Mission) -> dict[str, Any]:
        """Return sensor and models as `formulations.mapping.survey` takes them."""
        known = {"model": self.model, "offered": self.offered, "planning": self.planning}
        return known | {"noise_sd": mission.sensing.noise_sd, "period": mission.sensing.period}


def belief_of(mission: Mission, environment: Path) -> Belief:
    """Return what `mission` believes; `environment` is the folder of that stage."""
    wanted = mission.map
    kernels = tuple(KERNELS.values()) if wanted.kernel == "auto" else (KERNELS[wanted.kernel],)
    names = MEANS if wanted.mean == "auto" else dict.fromkeys(("constant", wanted.mean))
    scenario, ground = kept_scenario(environment), kept_terrain(environment)
    trends = tuple(_trend(name, mission, scenario, ground) for name in names)
    return Belief(
        map_model_of(mission),
        Offered(kernels, trends, None if wanted.tau == "auto" else known_tau(mission), turned=True),
        kernel_of(mission.place.signal_sd, scales_of(mission.place.length_scale), value_maps(mission).get("prior_sd")),
    )


def map_model_of(mission: Mission) -> MapModel:
    """Return what the map believes at take-off."""
    kind = SquaredExponential if mission.map.kernel == "auto" else KERNELS[mission.map.kernel]
    return MapModel(map_kernel(mission, kind), tau=known_tau(mission))


def known_tau(mission: Mission) -> float:
    """Return how long the field takes to drift [s], infinite where it stays or that is to be told by likelihood."""
    tau = mission.map.tau
    return tau if isinstance(tau, float) else math.inf


def map_kernel(mission: Mission, kind: type[Kernel]) -> Kernel:
    """Return the kernel believed at take-off: of a map of the prior sd where the map, or else [place], has one."""
    wanted, scales = mission.map, scales_of(mission.map.length_scale)
    if wanted.prior_sd is not None:
        return kind.of_prior(value_map(mission, "map.prior_sd", wanted.prior_sd, wanted.signal_sd), scales)
    if (planned := value_maps(mission).get("prior_sd")) is not None:
        return kind.of_prior(planned, scales)
    return kind(wanted.signal_sd, scales)


def _trend(name: str, mission: Mission, scenario: Scenario, ground: Terrain | None) -> Trend:
    if name == CONSTANT.name:
        return CONSTANT
    assert scenario.radio is not None  # fitting.py has looked
    source = RadioSource.from_table(scenario.radio)
    if name == "path-loss":
        below = source.height + (0.0 if ground is None else float(ground(np.array([source.position]))[0]))
        above = mission.altitude.above - (0.0 if mission.altitude.frame is Frame.ABOVE_GROUND else below)
        return path_loss(*source.position, max(above, source.height))
    predicted, open_sky = (_predicted(model, mission, ground) for model in ("diffraction", "free-space"))

    def loss(points: Floats) -> Floats:
        return np.maximum(open_sky(points) - predicted(points), 0.0)

    return Trend(name, predicted, loss=loss)


def _predicted(model: Model, mission: Mission, ground: Terrain | None) -> RadioMap:
    """Return the signal by a model, without shadowing."""
    field = structs.replace(mission.field, file=None, unit=None, model=model, shadowing_sd=0.0)
    return signal_of(replace(mission, field=field), ground)
