"""The page about a mission's products: figures, tables, the growing map, and the sentences that say who won."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from instances.arrays import Floats
from instances.moving_cost import CostKind
from reports import numbers
from reports.columns import FLIGHT, TOURS, survey
from reports.figures.field import draw_field
from reports.figures.flight import draw_flight, draw_plans
from reports.figures.heights import draw_heights
from reports.figures.map import draw_judged, draw_stages
from reports.figures.mission import draw_comparison, draw_progress
from reports.figures.svg import Drawn
from reports.figures.value_maps import draw_value_maps
from reports.figures.verdicts import draw_verdicts
from reports.figures.wind import draw_wind
from reports.kinds import is_number
from reports.pages.blocks import Beside, Block, Facts, Lines, Section, Source, Table, table_of
from reports.pages.calm import calm_twin
from reports.pages.clocked import clocked_plan
from reports.pages.exported import exported
from reports.pages.film import film, player
from reports.pages.map_model import map_model
from reports.pages.page import Page, write_page
from reports.pages.polish import path_polish
from reports.pages.replans import replanned
from reports.pages.turns import coupled, spaced
from reports.products import Products
from reports.verdicts import MISSION, Verdict, difference, sentence, verdicts


def write_mission_page(folders: dict[str, Path], path: Path, said: dict[str, Any]) -> list[Drawn]:
    """Write the page about a mission's products to `path` and return its figures.

    folders : stage → its folder. said : what only the mission knows: ``title``, ``settings`` (text), ``stages`` (rows
    of name and text).
    """
    products = Products(folders)
    scenario, unit = products.scenario, products.unit
    ticks, table, judged_plans = products.ticks, products.compared, verdicts(products.draws)
    planned_tracks, flown = products.table("flight", "flown.csv"), products.flown
    samples = products.table("map", "samples.csv")
    wind = [] if scenario.wind is None else [draw_wind(scenario.wind, scenario.region)]
    source = tuple(scenario.radio["position"]) if scenario.radio else None
    given = [draw_field(products.field, scenario.region, products.terrain, source), *wind]
    flight = draw_flight(scenario, products.flown_tasks, products.table("flight", "reference.csv"), planned_tracks)
    heights = draw_heights(planned_tracks, products.terrain)
    stages = draw_stages(products.maps, scenario.region, scenario.depots, flown, samples, unit)
    judged = [draw_judged(products.maps, scenario.region, unit), draw_progress(ticks, unit)]
    compared = [
        *([draw_verdicts(products.draws, judged_plans, unit)] if judged_plans else []),
        draw_comparison(products.of_plans("compare-ticks.csv"), unit),
        draw_plans(scenario.region, scenario.depots, products.of_plans("tracks.csv"), table, unit),
    ]
    data = film(products, flown, samples, ticks)
    growing = [player(products, data), *map_model(products.map_model, unit), Beside([stages, list(judged)])]
    told = draw_value_maps(products.value_maps, scenario.region, scenario_tasks(products), unit)
    maps = [] if told is None else [told]
    planned: list[Block] = [_placed(products), *maps, _routed(products), *_tours(products), *_laps(products)]
    planned += spaced(products.spacing)
    moved, polished = path_polish(products, scenario_tasks(products))
    planned += [*moved, flight, heights]
    planned += [_checks(products), exported(folders)]
    worth, twin = calm_twin(products, scenario_tasks(products))
    by_clock, changing = clocked_plan(products, flown)
    plans = _plans(table, judged_plans, unit)
    blocks: list[Block] = [
        Facts(_headline(products, ticks), large=True),
        Lines([sentence(verdict, unit, products.over) for verdict in judged_plans]),
        Section("Environment", [*_drifting(products), Beside(given)], "given"),
        Section("Tasks, routes and flight", planned, "plan", "Plan"),
        *replanned(products.replans, unit),
        Section("The map as it grows", growing, "map", "Map"),
        Section("Against what a person would fly otherwise", [plans, Beside(compared)], "compared", "Compared"),
        *([Section("What planning in the wind is worth", worth, "calm", "Wind")] if worth else []),
        *([Section("What planning by the clock is worth", by_clock, "clock", "Clock")] if by_clock else []),
        _made(said),
    ]
    about = _about(products, ticks, table)
    write_page(Page(said["title"], about, blocks, "Lengths in metres, costs in seconds.", "film.js", data), path)
    return [*given, *maps, *polished, flight, heights, stages, *judged, *compared, *twin, *changing]


WORDS = [
    ("information", "½ log det(I + K/σ_n²) of all measurements under the planning kernel: what they say of the field "
     "[nats]"),
    ("lawnmower", "parallel lanes, the fewest that are at least as long as the mission's tours, shared so that the "
     "longest tour is about least"),
    ("random", "uniform random tasks, as many as make the tours at least as long, routed like the mission's"),
    ("greedy", "as many tasks as the mission has, each put where it gains most, routed like the mission's"),
]  # fmt: skip
"""What no column of a table explains."""


CAPTION = "Means over the draws; random tours are other ones in each draw."


def _made(said: dict[str, Any]) -> Section:
    parts = (
        ("Stages", Facts(said["stages"])),
        ("Settings", Source(said["settings"])),
        ("What the words mean", Facts(WORDS)),
    )
    return Section("How it was made", [Section(title, [block]) for title, block in parts], "made")


COST_NAMES = {CostKind.ENERGY: "energy cost", CostKind.TIME: "flight time"}
"""What a tour's cost is called."""


