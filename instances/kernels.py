"""numba, with the machine code it keeps under the digest of the sources: an edited kernel always takes effect.

numba looks at the file of a kernel when it decides whether kept machine code is still good, not at the kernels and
constants that the file imports. So machine code lies in the user's cache folder, below the digest of the file and of
every source it imports, directly or not (`instances.code.closure_digest`): an edit compiles again what can see it and
nothing else. Folders that nobody used for a week are removed. Below that numba would go by where the sources lie; here
a second checkout or installation of the same ones finds what is there. Every kernel takes `njit` from here, and what
is one function or another by the types of its arguments `overload`.
"""

from __future__ import annotations

import contextlib
import gc
import itertools
import os
import secrets
import shutil
import tempfile
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba.core import event
from numba.core.bytecode import FunctionIdentity
from numba.core.caching import UserProvidedCacheLocator
from numba.extending import overload as numba_overload
from platformdirs import user_cache_path

from instances import compilation
from instances.code import KERNEL_PACKAGES, ROOT, closure_digest, code_digest
from instances.kernel_compiler import Kernel, KernelCompiler

__all__ = ["njit", "overload"]

KEPT = 7 * 24 * 3600.0
"""Seconds after its last use that machine code of other sources is kept: several checkouts may be in use."""
PREFIX, MODULE_PREFIX = "kernels-", "kernels-of-"
"""Of the folder of plug-ins' kernels, which may call any of ours; and of the folder of each of our modules."""


def njit(**options: Any) -> Callable[[Any], Any]:
    """Return a decorator that makes a function a kernel, kept once it is compiled; options are those of `numba.njit`.

    None is wrapped for callers in C, of which there are none. What a kernel of ours computes as an index of an array
    must not be negative (kernel_passes.py).
    """
    chosen = {key: value for key, value in options.items() if key != "cache"}

    def made(function: Any) -> Kernel:
        kernel = Kernel(function, targetoptions={**chosen, "nopython": True, "no_cfunc_wrapper": True})
        kernel.enable_caching()
        return kernel

    return made


def overload(function: Any) -> Any:
    """Return a decorator of what chooses, by types, the function that kernels call as `function`, a kernel too."""
    options: Any = {"pipeline_class": KernelCompiler}
    return numba_overload(function, strict=False, jit_options=options)


def cache_folder() -> Path:
    """Return the folder of machine code of others' kernels with today's sources, made where it is not there yet."""
    name = PREFIX + code_digest(KERNEL_PACKAGES)
    asked = os.environ.get("NUMBA_CACHE_DIR")
    if asked and Path(asked).name.startswith(PREFIX):  # set by the process that started this one
        asked = str(Path(asked).parent)
    for parent in (Path(asked) if asked else user_cache_path("mmmdmtsp-workbench"), Path(tempfile.gettempdir())):
        folder = parent / name
        with contextlib.suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            os.utime(folder)
            return folder
    raise OSError("no folder can be written in which numba could keep compiled kernels; set NUMBA_CACHE_DIR to one")


def remove_old(parent: Path) -> None:
    """Remove machine code below `parent` that was not used for `KEPT` seconds."""
    for folder in parent.glob(f"{PREFIX}*"):
        with contextlib.suppress(OSError):
            if time.time() - folder.stat().st_mtime > KEPT:
                shutil.rmtree(folder, ignore_errors=True)


@cache
def module_folder(parent: Path, source: Path) -> str:
    """Return the folder below `parent` of machine code of the kernels in `source`; it counts as used from now on."""
    folder = parent / (MODULE_PREFIX + closure_digest(source))
    with contextlib.suppress(OSError):  # not there yet
        os.utime(folder)
    return str(folder / numba.__version__ / source.parent)


@cache
def try_out(folder: str) -> None:
    """Raise OSError where files cannot be made in a folder; tried once for all kernels of a module."""
    tempfile.TemporaryFile(dir=folder).close()


class KernelLocator(UserProvidedCacheLocator):
    """Keeps the machine code of a kernel of ours by what its module sees and numba's version, wherever that lies."""

    def __init__(self, py_func: Any, py_file: str) -> None:
        super().__init__(py_func, py_file)
        self._cache_path = module_folder(Path(self._cache_path).parents[1], Path(py_file).relative_to(ROOT))

    def ensure_cache_path(self) -> None:
        """Make the folder where there is none; raise OSError where it cannot be written to."""
        os.makedirs(self._cache_path, exist_ok=True)
        try_out(self._cache_path)

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> KernelLocator | None:
        """Return the locator of a kernel, or None for one of somebody else."""
        ours = any(Path(py_file).is_relative_to(ROOT / package) for package in KERNEL_PACKAGES)
        return super().from_function(py_func, py_file) if ours else None


class _Told(event.Listener):
    """Tells of compilations, not of machine code that is loaded."""

    def on_start(self, compiled: Any) -> None:
        compilation.begun()

    def on_end(self, compiled: Any) -> None:
        compilation.ended()


class _Uncollected(event.Listener):
    """Lets Python look for garbage after a compilation only: within it looks often, and finds little.

    One compilation goes on at a time: numba has a lock around them.
    """

    def __init__(self) -> None:
        self._under_way = 0
        self._collects = True

    def on_start(self, compiled: Any) -> None:
        if not self._under_way:
            self._collects = gc.isenabled()
            gc.disable()
        self._under_way += 1

    def on_end(self, compiled: Any) -> None:
        self._under_way -= 1
        if not self._under_way and self._collects:
            gc.enable()


event.register("numba:compile", _Told())
event.register("numba:compile", _Uncollected())
# numba tells functions of one name and type apart, such as those inside np.sort and np.argsort, by a number that begins
# at 1 in every process, also in machine code that it keeps: two processes' numbers would meet, and one sort run for the
# other (tests/instances/test_kernel_names.py).
FunctionIdentity._unique_ids = itertools.count(secrets.randbits(48))
_folder = cache_folder()
remove_old(_folder.parent)
os.environ["NUMBA_CACHE_DIR"] = str(_folder)  # child processes inherit it
numba.config.reload_config()  # else numba would do so later and forget the next line
vars(numba.config)["CACHE_LOCATOR_CLASSES"] = (
    f"{__name__}.{KernelLocator.__name__},UserProvidedCacheLocator,IPythonCacheLocator"
)
