"""The contents of a mission page: figures, tables, the growing map, and the sentences that say who won."""

from __future__ import annotations

import base64
import io
import json
from typing import Any

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.image import imsave

from instances.arrays import Floats
from reports.figures.field import SIGNAL, UNCERTAINTY, UNCERTAINTY_POWER, draw_field
from reports.figures.flight import colour_of, draw_flight, draw_plans
from reports.figures.map import draw_judged, draw_stages, signal_range
from reports.figures.mission import draw_comparison, draw_progress
from reports.figures.svg import Drawn, inline_svg
from reports.figures.wind import draw_wind
from reports.mission import Products


def sections(products: Products) -> tuple[dict[str, Any], list[Drawn]]:
    """Return what the template is filled with, and every figure."""
    scenario, unit, maps = products.scenario, products.unit, products.maps
    tasks = scenario_tasks(products)
    flown, reference = products.table("flight", "flown.csv"), products.table("flight", "reference.csv")
    samples, ticks = products.table("map", "samples.csv"), products.table("map", "ticks.csv")
    table = products.table("compare", "compare.csv")
    source = tuple(scenario.radio["position"]) if scenario.radio else None
    given = [draw_field(products.field, scenario.region, products.terrain, source)]
    if scenario.wind is not None:
        given.append(draw_wind(scenario.wind, scenario.region))
    plan = [draw_flight(scenario, tasks, reference, flown)]
    mapped = [
        draw_stages(maps, scenario.region, scenario.depots, flown, samples, unit),
        draw_judged(maps, scenario.region, unit),
        draw_progress(ticks, unit),
    ]
    compared = [
        draw_comparison(products.table("compare", "compare-ticks.csv"), table, unit),
        draw_plans(scenario.region, scenario.depots, products.table("compare", "tracks.csv"), table, unit),
    ]
    page = {
        "about": _about(products, ticks, table),
        "headline": _headline(products, ticks, table),
        "given": [_shown(d) for d in given],
        "plan": [_shown(d) for d in plan],
        "placed": _placed(products),
        "routed": _routed(products),
        "checks": _checks(products),
        "exported": _exported(products),
        "mapped": [_shown(d) for d in mapped],
        "film": film(products, flown, samples),
        "compared": [_shown(d) for d in compared],
        "comparison": _comparison(table, unit),
        "verdict": verdict(table, unit),
        "unit": unit,
    }
    return page, [*given, *plan, *mapped, *compared]


def scenario_tasks(products: Products) -> Floats:
    """Return the tasks (n, 2) [m]."""
    return products.table("place", "tasks.csv")[["x", "y"]].to_numpy()


def verdict(table: pd.DataFrame, unit: str) -> list[str]:
    """Return a sentence a baseline: who has the smaller error and density, and at what length."""
    own = table[table["name"] == "mission"].iloc[0]
    sentences = []
    for name, rows in table[table["name"] != "mission"].groupby("name", sort=False):
        other = rows[["length", "rmse", "nlpd"]].mean()
        better, certain = own["rmse"] < other["rmse"], own["nlpd"] < other["nlpd"]
        longer = other["length"] / own["length"] - 1
        length = f"{abs(longer):.0%} {'longer' if longer >= 0 else 'shorter'}"
        error = f"RMSE {own['rmse']:.2f} against {other['rmse']:.2f} {unit} ({own['rmse'] / other['rmse']:.0%})"
        winner = (
            "The mission wins" if better and certain else "The baseline wins" if not (better or certain) else "A draw"
        )
        density = f"NLPD {own['nlpd']:.2f} against {other['nlpd']:.2f} nats"
        sentences.append(f"{winner} against {name}: {error}, {density}; {name} flies {length}.")
    return sentences


