"""The criterion: exact values, laws, and derivatives against casadi's own differentiation."""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.kernel import SquaredExponential
from formulations.task_location.criterion import Convention, Criterion, convention
from formulations.task_location.derivatives import Expansion
from formulations.task_location.nelder_mead import JointForm
from formulations.task_location.uncertainty import information_gain, posterior_sd
from instances.environment.region import Region
from instances.errors import InputError

KERNEL = SquaredExponential(30.0, (4000.0, 4000.0))
SQUARE = Region.rectangle(20_000, 20_000)
CELLS = SQUARE.cell_centres(8, 8)


def worth(name: str, tests: list[list[float]], tasks: list[list[float]], **rest: float) -> float:
    return Criterion(KERNEL, np.array(tests, float), convention=Convention(name), **rest).value(np.array(tasks, float))


def test_one_task_on_one_test_point():
    assert worth("a", [[0, 0]], [[0, 0]]) == pytest.approx(0.5 * math.log(901), abs=1e-9)
    assert worth("b", [[0, 0]], [[0, 0]]) == pytest.approx(0.5 * math.log(901**2 / (901**2 - 900**2)), abs=1e-9)


def test_one_task_three_kilometres_from_a_latent_test_point():
    assert worth("a", [[0, 0]], [[3000, 0]]) == pytest.approx(0.420998, abs=1e-6)


@pytest.mark.parametrize(
    ("points", "nats"),
    [
        ([[7.0, 7.0]] * 5, 4.206027),
        ([[0, 0], [4000, 0]], 6.574813),
        ([[0, 0], [20_000, 0], [0, 20_000], [20_000, 20_000]], 13.6070105),
        ([[x, y] for x in (0, 10_000, 20_000) for y in (0, 10_000, 20_000)], 30.604194),
        ([[6000 * math.cos(t * math.pi / 4), 6000 * math.sin(t * math.pi / 4)] for t in range(8)], 25.723651),
    ],
)
def test_information_gain_closed_forms(points, nats):
    assert worth("ig", [[0, 0]], points) == pytest.approx(nats, abs=1e-6)
    assert information_gain(KERNEL, 1.0, np.array(points, float)) == pytest.approx(nats, abs=1e-6)


def test_ring_is_the_circulant_sum():
    ring = np.array([[6000 * math.cos(t * math.pi / 4), 6000 * math.sin(t * math.pi / 4)] for t in range(8)])
    eigenvalues = np.fft.fft(KERNEL(ring, ring)[0]).real
    assert information_gain(KERNEL, 1.0, ring) == pytest.approx(0.5 * np.log1p(eigenvalues).sum(), abs=1e-9)


def test_tasks_among_latent_tests_learn_everything_they_can():
    tests = SQUARE.cell_centres(5, 5)
    tasks = tests[[0, 3, 11, 17]].tolist()
    assert worth("a", tests.tolist(), tasks) == pytest.approx(worth("ig", tests.tolist(), tasks), abs=1e-6)


points_strategy = st.lists(st.tuples(st.floats(0, 20_000), st.floats(0, 20_000)), min_size=1, max_size=6).map(
    lambda rows: np.array(rows, float)
)


@settings(deadline=None, max_examples=40)
@given(points_strategy)
def test_both_noisy_at_most_latent_at_most_gain(tasks):
    b = Criterion(KERNEL, CELLS)
    values = [
        b.under(c).value(tasks) for c in (Convention.BOTH_NOISY, Convention.LATENT_TESTS, Convention.INFORMATION_GAIN)
    ]
    assert 0 < values[0] <= values[1] + 1e-9 <= values[2] + 2e-9


