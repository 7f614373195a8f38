"""Synthetic stores: the layout and keys of real ones, made without a solver."""

import json
from pathlib import Path

import numpy as np
import pytest

from instances import Instance, makespan, tour_costs
from instances.files import write_instance


def synthetic_instance(n, m, seed, family="uniform", wind=0.0):
    """Uniform points in 20 km; rigid-rotation-like wind makes c_ij ≠ c_ji."""
    rng = np.random.default_rng(seed)
    xy = rng.uniform(0, 20_000, (n + m, 2))
    distance = np.hypot(*(xy[:, None] - xy[None]).T).T
    drift = wind * (xy[:, None, 0] * xy[None, :, 1] - xy[None, :, 0] * xy[:, None, 1]) / 2e4
    cost = np.maximum(distance / 100 + drift / 1e3, distance / 400)
    np.fill_diagonal(cost, 0.0)
    return Instance(f"{family}-n{n}-m{m}-{seed}", cost, n, m, xy, {"family": family, "seed": seed})


def random_routes(instance, rng, effort):
    """The best of `effort` random assignments, each toured nearest neighbour first, with the costs on the way."""
    best, found = None, []
    for _ in range(effort):
        owner = rng.integers(0, instance.n_depots, instance.n_tasks)
        routes = []
        for k in range(instance.n_depots):
            left, here, route = set(np.flatnonzero(owner == k).tolist()), instance.n_tasks + k, []
            while left:
                here = min(left, key=lambda j: instance.cost[here, j])
                left.remove(here)
                route.append(here)
            routes.append(route)
        value = makespan(instance, routes)
        if not found or value < found[-1]:
            best = routes
            found.append(value)
    return best, found


def run_record(instance, solver, seed, routes, *, values=(), proves=False, bound=None, status=None, limit=10.0, **keys):
    """One run as the store holds it; any key can be overridden."""
    costs = [float(c) for c in tour_costs(instance, routes)] if routes is not None else []
    objective = max(costs) if costs else None
    end = 0.5 * limit
    times = np.geomspace(0.01, end, max(len(values), 1))
    record = {
        "schema": 1, "problem": "routing",
        "instance": {
            "name": instance.name, "digest": instance.digest,
            "n_tasks": instance.n_tasks, "n_depots": instance.n_depots,
            "family": instance.provenance["family"], "asymmetry": instance.asymmetry,
        },
        "solver": solver, "options": {}, "label": solver, "proves": proves, "seed": seed, "time_limit": limit,
        "threads": 1, "iterations": None,
        "status": status or ("NO_SOLUTION" if routes is None else "FEASIBLE"),
        "objective": objective, "bound": bound, "gap": None, "elapsed": end, "routes": routes,
        "trace": [[float(t), v, None] for t, v in zip(times, values, strict=False)],
        "stopped_by": "time", "message": "", "tolerance": 0.0, "statistics": {}, "tour_costs": costs,
        "claimed_objective": objective, "prepare_elapsed": 0.3, "wall_elapsed": end + 0.3, "cpu_seconds": end,
        "peak_memory": 120_000_000, "log": "", "environment": "abc", "created": "2026-01-01T00:00:00Z",
    }  # fmt: skip
    return record | keys


class StoreMaker:
    """Writes instances and runs into a folder the way the workbench does."""

    record = staticmethod(run_record)

    def __init__(self, root: Path):
        self.root = root
        environment = {"machine": {"processor": "test", "cores": 2, "memory": 8e9}, "versions": {"python": "3.11"}}
        (root / "environments").mkdir(parents=True, exist_ok=True)
        (root / "environments" / "abc.json").write_text(json.dumps(environment))

    def put(self, instance, record):
        folder = self.root / f"{instance.name}-{instance.digest}"
        folder.mkdir(exist_ok=True)
        if not (folder / "instance.json").exists():
            write_instance(instance, folder / "instance.json")
        options = ",".join(f"{k}={v}" for k, v in record["options"].items()) or "default"
        path = folder / f"{record['solver']}-{options}-s{record['seed']}-t{record['time_limit']:g}.json"
        path.write_text(json.dumps(record))
        return path

    def study(self, sizes=((8, 2), (12, 3)), count=3, seeds=3, efforts=None, seed=0):
        """Instances of two families; heuristics of different effort and one exact method that proves the small ones."""
        efforts = efforts or {"greedy": 1, "ga": 8, "memetic": 60}
        for i in range(count):
            for n, m in sizes:
                family, wind = (("uniform", 0.0), ("ring", 0.4))[i % 2]
                instance = synthetic_instance(n, m, seed + i, family, wind)
                self._heuristics(instance, efforts, seeds)
        return self.root

    def _heuristics(self, instance, efforts, seeds):
        overall = None
        for solver, effort in efforts.items():
            for s in range(seeds):
                rng = np.random.default_rng([s, effort, instance.n_tasks])
                routes, values = random_routes(instance, rng, effort)
                record = run_record(instance, solver, s, routes, values=values)
                record["elapsed"] = record["trace"][-1][0] if effort == 1 else record["elapsed"]
                self.put(instance, record)
                if overall is None or makespan(instance, routes) < makespan(instance, overall):
                    overall = routes
        value = makespan(instance, overall)
        small = instance.n_tasks <= 10
        for label, share, options in (("milp", 0.8, {}), ("milp (cuts=false)", 0.7, {"cuts": False})):
            bound = value if small else share * value
            trace = [[0.05, 1.3 * value, 0.3 * value], [0.4, 1.1 * value, share * value], [1.0 / share, value, bound]]
            self.put(
                instance,
                run_record(
                    instance, "milp", 0, overall, proves=True, bound=bound, status="OPTIMAL" if small else "FEASIBLE",
                    label=label, options=options, trace=trace, elapsed=1.2 / share if small else 10.0,
                    stopped_by="proof" if small else "time", log="line\n" * 5, statistics={"rounds": 3},
                ),
            )  # fmt: skip


@pytest.fixture(scope="session")
def store_maker():
    """Return the class itself, for fixtures of a wider scope."""
    return StoreMaker


@pytest.fixture
def make_store(tmp_path):
    """Return a function: name → StoreMaker in its own folder."""
    return lambda name="runs": StoreMaker(tmp_path / name)
