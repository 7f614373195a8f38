"""What is given: instances, routes and their independent check, file formats, generators, the environment."""

from instances.errors import InputError
from instances.instance import Instance
from instances.routes import Routes, as_routes, check_routes, makespan, objective, take_offs, tour_costs
from instances.travel import Travel

__all__ = [
    "InputError",
    "Instance",
    "Routes",
    "Travel",
    "as_routes",
    "check_routes",
    "makespan",
    "objective",
    "take_offs",
    "tour_costs",
]