@settings(deadline=None, max_examples=30)
@given(points_strategy, st.floats(0.2, 5.0), st.floats(0.2, 5.0), st.floats(-1e5, 1e5), st.sampled_from("ab"))
def test_stretching_axes_with_their_length_scales_and_shifting_change_nothing(tasks, sx, sy, shift, name):
    stretch = np.array([sx, sy])
    one = Criterion(KERNEL, CELLS, convention=Convention(name))
    scales = (4000 * sx, 4000 * sy)
    other = Criterion(SquaredExponential(30.0, scales), CELLS * stretch + shift, convention=Convention(name))
    # (a) cuts eigenvalues off at 1e-13: rounding of the shifted points moves that edge
    assert other.value(tasks * stretch + shift) == pytest.approx(one.value(tasks), abs=1e-8 if name == "b" else 1e-4)


@settings(deadline=None, max_examples=20)
@given(points_strategy, st.randoms(use_true_random=False))
def test_order_does_not_matter_and_one_more_task_never_hurts(tasks, shuffler):
    criterion = Criterion(KERNEL, CELLS)
    order = list(range(len(tasks)))
    shuffler.shuffle(order)
    assert criterion.value(tasks[order]) == pytest.approx(criterion.value(tasks), abs=1e-9)
    assert criterion.value(tasks[:-1]) <= criterion.value(tasks) + 1e-9 if len(tasks) > 1 else True


@settings(deadline=None, max_examples=20)
@given(points_strategy, st.floats(0.1, 10))
def test_scaling_signal_and_noise_together_changes_nothing(tasks, factor):
    one = Criterion(KERNEL, CELLS)
    other = Criterion(SquaredExponential(30.0 * factor, (4000.0, 4000.0)), CELLS, noise_sd=factor)
    assert other.value(tasks) == pytest.approx(one.value(tasks), abs=1e-8)


@settings(deadline=None, max_examples=25)
@given(points_strategy)
def test_the_paper_s_joint_determinant_is_the_same_number(tasks):
    weights = np.linspace(0.2, 3.0, len(CELLS))
    criterion = Criterion(KERNEL, CELLS, weights, noise_sd=1.5, test_noise_sd=0.7)
    assert JointForm(criterion).value(tasks) == pytest.approx(criterion.value(tasks), abs=1e-8)


def test_weight_two_is_two_readings_and_weight_zero_is_none():
    tasks = SQUARE.sample(5, np.random.default_rng(1))
    doubled = Criterion(KERNEL, CELLS, np.where(np.arange(len(CELLS)) < 10, 2.0, 1.0))
    assert doubled.value(tasks) == pytest.approx(
        Criterion(KERNEL, np.vstack([CELLS, CELLS[:10]])).value(tasks), abs=1e-8
    )
    dropped = Criterion(KERNEL, CELLS, (np.arange(len(CELLS)) >= 10).astype(float))
    assert dropped.value(tasks) == pytest.approx(Criterion(KERNEL, CELLS[10:]).value(tasks), abs=1e-10)


def test_information_never_passes_what_the_tests_hold():
    tests = SQUARE.cell_centres(3, 3)
    criterion = Criterion(KERNEL, tests, test_noise_sd=5.0)
    many = SQUARE.sample(150, np.random.default_rng(0))
    assert 0.9 * criterion.ceiling() < criterion.value(many) < criterion.ceiling()


def casadi_information(criterion: Criterion, n: int) -> tuple[ca.Function, ca.Function]:
    """Return gradient and Hessian of I by casadi's differentiation of log det, with the kernel written in casadi."""
    z = ca.SX.sym("z", 2, n)
    scales = criterion.scales

    def kernel(a: ca.SX, b: ca.SX) -> ca.SX:
        rows = []
        for i in range(a.shape[1]):
            gap = (b - ca.repmat(a[:, i], 1, b.shape[1])) / ca.repmat(ca.DM(scales), 1, b.shape[1])
            rows.append(criterion.kernel.signal_sd**2 * ca.exp(-0.5 * ca.sum1(gap * gap)))
        return ca.vertcat(*rows)

    def log_det(matrix: ca.SX) -> ca.SX:
        return 2 * ca.sum1(ca.log(ca.diag(ca.chol(matrix))))

    tests = criterion.kernel(criterion.tests, criterion.tests) + criterion.test_noise * np.eye(len(criterion.tests))
    cross = kernel(z, ca.SX(criterion.tests.T))
    prior = kernel(z, z) + criterion.noise * ca.SX.eye(n)
    value = 0.5 * (log_det(prior) - log_det(prior - cross @ ca.SX(np.linalg.inv(tests)) @ cross.T))
    flat = ca.reshape(z, -1, 1)
    curvature, gradient = ca.hessian(value, flat)
    return ca.Function("g", [z], [gradient]), ca.Function("h", [z], [curvature])