def film(products: Products, flown: pd.DataFrame, samples: pd.DataFrame) -> dict[str, Any]:
    """Return the growing map: a picture of estimate and uncertainty a kept tick, and the tracks, for the slider."""
    maps = products.maps
    low, high = signal_range(maps)
    most = float(np.nanmax(maps.sd[0]))
    west, east, south, north = maps.extent
    tracks = [
        {
            "colour": colour_of(int(str(k))),
            "points": np.column_stack([track["x"] / 1e3, track["y"] / 1e3, track["time"]])[::6].round(3).tolist(),
        }
        for k, track in flown.groupby("uav")
    ]
    ticks = products.table("map", "ticks.csv").set_index("time")
    frames = [
        {
            "time": float(t),
            "mean": _picture(maps.mean[k], low, high, SIGNAL),
            "sd": _picture(maps.sd[k] ** UNCERTAINTY_POWER, 0.0, most**UNCERTAINTY_POWER, UNCERTAINTY),
            "rmse": round(float(ticks.loc[t, "rmse"]), 3),
            "samples": int(ticks.loc[t, "samples"]),
        }
        for k, t in enumerate(maps.time)
    ]
    bars = [
        {"picture": _bar(SIGNAL), "low": f"{low:.0f}", "high": f"{high:.0f}"},
        {"picture": _bar(UNCERTAINTY), "low": "0", "high": f"{most:.0f}"},
    ]
    dots = samples[["x", "y", "time"]].to_numpy() / np.array([1e3, 1e3, 1.0])
    data = {"frames": frames, "tracks": tracks, "samples": dots.round(3).tolist(), "unit": products.unit}
    box = {"west": west, "south": south, "width": east - west, "height": north - south}
    return {"data": json.dumps(data | {"box": box}).replace("<", "\\u003c"), "box": box, "bars": bars,
            "last": frames[-1]}  # fmt: skip


def _picture(values: Floats, low: float, high: float, colours: str) -> str:
    """Return a raster as a PNG data URI, a pixel a cell, north up; cells outside the region are clear."""
    shades = colormaps[colours](np.clip((values - low) / (high - low or 1.0), 0, 1), bytes=True)
    shades[~np.isfinite(values)] = 0
    buffer = io.BytesIO()
    imsave(buffer, np.ascontiguousarray(shades[::-1]), format="png")
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode()


def _bar(colours: str) -> str:
    return _picture(np.linspace(0, 1, 128)[None, :], 0.0, 1.0, colours)


def _about(products: Products, ticks: pd.DataFrame, table: pd.DataFrame) -> str:
    scenario = products.scenario
    own = table[table["name"] == "mission"].iloc[0]
    return (
        f"{scenario.n_depots} UAVs fly {own['length'] / 1e3:.1f} km past {len(scenario_tasks(products))} tasks and "
        f"measure {int(own['samples'])} times; the last comes home after {ticks['time'].iloc[-1] / 60:.1f} min. "
        "Every number below was measured on the stored products."
    )


def _headline(products: Products, ticks: pd.DataFrame, table: pd.DataFrame) -> list[dict[str, str]]:
    end = ticks.iloc[-1]
    unit = products.unit
    run = products.values("routes", "run.json")
    return [
        {"term": "RMSE of the map", "text": f"{end['rmse']:.2f} {unit}"},
        {"term": "NLPD", "text": f"{end['nlpd']:.2f} nats"},
        {"term": "covered by the 95 % interval", "text": f"{end['coverage']:.1%}"},
        {"term": "information gathered", "text": f"{end['information']:.0f} nats"},
        {"term": "longest tour, cost", "text": f"{run['objective']:.1f} s"},
    ]


def _placed(products: Products) -> str:
    said = products.values("place", "placement.json")
    if said["method"] == "given":
        return f"The scenario gives {len(said['points'])} tasks."
    bound = ""
    if said.get("certificate"):
        bound = f", {said['ratio']:.0%} of the bound that no placement passes ({said['certificate']:.1f})"
    return (
        f"Task locations by {said['method']} ({said['status']}): {len(said['points'])} tasks with "
        f"{said['mutual_information']:.1f} nats of mutual information (criterion b){bound}."
    )


