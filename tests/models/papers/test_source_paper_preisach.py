"""The source paper's equations (12) to (17): what they say, corrected where they cannot hold, and its construction.

"A modified friction model with hysteresis by Preisach": f_h(z) by relays (12), (13), by sums over the extremes (14),
(15), and the reformed Dahl model (16), (17) that its measure is taken from.
"""

import numpy as np
import pytest

from bristle import hysteresis, response
from bristle.apps.paper import EXPERIMENTS
from bristle.apps.paper.setting import read_setting
from bristle.apps.paper.sums import summed, summed_as_printed
from bristle.core.dispatch import everett
from bristle.models.hysteresis.everett import KERNELS


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
    gaps = []
    for f_s in (0.9, 1.0, 1.1):
        tip = tip_17(2.0 / f_s, f_s)
        gaps.append(rising_17(2.0, 1.0, 1.0, 2.0, tip) - tip)
    assert gaps == pytest.approx([0.053, 0.0, -0.050], abs=5e-4)
    # Nor with another slope than s.
    tip = tip_17(2.2)
    assert abs(rising_17(2.0, 1.0, 1.0, 2.0, tip) - tip) > 0.01


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


class Relays:
    """Relays one by one, all down at first: the definition (12) and (13), and nothing else."""

    def __init__(self, levels, weights):
        self.switch, self.weights = 0.5 * (levels[1:] + levels[:-1]), np.tril(weights)
        self.up = np.zeros(weights.shape, dtype=bool)

    def move(self, z):
        self.up = np.where(
            self.switch[:, None] < z, True, np.where(self.switch[None, :] > z, False, self.up)
        )

    @property
    def S_plus(self):
        """The integral over those that are up."""
        return float(np.sum(self.weights, where=self.up))


def cells_of(E, levels):
    """The measure of each cell, by differences of E at its corners."""
    corners = np.array(
        [[E(a, b) if a > b else 0.0 for b in levels.tolist()] for a in levels.tolist()]
    )
    return corners[1:, :-1] - corners[:-1, :-1] - corners[1:, 1:] + corners[:-1, 1:]


SETTING = read_setting(EXPERIMENTS / "fig_04.toml")
OPERATOR, TURNS, ARM = SETTING.operator, SETTING["path", "turns"], SETTING.arm
X = -TURNS[0]
LEVELS = np.linspace(-X, X, 61)
Q = OPERATOR.component.measure(OPERATOR.parameters)
WEIGHTS = cells_of(lambda a, b: everett(a, b, Q), LEVELS)


def nested(generator, low, count):
    """Levels each inside the two before, `low` first."""
    path = [low, 0]
    path[1] = int(generator.integers(low + 2, -low))
    while len(path) < count and abs(path[-1] - path[-2]) > 2:
        path.append(int(generator.integers(min(path[-2:]) + 1, max(path[-2:]))))
    return path


def test_14_and_15_as_printed_are_right_for_relays_of_0_and_1_but_for_one_constant():
    generator = np.random.default_rng(3)
    apart, too_much, signed = [], [], []
    for _ in range(40):
        # For one operator relays of 0 and 1 weigh twice what relays of -1 and 1 do.
        relays, path = Relays(LEVELS, 2.0 * WEIGHTS), nested(generator, -30, 12)
        for count, level in enumerate(path[1:], 2):
            walked = [X * item / 30 for item in path[:count]]
            relays.move(X * level / 30)
            force = response(OPERATOR, walked)[-1]
            apart.append(summed_as_printed(OPERATOR, walked) - relays.S_plus)
            too_much.append(ARM * (summed_as_printed(OPERATOR, walked) - force))
            signed.append(ARM * (summed_as_printed(OPERATOR, walked, lower=-1) - force))
            assert summed(OPERATOR, walked) == pytest.approx(force, abs=1e-12)
    assert len(apart) > 150
    assert np.max(np.abs(apart)) < 1e-11
    # One constant along every path: half of the loop between the saturations.
    assert 1e3 * np.array(too_much) == pytest.approx(39.147, abs=5e-4)
    assert np.ptp(too_much) < 1e-15
    assert ARM * 0.5 * np.ptp(response(OPERATOR, [-X, X], history=[X])) == pytest.approx(
        too_much[0], abs=1e-15
    )
    # With relays of -1 and 1 what is missing is none.
    assert np.ptp(signed) > 0.02


