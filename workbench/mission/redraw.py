"""What chance decides: shadowing and noise, drawn again, and shadowing that drifts during the flight."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from instances.arrays import Floats
from instances.environment.drift import DriftingField
from instances.environment.propagation import shadowing
from instances.environment.radio import RadioMap
from instances.environment.radio_changing import ChangingField
from reports.numbers import counted
from workbench.mission.settings import Mission

Kept = RadioMap | ChangingField
"""What the environment keeps."""
Measured = Kept | DriftingField


def measured_field(mission: Mission, field: Kept) -> Measured:
    """Return the field that is measured: `field` itself, or one that drifts from it on."""
    if mission.field.tau is None or isinstance(field, ChangingField):
        return field
    own = _shadowing(mission, field, mission.field.seed)
    return _drifting(mission, replace(field, values=field.values - own), mission.field.seed)


def conditions(mission: Mission, field: Kept) -> Iterator[tuple[Measured, int]]:
    """Yield a field and a noise seed for each of the comparison's seeds, first the mission's own.

    field : the mission's own at take-off, or as it changes.
    """
    yield measured_field(mission, field), mission.sensing.seed
    made, redrawn = mission.field, _is_redrawn(mission)
    if redrawn and isinstance(field, RadioMap):
        own = _shadowing(mission, field, made.seed)
    for number in range(1, mission.compare.seeds):
        seed, noise = (_seed(mission, given, number) for given in (made.seed, mission.sensing.seed))
        if not redrawn or isinstance(field, ChangingField):
            yield field, noise
        elif made.tau is not None:
            yield _drifting(mission, replace(field, values=field.values - own), seed), noise
        else:
            yield replace(field, values=field.values - own + _shadowing(mission, field, seed)), noise


def redrawn_words(mission: Mission) -> str:
    """Return over what the comparison's draws are, for a sentence."""
    seeds = counted(mission.compare.seeds, "noise seed")
    if _is_redrawn(mission):
        return f"{seeds}, each with shadowing of its own"
    why = "has no shadowing" if mission.field.file is None else "is a file"
    return f"{seeds} (the field {why} and is not drawn again)"


def _is_redrawn(mission: Mission) -> bool:
    """Return whether chance had a part in the field."""
    return mission.field.file is None and mission.field.shadowing_sd > 0


def _drifting(mission: Mission, still: RadioMap, seed: int) -> DriftingField:
    """Return `still` with shadowing that drifts from that of `seed` on, a frame a round of measurements."""

    def drawn(number: int) -> Floats:
        return _shadowing(mission, still, _derived(seed, number) if number else seed)

    assert mission.field.tau is not None
    return DriftingField(still, drawn, mission.field.tau, mission.sensing.period)


def _shadowing(mission: Mission, field: RadioMap, seed: int) -> Floats:
    """Return the shadowing of `seed` at the nodes of `field`."""
    spacing = (float(field.x[1] - field.x[0]), float(field.y[1] - field.y[0]))
    return shadowing(field.values.shape, spacing, mission.field.shadowing_sd, mission.field.decorrelation, seed)


def _seed(mission: Mission, given: int, number: int) -> int:
    """Return the seed of draw `number` of what the mission drew with the seed `given`."""
    return _derived(mission.compare.seed, given, number)


def _derived(*entropy: int) -> int:
    return int(np.random.SeedSequence(list(entropy)).generate_state(1)[0])