@pytest.mark.parametrize("scales", [(4000.0, 4000.0), (3000.0, 7000.0)])
def test_gradient_and_hessian_agree_with_casadi(scales):
    criterion = Criterion(SquaredExponential(30.0, scales), SQUARE.cell_centres(4, 4), noise_sd=1.3)
    tasks = SQUARE.sample(5, np.random.default_rng(3))
    gradient, curvature = casadi_information(criterion, 5)
    here = Expansion(criterion, tasks)
    units = np.tile(scales, 5)  # compared in length scales, where derivatives are of order 1
    assert here.value == pytest.approx(criterion.value(tasks), abs=1e-10)
    assert here.gradient.ravel() * units == pytest.approx(np.array(gradient(tasks.T)).ravel() * units, abs=1e-9)
    theirs = np.array(curvature(tasks.T)) * units * units[:, None]
    assert np.abs(here.hessian * units * units[:, None] - theirs).max() < 1e-9


@pytest.mark.parametrize("name", ["a", "ig"])
def test_derivatives_under_the_other_conventions_agree_with_differences(name):
    criterion = Criterion(KERNEL, CELLS, convention=Convention(name))
    tasks = SQUARE.sample(4, np.random.default_rng(5))
    here, step = Expansion(criterion, tasks), 2.0
    for j in range(8):
        move = (step * np.eye(1, 8, j)).reshape(4, 2)
        ahead, behind = Expansion(criterion, tasks + move), Expansion(criterion, tasks - move)
        assert here.gradient.ravel()[j] == pytest.approx((ahead.value - behind.value) / (2 * step), abs=1e-7)
        assert here.hessian[j] == pytest.approx((ahead.gradient - behind.gradient).ravel() / (2 * step), abs=1e-9)


def test_posterior_sd_of_one_reading():
    sd = posterior_sd(KERNEL, 1.0, np.array([[0.0, 0.0]]), np.array([[0.0, 0.0], [4000.0, 0.0], [1e6, 0.0]]))
    beside = 900 - (900 * math.exp(-0.5)) ** 2 / 901
    assert sd == pytest.approx([math.sqrt(900 / 901), math.sqrt(beside), 30.0])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"tests": np.empty((0, 2))}, "none inside the region"),
        ({"tests": [[0.0, math.nan]]}, "point 0 is not finite"),
        ({"tests": [[0.0, 1.0, 2.0]]}, "shape"),
        ({"weights": [1.0] * 63 + [math.nan]}, "test point 63 is not a finite number"),
        ({"weights": [-1.0] + [1.0] * 63}, "test point 0 is negative"),
        ({"weights": [0.0] * 64}, "all are 0"),
        ({"weights": [1.0]}, "1 for 64"),
        ({"noise_sd": 0.0}, "noise_sd"),
        ({"noise_sd": 1e-4}, "drown in rounding"),
        ({"test_noise_sd": math.inf}, "test_noise_sd"),
    ],
)
def test_unusable_criteria_are_refused(change, words):
    with pytest.raises(InputError, match=words):
        Criterion(**{"kernel": KERNEL, "tests": CELLS} | change)


def test_the_literal_criterion_is_refused_with_the_reason():
    with pytest.raises(InputError, match="ill-posed"):
        convention("literal")
    with pytest.raises(InputError, match="unknown criterion"):
        convention("bb")
    with pytest.raises(InputError, match="needs criterion b"):
        JointForm(Criterion(KERNEL, CELLS, convention=Convention.LATENT_TESTS))
