"""Survey: several UAVs fly, measure and map at the same time (paper, sub-problem 4 and §Numerical Example).

Every `period` seconds each UAV still in the air measures the field with noise σ_n; the Gaussian process takes the
samples in, and every `refit_every` ticks its model (kernel, hyperparameters, mean) is chosen anew by likelihood (eq.
GPR2, `formulations.mapping.map_model`). After each tick the map is judged against the truth, which only the judge sees;
where the field drifts, it is measured as it is then, and the map of a tick is judged against the field of that time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from formulations.kernel import Kernel
from formulations.mapping.flight import Flight
from formulations.mapping.gaussian_process import GaussianProcess, Posterior
from formulations.mapping.map_model import EVERY_KERNEL, Fitted, MapModel, Offered, choose_model
from instances import InputError
from instances.arrays import Floats, Ints

Field = Callable[[Floats], Floats]
"""Value of the field at points [m] of shape (k, 2), shape (k,)."""


@runtime_checkable
class Drifting(Protocol):
    """A field that is another one at another time."""

    def at(self, time: float) -> Field:
        """Return the field at `time` [s]."""
        ...


def field_at(field: Field | Drifting, time: float) -> Field:
    """Return `field` as it is at `time` [s]."""
    return field.at(time) if isinstance(field, Drifting) else field


Z95 = 1.959963984540054
"""97.5 % quantile of the standard normal: a 95 % interval is mean ± Z95 sd."""


@dataclass(frozen=True)
class Score:
    """How good a map is, in the field's unit unless said.

    rmse : root mean square error of the mean.
    nlpd : mean negative log predictive density of a new noisy measurement at each map point [nats].
    coverage : share of map points whose true value lies in the 95 % interval (0 to 1).
    mean_sd, max_sd : mean and greatest posterior standard deviation.
    """

    rmse: float
    nlpd: float
    coverage: float
    mean_sd: float
    max_sd: float


def score(posterior: Posterior, truth: ArrayLike, noise_sd: float) -> Score:
    """Judge a map against the truth at its points.

    NLPD is the expectation over the noise of a new measurement: ½ log 2πs² + ((f − f̄)² + σ_n²) / 2s², s² = sd² + σ_n².
    """
    error = np.asarray(truth, dtype=float) - posterior.mean
    variance = posterior.sd**2 + noise_sd**2
    nlpd = 0.5 * np.log(2 * np.pi * variance) + (error**2 + noise_sd**2) / (2 * variance)
    return Score(
        rmse=float(np.sqrt(np.mean(error**2))),
        nlpd=float(nlpd.mean()),
        coverage=float(np.mean(np.abs(error) <= Z95 * posterior.sd)),
        mean_sd=float(posterior.sd.mean()),
        max_sd=float(posterior.sd.max()),
    )


@dataclass(frozen=True)
class Tick:
    """The state of the map after one round of measurements.

    time [s]; samples so far; information IG gathered so far and entropy H(y) of the samples [nats], both under the
    planning kernel; score; the model in use and the likelihoods it was chosen by; posterior, kept for the ticks asked
    for, else None.
    """

    time: float
    samples: int
    information: float
    entropy: float
    score: Score
    fitted: Fitted
    posterior: Posterior | None = None


@dataclass(frozen=True)
class Survey:
    """What a survey produced: ticks in order and every sample with its UAV.

    positions [m], shape (N, 2); values, shape (N,); uavs, shape (N,); times [s], shape (N,).
    """

    ticks: tuple[Tick, ...]
    positions: Floats
    values: Floats
    uavs: Ints
    times: Floats


def fly_survey(
    flights: Sequence[Flight],
    field: Field | Drifting,
    points: Floats,
    *,
    model: MapModel,
    offered: Offered = EVERY_KERNEL,
    planning: Kernel | None = None,
    noise_sd: float = 1.0,
    period: float = 10.0,
    refit_every: int = 10,
    seed: int = 0,
    keep: Callable[[int, int], bool] = lambda tick, last: True,
) -> Survey:
    """Fly `flights` together, measure `field` and map it at `points` [m], shape (p, 2).

    model : what is believed before the first measurement; offered : the kernels and means that fits choose from;
    planning : under which information and entropy are stated, whatever is fitted (the kernel of `model` unless given),
    with the τ of `model`, so that those of several surveys compare. refit_every : ticks between fits, 0 for none (a
    last fit is made at the end). keep(tick, last) says which ticks keep their whole posterior. Raises InputError where
    no flight lasts a sensing period.
    """
    schedule = _schedule(flights, period)
    process, ledger = GaussianProcess(model, noise_sd, points), _ledger(planning or model.kernel, model.tau, noise_sd)
    ticks, fitted, truth = [], Fitted(model), np.empty(0)
    for number, measured in enumerate(_measured(schedule, field, noise_sd, seed)):
        process.extend(measured.positions, measured.values, measured.time)
        ledger.extend(measured.positions, measured.values, measured.time)
        last = number == len(schedule) - 1
        if refit_every and ((number + 1) % refit_every == 0 or last):
            fitted = choose_model(fitted.model, offered, noise_sd, *process.samples, process.times)
            process = process.refitted(fitted.model)
        if number == 0 or isinstance(field, Drifting):
            truth = measured.field(points)
        tick = _tick(measured.time, process, ledger, truth, fitted)
        ticks.append(tick if keep(number, len(schedule) - 1) else replace(tick, posterior=None))
    uavs = np.concatenate([each for _, each, _ in schedule])
    return Survey(tuple(ticks), *process.samples, uavs, process.times)


def last_map(
    flights: Sequence[Flight],
    field: Field | Drifting,
    points: Floats,
    *,
    model: MapModel,
    offered: Offered = EVERY_KERNEL,
    planning: Kernel | None = None,
    noise_sd: float = 1.0,
    period: float = 10.0,
    refit: bool = True,
    seed: int = 0,
) -> Tick:
    """Return the state after all measurements of `fly_survey`, the same ones for the same seed, fitted once.

    It is what a survey is worth, many times sooner than tick by tick.
    """
    schedule = _schedule(flights, period)
    positions = np.concatenate([each for _, _, each in schedule])
    times = np.concatenate([np.full(len(uavs), time) for time, uavs, _ in schedule])
    values = np.concatenate([measured.values for measured in _measured(schedule, field, noise_sd, seed)])
    fitted = choose_model(model, offered, noise_sd, positions, values, times) if refit else Fitted(model)
    process = GaussianProcess(fitted.model, noise_sd, points)
    ledger = _ledger(planning or model.kernel, model.tau, noise_sd)
    process.extend(positions, values, times)
    ledger.extend(positions, values, times)
    now = schedule[-1][0]
    return _tick(now, process, ledger, field_at(field, now)(points), fitted)


_Schedule = list[tuple[float, Ints, Floats]]
"""Of every round of measurements its time [s], the UAVs that measure and their positions [m], shape (b, 2)."""


class _Round(NamedTuple):
    """One round of measurements: time [s], positions [m], shape (b, 2), values, shape (b,), and the field then."""

    time: float
    positions: Floats
    values: Floats
    field: Field


def _measured(schedule: _Schedule, field: Field | Drifting, noise_sd: float, seed: int) -> Iterator[_Round]:
    """Yield every round of measurements of `field`, noise included, in order."""
    rng = np.random.default_rng(seed)
    for time, uavs, positions in schedule:
        now = field_at(field, time)
        yield _Round(time, positions, now(positions) + rng.normal(0.0, noise_sd, len(uavs)), now)


def _ledger(kernel: Kernel, tau: float, noise_sd: float) -> GaussianProcess:
    """Return a process that maps nothing and keeps account of information."""
    return GaussianProcess(MapModel(kernel, tau=tau), noise_sd, np.empty((0, 2)))


def _tick(time: float, process: GaussianProcess, ledger: GaussianProcess, truth: Floats, fitted: Fitted) -> Tick:
    posterior = process.posterior(time)
    judged = score(posterior, truth, process.noise_sd)
    count = len(process.samples[1])
    return Tick(time, count, ledger.information(), ledger.entropy(), judged, fitted, posterior)


def promised_sd(
    flights: Sequence[Flight],
    points: Floats,
    *,
    kernel: Kernel,
    noise_sd: float,
    period: float,
    tau: float = math.inf,
) -> float:
    """Return the mean posterior sd at `points` [m], shape (p, 2), that a survey by `flights` promises under `kernel`.

    It is known before take-off: the posterior sd (eq. GPR1) does not depend on what is measured. tau : of a field that
    drifts [s]; then it is the sd at the end.
    """
    process = GaussianProcess(MapModel(kernel, tau=tau), noise_sd, points)
    for flight in flights:
        times, positions = flight.measurements(period)
        process.extend(positions, np.zeros(len(positions)), times)
    return float(process.posterior().sd.mean())


def _schedule(flights: Sequence[Flight], period: float) -> _Schedule:
    """Return every round of measurements, in order."""
    if not period > 0:
        raise InputError(f"the sensing period must be positive, got {period} s")
    measured = [flight.measurements(period) for flight in flights]
    longest = max((len(times) for times, _ in measured), default=0)
    if longest == 0:
        tour = max((flight.duration for flight in flights), default=0.0)
        raise InputError(f"the sensing period ({period:g} s) is longer than the longest tour ({tour:.0f} s)")
    schedule = []
    for k in range(longest):
        uavs = np.array([u for u, (times, _) in enumerate(measured) if k < len(times)], dtype=np.int64)
        schedule.append(((k + 1) * period, uavs, np.array([measured[u][1][k] for u in uavs])))
    return schedule
