"""The travel of a piezo actuator over its voltage: plays, which stops cannot follow."""

import numpy as np
import pytest

from bristle.files.curves import read_curves
from bristle.identification.hysteresis.linear import fit_stops

THRESHOLDS = np.array([3.0, 6.0, 12.0, 25.0])  # V
WEIGHTS = np.array([2e-8, 1e-8, 1.5e-8, 1e-8])  # m/V
ELASTIC = 6e-8  # m/V


def travel(voltage):
    """A stack of plays, one after the other: each follows the voltage at a distance."""
    places, output = np.zeros(THRESHOLDS.size), np.empty(voltage.size)
    for k, volt in enumerate(voltage):
        places = np.clip(places, volt - THRESHOLDS, volt + THRESHOLDS)
        output[k] = ELASTIC * volt + WEIGHTS @ places
    return output


@pytest.fixture
def curves(tmp_path):
    t = np.linspace(0.0, 1.0, 3000)
    voltage = 60.0 * (1.0 - np.cos(8.0 * np.pi * t)) * (1.0 - 0.8 * t)
    rows = [
        f"{volt:.6f};{1e6 * metre:.9f}"
        for volt, metre in zip(voltage, travel(voltage), strict=True)
    ]
    (tmp_path / "stack.csv").write_text("\n".join(["U [V];s [um]", *rows]) + "\n")
    described = {"schema": 1, "kind": "piezo", "columns": {"input": "U", "output": "s"}}
    return read_curves(tmp_path / "stack.csv", described)


def test_plays_are_found_for_a_lagging_output(curves):
    assert (curves.kind, curves.curves[0].f.max() < 2e-5) == ("piezo", True)
    fit = fit_stops(curves, thresholds=THRESHOLDS)
    p = fit.operator.parameters
    np.testing.assert_allclose(p.weights, -WEIGHTS, rtol=1e-4)
    assert p.spring == pytest.approx(ELASTIC + WEIGHTS.sum(), rel=1e-4)
    assert fit.rms < 1e-3 * np.ptp(curves.curves[0].f)


def test_other_kinds_are_fitted_with_stops_only(curves):
    from dataclasses import replace

    assert np.all(
        fit_stops(replace(curves, kind="translational")).operator.parameters.weights >= 0.0
    )
