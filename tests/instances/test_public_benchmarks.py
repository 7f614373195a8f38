"""Every public instance reads, and every stored tour costs what its source says."""

import csv
import json
from importlib.resources import files
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import vrplib

from instances import as_routes, check_routes, makespan
from instances.best_known import best_known
from instances.files import read_instance, read_routes, write_instance, write_routes
from instances.formats.tsplib_text import weight_scale

FOLDER = Path(__file__).resolve().parents[2] / ".." / "shared" / "benchmarks"
FILES = sorted(FOLDER.glob("*/*.mdm"))

pytestmark = pytest.mark.skipif(not FILES, reason=f"no benchmark instances beside the repository ({FOLDER.name})")


def rows():
    if not FILES:
        return {}
    with (FOLDER / "best_known.csv").open() as file:
        return {(row["set"], row["instance"]): row for row in csv.DictReader(file)}


ROWS = rows()
TOURS = json.loads((FOLDER / "tours.json").read_text()) if FILES else {}

# large ones share their coordinates with a smaller fleet's file: one each is enough for every day
DAILY = [f for f in FILES if not f.stem.startswith(("fl3795", "rl5915", "pcb3038")) or f.stem.endswith("_3")]


WRITTEN = ("eil51_5", "md1", "md8", "amd_kro124p_5")
"""Whose tours are looked up in files that we write: one depot, several, and costs that differ by direction."""


def check(file):
    instance = read_instance(file)
    row = ROWS[file.parent.name, file.stem]
    if row["n_tasks"]:
        assert (instance.n_tasks, instance.n_depots) == (int(row["n_tasks"]), int(row["m"]))
        symmetric = (instance.cost == instance.cost.T).all()
        assert bool(symmetric) == (row["symmetric"] == "True")
        known = best_known(instance.digest)
        assert known is not None
        assert known.best_known <= float(row["best_known"])
    tour = TOURS.get(instance.name)
    if tour is None:
        return
    ours = {node: i for i, node in enumerate(instance.provenance["nodes"][: instance.n_tasks])}
    routes = [[ours[node + 1] for node in route if node + 1 in ours] for route in tour["routes"]]
    assert check_routes(instance, routes) == []
    # stated to six decimals, or a whole number where the weights are whole
    assert makespan(instance, routes) == pytest.approx(tour["value"], abs=5.1e-7, rel=0)
    if tour["value"] == float(row["best_known"]):
        assert makespan(instance, routes) == pytest.approx(float(row["best_known"]), abs=5.1e-7, rel=0)
    else:  # a tour, but not of the best value known
        assert tour["value"] > float(row["best_known"])


@pytest.mark.parametrize("file", DAILY, ids=lambda f: f.stem)
def test_reads_and_stored_tours_re_evaluate(file):
    check(file)


@pytest.mark.slow
@pytest.mark.parametrize("file", [f for f in FILES if f not in DAILY], ids=lambda f: f.stem)
def test_the_largest_ones_too(file):
    check(file)


@pytest.mark.parametrize("ending", [".atsp", ".mtsp", ".vrp"])
@pytest.mark.parametrize("file", [f for f in FILES if f.stem in WRITTEN], ids=lambda f: f.stem)
def test_vrplib_finds_the_stated_value_in_what_we_write(tmp_path, file, ending):
    instance = read_instance(file)
    tour = TOURS[instance.name]
    ours = {node: i for i, node in enumerate(instance.provenance["nodes"][: instance.n_tasks])}
    write_routes(
        [[ours[node + 1] for node in r if node + 1 in ours] for r in tour["routes"]], instance, tmp_path / "a.sol"
    )
    write_instance(instance, tmp_path / f"a{ending}")
    theirs, solution = vrplib.read_instance(tmp_path / f"a{ending}"), vrplib.read_solution(tmp_path / "a.sol")
    seconds = theirs["edge_weight"] / weight_scale(instance)
    legs = [
        [at, *r, at] for at, r in zip(np.resize(theirs["depot"], instance.n_depots), solution["routes"], strict=True)
    ]
    longest = max(sum(seconds[a, b] for a, b in pairwise(stops)) for stops in legs)
    assert longest == pytest.approx(tour["value"], rel=1e-7)
    assert read_routes(tmp_path / "a.sol", read_instance(tmp_path / f"a{ending}")) == read_routes(
        tmp_path / "a.sol", instance
    )


def test_every_stored_tour_has_its_file():
    assert set(TOURS) <= {file.stem for file in DAILY}


OURS = json.loads(files("instances").joinpath("data/tours.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", OURS)
def test_values_found_here_have_the_routes_that_show_them(name):
    instance = next(i for f in FILES if f.stem == name and (i := read_instance(f)).digest == OURS[name]["digest"])
    routes = as_routes(OURS[name]["routes"])
    assert check_routes(instance, routes) == []
    known = best_known(instance.digest)
    assert known is not None
    assert makespan(instance, routes) == pytest.approx(known.best_known, abs=5.1e-7, rel=0)
    assert known.best_known < float(next(r for (_, n), r in ROWS.items() if n == name)["best_known"])
