"""Every option of every method has words, and the range these state is the range that is taken."""

import re

import pytest

from formulations.moving_cost.registry import METHODS as COSTS
from formulations.routing.registry import SOLVERS
from formulations.selection.registry import METHODS as SELECTIONS
from formulations.task_location.registry import METHODS as PLACES
from instances.errors import InputError
from instances.families import FAMILIES
from instances.registry import option_meanings

OPTIONS = [
    pytest.param(registry, name, option, id=f"{registry.kind} {name} {option}")
    for registry in (SOLVERS, PLACES, COSTS, SELECTIONS)
    for name in registry.built_in
    for option in registry.defaults(name)
]


@pytest.mark.parametrize(("registry", "name", "option"), OPTIONS)
def test_an_option_says_what_it_means_and_takes(registry, name, option):
    meaning, default = registry.meanings(name)[option], registry.defaults(name)[option]
    assert len(meaning.split()) >= 2
    bounds = [float(n) for n in re.findall(r"\((?:at least )?([\d.]+)(?: to ([\d.]+))?\)", meaning) for n in n if n]
    if "(above 0" in meaning:
        with pytest.raises(InputError):
            registry.make(name, {option: type(default)(0)})
    for bound, outside in zip(bounds, (-1, 1), strict=False):
        registry.make(name, {option: type(default)(bound)})
        with pytest.raises(InputError):
            registry.make(name, {option: type(default)(bound + outside)})


def test_the_words_are_those_of_the_docstring_or_of_what_is_inherited_from():
    class Base:
        """A method.

        first : one
            and more.
        other : two.
        """

    class Own(Base):
        """Another.

        other : mine.
        """

    assert option_meanings(Own) == {"first": "one and more", "other": "mine"}


def test_a_parameter_of_a_family_says_what_it_means():
    for name in FAMILIES.built_in:
        assert all(len(parameter.meaning.split()) >= 2 for parameter in FAMILIES.load(name).parameters)


def test_one_solver_is_listed_with_its_options(cli):
    code, out, _ = cli("solvers", "ga")
    assert code == 0
    assert "    elite = 0.01: share of the population that survives as it is (0 to 1)\n" in out
    assert "memetic" not in out
    assert cli("solvers", "gaa")[2] == (
        "workbench: unknown solver 'gaa'; did you mean 'ga'? (workbench solvers lists them)\n"
    )


def test_a_solver_of_others_is_asked_for_its_options_where_it_is_named(cli):
    assert cli("solvers", "misbehaving:Honest")[1].endswith("    delay = 0.0\n")


def test_methods_are_listed_by_the_command_that_takes_them(cli):
    out = cli("methods", "refined")[1]
    assert out.startswith("workbench costs --method ...\n  refined: ")
    assert "select" not in out
