"""Bands around simulated motions: of axes whose friction is another than the model's, and what makes them wide."""

from dataclasses import replace

import numpy as np
import pytest

from bristle import controllers, friction, sensors
from bristle.core import Axis
from bristle.engine import run_closed_loop
from bristle.identification import identify
from bristle.logs.log import Channel, Log
from bristle.plants import inertia
from bristle.prediction import predict

pytestmark = pytest.mark.slow

DT = 1e-3
PLANT = inertia(M=12.0)
TRUTH = friction.find("stribeck+asymmetry")(
    F_C_pos=8.0, F_C_neg=6.0, F_S_pos=10.0, F_S_neg=7.5, v_S=5e-3, F_v_pos=30.0, F_v_neg=35.0, offset=1.0
)
AXIS = Axis(controller=controllers.cascade(k_p=80.0, k_v=3000.0), resolution=1e-7)


def recorded(slow: float, quick: float) -> Log:
    """The log of the axis on a sum of two sines [rad/s]."""
    t = DT * np.arange(8000)
    desired = np.zeros((4, t.size))
    desired[0] = 0.02 * (np.sin(slow * t) + 0.4 * np.sin(quick * t)) * np.minimum(t, 1.0)
    trace = run_closed_loop(PLANT, TRUTH, AXIS.controller, sensors.encoder(resolution=AXIS.resolution), desired, DT, steps=8)
    effort = trace.command + 0.1 * np.random.default_rng(3).normal(size=t.size)
    return Log(
        time=Channel(t, "s", "t"),
        position=Channel(trace.measured, "m", "q"),
        effort=Channel(effort, "N", "u"),
        reference=Channel(desired[0], "m", "r"),
        sample_time=DT,
        segments=(slice(0, t.size),),
    )


@pytest.fixture(scope="module")
def fit():
    return identify(recorded(3.1, 10.7), "coulomb_viscous+asymmetry", axis=AXIS, blocks=0, draws=40).best


def test_open_loop_bands_grow_as_the_motion_drifts(fit):
    prediction = predict(fit.plant, fit.friction, recorded(2.3, 7.9), AXIS, "open-loop", bands=fit.resampling.bands)
    width = prediction.position_half_width
    parts = [np.median(item) for item in np.array_split(width, 8)]
    assert np.all(np.diff(parts) > 0.0)
    assert 3.0 * parts[0] < parts[7] > 1.5 * parts[2]
    assert 90.0 < prediction.position_inside_percent < 99.0
    assert prediction.half_width is prediction.inside_percent is None


def test_each_source_widens_the_bands_and_noise_alone_gives_its_width(fit):
    log = recorded(2.3, 7.9)
    whole = fit.resampling.bands
    sure = {name: np.repeat(fit.parameters[name].value, 5) for name in whole.draws}
    noise = replace(whole, draws=sure, scatter=0.0, unexplained=0.0, inflation=1.0)

    def width(bands):
        return predict(fit.plant, fit.friction, log, AXIS, "closed-loop", bands=bands).half_width

    alone = width(noise)
    np.testing.assert_allclose(alone, 1.96 * whole.noise, rtol=1e-9)
    for wider in (
        replace(noise, draws=whole.draws),
        replace(noise, scatter=0.05),
        replace(noise, unexplained=0.5),
        replace(noise, inflation=1.5),
    ):
        assert np.median(width(wider)) > 1.1 * np.median(alone)


def test_the_position_band_of_a_certain_model_is_the_encoder_rounding(fit):
    log, step = recorded(2.3, 7.9), 2e-5
    sure = {name: np.repeat(fit.parameters[name].value, 5) for name in fit.resampling.bands.draws}
    bands = replace(fit.resampling.bands, draws=sure, scatter=0.0, unexplained=0.0, left_in_open_loop=0.0)
    axis, motion = replace(AXIS, resolution=step), log.position.values
    coarse = replace(log, position=replace(log.position, values=np.round(motion / step) * step))
    prediction = predict(fit.plant, fit.friction, coarse, axis, "open-loop", bands=bands)
    # Rounding is no normal error: 95 % of it is nearer than 1.96 times its root mean square.
    expected = np.quantile(np.abs(coarse.position.values - motion), 0.95)
    assert prediction.position_half_width == pytest.approx(expected, rel=0.02)
