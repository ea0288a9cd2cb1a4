"""Bands around simulated positions hold what was measured: logs by simulators that are not the package's."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.prediction import foreign_axis, foreign_oscillator
from tests.prediction.known_axis import AXIS, recorded

from bristle import controllers
from bristle.core import Axis
from bristle.identification import identify
from bristle.prediction import predict

OPEN = Axis(
    plant="oscillator",
    resolution=foreign_oscillator.AXIS_STEP,
    at_rest=True,
    method="output_error",
    offset=0.0,
)
SLIDE = foreign_axis.VERTICAL._replace(weight=0.0)
LOOP = Axis(
    controller=controllers.cascade(k_p=SLIDE.k_p, k_v=SLIDE.k_v, k_i=SLIDE.k_i, k_ff=SLIDE.k_ff),
    resolution=SLIDE.count,
)


def swings(seconds=6.0, quick=1.9):
    """Three sines that begin gently [m]."""
    t = 1e-3 * np.arange(round(1e3 * seconds))
    begun = np.clip(t / 0.5, 0.0, 1.0)
    parts = ((2e-2, 0.55, 5.0), (3e-3, quick, 1.0), (4e-4, 4.9, 4.0))
    sines = sum(
        size * (np.sin(2.0 * np.pi * f * t + phase) - np.sin(phase)) for size, f, phase in parts
    )
    return begun**2 * (3.0 - 2.0 * begun) * sines


@cache
def fitted_in_open_loop(noise, step):
    log = foreign_oscillator.recorded(1, noise=noise, step=step)
    return identify(log, "bouc_wen", axis=replace(OPEN, resolution=step), blocks=0, draws=20).best


@cache
def fitted_along_the_motion(jitter):
    log = foreign_axis.recorded(SLIDE, swings(), jitter=jitter)
    return identify(log, "lugre", axis=LOOP, blocks=0, draws=20).best


@pytest.mark.slow
@pytest.mark.parametrize(("noise", "step"), [(8e-6, 1e-6), (0.0, 1e-5)])
@pytest.mark.parametrize("seed", [1, 2])
def test_open_loop_bands_cover_19_of_20_positions(noise, step, seed):
    fit = fitted_in_open_loop(noise, step)
    log = foreign_oscillator.recorded(seed, noise=noise, step=step)
    prediction = predict(
        fit.plant,
        fit.friction,
        log,
        replace(OPEN, resolution=step),
        "open-loop",
        bands=fit.resampling.bands,
    )
    assert 90.0 < prediction.position_inside_percent < 98.0


@pytest.mark.slow
@pytest.mark.parametrize("jitter", [0.0, 3e-6])
@pytest.mark.parametrize("seed", [5, 8])
def test_closed_loop_bands_cover_after_a_fit_by_inverse_dynamics(jitter, seed):
    fit = fitted_along_the_motion(jitter)
    log = foreign_axis.recorded(SLIDE, swings(), jitter=jitter, seed=seed)
    prediction = predict(
        fit.plant, fit.friction, log, LOOP, "closed-loop", bands=fit.resampling.bands
    )
    assert 90.0 < prediction.position_inside_percent < 98.0
    # What is left over brings them nearer to 95 %: little where rounding is all there is, nearly all of it elsewhere.
    bare = replace(fit.resampling.bands, left_in_closed_loop=0.0)
    without = predict(fit.plant, fit.friction, log, LOOP, "closed-loop", bands=bare)
    assert abs(prediction.position_inside_percent - 95.0) < 0.5 * abs(
        without.position_inside_percent - 95.0
    )
    assert not jitter or without.position_inside_percent < 50.0


@pytest.mark.slow
def test_a_loop_that_cannot_be_simulated_has_the_band_of_position_noise():
    log = foreign_axis.recorded(SLIDE, swings(1.5), jitter=3e-6)
    unknown = identify(
        log, "coulomb_viscous", axis=replace(LOOP, controller=None), blocks=0, draws=20
    ).best.resampling.bands
    assert unknown.left_in_closed_loop == pytest.approx(3e-6, rel=0.1)


@pytest.mark.slow
def test_pulses_beyond_the_drive_limit_are_predicted_with_a_limit_on_the_sum():
    slide = foreign_axis.Axis(
        95.0, 0.0, 20.0, 20.0, 1.0, 240.0, 1e7, 5e3, 160.0, 8500.0, 0.0, 0.0, 5e-8
    )
    limit, pulse = 350.0, 178.0
    axis = Axis(
        controller=controllers.cascade(k_p=slide.k_p, k_v=slide.k_v),
        resolution=slide.count,
        effort_limit=limit,
        presliding=4e-6,
    )

    def recorded(seed, quick):
        desired = swings(6.0, quick)
        pulses = np.where(
            np.sin(2.0 * np.pi * 1.3 * np.arange(desired.size) / 1e3) > 0.6, pulse, 0.0
        )
        return foreign_axis.recorded(
            slide, 2.3 * desired, seed=seed, noise=0.5, pulses=pulses, limit=limit
        )

    log = recorded(5, 1.9)
    law = log.effort.values - log.injected_effort
    assert np.min(law) < -1.1 * limit
    fit = identify(log, "coulomb_viscous", axis=axis, blocks=0, draws=20).best
    for unseen in (log, recorded(8, 1.9), recorded(9, 2.2)):
        prediction = predict(
            fit.plant, fit.friction, unseen, axis, "closed-loop", bands=fit.resampling.bands
        )
        assert prediction.metrics["force_error_percent"] < 3.0
        assert 85.0 < prediction.inside_percent < 99.0
        assert 85.0 < prediction.position_inside_percent < 99.0


# --- an axis whose friction is another than the model's ---------------------------------------------------------------


@pytest.fixture(scope="module")
def fit():
    return identify(
        recorded(count=8000, noise=0.1), "coulomb_viscous+asymmetry", axis=AXIS, blocks=0, draws=40
    ).best


@pytest.mark.slow
def test_open_loop_bands_grow_as_the_motion_drifts(fit):
    prediction = predict(
        fit.plant,
        fit.friction,
        recorded(2.3, 7.9, count=8000, noise=0.1),
        AXIS,
        "open-loop",
        bands=fit.resampling.bands,
    )
    width = prediction.position_half_width
    parts = [np.median(item) for item in np.array_split(width, 8)]
    assert np.all(np.diff(parts) > 0.0)
    assert 3.0 * parts[0] < parts[7] > 1.5 * parts[2]
    assert 90.0 < prediction.position_inside_percent < 99.0
    assert prediction.half_width is prediction.inside_percent is None


@pytest.mark.slow
def test_the_position_band_of_a_certain_model_is_the_encoder_rounding(fit):
    log, step = recorded(2.3, 7.9, count=8000, noise=0.1), 2e-5
    sure = {name: np.repeat(fit.parameters[name].value, 5) for name in fit.resampling.bands.draws}
    bands = replace(
        fit.resampling.bands, draws=sure, scatter=0.0, unexplained=0.0, left_in_open_loop=0.0
    )
    axis, motion = replace(AXIS, resolution=step), log.position.values
    coarse = replace(log, position=replace(log.position, values=np.round(motion / step) * step))
    prediction = predict(fit.plant, fit.friction, coarse, axis, "open-loop", bands=bands)
    # Rounding is no normal error: 95 % of it is nearer than 1.96 times its root mean square.
    expected = np.quantile(np.abs(coarse.position.values - motion), 0.95)
    assert prediction.position_half_width == pytest.approx(expected, rel=0.02)
