"""The source paper's equations (12) to (17): what they say, corrected where they cannot hold, and its construction.

"A modified friction model with hysteresis by Preisach": f_h(z) by relays (12), (13), by sums over the extremes (14),
(15), and the reformed Dahl model (16), (17) that its measure is taken from.
"""

import numpy as np
import pytest

from bristle import hysteresis, response
from bristle.core.dispatch import everett
from bristle.hysteresis.everett import KERNELS


def tip_17(k, f_p=1.0):
    """f_r as printed after (17), with f_s = f_p and S = s: the only reading in which a loop closes."""
    return 0.5 * f_p * (np.sqrt((1.0 + k) ** 2 + 4.0 * k) - (1.0 + k))


def falling_16(x, s, f_p, x_r, f_r):
    return (f_r * (f_p + f_r) - s * f_p * (x_r - x)) / (f_p + f_r + s * (x_r - x))


def rising_17(x, s, f_p, x_r, f_r):
    return (-f_r * (f_p + f_r) + s * f_p * (x_r + x)) / (f_p + f_r + s * (x_r + x))


@pytest.mark.parametrize("k", np.geomspace(1e-3, 1e3, 25))
def test_16_and_17_every_symmetric_loop_is_that_of_the_exact_kernel(k):
    s, f_p = 125.7e3, 0.156
    x_r = k * f_p / s
    operator = hysteresis.preisach(kernel="reformed_dahl_exact", s=s, f_p=f_p)
    x = np.linspace(-x_r, x_r, 401)
    f = response(operator, np.concatenate([x[::-1], x]), history=[x_r, -x_r])
    # f_r as printed cancels at small k; the loop that it belongs to is the same.
    f_r = 2.0 * f_p * k / (np.sqrt(1.0 + 6.0 * k + k * k) + 1.0 + k)
    assert abs(tip_17(k, f_p) - f_r) <= 1e-12 * f_p * (1.0 + k)
    assert np.max(np.abs(f[:401] - falling_16(x[::-1], s, f_p, x_r, f_r))) <= 1e-13 * f_p
    assert np.max(np.abs(f[401:] - rising_17(x, s, f_p, x_r, f_r))) <= 1e-13 * f_p


def test_17_closes_with_no_other_tip():
    for f_s in (0.9, 1.1):
        tip = tip_17(1.0 / f_s, f_s)
        assert abs(rising_17(1.0, 1.0, 1.0, 1.0, tip) - tip) > 0.03


def extremes(path):
    """The alternating maxima and minima that dominate all later ones, after negative saturation at path[0]."""
    M, m, past = [], [path[0]], path[1:]
    while past.size > 1:
        top = int(np.argmax(past)) if len(M) < len(m) else int(np.argmin(past))
        if top == past.size - 1:
            break
        (M if len(M) < len(m) else m).append(past[top])
        past = past[top + 1 :]
    return M, m


def by_sums(path, E):
    """Equations (14) and (15), with the factor 2 and the offset that relays of -1 and +1 need."""
    M, m = extremes(path)
    N, z = len(M), path[-1]
    if len(M) == len(m):
        done = sum(E(M[k], m[k]) - E(M[k], m[k + 1]) for k in range(N - 1))
        return -E(-path[0], path[0]) + 2.0 * done + 2.0 * (E(M[-1], m[N - 1]) - E(M[-1], z))
    done = sum(E(M[k], m[k]) - E(M[k], m[k + 1]) for k in range(N))
    return -E(-path[0], path[0]) + 2.0 * done + 2.0 * E(z, m[N])


@pytest.mark.parametrize("kernel", KERNELS)
def test_14_and_15_with_factor_2_and_offset_are_the_turning_points(kernel):
    operator = hysteresis.preisach(kernel=kernel, s=1.0, f_p=1.0)
    q = operator.component.measure(operator.parameters)
    generator = np.random.default_rng(17)
    worst, deepest = 0.0, 0
    for _ in range(200):
        # Under a falling envelope many extremes stay, at random they wipe each other out.
        envelope = 3.9 * generator.uniform(0.7, 1.0) ** np.arange(generator.integers(2, 20))
        turns = np.concatenate([[-4.0], envelope * generator.uniform(-1.0, 1.0, envelope.size)])
        f = response(operator, turns)[-1]
        worst = max(worst, abs(f - by_sums(turns, lambda a, b: everett(a, b, q))))
        deepest = max(deepest, len(extremes(turns)[0]))
    assert worst <= 1e-14
    assert deepest >= 5


def test_14_as_printed_is_not():
    operator = hysteresis.preisach(kernel="dahl_masing", s=1.0, f_p=1.0)
    q = operator.component.measure(operator.parameters)
    printed = everett(-3.0, -4.0, q)
    assert abs(printed - response(operator, [-4.0, -3.0])[-1]) > 0.2


def test_12_a_measure_of_friction_cannot_be_positive():
    # With mu >= 0, as printed, a loop gives energy back.
    grid = hysteresis.relay_grid(levels=np.linspace(-1.0, 1.0, 21), weights=np.full(210, 1.0 / 210))
    x = np.concatenate([np.linspace(1.0, -1.0, 201), np.linspace(-1.0, 1.0, 201)])
    f = response(grid, x)
    assert np.sum(0.5 * (f[1:] + f[:-1]) * np.diff(x)) < -0.1


def test_13_needs_the_relays_that_are_down_too():
    # At negative saturation S+ is empty, and the force is not zero.
    operator = hysteresis.preisach(kernel="dahl_masing", s=1.0, f_p=1.0)
    assert response(operator, [-50.0])[0] < -0.9


@pytest.mark.parametrize(
    ("k", "corner", "symmetry"),
    [(0.5, 0.064, 0.032), (1.0, 0.117, 0.058), (2.0, 0.178, 0.089), (5.0, 0.251, 0.125), (10.0, 0.289, 0.145)],
)
def test_100_transition_branches_describe_no_operator(k, corner, symmetry):
    branches = hysteresis.transition_branches(s=2.0, f_p=3.0, x_r=1.5 * k)
    assert abs(branches.corner_error - corner) < 6e-4
    assert abs(branches.symmetry_error - symmetry) < 6e-4


def test_100_transition_branches_give_their_own_branches_and_miss_the_mirrored_ones():
    k = 5.0
    branches = hysteresis.transition_branches(s=1.0, f_p=1.0, x_r=k)
    operator, f_r = branches.operator(), branches.f_r
    x = branches.inputs
    for i in (20, 50, 80):
        own = response(operator, x[i::-1], history=[-k, x[i]])
        assert np.max(np.abs((own - own[0]) - (branches.f[i, i::-1] - branches.f[i, i]))) < 4e-3
    # The ascending branch itself is that of (17) only where descending ones were not asked for.
    risen = response(operator, x, history=[-k])
    missed = np.max(np.abs(risen - rising_17(x, 1.0, 1.0, k, f_r)))
    assert 0.2 * f_r < missed < 0.3 * f_r
    exact = hysteresis.preisach(kernel="reformed_dahl_exact", s=1.0, f_p=1.0)
    assert np.max(np.abs(response(exact, x, history=[-k]) - rising_17(x, 1.0, 1.0, k, f_r))) <= 1e-15


def test_100_transition_branches_are_asked_for_with_sense():
    for bad in ({"s": 0.0}, {"f_p": -1.0}, {"x_r": np.nan}, {"count": 1}):
        with pytest.raises(ValueError, match=next(iter(bad))):
            hysteresis.transition_branches(**({"s": 1.0, "f_p": 1.0, "x_r": 1.0} | bad))
