"""Noise taken off reversal curves, as far as the curves beside them agree."""

import numpy as np
import pytest
from tests.golden.simulated import MASING, NOISE, reversal_curves

from bristle.identification.hysteresis import identify_operator, result as curves
from bristle.identification.hysteresis.result import smoothed
from bristle.logs.curves import Curve, Curves
from bristle.models.hysteresis import preisach


@pytest.fixture(scope="module")
def clean():
    return reversal_curves(
        preisach(kernel="reformed_dahl_exact", s=1.0, f_p=1.0), count=61, samples=91
    )


def with_noise(curves, rng):
    return Curves(
        tuple(
            Curve(curve.u, curve.f + NOISE * rng.standard_normal(curve.u.size)) for curve in curves
        ),
        "saturated",
    )


def off(curves, truth):
    return float(
        np.sqrt(
            np.mean(np.concatenate([a.f - b.f for a, b in zip(curves, truth, strict=True)]) ** 2)
        )
    )


def test_noise_that_neighbours_do_not_share_is_removed(clean):
    result = smoothed(with_noise(clean, np.random.default_rng(5)))
    assert result.window >= 5
    assert off(result.recorded.curves, clean) < 0.7 * NOISE
    assert all(np.array_equal(a.u, b.u) for a, b in zip(result.recorded.curves, clean, strict=True))


def test_curves_without_noise_keep_their_shape(clean):
    result = smoothed(Curves(clean, "saturated"))
    assert off(result.recorded.curves, clean) < 0.1 * NOISE


def test_curves_that_turn_within_a_few_samples_are_unchanged():
    steep = reversal_curves(MASING, count=81, samples=8)
    assert smoothed(Curves(steep, "saturated")).window == 1


def test_falling_and_rising_curves_are_smoothed_equally(clean):
    rng, other = np.random.default_rng(6), np.random.default_rng(6)
    mirrored = tuple(Curve(-item.u, -item.f) for item in clean)
    rising, falling = smoothed(with_noise(clean, rng)), smoothed(with_noise(mirrored, other))
    assert falling.window == rising.window


@pytest.mark.slow
def test_smoothed_curves_predict_held_out_curves_better(clean, monkeypatch):
    recorded = with_noise(clean, np.random.default_rng(7))
    best = identify_operator(recorded, "reversal_table", folds=2).best
    monkeypatch.setattr(curves, "WINDOWS", (1,))
    as_recorded = identify_operator(recorded, "reversal_table", folds=2).best
    assert any("smoothed each curve" in note for note in best.notes)
    assert not any("smoothed each curve" in note for note in as_recorded.notes)
    assert best.held_out.mean_percent < 0.95 * as_recorded.held_out.mean_percent
