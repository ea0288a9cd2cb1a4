"""The four-parameter law of a gear: equation, identification from driving and back-driving, and export of the same kernel."""

from __future__ import annotations

import numpy as np
import pytest
from tests.docs.conftest import ROOT

import bristle as br
from bristle.core.axis import Axis
from bristle.engine.motion import along
from bristle.logs import Log

DT = 1e-3
TRUE = {"mu_avg": 0.2, "mu_dif": 0.08, "h": 2e-3, "sigma_2": 0.5}


@pytest.fixture(scope="module")
def law():
    return br.load_code(ROOT / "examples" / "efficiency.py")


def test_a_gear_loses_more_in_driving_than_in_back_driving(law):
    model = law(kind="rotational", **TRUE | {"sigma_2": 0.0})
    turns = {side: np.full(400, side * 0.1) for side in (1.0, -1.0)}
    loss = {
        (side, tau): float(along(model, dt=DT, v=v, x=DT * np.cumsum(v), transmitted=tau)[-1])
        for side, v in turns.items()
        for tau in (5.0, -5.0)
    }
    assert loss[1.0, 5.0] == pytest.approx(0.28 * 5.0)  # drives
    assert loss[-1.0, -5.0] == pytest.approx(-0.28 * 5.0)
    assert loss[-1.0, 5.0] == pytest.approx(-0.12 * 5.0)  # is driven by the load
    assert loss[1.0, -5.0] == pytest.approx(0.12 * 5.0)


def test_the_force_follows_the_equation_at_any_step(law):
    model = law(kind="rotational", **TRUE)
    v = 0.05 * np.sin(2.0 * np.pi * np.arange(0.0, 1.0, 1e-5))
    z, forces = 0.0, []
    for speed in v:
        z += 1e-5 * (speed - abs(speed) * z) / TRUE["h"]
        forces.append(TRUE["mu_avg"] * 7.0 * z + TRUE["mu_dif"] * 7.0 * z * z + TRUE["sigma_2"] * speed)
    coarse = v.reshape(-1, 200).mean(axis=1)
    force = along(model, dt=200e-5, v=coarse, x=200e-5 * np.cumsum(coarse), transmitted=7.0)
    assert force == pytest.approx(np.reshape(forces, (-1, 200)).mean(axis=1), abs=0.02)


@pytest.fixture(scope="module")
def fitted(law):
    t = np.arange(0.0, 40.0, DT)
    q = 0.9 * np.sin(0.7 * t) + 0.5 * np.sin(1.9 * t + 1.0) + 0.2 * np.sin(4.4 * t)
    v = np.gradient(q, DT)
    tau = 0.4 * np.gradient(v, DT) + 9.5 * np.sin(q) + 2.0 * np.cos(q)
    force = along(law(kind="rotational", **TRUE), dt=DT, v=v, x=q + 0.5 * DT * v, transmitted=tau)
    noise = 0.02 * np.random.default_rng(1).normal(size=t.size)
    log = Log.from_columns({"time": t, "position": q, "effort": tau + force + noise}, kind="rotational")
    axis = Axis(kind="rotational", gravity=True)
    return br.identify(log, [law, "coulomb_viscous+transmitted"], axis=axis, method="inverse_dynamics", draws=0)


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


@pytest.mark.parametrize("target", ["c", "st", "cuda", "wasm"])
def test_the_same_kernel_is_exported(law, target, tmp_path):
    written = br.export(law(kind="rotational", **TRUE), target, tmp_path / target, name="gear")
    assert written.files
