"""Take-off within a window, in searches by the clock: tours are priced by the landing of their best take-off.

    C_k = min {A_k(t) : A_k(t) − t ≤ L_k, 0 ≤ t ≤ window}     (``instances/take_off.py``)

A tour within endurance at once is flown as where nobody waits. One past it is flown anew from later take-offs: begun
at t it is past endurance by e = A(t) − t − L > 0, and as A never falls it is so until t + e; between two bends A is a
line, on which e is known: its root is the best take-off where it lies on the line, and the next one tried is the later
of t + e and the line's end where it does not. Where no take-off is within endurance the tour costs

    beyond · F / L    F the least flight seen

`beyond` being no less than the longest tour of the best routes found: every such tour counts as worse, the less the
closer its flight is to endurance. A search never says that routes can be flown: `instances.routes` does, exactly.
"""

from __future__ import annotations

import numpy as np

from formulations.routing.clocks import Clocks, knot_at
from instances import Instance
from instances.arrays import Floats, Ints
from instances.kernels import njit

LIMIT, WINDOW, BEYOND = range(3)
"""Columns (m, 3) [s]: longest flight, +inf for a UAV that need not wait, longest wait, what `beyond` is."""
_ROUNDING = 1e-9
"""Share by which `beyond` must fall to be worth pricing tours anew."""
_MOST_FLIGHTS = 100
"""Take-offs tried of a tour: where they do not suffice it counts as one that cannot be flown."""
_STEEPEST = 100.0
"""Most seconds later that a UAV is taken to land for a second's delay on its way."""


class Waits:
    """Who may wait for how long, and `beyond`, which follows the best routes; `table` (m, 3) is what kernels read."""

    def __init__(self, instance: Instance, longest: float) -> None:
        """Begin with a `beyond` of at least `longest` [s] and of every landing within endurance."""
        self.table = np.zeros((instance.n_depots, 3))
        self.table[:, LIMIT] = np.inf
        self.any = instance.travel is not None and "window" in instance.axes
        if self.any and instance.travel is not None:
            limited = instance.limits[np.isfinite(instance.limits)]
            self.table[:, LIMIT] = instance.limits
            self.table[:, WINDOW] = instance.travel.window
            self.table[:, BEYOND] = max(longest, float(limited.max(initial=0.0)) + instance.travel.window)

    def follow(self, longest: float) -> bool:
        """Let `beyond` fall to the `longest` tour [s] of routes that can be flown; return whether it did.

        Tours priced before are then to be priced anew.
        """
        if not self.any or longest >= self.table[0, BEYOND] * (1 - _ROUNDING):
            return False
        self.table[:, BEYOND] = longest
        return True


@njit(cache=True, nogil=True)
def wait(clocks: Clocks, g: int, stops: Ints, about: Floats) -> tuple[float, float, float]:
    """Return take-off [s], cost [s] and what a second's delay on the way adds to it, of a tour past endurance at once.

    stops : depot, tasks in flying order, depot; about : the row of its UAV in `Waits.table`.
    """
    begins, shortest, chosen = 0.0, np.inf, 0.0
    for _ in range(_MOST_FLIGHTS):
        landing, rate, until = _line(clocks, g, stops, begins)
        flight = landing - begins
        if flight < shortest:
            shortest, chosen = flight, begins
        steep = min(_STEEPEST, 1.0 / (1.0 - rate)) if rate < 1.0 else _STEEPEST
        past = flight - about[LIMIT]
        if past <= 0.0:
            return begins, landing, steep
        root = begins + past / (1.0 - rate) if rate < 1.0 else np.inf
        if root <= min(until, about[WINDOW]):
            return root, root + about[LIMIT], steep
        begins = max(until, begins + past)
        if begins > about[WINDOW]:
            break
    share = about[BEYOND] / about[LIMIT]
    return chosen, share * shortest, share


@njit(cache=True, nogil=True)
def _line(clocks: Clocks, g: int, stops: Ints, begins: float) -> tuple[float, float, float]:
    """Return landing [s] of a tour begun at `begins` [s], and the rate of its line and the take-off where it ends."""
    time, rate, until = begins, 1.0, np.inf
    for i in range(stops.size - 1):
        q = knot_at(clocks, time)
        if rate > 0.0:
            until = min(until, begins + (clocks.knots[q + 1] - time) / rate)
        slope = clocks.lines[g, stops[i], stops[i + 1], q, 1]
        time += clocks.lines[g, stops[i], stops[i + 1], q, 0] + slope * (time - clocks.knots[q])
        rate = max(0.0, rate * (1.0 + slope))
    return time, rate, until
