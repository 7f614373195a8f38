"""Make one instance of a family: in closed form directly, or through moving costs where it makes a Scenario."""

from __future__ import annotations

from typing import Any

from instances import Instance
from instances.families import FAMILIES, MISSIONS, generate, make_scenario
from instances.families import family as family_of


def make_instance(family: str, n_tasks: int, n_depots: int, seed: int, parameters: dict[str, Any]) -> Instance:
    """Return one instance of `family`; InputError for an unknown family, parameter or value."""
    if family in MISSIONS:
        from formulations.moving_cost.costing import instance_of  # here: numba takes its time

        return instance_of(make_scenario(family, n_tasks, n_depots, seed, **parameters))[0]
    return generate(family, n_tasks, n_depots, seed, **parameters)


def check_family(family: str, parameters: dict[str, Any]) -> None:
    """Raise InputError for an unknown family, parameter or value, without making anything."""
    family_of(family).values(parameters)


def families() -> dict[str, dict[str, Any]]:
    """Return every family's description and parameters (default, unit, meaning, choices), by name."""
    return {
        name: {
            "about": family.description,
            "parameters": {
                p.name: {"default": p.default, "unit": p.unit, "meaning": p.meaning, "choices": list(p.choices)}
                for p in family.parameters
            },
        }
        for name, family in (FAMILIES | MISSIONS).items()
    }