def _cost_name(products: Products) -> str:
    return COST_NAMES[products.scenario.cost if products.headings is None else CostKind.TIME]


def scenario_tasks(products: Products) -> Floats:
    """Return the tasks (n, 2) [m]."""
    return products.table("place", "tasks.csv")[["x", "y"]].to_numpy()


def _about(products: Products, ticks: pd.DataFrame, table: pd.DataFrame) -> str:
    scenario = products.scenario
    own = table[table["name"] == MISSION].iloc[0]
    return (
        f"{scenario.n_depots} UAVs fly {own['length'] / 1e3:.1f} km past {len(scenario_tasks(products))} tasks and "
        f"measure {int(own['samples'])} times; the last comes home after {ticks['time'].iloc[-1] / 60:.1f} min. "
        "Every number below was measured on the stored products."
    )


def _headline(products: Products, ticks: pd.DataFrame) -> list[tuple[str, str]]:
    end = ticks.iloc[-1]
    return [
        ("RMSE of the map", f"{end['rmse']:.2f} {products.unit}"),
        ("NLPD", f"{end['nlpd']:.2f} nats"),
        ("covered by the 95 % interval", f"{end['coverage']:.1%}"),
        ("information gathered", f"{end['information']:.0f} nats"),
        (f"longest tour, {_cost_name(products)}", f"{products.bound['objective']:.1f} s"),
    ]


def _placed(products: Products) -> str:
    said = products.placement
    if said["method"] == "given":
        return f"The scenario gives {len(said['points'])} tasks."
    bound = ""
    if said.get("certificate"):
        bound = f", {said['ratio']:.0%} of the bound that no placement passes ({said['certificate']:.1f})"
    return (
        f"Task locations by {said['method']} ({said['status']}): {len(said['points'])} tasks with "
        f"{said['mutual_information']:.1f} nats of mutual information (criterion b){bound}.{_left_unknown(products)}"
    )


def _left_unknown(products: Products) -> str:
    """Return the weighted rms sd that was minimised, and its bound; "" where information was maximised."""
    said = products.placement
    if "average_variance" not in said:
        return ""
    left, least = (max(said[name], 0.0) ** 0.5 for name in ("average_variance", "average_variance_bound"))
    return (
        f" They were placed for the least weighted mean variance J at the test points: readings at the tasks leave √J "
        f"= {left:.2f} {products.unit}, and no {len(said['points'])} readings anywhere leave less than {least:.2f}."
    )


def _routed(products: Products) -> str:
    run, effect = products.routes, products.instance.provenance.get("wind_effect", {})
    bound = products.bound
    left, asymmetry = (_share(effect, name) for name in ("rotational_asymmetry", "asymmetry"))
    matters = (
        "to flight times any wind matters"
        if products.scenario.cost is CostKind.TIME
        else f"the wind's vorticity leaves an asymmetry of {left:.2%} that tours feel"
        if left > 1e-4
        else "the wind is as good as a potential and changes no closed tour"
    )
    if products.headings is not None:
        return coupled(products.headings, run.label, bound)
    return (
        f"Routes by {run.label} ({run.status}): longest tour {run.objective:.2f} s; none can be below "
        f"{bound['bound']:.2f} s (by {bound['by']}), so that is at most {bound['gap']:.1%} too long. Costs differ by "
        f"direction by {asymmetry:.1%}; {matters}.{_left_out(products)}"
    )


