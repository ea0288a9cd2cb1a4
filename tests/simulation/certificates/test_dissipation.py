"""Dissipation over closed cycles, for friction, for magnets, and for what produces energy."""

from typing import Annotated, NamedTuple

import numpy as np
import pytest
from tests.simulation.certificates.ballscrew import composite, gms, lugre, maxwell_slip

from bristle import friction, hysteresis
from bristle.core import FrictionModel, Variable, kernel
from bristle.core.mathematics import direction
from bristle.simulation.certificates import certify, check


@pytest.mark.parametrize(
    "model", [lugre(), composite(), maxwell_slip(), pytest.param(gms(), marks=pytest.mark.slow)]
)
def test_friction_takes_energy_out_of_every_cycle(model):
    result = certify.dissipation(model, certify.holding_of(model), certify.fattest_loop(model))
    assert result.passed
    assert result.value >= -1e-9


@pytest.mark.parametrize("reach", [1.2, 2.0, 5.0])
def test_the_kept_share_of_a_settled_loop_is_its_area_over_its_work(monkeypatch, reach):
    # An element that slips at 1 N after 1 um, led by `reach` to and fro: 4 (reach - 1) stay, 1 comes back twice in a
    # round and is put in again. The first way out from rest is another one.
    monkeypatch.setattr(certify, "REACHES", 1e-6 * np.array([reach]))
    loop = certify.fattest_loop(friction.maxwell_slip(F_C=1.0, k_i=[1e6], nu_i=[1.0]))
    assert loop.share == pytest.approx(4.0 * (reach - 1.0) / (4.0 * (reach - 1.0) + 2.0), rel=1e-3)
    assert loop.reach == 1e-6 * reach
    assert not loop.is_magnetic


class Parameters(NamedTuple):
    F_C: Annotated[float, Variable("force", "force that pushes along", min=0.0)]


class State(NamedTuple):
    """None."""


class Move(NamedTuple):
    """None."""


@kernel
def push(state, memory, motion, dt, p):
    return 0.1 * p.F_C * direction(motion.v) - p.F_C * motion.v, Move()


@kernel
def stay(state, memory, move, p):
    return state


def test_a_model_that_creates_energy_at_speed_is_found():
    pushes = FrictionModel(
        name="pushes",
        description="pushes",
        Parameters=Parameters,
        State=State,
        trial=push,
        commit=stay,
    )
    result = check(pushes(F_C=1.0))
    assert not result["dissipation"].passed
    assert result["dissipation"].value < -0.1
    assert not result["passive"].applies


def test_a_magnet_has_no_passivity_and_still_dissipates():
    # Its output lags behind the input, where that of friction runs ahead.
    result = check(
        hysteresis.tabulated(
            lambda a, b: 0.25 * (a - b) ** 2 + 0.1 * (a - b), 1.0, rows=11, columns=11
        )
    )
    assert [name for name, item in result.items() if item.applies] == ["closure", "dissipation"]
    assert result["dissipation"].passed
    assert result["closure"].passed
