"""A field better known in one place than in another: planning, bounds, maps and fits take k(x, x) from a map."""

from __future__ import annotations

import math

import numpy as np
import pytest

from formulations.average_variance import AverageVariance
from formulations.kernel import KERNELS, SquaredExponential
from formulations.mapping.gaussian_process import GaussianProcess
from formulations.mapping.likelihood import RestrictedLikelihood
from formulations.mapping.map_model import EVERY_KERNEL, MapModel, choose_model
from formulations.mapping.trend import CONSTANT
from formulations.selection.worth import Worth, worth_of
from formulations.task_location.certificate import certificate
from formulations.task_location.criterion import Convention, Criterion
from formulations.task_location.derivatives import Expansion
from formulations.task_location.fewest import fewest_tasks
from formulations.task_location.greedy import greedy_choice
from formulations.task_location.greedy_swap import Exchange
from formulations.task_location.nelder_mead import JointForm
from formulations.task_location.placement import PlacementProblem, lattice, place
from formulations.task_location.registry import make_method
from formulations.task_location.uncertainty import posterior_sd
from instances.environment.region import Region
from instances.environment.value_map import ValueMap
from instances.errors import InputError

SQUARE = Region.rectangle(20_000, 20_000)
AXIS = np.linspace(0.0, 20_000.0, 11)
ROUGH = ValueMap(AXIS, AXIS, np.random.default_rng(1).uniform(0.0, 60.0, (11, 11)))
KERNEL = SquaredExponential.of_prior(ROUGH, (4000.0, 3000.0))
WEST = ValueMap(AXIS, AXIS, np.tile(np.where(AXIS < 8000, 60.0, 6.0), (11, 1)))


def criterion(name: str = "b", cells: int = 6, kernel: SquaredExponential = KERNEL) -> Criterion:
    return Criterion(kernel, SQUARE.cell_centres(cells, cells), convention=Convention(name))


def test_one_task_on_one_test_point_of_sixty():
    flat = ValueMap(AXIS, AXIS, np.full((11, 11), 60.0))
    kernel = SquaredExponential.of_prior(flat, (4000.0, 4000.0))
    both = Criterion(kernel, np.zeros((1, 2))).value([[0.0, 0.0]])
    assert both == pytest.approx(3.747979271525, abs=1e-12)
    assert both == pytest.approx(0.5 * math.log(3601**2 / (3601**2 - 3600**2)), abs=1e-11)


def test_the_joint_determinant_is_the_same_number():
    tasks = SQUARE.sample(5, np.random.default_rng(2))
    assert JointForm(criterion()).value(tasks) == pytest.approx(criterion().value(tasks), abs=1e-9)


@pytest.mark.parametrize("name", ["b", "a", "ig"])
def test_gradient_and_hessian_agree_with_differences(name):
    about = criterion(name)
    tasks, step = SQUARE.sample(4, np.random.default_rng(3)), 0.5
    here = Expansion(about, tasks)
    assert here.value == pytest.approx(about.value(tasks), abs=1e-11)
    for j in range(8):
        move = (step * np.eye(1, 8, j)).reshape(4, 2)
        ahead, behind = Expansion(about, tasks + move), Expansion(about, tasks - move)
        slope, bend = here.gradient.ravel() * 4000, here.hessian * 4000**2
        assert slope[j] == pytest.approx((ahead.value - behind.value) / (2 * step) * 4000, abs=1e-4)
        assert bend[j] == pytest.approx((ahead.gradient - behind.gradient).ravel() / (2 * step) * 4000**2, abs=1e-2)


@pytest.mark.parametrize("name", KERNELS)
def test_the_average_variance_and_its_gradient_know_the_map(name):
    rng, kernel = np.random.default_rng(8), KERNELS[name].of_prior(ROUGH, (4000.0, 3000.0))
    targets, known, points = (SQUARE.sample(k, rng) for k in (60, 5, 4))
    judged = AverageVariance(kernel, 1.0, targets, rng.uniform(0, 1, 60), known)
    left = posterior_sd(kernel, 1.0, np.vstack([points, known]), targets) ** 2
    value, gradient = judged(points)
    assert value == pytest.approx(judged.shares @ left, rel=1e-9)
    for j in range(8):
        move = (0.5 * np.eye(1, 8, j)).reshape(4, 2)
        slope = judged.value(points + move) - judged.value(points - move)
        assert gradient.ravel()[j] == pytest.approx(slope, rel=1e-4, abs=1e-5 * np.abs(gradient).max())
    assert judged.lower_bound(4) <= value


def test_greedy_and_exchanges_are_the_naive_ones():
    about, sites = criterion(), lattice(SQUARE, 7)
    chosen: list[int] = []
    for _ in range(6):
        gains = [about.value(sites[[*chosen, j]]) if j not in chosen else -1 for j in range(len(sites))]
        chosen.append(int(np.argmax(gains)))
    assert greedy_choice(about, sites, 6) == chosen
    exchange = Exchange(about, sites, [0, 1, 2])
    exchange.improve(1)
    assert exchange.chosen[1] == max(set(range(49)) - {0, 2}, key=lambda j: about.value(sites[[0, j, 2]]))


