"""The Preisach operator against the definition, Maxwell elements, Masing's rule and the second law."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from tests.models.hysteresis.paths import MASING, along, of, walk

from bristle import hysteresis, response
from bristle.core.dispatch import everett
from bristle.models.hysteresis.everett import KERNELS

every_kernel = pytest.mark.parametrize("kernel", KERNELS)


@every_kernel
@pytest.mark.parametrize("count", [100, 200])
def test_turning_points_are_the_relays_at_extremes_on_their_grid(kernel, count):
    levels = np.linspace(-3.0, 3.0, count + 1)
    path = levels[np.random.default_rng(7).integers(0, count + 1, 300)]
    grid = hysteresis.relays_of(of(kernel), 3.0, count)
    assert np.max(np.abs(response(of(kernel), path) - response(grid, path))) <= 1e-13


def maxwell(kernel, count):
    """Elements of equal stiffness whose thresholds follow the published stiffness density of the kernel."""
    share = (np.arange(count) + 0.5) / count
    thresholds = {"dahl_masing": (1.0 - share) ** -0.5 - 1.0, "exp_masing": -np.log1p(-share)}[
        kernel
    ]
    return hysteresis.prandtl_ishlinskii(thresholds=thresholds, weights=np.full(count, 1.0 / count))


@pytest.mark.parametrize("kernel", ["dahl_masing", "exp_masing"])
def test_turning_points_are_thousands_of_maxwell_elements(kernel):
    path = walk(8, 1000)
    errors = [
        np.max(np.abs(response(of(kernel), path) - response(maxwell(kernel, n), path)))
        for n in (30, 300, 3000)
    ]
    assert errors[-1] <= 1e-5
    assert errors[0] > 30.0 * errors[1] > 900.0 * errors[2]


@every_kernel
@settings(max_examples=50, deadline=None)
@given(path=st.lists(st.floats(-3.0, 3.0), min_size=1, max_size=12), tip=st.floats(0.1, 3.0))
def test_the_sign_is_only_a_direction(kernel, path, tip):
    whole = np.array([tip, *path])
    assert np.array_equal(response(of(kernel), whole), -response(of(kernel), -whole))


@pytest.mark.parametrize("kernel", MASING)
@settings(max_examples=50, deadline=None)
@given(tip=st.floats(0.01, 30.0), share=st.floats(1e-6, 1.0))
def test_masing_a_branch_is_the_virgin_curve_doubled(kernel, tip, share):
    below = tip - 2.0 * tip * share
    first, branch = response(of(kernel), [tip, below])
    (virgin,) = response(of(kernel), [0.5 * (tip - below)])
    assert abs((first - branch) - 2.0 * virgin) <= 1e-15 * max(1.0, tip)


@pytest.mark.parametrize("kernel", MASING)
@settings(max_examples=50, deadline=None)
@given(bias=st.floats(-5.0, 5.0))
def test_masing_kernels_are_congruent_everywhere(kernel, bias):
    # Both loops lie inside a large one, far apart: only those that know no origin have the same shape.
    loop = along([-0.4, 0.4, -0.4], 5)
    here = response(of(kernel), loop, history=[-9.0])[5:]
    present = response(of(kernel), loop + bias, history=[-9.0])[5:]
    assert np.max(np.abs((here - here[0]) - (present - present[0]))) <= 1e-14


def test_the_exact_kernel_has_an_origin():
    loop = along([-0.4, 0.4, -0.4], 5)
    here, present = (
        response(of("reformed_dahl_exact"), loop + bias, history=[-9.0])[5:] for bias in (0.0, 4.0)
    )
    assert np.max(np.abs((here - here[0]) - (present - present[0]))) > 1e-2


@every_kernel
def test_no_closed_cycle_returns_energy(kernel):
    generator = np.random.default_rng(9)
    pieces, ends = [np.array([0.0])], []
    for _ in range(500):
        cycle = generator.uniform(-1.0, 1.0, generator.integers(2, 7)) * 10 ** generator.uniform(
            -2.0, 1.0
        )
        # Twice: after the first time round it is closed, whatever came before.
        pieces.append(along([pieces[-1][-1], *cycle, cycle[0], *cycle[1:], cycle[0]], 40)[1:])
        ends.append((40 * cycle.size, int(sum(map(len, pieces)))))
    path = np.concatenate(pieces)
    force = response(of(kernel), path)
    mean, step = 0.5 * (force[1:] + force[:-1]), np.diff(path)
    rounds = [slice(end - 1 - length, end - 1) for length, end in ends]
    assert max(abs(force[item.stop] - force[item.start]) for item in rounds) <= 1e-14
    taken = np.array([np.sum(mean[item] * step[item]) for item in rounds])
    # Between turns the branches bend so that the trapezoids give less than was taken.
    assert np.min(taken) >= 0.0


@every_kernel
def test_off_the_diagonal_the_measure_is_negative(kernel):
    q = of(kernel).component.measure(of(kernel).parameters)
    generator = np.random.default_rng(10)
    h = 1e-3
    for _ in range(500):
        beta, alpha = np.sort(generator.uniform(-5.0, 5.0, 2))
        if alpha - beta > 3.0 * h:
            cell = (
                everett(alpha + h, beta, q)
                - everett(alpha, beta, q)
                - everett(alpha + h, beta + h, q)
            )
            assert cell + everett(alpha, beta + h, q) <= 1e-16


def test_the_loop_of_a_magnet_runs_in_the_opposite_sense():
    magnet = hysteresis.tabulated(lambda alpha, beta: 0.25 * (alpha - beta) ** 2, 1.0)
    loop = along([1.0, -1.0, 1.0], 200)
    for operator, sign in ((magnet, -1.0), (of("dahl_masing"), 1.0)):
        f = response(operator, loop)
        assert sign * np.sum(0.5 * (f[1:] + f[:-1]) * np.diff(loop)) > 0.1


@pytest.mark.parametrize("exponent", [1.0 - 1e-7, 1.0 + 1e-7])
def test_the_exponent_of_dahl_goes_over_into_the_exponential(exponent):
    path = walk(11, 300)
    near = response(of("dahl_masing", exponent=exponent), path)
    assert np.max(np.abs(near - response(of("exp_masing"), path))) <= 1e-7
    assert np.array_equal(
        response(of("dahl_masing", exponent=1.0), path), response(of("exp_masing"), path)
    )


@every_kernel
def test_at_large_inputs_every_kernel_is_saturated_and_finite(kernel):
    f = response(of(kernel), [1e9, -1e9, 1e200, -1e200, 0.0])
    assert np.all(np.isfinite(f))
    assert np.max(np.abs(np.abs(f[:4]) - 1.0)) <= 1e-8
