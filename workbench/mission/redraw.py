"""Redrawing what chance decided: the field's shadowing, where the mission made it, and the sensor's noise."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from instances.environment.propagation import shadowing
from instances.environment.radio import RadioMap
from reports.numbers import counted
from workbench.mission.settings import Mission


def conditions(mission: Mission, field: RadioMap) -> Iterator[tuple[RadioMap, int]]:
    """Yield a field and a noise seed for each of the comparison's seeds, first the mission's own."""
    yield field, mission.sensing.seed
    made, grid = mission.field, (field.values.shape, (_step(field.x), _step(field.y)))
    redrawn = _is_redrawn(mission)
    if redrawn:
        own = shadowing(*grid, made.shadowing_sd, made.decorrelation, made.seed)
    for number in range(1, mission.compare.seeds):
        seed, noise = (_seed(mission, given, number) for given in (made.seed, mission.sensing.seed))
        if redrawn:
            drawn = shadowing(*grid, made.shadowing_sd, made.decorrelation, seed)
            yield replace(field, values=field.values - own + drawn), noise
        else:
            yield field, noise


def redrawn_words(mission: Mission) -> str:
    """Return over what the comparison's draws are, for a sentence."""
    seeds = counted(mission.compare.seeds, "noise seed")
    if _is_redrawn(mission):
        return f"{seeds}, each with shadowing of its own"
    why = "has no shadowing" if mission.field.file is None else "is a file"
    return f"{seeds} (the field {why} and stays as it is)"


def _is_redrawn(mission: Mission) -> bool:
    """Return whether chance had a part in the field."""
    return mission.field.file is None and mission.field.shadowing_sd > 0


def _step(axis: np.ndarray) -> float:
    return float(axis[1] - axis[0])


def _seed(mission: Mission, given: int, number: int) -> int:
    """Return the seed of draw `number` of what the mission drew with the seed `given`."""
    return int(np.random.SeedSequence([mission.compare.seed, given, number]).generate_state(1)[0])
