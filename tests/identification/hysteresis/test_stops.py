"""Stops with non-negative weights: what they reach on known friction, and what they refuse."""

import numpy as np
import pytest
from tests.golden.simulated import MASING, recorded, to_and_fro
from tests.identification.hysteresis.test_grid import error_on_unseen

from bristle import hysteresis, response
from bristle.core.errors import InputError
from bristle.identification.hysteresis.linear import fit_stops, thresholds_over
from bristle.logs.curves import Curve, Curves


@pytest.mark.slow
@pytest.mark.parametrize(("count", "most"), [(20, 0.0035), (40, 0.0018)])
def test_friction_of_prandtl_and_ishlinskii_is_found_to_a_fraction_of_a_percent(count, most):
    errors = []
    for seed in range(30):
        rng = np.random.default_rng(seed)
        fit = fit_stops(recorded(MASING, to_and_fro(rng), rng), count=count)
        errors.append(error_on_unseen(fit.operator, MASING, rng, fit.offset))
    assert np.median(errors) <= most
    assert np.mean(np.array(errors) <= most) > 0.9


def test_the_virgin_curve_is_that_of_the_truth():
    rng = np.random.default_rng(5)
    fit = fit_stops(recorded(MASING, to_and_fro(rng), rng, offset=0.7), count=40)
    x = np.linspace(0.05, 3.0, 30)
    assert np.max(np.abs(response(fit.operator, x) - response(MASING, x))) < 0.01
    assert fit.offset == pytest.approx(0.7, abs=0.005)
    assert fit.rms == pytest.approx(0.005, rel=0.1)


def test_weights_on_the_true_thresholds_are_recovered():
    truth = hysteresis.prandtl_ishlinskii(
        thresholds=[0.2, 0.7, 1.6], weights=[2.0, 0.5, 1.0], spring=0.3
    )
    fit = fit_stops(
        recorded(truth, to_and_fro(np.random.default_rng(0))),
        thresholds=np.array([0.2, 0.4, 0.7, 1.6]),
    )
    found = fit.operator.values
    assert [*found["thresholds"], *found["weights"], found["spring"]] == pytest.approx(
        [0.2, 0.7, 1.6, 2.0, 0.5, 1.0, 0.3], abs=1e-5
    )


def test_weights_are_never_negative():
    rng = np.random.default_rng(4)
    u = to_and_fro(rng)
    fit = fit_stops(Curves((Curve(u, rng.standard_normal(u.size)),)))
    assert np.all(fit.operator.values["weights"] >= 0.0)
    assert fit.operator.values["spring"] >= 0.0


def test_thresholds_without_a_range_are_refused():
    with pytest.raises(InputError, match="must have a range"):
        thresholds_over(0.0)
    assert np.allclose(np.diff(np.log(thresholds_over(1e-5, 30))), np.log(100.0) / 29.0)
