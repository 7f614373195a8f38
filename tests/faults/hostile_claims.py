"""Solvers that claim what is not so, or return what is no result."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass

import numpy as np

from formulations.routing.solver import Event, Result, Status
from instances import makespan
from tests.faults.hostile import Honest, honest, plug_in, routes_of


def value_of(instance):
    return makespan(instance, routes_of(instance))


@plug_in
def bound_streamed_too_high(instance, observe):
    observe(Event(0.0, None, 1.5 * value_of(instance), None))


@plug_in
def bound_in_the_end_too_high(instance, observe):
    return honest(instance, observe, bound=1.5 * value_of(instance))


@plug_in
def optimal_without_bound(instance, observe):
    return honest(instance, observe, status=Status.OPTIMAL)


@plug_in
def optimal_without_routes(instance, observe):
    value = value_of(instance)
    return Result(Status.OPTIMAL, value, value, 0.0, None, stopped_by="proof")


@plug_in
def optimal_with_gap(instance, observe):
    return honest(instance, observe, status=Status.OPTIMAL, bound=0.9 * value_of(instance))


@plug_in
def optimal_within_anything(instance, observe):
    return honest(instance, observe, status=Status.OPTIMAL, bound=0.0, tolerance=value_of(instance))


@plug_in
def infeasible_beside_routes(instance, observe):
    return honest(instance, observe, status=Status.INFEASIBLE, stopped_by="proof")


@dataclass(frozen=True)
class Infeasible(Honest):
    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        return Result(Status.INFEASIBLE, stopped_by="proof")


@dataclass(frozen=True)
class Gives(Honest):
    """Returns routes in which `nodes` stand in place of the first task, with the cost of honest ones."""

    nodes: str = ""

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        nodes = tuple(eval(self.nodes))
        routes = (nodes + tuple(instance.tasks)[1:], *(() for _ in range(instance.n_depots - 1)))
        return Result(Status.FEASIBLE, value_of(instance), None, 0.0, routes, stopped_by="finished")


@plug_in
def too_few_routes(instance, observe):
    return honest(instance, observe, routes=routes_of(instance)[:1])


@plug_in
def too_many_routes(instance, observe):
    return honest(instance, observe, routes=(*routes_of(instance), ()))


@plug_in
def routes_are_a_text(instance, observe):
    return honest(instance, observe, routes="0 1 2 3")


@plug_in
def routes_of_fractions(instance, observe):
    return honest(instance, observe, routes=((0.5, 1.0, 2.0, 3.0), ()))


@dataclass(frozen=True)
class Returns(Honest):
    """Returns honest routes with one field that is not; `value` is a Python expression."""

    field: str = ""
    value: str = ""

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        known = {"np": np, "math": math, "nested": nested, "value": value_of(instance), "Evil": Evil}
        return honest(instance, observe, **{self.field: eval(self.value, known)})


def nested(depth):
    table: dict = {}
    for _ in range(depth):
        table = {"in": table}
    return table


class Evil:
    """Ends the process when it is written or measured."""

    def __str__(self):
        os._exit(3)

    __repr__ = __float__ = __str__


@plug_in
def cost_is_half(instance, observe):
    return honest(instance, observe, objective=0.5 * value_of(instance))


@plug_in
def cost_is_half_while_streaming(instance, observe):
    observe(Event(0.0, 0.5 * value_of(instance), None, routes_of(instance)))


@plug_in
def flood_of_events(instance, observe):
    value = value_of(instance)
    for number in range(30_000):
        observe(Event(0.0, value, 1e-5 * number * value, None))


@plug_in
def not_a_result(instance, observe):
    return "banana"


@plug_in
def an_evil_result(instance, observe):
    return Evil()


@dataclass(frozen=True)
class Declines(Honest):
    """Declines with a reason that is a Python expression."""

    reason: str = ""

    def accepts(self, instance):
        return eval(self.reason)


@dataclass(frozen=True)
class Raises(Honest):
    """Raises what the Python expression `error` says, after honest routes."""

    error: str = ""

    def solve(self, instance, *, limits, seed=0, observe=None, start=None):
        honest(instance, observe)
        raise eval(self.error)