def _routed(products: Products) -> str:
    run, instance = products.values("routes", "run.json"), products.instance
    gap = f", gap {run['gap']:.1%}" if run.get("gap") is not None else ""
    effect = instance.provenance.get("wind_effect", {})
    left = effect.get("rotational_asymmetry", 0.0)
    matters = (
        f"the wind's vorticity leaves an asymmetry of {left:.2%} that tours feel"
        if left > 1e-4
        else "the wind is as good as a potential and changes no closed tour"
    )
    return (
        f"Routes by {run['label']} ({run['status']}{gap}): longest tour {run['objective']:.2f} s. Costs differ by "
        f"direction by {effect.get('asymmetry', 0.0):.1%}; {matters}."
    )


def _exported(products: Products) -> str:
    """Return which files ground-control software can take, or how to get them."""
    folder = products.folders["flight"]
    files = sorted(path.name for ending in ("plan", "kml") for path in folder.glob(f"uav-*.{ending}"))
    if not files:
        return "Without an origin = [latitude, longitude] in the mission file there are no ground-control files."
    return f"For ground control (QGroundControl, KML; also GeoJSON), in {folder.name}: {', '.join(files)}."


def _checks(products: Products) -> dict[str, Any]:
    columns = [
        ("flown [km]", "length", 1e-3, 2),
        ("reference path [km]", "reference_length", 1e-3, 2),
        ("nearest to its tasks within [m]", "task_distance", 1, 3),
        ("least radius [m]", "least_radius", 1, 2),
        ("off the reference at most [m]", "deviation", 1, 0),
        ("end to start [m]", "closure", 1, 3),
        ("inside no-fly zones [m]", "in_no_fly", 1, 0),
    ]
    rows = []
    for row in products.table("flight", "flight-check.csv").to_dict("records"):
        cells = [{"text": f"{row[key] * scale:.{digits}f}", "kind": ""} for _, key, scale, digits in columns]
        if row["in_no_fly"] > 0:
            cells[-1]["kind"] = "bad"
        if row["length"] == 0:
            cells = [{"text": "stays home", "kind": ""}] + [{"text": "", "kind": ""}] * (len(columns) - 1)
        rows.append({"name": f"UAV {int(row['uav'])}", "cells": cells})
    return {"headings": ["UAV", *(heading for heading, *_ in columns)], "rows": rows}


def _comparison(table: pd.DataFrame, unit: str) -> dict[str, Any]:
    columns = [
        ("tasks or lanes", "count", 1, 0),
        ("flown [km]", "length", 1e-3, 1),
        ("longest tour [km]", "longest", 1e-3, 1),
        ("outside or in no-fly zones [km]", "outside", 1e-3, 2),
        ("samples", "samples", 1, 0),
        (f"RMSE [{unit}]", "rmse", 1, 3),
        ("NLPD [nats]", "nlpd", 1, 3),
        ("covered by the 95 % interval [%]", "coverage", 100, 1),
        (f"mean sd [{unit}]", "mean_sd", 1, 2),
        (f"greatest sd [{unit}]", "max_sd", 1, 2),
    ]
    least = {key: table[key].min() for key in ("rmse", "nlpd", "mean_sd", "max_sd")}
    rows = []
    for row in table.to_dict("records"):
        several = (table["name"] == row["name"]).sum() > 1
        cells = [
            {"text": f"{row[key] * scale:.{digits}f}", "kind": "best" if row[key] == least.get(str(key)) else ""}
            for _, key, scale, digits in columns
        ]
        rows.append({"name": row["name"] + (f", draw {int(row['draw']) + 1}" if several else ""), "cells": cells})
    return {"headings": ["Plan", *(heading for heading, *_ in columns)], "rows": rows}


def _shown(drawn: Drawn) -> dict[str, Any]:
    return {"key": drawn.key, "title": drawn.title, "caption": drawn.caption, "svg": inline_svg(drawn)}
