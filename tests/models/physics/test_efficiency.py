"""Losses of a gear: equation, identification from driving and back-driving, numbers of a geared arm, and exports."""

from __future__ import annotations

import numpy as np
import pytest

import bristle as br
from bristle.core import InputError
from bristle.core.axis import Axis
from bristle.engine import interpreted
from bristle.engine.motion import along
from bristle.identification import models_of
from bristle.logs import Log
from bristle.models.friction import MODELS, efficiency

DT = 1e-3
TRUE = {"mu_avg": 0.2, "mu_dif": 0.08, "h": 2e-3, "sigma_2": 0.5}


@pytest.mark.parametrize(
    ("side", "tau", "loss"),
    [
        (1.0, 5.0, 0.28 * 5.0),  # drives
        (-1.0, -5.0, -0.28 * 5.0),
        (-1.0, 5.0, -0.12 * 5.0),  # is driven by the load
        (1.0, -5.0, 0.12 * 5.0),
    ],
)
def test_a_gear_loses_more_in_driving_than_in_back_driving(side, tau, loss):
    model, v = efficiency(kind="rotational", **TRUE | {"sigma_2": 0.0}), np.full(400, side * 0.1)
    with interpreted():
        assert along(model, dt=DT, v=v, x=DT * np.cumsum(v), transmitted=tau)[-1] == pytest.approx(
            loss
        )


def test_the_force_follows_the_equation_at_any_step():
    model = efficiency(kind="rotational", **TRUE)
    v = 0.05 * np.sin(2.0 * np.pi * np.arange(0.0, 0.5, 1e-5))
    z, forces = 0.0, []
    for speed in v:
        z += 1e-5 * (speed - abs(speed) * z) / TRUE["h"]
        forces.append(
            TRUE["mu_avg"] * 7.0 * z + TRUE["mu_dif"] * 7.0 * z * z + TRUE["sigma_2"] * speed
        )
    coarse = v.reshape(-1, 200).mean(axis=1)
    with interpreted():
        force = along(model, dt=200e-5, v=coarse, x=200e-5 * np.cumsum(coarse), transmitted=7.0)
    assert force == pytest.approx(np.reshape(forces, (-1, 200)).mean(axis=1), abs=0.02)


def log_of(law, duration):
    t = np.arange(0.0, duration, DT)
    q = 0.9 * np.sin(0.7 * t) + 0.5 * np.sin(1.9 * t + 1.0) + 0.2 * np.sin(4.4 * t)
    v = np.gradient(q, DT)
    tau = 0.4 * np.gradient(v, DT) + 9.5 * np.sin(q) + 2.0 * np.cos(q)
    force = along(law, dt=DT, v=v, x=q + 0.5 * DT * v, transmitted=tau)
    noise = 0.02 * np.random.default_rng(1).normal(size=t.size)
    return Log.from_columns(
        {"time": t, "position": q, "effort": tau + force + noise}, kind="rotational"
    )


def identified(law, models, free=(), duration=12.0):
    axis = Axis(kind="rotational", gravity=True)
    return br.identify(
        log_of(law, duration), models, axis=axis, method="inverse_dynamics", draws=0, free=free
    )


@pytest.fixture(scope="module")
def fitted():
    return identified(
        efficiency(kind="rotational", **TRUE), ["efficiency", "coulomb_viscous+transmitted"]
    )


def test_driving_and_back_driving_identify_the_four_parameters(fitted):
    best = fitted.best
    assert best.name == "efficiency"
    for name, true in TRUE.items():
        assert best.parameters[name].status == "identified"
        assert best.parameters[name].value == pytest.approx(true, rel=0.02)
    assert best.parameters["g_sin"].value == pytest.approx(9.5, rel=0.005)


def test_a_rise_of_the_level_is_another_law(fitted):
    rising = fitted.fits[1]
    assert rising.error_percent > 20.0 * fitted.best.error_percent


@pytest.mark.slow
def test_fall_over_speed_and_friction_without_load_are_identified_if_freed():
    true = TRUE | {"mu_fall": 0.15, "v_S": 0.3, "F_idle": 0.6}
    best = identified(
        efficiency(kind="rotational", **true),
        "efficiency",
        free=("mu_fall", "v_S", "F_idle"),
        duration=12.0,
    ).best
    for name in ("mu_avg", "mu_fall", "v_S", "F_idle"):
        assert best.parameters[name].value == pytest.approx(true[name], rel=0.05), name


def test_all_models_include_the_law_only_if_the_axis_transmits_an_effort():
    assert "efficiency" not in {model.name for model in models_of("all")}
    with_load = {model.name for model in models_of("all", transmits=True)}
    assert with_load - {model.name for model in models_of("all")} == {"efficiency"}
    assert {model.name for model in models_of("efficiency")} == {"efficiency"}
    assert with_load <= set(MODELS)


@pytest.mark.parametrize("mu_dif", [0.3, -0.3])
def test_a_load_that_drives_the_motor_cannot_gain_energy(mu_dif):
    with pytest.raises(InputError, match=r"mu_avg >= \|mu_dif\|"):
        efficiency(mu_avg=0.2, mu_dif=mu_dif, h=1e-3)
