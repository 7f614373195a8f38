"""Ensembles in stores: reports say what routes take over the members, without the files these were read from."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from shapely.geometry import Polygon, box

from instances import Instance
from instances.environment.region import Region
from instances.environment.wind_changing import Turning
from instances.environment.wind_forecast import Forecast, sampled
from instances.files import read_instance
from instances.fleet import Fleet
from instances.moving_cost import CostKind
from instances.paths import Paths
from instances.scenario import Scenario, write_scenario
from reports.columns import listed_runs
from reports.metrics import with_gaps
from reports.pages.study_sections import over_members
from reports.record import ENSEMBLE, SPREAD
from reports.stores import read_stores
from reports.tables import RUN_COLUMNS, run_table
from workbench.jobs.job import folder_of
from workbench.jobs.store import Store
from workbench.planning import write_plan
from workbench.problems.routing import ROUTING
from workbench.sources import FileSource
from workbench.tours import planned_beside

NODES = np.array([[1e3, 1e3], [7e3, 1e3], [4e3, 6e3]])
REGION = Region(Polygon([(0, 0), (8000, 0), (8000, 7000), (3000, 8000)]))
STRAIGHT = Paths.of(3, [NODES[[a, b]] if a != b else np.empty((0, 2)) for a in range(3) for b in range(3)])
LENGTHS = np.hypot(*(NODES[:, None] - NODES[None]).transpose(2, 0, 1))


def blowing(u: float, turning: float = 90.0) -> Forecast:
    wind = sampled(Turning((u, 1.0), np.radians(turning) / 3600), REGION, np.arange(0.0, 1501.0, 300.0), 3)
    return replace(wind, take_off=100.0)


CALM, STORMY = (blowing(2.0), blowing(6.0, -400.0), blowing(-5.0)), (blowing(2.0), blowing(25.0))


def given(folder: Path, *members: Forecast, fleet: Fleet | None = None) -> Path:
    """An instance file, with its paths and the scenario they were planned in beside it."""
    pytest.importorskip("xarray")
    folder.mkdir()
    wind, zone = replace(blowing(3.0), members=members), box(6000, 6000, 6500, 6500)
    scenario = Scenario("windy", REGION, NODES[2:], 20.0, wind, NODES[:2], no_fly=(zone,), cost=CostKind.TIME,
                        fleet=fleet or Fleet())  # fmt: skip
    write_scenario(scenario, folder / "given.toml")
    instance = Instance("windy", LENGTHS / 20.0, 2, 1, NODES, {"family": "file"})
    write_plan(instance, STRAIGHT, folder / "windy.json", folder / "given.toml")
    return folder / "windy.json"


@pytest.fixture(scope="module")
def calm(tmp_path_factory):
    return given(tmp_path_factory.mktemp("calm") / "given", *CALM)


@pytest.fixture(scope="module")
def stored(calm, store_maker, tmp_path_factory):
    """A store's folder that keeps the ensemble."""
    return kept(calm, store_maker(tmp_path_factory.mktemp("stored") / "runs"))


def kept(file: Path, store) -> Path:
    """Keep the item of `file` as `workbench compare` does, with runs of two methods; return its folder."""
    instance = read_instance(file)
    Store(store.root).keep_items(ROUTING, {folder_of(instance): FileSource(file)})
    store.put(instance, store.record(instance, "ga", 0, ((0, 1),)))
    store.put(instance, store.record(instance, "memetic", 1, ((1, 0),)))
    store.put(instance, store.record(instance, "greedy", 0, None))
    return store.root / folder_of(instance)


def flown(file, routes):
    """Return the spread that `workbench solve` tells of."""
    instance = read_instance(file)
    return planned_beside(file, instance).spread(instance, routes)


