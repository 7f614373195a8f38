"""After `prepare` nothing is left to compile: a solve whose limit is short must not spend it on that."""

import subprocess
import sys

SCRIPT = """
import importlib, pkgutil
import numpy as np
from numba.core.dispatcher import Dispatcher
import formulations.routing.columns as columns
from formulations.routing.branch_and_price import BranchAndPrice
from formulations.limits import Limits
from instances import Instance

def kernels():
    names = [found.name for found in pkgutil.iter_modules(columns.__path__)]
    modules = [importlib.import_module(f"{columns.__name__}.{name}") for name in names]
    return {name: f for module in modules for name, f in vars(module).items() if isinstance(f, Dispatcher)}

place = np.random.default_rng(0).uniform(0, 1, (16, 2))
instance = Instance("plane", np.hypot(*(place[:, None] - place).transpose(2, 0, 1)), 14, 2)
BranchAndPrice().prepare(instance)
ready = {name: len(f.signatures + f.inner.signatures) for name, f in kernels().items()}
loose = tuple(tuple(range(k, 14, 2)) for k in range(2))
result = BranchAndPrice(starts=0).solve(instance, limits=Limits(time=60.0), start=loose)
later = {name: len(f.signatures + f.inner.signatures) for name, f in kernels().items()}
print("worked with:", *sorted({"cuts", "pools"} & set(result.statistics)))
print("join compiled:", ready["join"])  # of tours from both sides, which so few tasks do not need
print("compiled later:", sorted(name for name in later if later[name] > ready[name]))
"""


def test_the_warm_up_compiles_every_kernel() -> None:
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == ["worked with: cuts pools", "join compiled: 1", "compiled later: []"]