def _left_out(products: Products) -> str:
    """Return what endurance leaves out and what it would have told."""
    said = products.selection
    if said is None:
        return ""
    left, lost = said["left_out"], said["everything"] - said["worth"]
    return (
        f" Endurance does not suffice for all tasks: {numbers.counted(len(left), 'task')} left out "
        f"({', '.join(map(str, left))}) would have told {lost:.2f} of {said['everything']:.2f} nats; no selection that "
        f"can be flown tells more than {said['bound']:.2f}, this one tells {said['worth']:.2f}."
    )


def _drifting(products: Products) -> list[Block]:
    """Return that the field drifts or changes, where it does."""
    tau, lasts = products.field_tau, products.field_lasts
    if tau is not None:
        how = f"The shadowing drifts: its correlation over time falls to 1/e in τ = {tau:g} s."
    elif lasts is not None:
        how = f"The field changes over {lasts:g} s after take-off, linear between its frames, and then stays."
    else:
        return []
    return [
        f"{how} The picture is the field at take-off; it is measured as it is at each moment, and each map is judged "
        "against the field then."
    ]


def _laps(products: Products) -> list[Block]:
    """Return how often the tours are flown and which way round, where that is not once and as they were routed."""
    said = products.laps
    if said is None:
        return []
    counts = [len(turned) for turned in said["turned"]]
    each = ", ".join(f"UAV {uav} {numbers.counted(count, 'lap')}" for uav, count in enumerate(counts))
    words = f"Costs above are those of one lap. Flown are: {each}."
    if said["sd"] is None:
        return [words]
    turned = sum(map(sum, said["turned"]))
    return [
        f"{words} The field drifts, and what is measured last is known best: {numbers.counted(turned, 'lap')} turned "
        f"round, which promises a root mean square sd of {said['sd']:.3g} {products.unit} at the end, "
        f"{said['unturned_sd']:.3g} with none turned. Directions are worth a few per cent; they are chosen where free."
    ]


def _tours(products: Products) -> list[Block]:
    """Return what the chosen tours take and cost, and what the wind is worth to them."""
    tours, scenario = products.table("routes", "tours.csv"), products.scenario
    words = f"Tours are chosen by {scenario.cost.described(scenario.speed)}. Along their reference paths at this speed:"
    if products.headings is not None:
        words = "Tours are chosen by the time of flight, turns included. Along their tracks at this speed:"
    return [words, table_of(tours.assign(uav="UAV " + tours["uav"].astype(str)), TOURS, key="tours")]


def _share(effect: object, name: str) -> float:
    """Return a number of the stated effect of the wind, 0 where it states none."""
    value = effect.get(name) if isinstance(effect, dict) else None
    return float(value) if is_number(value) else 0.0


def _checks(products: Products) -> Table:
    flown = products.table("flight", "flight-check.csv")
    home = flown["length"] == 0
    names: pd.Series = "UAV " + flown["uav"].astype(str) + np.where(home, ", stays home", "")
    return table_of(flown.mask(home).assign(uav=names), FLIGHT, key="flight")


def _plans(table: pd.DataFrame, judged: list[Verdict], unit: str) -> Table:
    """Return the plans compared; what nobody may fly is marked as such and not as the best."""
    more = {v.name: _more(v) for v in judged}
    refused = {v.name for v in judged if v.refused}
    said = {v.name: v.outcome for v in judged}
    names = [f"{name}, not flyable" if name in refused else name for name in table["name"]]
    shown = table.assign(name=names, **{key: table["name"].map(of) for key, of in (("more", more), ("verdict", said))})
    flyable = [name not in refused for name in table["name"]]
    return table_of(shown, survey(unit), key="plans", caption=CAPTION, rivals=flyable)


def _more(verdict: Verdict) -> str:
    """Return how much greater the baseline's RMSE is, with its interval where there is one."""
    if verdict.rmse.pairs < 2:
        return numbers.signed([verdict.turned.mean], abs(verdict.turned.mean))[0]
    mean, low, high = difference(verdict.turned)
    return f"{mean} ({low} to {high})"
