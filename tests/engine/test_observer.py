"""A loose observer: what it predicts of a recorded position, and how that changes with the models."""

import math

import numpy as np
import pytest

from bristle import friction, plants
from bristle.core.packing import pack
from bristle.engine import run_open_loop
from bristle.engine.loop_derivatives import Sensitive
from bristle.engine.observer import gains_of, prediction_errors

DT, COUNT = 1e-3, 1200
TIME = DT * np.arange(COUNT)
EFFORT = 30.0 * np.sin(2.0 * np.pi * 3.0 * TIME) + 14.0 * np.sin(2.0 * np.pi * 11.0 * TIME)
PLANT = plants.inertia(M=2.0)
MODELS = {
    "elastoplastic": friction.elastoplastic(
        F_C=20.0, F_S=26.0, v_S=5e-3, sigma_0=2e6, sigma_1=800.0, sigma_2=30.0, z_ba=3e-6
    ),
    "lugre": friction.lugre(F_C=20.0, F_S=26.0, v_S=5e-3, sigma_0=2e6, sigma_1=800.0, sigma_2=30.0),
    "gms": friction.gms(
        F_C=20.0, F_S=26.0, v_S=5e-3, k_i=[2e6, 1e6], nu_i=[0.6, 0.4], C=400.0, sigma_2=30.0
    ),
    "preisach_lugre": friction.preisach_lugre(
        s=2e6, f_p=40.0, F_C=20.0, F_S=26.0, v_S=5e-3, sigma_1=800.0, sigma_2=30.0
    ),
}


def still(model, directions=1):
    return Sensitive(model, np.zeros((pack(model.parameters).size, directions)))


def moved(model, name, step):
    return model.component(**{**model.values, name: model.values[name] + step})


def slope_of(model, name):
    step = 1e-6 * abs(model.values[name])
    high, low = (
        np.nan_to_num(pack(moved(model, name, side * step).parameters), posinf=0.0)
        for side in (1.0, -1.0)
    )
    return (high - low)[:, None] / (2.0 * step)


def errors(plant, model, position, bandwidth=40.0, weights=(1.0,), efforts=None, tangents=None):
    rows = np.append(EFFORT, EFFORT[-1:])[None] if efforts is None else efforts
    tangents = np.zeros((len(weights), 1)) if tangents is None else tangents
    return prediction_errors(
        plant, model, position, rows, np.array(weights), tangents, bandwidth, DT, 8
    )


def recorded(model):
    fine = np.interp(np.arange(8 * COUNT) / 8.0, np.arange(COUNT), EFFORT)
    trace = run_open_loop(PLANT, model, fine, DT / 8.0, hold="linear")
    return trace.position[::8].copy()


def test_the_observer_predicts_the_motion_of_the_same_models():
    position = recorded(MODELS["lugre"])
    error, _ = errors(still(PLANT), still(MODELS["lugre"]), position)
    assert np.ptp(position) > 1e-3
    assert np.max(np.abs(error)) < 1e-11


def test_the_observer_estimates_a_missing_constant_force():
    position = recorded(MODELS["lugre"])
    shifted = np.append(EFFORT, EFFORT[-1:])[None] + 5.0
    error, _ = errors(still(PLANT), still(MODELS["lugre"]), position, efforts=shifted)
    assert np.max(np.abs(error[:60])) > 1e-6
    assert np.max(np.abs(error[600:])) < 0.02 * np.max(np.abs(error[:60]))


def test_errors_of_a_free_body_decay_with_three_equal_poles():
    gains = gains_of(100.0, DT)
    system = np.array([[1.0, DT, 0.5 * DT**2], [0.0, 1.0, DT], [0.0, 0.0, 1.0]])
    # An impulse over the sample moves the position by half of what it moves the velocity times the sample time.
    corrected = (
        np.array([gains[0] + 0.5 * DT**2 * gains[1], DT * gains[1], 0.0])
        + np.array([0.5 * DT**2, DT, 1.0]) * gains[2]
    )
    poles = np.linalg.eigvals(system - np.outer(corrected, [1.0, 0.0, 0.0]))
    assert np.abs(poles) == pytest.approx(math.exp(-0.1), abs=2e-4)


@pytest.mark.parametrize(
    "name",
    ["lugre", *(pytest.param(name, marks=pytest.mark.slow) for name in MODELS if name != "lugre")],
)
def test_observer_derivatives_agree_with_differences(name):
    model, position = MODELS[name], recorded(MODELS["lugre"])
    for parameter in [
        part
        for part, value in model.values.items()
        if isinstance(value, float) and math.isfinite(value) and abs(value) not in (0.0, 2.0, 0.9)
    ]:
        _, slopes = errors(still(PLANT), Sensitive(model, slope_of(model, parameter)), position)
        step = 1e-6 * abs(model.values[parameter])
        high, low = (
            errors(still(PLANT), still(moved(model, parameter, side * step)), position)[0]
            for side in (1.0, -1.0)
        )
        difference = (high - low) / (2.0 * step)
        assert np.linalg.norm(slopes[:, 0] - difference) < 1e-3 * np.linalg.norm(difference), (
            parameter
        )


def test_derivatives_by_mass_and_effort_weight_agree_with_differences():
    model, position = MODELS["lugre"], recorded(MODELS["lugre"])
    columns, tangents = (
        np.stack([np.append(EFFORT, 0.0), np.append(np.cos(20.0 * TIME), 0.0)]),
        np.array([[0.0, 0.0], [0.0, 1.0]]),
    )
    of_mass = np.hstack([slope_of(PLANT, "M"), np.zeros((1, 1))])

    def error(mass, weight):
        return errors(
            still(plants.inertia(M=mass)),
            still(model),
            position,
            weights=(1.0, weight),
            efforts=columns,
        )[0]

    _, slopes = errors(
        Sensitive(PLANT, of_mass),
        still(model, 2),
        position,
        weights=(1.0, 0.1),
        efforts=columns,
        tangents=tangents,
    )
    by_mass, by_weight = (
        (error(2.0 + 1e-6, 0.1) - error(2.0 - 1e-6, 0.1)) / 2e-6,
        (error(2.0, 0.1 + 1e-6) - error(2.0, 0.1 - 1e-6)) / 2e-6,
    )
    assert slopes[:, 0] == pytest.approx(by_mass, abs=1e-4 * np.max(np.abs(by_mass)))
    assert slopes[:, 1] == pytest.approx(by_weight, abs=1e-4 * np.max(np.abs(by_weight)))
