"""The passive residual model: no element returns energy, and only a residual model that gains is kept."""

import numpy as np
import pytest

from bristle.engine.motion import along
from bristle.models.friction import maxwell_slip

pytest.importorskip("numba")
from benchmarks.passive import LIMITS, Grid, Passive, Rows, slipping
from benchmarks.residual import Boosting, Gain, Sparse, judged

DT = 1e-3
GRID = Grid(np.geomspace(1e-6, 1e-3, LIMITS), np.geomspace(1e-3, 0.05, 6))


def velocity(seed: int, count: int = 4000) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return (
        1e-3
        * np.cumsum(rng.standard_normal(count))
        * np.sin(np.arange(count) * rng.uniform(0.002, 0.02))
    )


@pytest.mark.parametrize("seed", range(5))
def test_no_limit_lets_an_element_return_more_energy_than_it_took(seed):
    v, rng = velocity(seed), np.random.default_rng(100 + seed)
    limits = [limit for _, limit in GRID.elements(v)]
    limits.append(np.abs(rng.standard_normal(v.size)) * 1e-4)  # any limit, also one that jumps
    for limit in limits:
        force, dissipated = slipping(v, DT, limit)
        work = np.cumsum(force * v * DT)
        assert np.min(work) >= -1e-12 * np.max(work)
        assert np.min(dissipated) >= -1e-12 * np.max(limit) ** 2


def test_monotone_functions_dissipate_at_every_speed():
    v = np.linspace(-0.3, 0.3, 601)
    for force in GRID.monotone(v):
        assert np.all(force * v >= 0.0)
        assert np.all(np.diff(force) >= 0.0)


def test_element_with_constant_limit_is_a_maxwell_slip_element():
    v, r = velocity(7), 2e-5
    expected = along(maxwell_slip(F_C=r, k_i=[1.0], nu_i=[1.0], validate=False), v, DT)
    assert slipping(v, DT, np.full(v.size, r))[0] == pytest.approx(expected, abs=1e-12 * r)


def record(seed: int, stiffness: float) -> Rows:
    """Return the rows of an axis whose model lacks an element with a limit that rises with the speed."""
    v, rng = velocity(seed), np.random.default_rng(200 + seed)
    columns = np.column_stack(GRID.columns(v, DT))
    missing = stiffness * slipping(v, DT, 3e-5 * np.minimum(np.abs(v) / 0.01, 1.0))[0]
    lossless = np.column_stack([np.gradient(v, DT), np.ones(v.size)])
    explained = 5.0 * np.sign(v)
    state = np.column_stack([columns[:, :LIMITS], v])
    effort = explained + missing + 0.2 * rng.standard_normal(v.size)
    return Rows(
        effort,
        explained,
        np.column_stack([columns, -explained]),
        lossless,
        state,
        np.abs(v) < 1e-3,
        10,
    )


def test_missing_element_is_found_and_kept():
    verdict = judged(Passive, [record(1, 1e5)], [record(2, 1e5)], record(3, 1e5))
    assert verdict.kept
    assert verdict.unseen.percent > 50.0
    fitted = Passive().fit(record(1, 1e5))
    assert np.min(fitted.weights[:-2]) >= 0.0


def test_friction_of_the_model_never_changes_its_sign():
    rows = record(1, 0.0)
    rows.effort[:] -= 2.0 * rows.explained
    assert Passive().fit(rows).weights[-3] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("method", [Passive, Sparse])
def test_residual_of_noise_is_not_kept(method):
    for seed in (11, 21, 31):
        assert not judged(method, [record(seed, 0.0)], [], record(seed + 2, 0.0)).kept


def test_a_factor_on_the_error_is_the_gain():
    error = np.random.default_rng(5).standard_normal(1000)
    gain = Gain.of(error, 0.75 * error)
    assert gain.percent == pytest.approx(25.0)
    assert gain.spread == pytest.approx(0.0, abs=1e-9)
    other = Gain.of(error, np.random.default_rng(6).standard_normal(1000))
    assert other.spread > abs(other.percent) > 0.0


@pytest.mark.slow
def test_boosting_and_sparse_regression_find_a_product_of_the_state():
    pytest.importorskip("sklearn")
    first, unseen = record(1, 0.0), record(3, 0.0)
    for method in (Boosting, Sparse):
        sides = []
        for rows in (first, unseen):
            v = rows.state[:, -1]
            sides.append(rows.part(np.ones(v.size, dtype=bool)))
            sides[-1].effort[:] += 3.0 * rows.state[:, 6] * np.abs(v) / 0.05
        error = sides[1].effort - sides[1].explained
        left = error - method().fit(sides[0]).effort(sides[1])
        assert np.std(left) < 0.8 * np.std(error)
