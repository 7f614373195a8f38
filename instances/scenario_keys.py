"""What each key of a scenario file means, with its unit and an example: for people, in `workbench mission --help`."""

from __future__ import annotations

from typing import Any, NamedTuple


class ScenarioKey(NamedTuple):
    """One key: what it takes, what it means, and a value to show. `given` : whether a template gives it a value."""

    wanted: str
    meaning: str
    example: Any
    given: bool = True


SCENARIO_KEYS: dict[str, ScenarioKey] = {
    "name": ScenarioKey("a text", "short name; the file's name unless given", "survey"),
    "cost": ScenarioKey(
        "energy or time", "what a leg costs: the paper's energy at ground_speed, or flight time at airspeed", "energy"
    ),
    "ground_speed": ScenarioKey("a positive number [m/s]", "speed over ground, v0, with cost = energy", 100.0),
    "airspeed": ScenarioKey("a positive number [m/s]", "speed through the air, with cost = time", 30.0, False),
    "size": ScenarioKey(
        "two positive numbers [m]", "rectangle with (0, 0) in its lower left corner; or give region", [20000.0, 20000.0]
    ),
    "region": ScenarioKey(
        "a file", "its polygon, KML, KMZ, GeoJSON, GeoPackage or Shapefile; instead of size", "area.kml", False
    ),
    "no_fly": ScenarioKey("a file", "polygons that nobody may enter, as region", "zones.kml", False),
    "depots": ScenarioKey(
        "a list of points [x, y] [m] or [lon, lat], or a file of them",
        "one UAV at each",
        [[10000.0, 19000.0], [1000.0, 1000.0], [19000.0, 1000.0]],
    ),
    "tasks": ScenarioKey(
        "a whole number of at least 1, or a list of points [x, y] [m]", "how many tasks to place, or where they are", 40
    ),
    "crs": ScenarioKey(
        "a reference system, or local", "of lists and of files that state none: docs/coordinates.md", "EPSG:4326", False
    ),
    "terrain": ScenarioKey("a file", "elevation model, GeoTIFF or NetCDF", "dem.tif", False),
    "uav": ScenarioKey(
        "[[uav]] tables: depot, speed [m/s], endurance [s], count",
        "UAVs that differ: depot counts from 0, speed instead of the scenario's, endurance in seconds of cost",
        [{"depot": 0, "speed": 25.0, "endurance": 3600.0, "count": 1}],
        False,
    ),
    "service": ScenarioKey("a number [s], or one a task", "time spent at each task", 30.0, False),
    "return": ScenarioKey("own, any or none", "where tours end: at their own depot, at any, at their last task", "own"),
    "provenance": ScenarioKey("a table", "where the scenario comes from; kept, not read", {"made": "by hand"}, False),
}
"""Every key of a scenario that is no table with keys of its own."""

RADIO_KEYS: dict[str, ScenarioKey] = {
    "position": ScenarioKey("[x, y] [m]", "where the transmitter stands", [10000.0, 10000.0]),
    "height": ScenarioKey("a positive number [m]", "of its mast above the ground", 10.0),
    "frequency": ScenarioKey("a positive number [Hz]", "of the signal", 146e6),
    "power_dbm": ScenarioKey("a number [dBm]", "transmitted power", 40.0),
    "transmitter_gain_dbi": ScenarioKey("a number [dBi]", "gain of the transmitter's antenna", 6.0),
    "receiver_gain_dbi": ScenarioKey("a number [dBi]", "gain of the UAVs' antennas", 2.0),
}
"""Every key of [radio]: one transmitter, whose signal is measured where [field] names no file."""

WINDS: dict[str, tuple[str, dict[str, Any]]] = {
    "uniform": ("the same everywhere: velocity (u, v) [m/s]", {"velocity": [-5.0, 0.0]}),
    "shear": ("(rate · (y − y0), 0): rate [1/s], centre [m]", {"rate": 5e-4, "centre": [10000.0, 10000.0]}),
    "rotation": ("rigid, anticlockwise: rate [1/s], centre [m]", {"rate": 5e-4, "centre": [10000.0, 10000.0]}),
    "vortices": (
        "centres [m], circulation [m²/s] and core [m] of each",
        {"centres": [[6000.0, 8000.0]], "circulation": [60000.0], "core": [1500.0]},
    ),
    "turbulence": (
        "random eddies: rms [m/s], length_scale of the largest [m], seed, modes",
        {"rms": 3.0, "length_scale": 4000.0, "seed": 0, "modes": 48},
    ),
    "grid": (
        "a file: NetCDF, or WindNinja's _vel.asc with the units it is in (m/s, mph, kph, knots)",
        {"file": "wind.nc", "units": "m/s"},
    ),
    "terrain": (
        "flow over an elevation model (dem, a file) or made mountains: velocity of the inflow [m/s], profile log, "
        "power or uniform, known at reference [m] above the ground, altitude of the slice [m above sea level], cells",
        {
            "mountains": {"seed": 0, "relief": 2000.0, "length_scale": 12000.0},
            "velocity": [-7.0, -7.0],
            "profile": "log",
            "reference": 3000.0,
            "altitude": 3000.0,
            "cells": 160,
            "layers": 30,
        },
    ),
    "sum": (
        "of several winds, each a table with its kind",
        {
            "parts": [
                {"kind": "uniform", "velocity": [-5.0, 0.0]},
                {"kind": "turbulence", "rms": 2.0, "length_scale": 4000.0},
            ]
        },
    ),
}
"""Kind of [wind] → what it is and takes, and an example."""
