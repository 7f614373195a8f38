"""Moving costs between headings, for a scenario whose UAVs have turning radii: `workbench costs` of such a one."""

from __future__ import annotations

import dataclasses
import time
from pathlib import Path
from typing import Any

from formulations.moving_cost.turns.scenario import HeadingOptions, between_headings
from formulations.moving_cost.turns.spacing import advice, spacing_ratio
from instances.errors import InputError, naming, shown
from instances.files import write_instance
from instances.registry import refuse_unknown
from instances.scenario import Scenario
from workbench.terminal import print_json, say

ROUNDING = 5e-3
"""How far beyond a border a leg may lead [m]: depots may stand on it."""


def heading_options(given: dict[str, Any]) -> HeadingOptions:
    """Return which headings are asked for by ``--option``; InputError names what is wrong."""
    known = {field.name: field.default for field in dataclasses.fields(HeadingOptions)}
    refuse_unknown("costs between headings", "option", given, known)
    for name, value in given.items():
        if name == "depots":
            if value not in ("own", "closed"):
                raise InputError(f"--option depots: must be own or closed, got {shown(value)}")
        elif isinstance(value, bool) or not isinstance(value, int) or value < 0:
            raise InputError(f"--option {name}: must be a whole number of at least 0, got {shown(value)}")
    return HeadingOptions(**{"depots": "own", **given})


def write_turning_costs(
    scenario: Scenario, given: dict[str, Any], scenario_file: Path, out: Path, as_json: bool
) -> None:
    """Write the instance between headings of `scenario` to `out` and tell about it."""
    assert scenario.fleet.turning_radii is not None
    options, began = heading_options(given), time.perf_counter()
    with naming(scenario_file):
        instance = between_headings(scenario, options, scenario.free.polygon.buffer(ROUNDING))
    elapsed = time.perf_counter() - began
    write_instance(instance, out)
    ratio = spacing_ratio(scenario.free.area, scenario.n_tasks, float(scenario.fleet.turning_radii.max()))
    states = len(instance.travel.nodes) if instance.travel is not None else 0
    if as_json:
        about = {"instance": instance.name, "digest": instance.digest, "file": out, "method": "dubins"}
        print_json(about | {"states": states, "spacing": ratio, "advice": advice(ratio), "elapsed": elapsed})
        return
    say(f"{instance.summary()}; Dubins legs between {states} headings in {elapsed:.1f} s, flight times")
    say(f"tasks are {ratio:.3g} turning radii apart: {advice(ratio)}")