def test_tasks_go_where_little_is_known_and_no_placement_passes_the_bound():
    about = criterion(cells=8, kernel=SquaredExponential.of_prior(WEST, (4000.0, 4000.0)))
    problem = PlacementProblem(SQUARE, about, 8)
    found = place(problem, make_method("nlp", {"starts": 1}), "nlp")
    assert (found.points[:, 0] < 9000).sum() >= 6
    crowded = SQUARE.sample(8, np.random.default_rng(0)) * (0.4, 1.0)
    for name in ("b", "ig"):
        bound = certificate(about.under(Convention(name)), SQUARE, 8).bound
        assert max(found.information[name], about.under(Convention(name)).value(crowded)) <= bound


def test_the_map_is_the_batch_formula_and_no_number_of_readings_raises_a_variance():
    rng = np.random.default_rng(4)
    X, y, points = rng.uniform(0, 20_000, (30, 2)), rng.normal(size=30), rng.uniform(0, 20_000, (25, 2))
    process = GaussianProcess(KERNEL, 1.0, points, level=0.0)
    for k in range(0, 30, 4):
        process.extend(X[k : k + 4], y[k : k + 4])
    K, C = KERNEL(points, X), KERNEL(X, X) + np.eye(30)
    left = ROUGH(points) ** 2 - np.einsum("ij,ji->i", K, np.linalg.solve(C, K.T))
    posterior = process.posterior()
    assert posterior.mean == pytest.approx(K @ np.linalg.solve(C, y), rel=1e-8)
    assert posterior.sd**2 == pytest.approx(left, rel=1e-7, abs=1e-8)
    assert posterior_sd(KERNEL, 1.0, X, points) == pytest.approx(posterior.sd, rel=1e-7)
    assert (posterior.sd <= ROUGH(points) + 1e-9).all()


@pytest.mark.parametrize("name", KERNELS)
def test_the_likelihood_is_that_of_the_mapped_field_and_its_gradient_that_of_differences(name):
    rng = np.random.default_rng(5)
    X, truth = rng.uniform(0, 20_000, (30, 2)), KERNELS[name].of_prior(ROUGH, (3000.0, 5000.0))
    y = np.linalg.cholesky(truth(X, X) + np.eye(30)) @ rng.normal(size=30)
    mapped = truth.relative_sd
    assert mapped is not None
    likelihood = RestrictedLikelihood(1.0, X, y, CONSTANT, relative_sd=mapped(X))
    theta = np.log([40.0, 2500.0, 6000.0, 0.8])
    C = KERNELS[name](40.0, (2500.0, 6000.0), mapped)(X, X) + (1 + 0.8**2) * np.eye(30)
    Q = np.linalg.svd(np.ones((30, 1)))[0][:, 1:]
    contrasts, V = Q.T @ y, Q.T @ C @ Q
    density = -0.5 * (contrasts @ np.linalg.solve(V, contrasts) + np.linalg.slogdet(2 * np.pi * V)[1])
    value, gradient = likelihood(KERNELS[name], theta)
    assert value == pytest.approx(density - 0.5 * math.log(30), rel=1e-10)
    for k, step in enumerate(1e-5 * np.eye(4)):
        across = likelihood.value(KERNELS[name], theta + step) - likelihood.value(KERNELS[name], theta - step)
        assert gradient[k] == pytest.approx(across / 2e-5, rel=1e-5, abs=1e-5)


def test_a_fit_keeps_the_map_and_fits_its_height():
    rng = np.random.default_rng(6)
    X, truth = rng.uniform(0, 20_000, (120, 2)), SquaredExponential.of_prior(WEST, (4000.0, 4000.0))
    y = np.linalg.cholesky(truth(X, X) + np.eye(120)) @ rng.normal(size=120)
    believed = SquaredExponential(20.0, (2000.0, 2000.0), truth.relative_sd)
    kernel = choose_model(MapModel(believed), EVERY_KERNEL, 1.0, X, y).model.kernel
    assert kernel.relative_sd is truth.relative_sd
    assert isinstance(kernel, SquaredExponential)
    assert kernel.signal_sd == pytest.approx(60.0, rel=0.5)
    assert kernel.length_scales[0] == pytest.approx(4000.0, rel=0.3)


@pytest.mark.parametrize("name", ["ig", "b"])
def test_the_worth_of_tasks_is_made_again_from_what_it_says(name):
    tasks = SQUARE.sample(5, np.random.default_rng(7))
    worth = Worth.of_information(criterion(name), tasks)
    assert worth.value(range(5)) == pytest.approx(criterion(name).value(tasks), abs=1e-9)
    assert worth_of(worth.about, 5, tasks).value(range(5)) == pytest.approx(worth.value(range(5)), abs=1e-9)


def test_the_fewest_tasks_cannot_be_proved_under_a_map():
    with pytest.raises(InputError, match="cannot be proved under a map of the prior standard deviation"):
        fewest_tasks(SQUARE, KERNEL, 1.0, 3.0)