def test_13_sums_trapezoids_and_not_the_whole_of_S_plus():
    relays = Relays(LEVELS, WEIGHTS)
    for level in (24, -18, 15, -9, 3):
        relays.move(X * level / 30)
    # The trapezoids Q_k, column by column of the plane: from a minimum to the next, under the maximum between them.
    alpha, beta = 30.0 / X * relays.switch[:, None], 30.0 / X * relays.switch[None, :]
    links = [(-30, -18, 24), (-18, -9, 15), (-9, 3, 3)]
    by_cells = [
        np.sum(np.tril(WEIGHTS), where=(beta > low) & (beta < high) & (alpha < top))
        for low, high, top in links
    ]
    assert sum(by_cells) == pytest.approx(relays.S_plus, abs=1e-12)
    # Each of them is the difference of two triangles, and is no triangle.
    E = {
        (top, b): everett(X * top / 30, X * b / 30, Q)
        for low, high, top in links
        for b in (low, high)
    }
    for mass, (low, high, top) in zip(by_cells, links, strict=True):
        assert mass == pytest.approx(E[top, low] - E[top, high], abs=1e-12)
        assert top == high or abs(mass - E[top, low]) > 1.0
    # The sum as printed adds all of S+ for each k.
    assert abs(len(links) * relays.S_plus - sum(by_cells)) > 0.5 * abs(relays.S_plus)


def test_12_the_force_belongs_to_the_path_and_not_to_z():
    up, down = (response(OPERATOR, [start, 0.1 * TURNS[1]])[-1] for start in TURNS[:2])
    assert up > down + 10.0


def test_12_a_measure_of_friction_cannot_be_positive():
    # With mu >= 0, as a magnet has it, a loop gives energy back.
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
    [
        (0.5, 0.064, 0.032),
        (1.0, 0.117, 0.058),
        (2.0, 0.178, 0.089),
        (5.0, 0.251, 0.125),
        (10.0, 0.289, 0.145),
    ],
)
def test_100_transition_branches_describe_no_operator(k, corner, symmetry):
    branches = hysteresis.transition_branches(s=2.0, f_p=3.0, x_r=1.5 * k)
    assert abs(branches.corner_error - corner) < 6e-4
    assert abs(branches.symmetry_error - symmetry) < 6e-4


def by_its_own_loop(s, f_p):
    """Half of what (16), and (17) mirrored, leave at a reversal of their own amplitude, as printed."""

    def E(alpha, beta):
        x_r = max(alpha, -beta)
        f_r = tip_17(s * x_r / f_p, f_p)
        if alpha >= -beta:
            return 0.5 * (f_r - falling_16(beta, s, f_p, x_r, f_r))
        return 0.5 * (rising_17(alpha, s, f_p, x_r, f_r) + f_r)

    return E


@pytest.mark.parametrize("k", [0.5, 1.0, 5.0, 20.0])
def test_100_branches_each_of_its_own_loop_are_the_exact_kernel(k):
    s, f_p, X = 2.0, 3.0, 1.5 * k
    levels = np.linspace(-X, X, 101)
    E = by_its_own_loop(s, f_p)
    # No corner is missed and no direction preferred, where branches that leave one loop do both.
    tips = [(x_r, tip_17(s * x_r / f_p, f_p)) for x_r in levels[51:]]
    assert max(abs(falling_16(-x_r, s, f_p, x_r, f_r) + f_r) / f_r for x_r, f_r in tips) < 5e-14
    pairs = [(a, b) for a in levels for b in levels if b < a]
    assert max(abs(E(a, b) - E(-b, -a)) for a, b in pairs) <= 2e-15 * E(X, -X)
    # Its relays, one by one, against the kernel's turning points.
    weights = cells_of(E, levels)
    operator = hysteresis.preisach(kernel="reformed_dahl_exact", s=s, f_p=f_p)
    relays, worst = Relays(levels, weights), 0.0
    path = levels[np.random.default_rng(8).integers(0, 101, 300)]
    expected = response(operator, path, history=[-X])
    for z, f in zip(path, expected, strict=True):
        relays.move(z)
        worst = max(worst, abs(2.0 * relays.S_plus - np.sum(relays.weights) - f))
    assert worst <= 1e-13 * f_p


def test_100_transition_branches_give_their_own_branches_and_miss_the_mirrored_ones():
    k = 5.0
    branches = hysteresis.transition_branches(s=1.0, f_p=1.0, x_r=k)
    operator, f_r = branches.operator(), branches.f_r
    x = branches.inputs
    for i in (20, 50, 80):
        custom = response(operator, x[i::-1], history=[-k, x[i]])
        assert (
            np.max(np.abs((custom - custom[0]) - (branches.f[i, i::-1] - branches.f[i, i]))) < 4e-3
        )
    # The ascending branch itself is that of (17) only where descending ones were not asked for.
    risen = response(operator, x, history=[-k])
    missed = np.max(np.abs(risen - rising_17(x, 1.0, 1.0, k, f_r)))
    assert 0.2 * f_r < missed < 0.3 * f_r
    exact = hysteresis.preisach(kernel="reformed_dahl_exact", s=1.0, f_p=1.0)
    assert (
        np.max(np.abs(response(exact, x, history=[-k]) - rising_17(x, 1.0, 1.0, k, f_r))) <= 1e-15
    )


def test_100_transition_branches_are_asked_for_with_sense():
    for bad in ({"s": 0.0}, {"f_p": -1.0}, {"x_r": np.nan}, {"count": 1}):
        with pytest.raises(ValueError, match=next(iter(bad))):
            hysteresis.transition_branches(**({"s": 1.0, "f_p": 1.0, "x_r": 1.0} | bad))
