"""A survey whose plan changes in flight: measured on the way, re-planned every few rounds and at every event.

What comes out are flights, as they were flown in the end, and the re-plans. A survey (`mapping.survey`) that is then
flown along them with the same seed measures the same: all that maps and judges is one code.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import process_time

import numpy as np

from formulations.blas import one_thread
from formulations.mapping.clock import clocked
from formulations.mapping.flight import Flight
from formulations.mapping.survey import Drifting, Field, field_at
from formulations.replanning.aloft import Aloft, World
from formulations.replanning.onward import joined
from formulations.replanning.refuted import REFUTED, ahead
from formulations.replanning.replan import LESS, Plan, Planner, Replan, Replanner, fit
from formulations.replanning.spending import track_cost
from instances.arrays import Floats
from instances.errors import InputError

GROWN = 1.2
"""Times as many readings as at the last look are looked at for whether they refute what is believed."""


@dataclass(frozen=True, eq=False)
class Event:
    """What happens at `time` [s], in `words`: UAV `lost` flies no more, or `world` holds from then on."""

    time: float
    words: str
    lost: int | None = None
    world: World | None = None


Read = Callable[[int, Sequence[int], Floats], Floats]
"""Round of measurements from 1, UAVs that measure and where, (k, 2) [m], to what they read, (k,)."""


def drawn(field: Field | Drifting, noise_sd: float, period: float, seed: int) -> Read:
    """Return readings of `field` as `mapping.survey` draws them; rounds are to be read in order."""
    rng = np.random.default_rng(seed)

    def read(number: int, uavs: Sequence[int], positions: Floats) -> Floats:
        return field_at(field, number * period)(positions) + rng.normal(0.0, noise_sd, len(uavs))

    return read


class Measured:
    """What was read so far, round by round: positions (N, 2) [m], values (N,) and times (N,) [s]."""

    def __init__(self, read: Read, period: float) -> None:
        self.read, self.period, self.rounds = read, period, 0
        self.positions, self.values, self.times = np.empty((0, 2)), np.empty(0), np.empty(0)

    @property
    def samples(self) -> tuple[Floats, Floats, Floats]:
        """Positions, values and times."""
        return self.positions, self.values, self.times

    def until(self, time: float, flights: Sequence[Flight]) -> None:
        """Measure along `flights` up to `time` [s]."""
        while (self.rounds + 1) * self.period <= time + 1e-9:
            self.rounds += 1
            now = self.rounds * self.period
            flying = [k for k, f in enumerate(flights) if int(f.duration / self.period + 1e-9) >= self.rounds]
            if not flying:
                return
            here = np.array([flights[k].poses(flights[k].travelled([now]))[0, :2] for k in flying])
            self.values = np.concatenate([self.values, self.read(self.rounds, flying, here)])
            self.positions = np.concatenate([self.positions, here])
            self.times = np.concatenate([self.times, np.full(len(here), now)])


@one_thread()
def fly_replanned(
    aloft: Aloft, read: Read, planner: Planner, world: World, *, every: int = 10, events: Sequence[Event] = ()
) -> tuple[list[Flight], list[Replan]]:
    """Fly the fleet `aloft` from take-off to its last landing; return the flights as flown, and every re-plan.

    read : what sensors say. every : rounds of measurements between two re-plans, 0 for none but at events; the first is
    made as soon as readings refute what was believed before them (refuted.py). Raises InputError where an event leaves
    no safe way home.
    """
    measured = Measured(read, planner.period)
    coming, regular, made, model = sorted(events, key=lambda event: event.time), 1, list[Replan](), planner.model
    while aloft.active:
        event = coming[0] if coming else None
        tick = every * regular * planner.period if every else np.inf
        end = max(aloft.flights[k].duration for k in aloft.active)
        at, refuted = min(tick, event.time if event else np.inf), np.inf
        if every and model is planner.model:
            refuted = _refuted(planner, aloft, world, measured, min(at, end))
            at = min(at, refuted)
        if not at < end:
            break
        measured.until(at, aloft.flights)
        aloft.time = at
        samples = measured.samples
        if refuted < np.inf:
            made.append(_regular(Replanner(planner, aloft, world, samples, model), "readings refute what was believed"))
        elif event is not None and event.time <= tick:
            coming.pop(0)
            old = world
            world = _happened(event, aloft, world)
            made.append(_at_event(event, Replanner(planner, aloft, world, samples, model), old))
        else:
            regular += 1
            made.append(_regular(Replanner(planner, aloft, world, samples, model), f"{every} rounds of measurements"))
        model = made[-1].model
    return aloft.flights, made


def _refuted(planner: Planner, aloft: Aloft, world: World, measured: Measured, before: float) -> float:
    """Measure until readings refute the model that is planned by; return when [s], inf if not before `before` [s]."""
    looked = 0
    while (at := (measured.rounds + 1) * planner.period) < before - 1e-9:
        measured.until(at, aloft.flights)
        if len(measured.values) < GROWN * looked:
            continue
        looked = len(measured.values)
        fitted = fit(planner, world, planner.model, measured.samples)
        if ahead(fitted, planner.model, planner.noise_sd, *measured.samples) > REFUTED:
            return at
    return np.inf


def _happened(event: Event, aloft: Aloft, world: World) -> World:
    """Let `event` happen; return the world from then on."""
    if event.lost is not None:
        aloft.lose(event.lost)
    if event.world is None:
        return world
    aloft.settle(world.measure)
    wind = event.world.clock_wind
    if wind is not None:
        for k in aloft.active:
            aloft.flights[k] = joined(aloft.flown(k), clocked(aloft.rest(k), wind))
    return event.world


def _regular(one: Replanner, reason: str) -> Replan:
    """Decide for the plan in the air unless another promises less."""
    return _decided(one, reason, one.best(), one.promised(one.aloft.flights))


def _at_event(event: Event, one: Replanner, old: World) -> Replan:
    """Decide as `_regular`; where the plan in the air can be flown no more, for the best that can, or for home."""
    again, broken = one.aloft.ahead(), ""
    if not one.uavs:
        return _decided(one, event.words, [], np.nan)
    if event.world is not None:
        broken = _broken(one, old)
    plans = one.best(again, broken=bool(broken))
    if not broken:
        return _decided(one, event.words, plans, one.promised(one.aloft.flights))
    found = _decided(one, event.words, plans, np.inf, f"the plan in the air {broken}")
    if found.accepted:
        return found
    home = one.home()
    refused = one.world.allowed(home.flights, home.rests)
    if refused:
        raise InputError(f"at {one.aloft.time:g} s ({event.words}) there is no safe way home: {refused}")
    why = f"the plan in the air {broken} and no other can be flown: all fly straight home"
    if home.left < 0:
        why += f", {-home.left:.1f} s beyond the endurance of one"
    return _decided(one, event.words, [home], np.inf, why)


def _broken(one: Replanner, old: World) -> str:
    """Return why the plan in the air can be flown no more, or ""."""
    aloft, world = one.aloft, one.world
    rests = [aloft.rest(k) for k in range(len(aloft.flights))]
    refused = world.allowed(aloft.flights, rests)
    if refused:
        return f"may be flown no more ({refused})"
    for i, k in enumerate(one.uavs):
        needed, before = (track_cost(rests[k], each.measure) for each in (world, old))
        if one.spent[i] + needed > max(one.limits[i], one.spent[i] + before):
            return f"takes UAV {k} {one.spent[i] + needed - one.limits[i]:.1f} s beyond its endurance"
    return ""


def _decided(one: Replanner, reason: str, plans: list[Plan], before: float, because: str = "") -> Replan:
    """Return the re-plan by the first of `plans` that may be flown, if it promises less than `before`; and fly it."""
    aloft, chosen, why = one.aloft, None, "no other plan keeps the endurance"
    for plan in plans:
        if not plan.promised < before * LESS:
            why = "no plan promises less than the one in the air"
            break
        refused = one.world.allowed(plan.flights, plan.rests)
        if not refused:
            chosen = plan
            break
        why = f"the better plan would break a rule: {refused}"
    old = [aloft.rest(k) for k in range(len(aloft.flights))]
    after = chosen or (plans[0] if plans else None)
    record = Replan(
        time=aloft.time,
        reason=reason,
        samples=len(one.values),
        model=one.model,
        before=before if np.isfinite(before) else np.nan,
        after=np.nan if after is None else after.promised,
        tried=one.tried,
        accepted=chosen is not None,
        why=because or ("it promises less and keeps every rule" if chosen else why),
        old=old,
        new=old if chosen is None else chosen.rests,
        elapsed=process_time() - one.began,
    )
    if chosen is not None:
        aloft.flights, aloft.tasks = chosen.flights, chosen.tasks
    return record
