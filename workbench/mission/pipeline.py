"""Pipeline: run the stages of a mission in order, each only where its products are missing or out of date."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import psutil

from instances.code import code_digest, revision
from instances.disk import read_bytes, write_aside
from instances.errors import InputError, suggestion
from workbench.mission.settings import Mission
from workbench.mission.stamp import Stamp, digest_of, intact, products_of, read_stamp
from workbench.settings import make_folder

Tell = Callable[[str], None]


@dataclass(frozen=True)
class Stage:
    """One stage: its settings as JSON values, and the function that writes its products.

    The function lives in ``workbench.mission.<name>:make`` (imported when it is run), is given the mission, the
    folders of all stages, the folder to write into and someone to tell, and returns a sentence for people;
    ``settings`` there returns what the stage depends on besides `needs`.
    """

    name: str
    needs: tuple[str, ...]

    @property
    def module(self) -> Any:
        """The module that makes this stage."""
        return import_module(f"workbench.mission.{self.name}")


STAGES = (
    Stage("environment", ()),
    Stage("place", ("environment",)),
    Stage("costs", ("environment", "place")),
    Stage("routes", ("environment", "costs")),
    Stage("flight", ("environment", "costs", "routes")),
    Stage("map", ("environment", "flight")),
    Stage("compare", ("environment", "place", "costs", "routes", "flight", "map")),
    Stage("report", ("environment", "place", "costs", "routes", "flight", "map", "compare")),
)
NAMES = tuple(stage.name for stage in STAGES)
FOLDERS = {name: f"{number}-{name}" for number, name in enumerate(NAMES, 1)}


def run_mission(
    mission: Mission, out: Path, *, only: str | None = None, force_from: str | None = None, tell: Tell = lambda _: None
) -> dict[str, str]:
    """Make what is missing or out of date below `out`; return for each stage looked at "made" or "up to date".

    only : run just this stage, from the stored products of those before it. force_from : make this stage and all
    after it again. InputError where a product to start from is missing.
    """
    for name in (only, force_from):
        if name is not None and name not in NAMES:
            raise InputError(f"unknown stage '{name}'{suggestion(name, NAMES)} (stages: {', '.join(NAMES)})")
    folders = {name: out / folder for name, folder in FOLDERS.items()}
    forced, done = False, dict[str, str]()
    for stage in STAGES:
        forced = forced or stage.name == force_from
        if only is not None and stage.name != only:
            continue
        stamps = {name: _input(name, folders[name], stage) for name in stage.needs}
        inputs = {name: stamp.digest for name, stamp in stamps.items()}
        settings = digest_of(stage.module.settings(mission))
        target = folders[stage.name]
        found = read_stamp(target)
        wanted = Stamp(stage.name, settings, inputs, code_digest(), revision())
        fresh = found is not None and found.made_like(wanted) and intact(found, target)
        if fresh and not forced:
            done[stage.name] = "up to date"
            tell(f"{stage.name}: up to date")
            continue
        for name in (name for name, stamp in stamps.items() if stamp.code != wanted.code):
            tell(f"{stage.name}: starts from products of '{name}' that other code made")
        _make(stage, mission, folders, wanted, tell)
        done[stage.name] = "made"
    page = folders["report"] / "report.html"
    if page.is_file():  # where people look for it
        write_aside(out / page.name, read_bytes(page))
    return done


def _make(stage: Stage, mission: Mission, folders: dict[str, Path], stamp: Stamp, tell: Tell) -> None:
    """Make one stage aside, rename its folder and tell."""
    target = folders[stage.name]
    for left in target.parent.glob(f".{target.name}.*.part"):
        _refuse_living(left)
        shutil.rmtree(left, ignore_errors=True)  # of a run that was killed
    aside = make_folder(target.with_name(f".{target.name}.{os.getpid()}.part"))
    try:
        began = time.perf_counter()
        said: str = stage.module.make(mission, folders, aside, lambda words: tell(f"{stage.name}: {words}"))
        elapsed = round(time.perf_counter() - began, 3)
        replace(stamp, products=products_of(aside), elapsed=elapsed).write(aside)
        if target.exists():
            shutil.rmtree(target)
        aside.rename(target)
    finally:
        shutil.rmtree(aside, ignore_errors=True)
    tell(f"{stage.name}: {said} ({elapsed:.1f} s)")


def _refuse_living(aside: Path) -> None:
    """Raise InputError where the process that writes the folder `aside` is still there."""
    owner = aside.name.split(".")[-2]
    if owner.isdigit() and int(owner) != os.getpid() and psutil.pid_exists(int(owner)):
        raise InputError(f"{aside.parent}: process {owner} is working on this mission; wait for it or end it")


def _input(name: str, folder: Path, stage: Stage) -> Stamp:
    stamp = read_stamp(folder)
    if stamp is None:
        raise InputError(f"{folder}: stage '{stage.name}' starts from the products of '{name}', which are not there")
    if not intact(stamp, folder):
        raise InputError(f"{folder}: products of stage '{name}' are missing or were changed; run it with --from {name}")
    return stamp