def test_figures_are_those_of_solve_and_outlast_the_files(make_store, calm, tmp_path):
    store, file = make_store(), shutil.copytree(calm.parent, tmp_path / "given") / calm.name
    folder = kept(file, store)
    (folder / "wind-1.nc").unlink()
    kept(file, store)  # what was lost is kept anew
    told = {routes: flown(file, routes) for routes in (((0, 1),), ((1, 0),))}
    shutil.rmtree(file.parent)
    stores = read_stores(store.root)
    runs = stores.runs.set_index("method")
    assert stores.warnings == []
    for method, routes in (("ga", ((0, 1),)), ("memetic", ((1, 0),))):
        said = [getattr(told[routes], name) for name in SPREAD]
        assert runs.loc[method, [*ENSEMBLE]].tolist() == pytest.approx(said, rel=1e-9)
        again = flown(folder / "instance.json", routes)
        assert again.members == pytest.approx(told[routes].members, rel=1e-9), "solve knows the stored one as well"
    assert runs.loc["greedy", [*ENSEMBLE]].isna().all()
    worst = [told[routes].worst for routes in told]
    assert abs(worst[0] - worst[1]) > 1, "which way round matters"
    table = run_table(stores.runs)
    assert [name for name in table if name not in RUN_COLUMNS] == [*ENSEMBLE]
    assert {*ENSEMBLE} <= {column.key for column in listed_runs(stores.runs)}
    (section,) = over_members(with_gaps(stores.runs))
    note, table = section.blocks
    assert "On 1 instance the wind is an ensemble of forecasts." in str(note)
    assert f"{100 * (max(worst) / min(worst) - 1):#.3g}" in str(table)


def test_stores_without_an_ensemble_stay_as_they_are(make_store, tmp_path):
    for number, fleet in enumerate((None, Fleet(service=30.0))):
        store = make_store(f"runs{number}")
        file = given(tmp_path / f"given{number}", *(CALM if fleet else ()), fleet=fleet)
        folder = kept(file, store)
        assert sorted(path.name for path in folder.iterdir() if "-s" not in path.name) == ["instance.json"]
        runs = read_stores(store.root).runs
        assert list(run_table(runs)) == RUN_COLUMNS
        assert not {*ENSEMBLE} & {column.key for column in listed_runs(runs)}


@pytest.mark.parametrize(
    ("name", "old", "new", "words"),
    [
        ("wind-2.nc", None, "no grid", "wind-2.nc: cannot be read as NetCDF-3"),
        ("wind-2.nc", None, None, "wind-2.nc: cannot be read (No such file"),
        ("scenario.toml", "members = [", "members = 3 #", "scenario.toml: wind.members must be names of files, got 3"),
        ("scenario.toml", "[4000.0, 6000.0]", "[4000.0, 5000.0]", "scenario.toml: has other nodes than windy"),
        ("instance.paths.json.gz", None, "{", "instance.paths.json.gz: "),
    ],
)
def test_what_is_damaged_is_one_sentence(stored, tmp_path, name, old, new, words):
    damaged = shutil.copytree(stored, tmp_path / "runs") / name
    text = damaged.read_text() if old else ""
    assert old is None or old in text
    damaged.unlink() if new is None else damaged.write_text(text.replace(old, new) if old else new)
    stores = read_stores(tmp_path)
    (sentence,) = stores.warnings
    assert words in sentence
    assert sentence.endswith("what routes take over the members of the ensemble is not known.")
    assert stores.runs["value"].notna().sum() == 2
    assert stores.runs[[*ENSEMBLE]].isna().all(axis=None)


def test_a_member_stronger_than_the_airspeed_is_told(make_store, tmp_path):
    store = make_store()
    folder = kept(given(tmp_path / "given", *STORMY), store)
    (sentence,) = read_stores(store.root).warnings
    assert sentence.startswith(f"{folder}: ")
    assert "not less than the airspeed" in sentence


def test_a_member_that_is_missing_is_told_and_the_instance_kept_without(make_store, calm, tmp_path, caplog):
    store, file = make_store(), shutil.copytree(calm.parent, tmp_path / "given") / calm.name
    (file.parent / "wind-1.nc").unlink()
    folder = kept(file, store)
    (said,) = caplog.messages
    assert re.fullmatch(r".*given\.toml: .*wind-1\.nc: .*; so reports will not say what routes take over .*", said)
    assert not (folder / "scenario.toml").exists()
