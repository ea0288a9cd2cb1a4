"""The measure of cells with a sign for each: the data choose it, and that of a magnet does not fit a friction."""

import numpy as np
import pytest
from tests.golden.simulated import MASING, recorded, reversal_curves, to_and_fro

from bristle import hysteresis, response
from bristle.core.errors import InputError
from bristle.identification.hysteresis.linear import fit_grid
from bristle.logs.curves import Curve, Curves
from bristle.models.hysteresis import relays_of, tabulated

FEW_LARGE = {"turns": 14, "amplitude": 4.0}


def error_on_unseen(operator, truth, rng, offset=0.0, paths=10, **path):
    """Root mean square error on other paths."""
    unseen = [to_and_fro(rng, **path) for _ in range(paths)]
    return float(
        np.sqrt(
            np.mean([(response(operator, u) + offset - response(truth, u)) ** 2 for u in unseen])
        )
    )


@pytest.mark.parametrize("seed", range(3))
def test_friction_is_found_within_a_percent_by_the_sign_that_the_data_choose(seed):
    rng = np.random.default_rng(seed)
    fit = fit_grid(recorded(MASING, to_and_fro(rng), rng), cells=30)
    assert "the sign of a friction" in fit.notes[0]
    assert error_on_unseen(fit.operator, MASING, rng) <= 0.01


def test_the_sign_of_a_magnet_does_not_fit_a_friction():
    rng = np.random.default_rng(0)
    data = recorded(MASING, to_and_fro(rng, **FEW_LARGE), rng)
    magnet = fit_grid(data, cells=20, signs=("magnet",))
    assert error_on_unseen(magnet.operator, MASING, rng, **FEW_LARGE) > 0.3
    assert fit_grid(data, cells=20).rms < 0.03 * magnet.rms


def test_a_magnet_is_recognised_from_its_curves():
    magnet = tabulated(lambda a, b: 0.05 * (a - b) ** 2 + 0.1 * (a - b), 3.0)
    data = Curves(reversal_curves(magnet), start="saturated", kind="magnetic")
    fit = fit_grid(data, cells=20)
    assert "the sign of a magnet" in fit.notes[0]
    assert fit.operator.kind == "magnetic"
    assert fit.rms < 0.002 * data.full_scale
    assert relays_of(fit.operator, 3.0, 20).values["weights"].min() > -1e-9


def test_the_operator_has_the_fitted_weights_to_the_bit():
    E = np.array([3.0, 4.0, 2.0, 6.0, 5.0, 3.0])
    truth = hysteresis.preisach_grid(low=-3.0, high=3.0, E=E, offset=0.5)
    rng = np.random.default_rng(3)
    u = to_and_fro(rng)
    fit = fit_grid(Curves((Curve(u, response(truth, u)),)), cells=3)
    assert fit.operator.values["E"] == pytest.approx(E, abs=1e-6)
    assert fit.operator.values["offset"] == pytest.approx(0.5, abs=1e-6)
    assert len(fit.notes) == 1  # a curve crosses each cell


def test_unsuitable_data_are_refused():
    with pytest.raises(InputError, match="is constant"):
        fit_grid(Curves((Curve(np.zeros(9), np.zeros(9)),)))
