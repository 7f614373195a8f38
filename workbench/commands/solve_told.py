"""What `workbench solve` says of a run."""

from __future__ import annotations

import math

import numpy as np

from instances import Instance, take_offs
from instances.utilisation import endurance_margins, utilisation
from reports.record import Run


def as_object(run: Run, instance: Instance) -> dict[str, object]:
    """Return a run as the object that ``--json`` prints."""
    named = ("solver", "status", "objective", "bound", "gap", "elapsed", "routes", "stopped_by", "message", "trace")
    more = ("options", "seed", "time_limit", "threads", "tolerance", "tour_costs", "statistics", "cpu_seconds")
    rest = ("prepare_elapsed", "peak_memory", "code", "revision", "log")
    flat = run.flat()
    return (
        {"instance": run.instance["name"], "digest": run.instance["digest"]}
        | {name: flat[name] for name in (*named, *more, *rest)}
        | _use(run, instance)
    )


def _use(run: Run, instance: Instance) -> dict[str, list[float] | None]:
    """Return how much of its time and of its endurance each UAV uses."""
    costs = np.array(run.own["tour_costs"], dtype=float)
    limited = instance.endurance is not None and len(costs) > 0
    waits = take_offs(instance, run.own["routes"] or ())
    return {
        "utilisation": utilisation(costs).tolist(),
        "endurance_margins": endurance_margins(instance, costs - waits).tolist() if limited else None,
    } | ({"take_offs": waits.tolist()} if "window" in instance.axes else {})


def as_text(run: Run, instance: Instance) -> str:
    """Return a run as text for people."""
    value = "no routes" if run.objective is None else f"longest tour {run.objective:.6g} s"
    bound = "" if run.bound is None or run.gap is None else f", bound {run.bound:.6g} s (gap {run.gap:.2%})"
    lines = [f"{run.status}: {value}{bound}, {run.elapsed:.2f} s, stopped by {run.stopped_by or 'nothing'}"]
    lines += [run.message] if run.message else []
    costs = zip(run.own["routes"] or (), run.own["tour_costs"] or (), _shares(run, instance), strict=False)
    lines += [
        f"UAV {k}: {cost:.6g} s{share}, tasks {' '.join(map(str, route)) or '-'}"
        for k, (route, cost, share) in enumerate(costs)
    ]
    return "\n".join(lines)


def _shares(run: Run, instance: Instance) -> list[str]:
    """Return of each UAV what its tour is of the longest and what is left of its endurance, where UAVs differ."""
    used = _use(run, instance)
    margins = used["endurance_margins"] or [math.inf] * instance.n_depots
    shares = []
    waits = used.get("take_offs") or [0.0] * instance.n_depots
    for share, margin, wait in zip(used["utilisation"] or (), margins, waits, strict=False):
        words = [f"{share:.0%} of the longest"] if instance.axes else []
        words += [f"takes off after {wait:.6g} s"] if wait > 0 else []
        words += [f"{max(margin, 0.0):.0%} of its endurance left"] if margin < 1 else []
        shares.append(f" ({', '.join(words)})" if words else "")
    return shares
