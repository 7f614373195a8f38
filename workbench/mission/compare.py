"""Stage 7, compare: what a person would fly otherwise, measured and mapped over the same fields with the same UAVs.

Every plan is flown over the mission's own field and, `[compare] seeds` times in all, over fields and noise drawn again
(`workbench.mission.redraw`); random tours are drawn again with them. The plans themselves are made once
(`workbench.mission.baselines`): only measuring and mapping is repeated, and the mission's own re-planning, whose events
meet no other plan. What nobody may fly is told and does not count.

Products: compare.csv (a row a plan, the mission first: means over the draws, and the verdict), compare-draws.csv (a row
a plan and draw), compare.json (over what the draws are), compare-ticks.csv and tracks.csv (of the first draw);
those of the calm twin (calm.py) or, in a wind that changes, of the static plan (clock.py).
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pandas as pd
from msgspec import structs

from formulations.mapping.flight_check import length_outside
from formulations.mapping.map_grid import MapGrid
from formulations.mapping.survey import Tick, last_map
from instances.disk import write_aside
from instances.scenario import Scenario
from instances.scenario_folder import kept_field, kept_scenario, kept_terrain
from reports.verdicts import named, plans, sentence, verdicts
from workbench.mission.baselines import Baselines, Plan
from workbench.mission.belief import Belief, belief_of
from workbench.mission.calm import write_calm_twin
from workbench.mission.clock import write_static_plan
from workbench.mission.flight import kept_flights, track_frame
from workbench.mission.laps import kept_laps
from workbench.mission.map import survey_of, ticks_frame
from workbench.mission.redraw import Measured, conditions, measured_field, redrawn_words
from workbench.mission.settings import Mission

Tell = Callable[[str], None]


def settings(mission: Mission) -> dict[str, Any]:
    """Return what this stage depends on."""
    return structs.asdict(mission.compare)


def make(mission: Mission, folders: dict[str, Path], out: Path, tell: Tell) -> str:
    """Fly and map every baseline."""
    scenario, field = kept_scenario(folders["environment"]), kept_field(folders["environment"])
    own = Plan("mission", scenario.n_tasks, kept_flights(folders["map" if mission.replan.wanted else "flight"]))
    laps = kept_laps(folders["flight"])
    tell(", ".join(mission.compare.baselines))
    made = Baselines(mission, scenario, kept_terrain(folders["environment"]), own.length, laps).made()
    ways = [[own], *made]
    tell(f"mapping {len(ways)} plans")
    belief, again = belief_of(mission, folders["environment"]), _again(mission, folders)
    rows, ticks = _first_draw(mission, belief, scenario, measured_field(mission, field), ways)
    points = MapGrid.over(scenario.region, mission.map.cells).points
    for draw, (redrawn, seed) in enumerate(conditions(mission, field)):
        for drawn in (way[draw % len(way)] for way in ways if draw > 0):
            plan = again(redrawn, seed) if again is not None and drawn is own else drawn
            refit = mission.map.refit_every > 0
            last = last_map(plan.flights, redrawn, points, **belief.sensing(mission), refit=refit, seed=seed)
            rows.append(_row(plan, draw, last, scenario))
    draws = pd.DataFrame(rows)
    write_aside(out / "compare.csv", plans(draws).to_csv(index=False))
    write_aside(out / "compare-draws.csv", draws.to_csv(index=False))
    write_aside(out / "compare.json", json.dumps({"over": redrawn_words(mission)}))
    write_aside(out / "compare-ticks.csv", pd.concat(ticks).to_csv(index=False))
    tracks = [track_frame(way[0].flights).assign(name=way[0].name)[::20] for way in ways]
    write_aside(out / "tracks.csv", pd.concat(tracks).to_csv(index=False))
    tell("the calm twin")
    write_calm_twin(mission, scenario, folders, out)
    write_static_plan(mission, scenario, folders, out)
    judged = verdicts(draws)
    for verdict in judged:
        tell(sentence(verdict, field.unit, redrawn_words(mission)))
    return "; ".join(f"against {named(verdict.name)}: {verdict.outcome}" for verdict in judged)


def _again(mission: Mission, folders: dict[str, Path]) -> Callable[[Measured, int], Plan] | None:
    """Return what flies the mission over another field and noise, which it re-plans by; None where it does not."""
    if not mission.replan.wanted:
        return None
    from workbench.mission.replan import Replanning  # here: most missions need none of it

    replanning = Replanning(mission, folders)

    def flown(field: Measured, seed: int) -> Plan:
        return Plan("mission", replanning.scenario.n_tasks, replanning.flown(field, seed).flights)

    return flown


def _first_draw(
    mission: Mission, belief: Belief, scenario: Scenario, field: Measured, ways: list[list[Plan]]
) -> tuple[list[dict[str, Any]], list[pd.DataFrame]]:
    """Return a row and the ticks of each plan over the mission's own field."""
    rows, ticks = [], []
    for plan in (way[0] for way in ways):
        survey = survey_of(mission, belief, scenario.region, field, plan.flights)
        rows.append(_row(plan, 0, survey.ticks[-1], scenario))
        frame = ticks_frame(survey)
        flown = plan.length * frame["samples"] / frame["samples"].iloc[-1]
        ticks.append(frame.assign(name=plan.name, flown=flown))
    return rows, ticks


def _row(plan: Plan, draw: int, end: Tick, scenario: Scenario) -> dict[str, Any]:
    row = {"name": plan.name, "draw": draw, "count": plan.count, "length": plan.length}
    row["longest"] = max(flight.length for flight in plan.flights)
    row["outside"] = length_outside(plan.flights, scenario.free)
    row |= {"samples": end.samples, "information": end.information} | asdict(end.score)
    return row | {"refused": plan.refused}
