"""What a log says against itself stands beside every fit, with the parameters that it concerns."""

import numpy as np
import pytest
from tests.logs.test_check import MASS, Run

from bristle.identification import identify
from bristle.report.messages import message, warnings_of


def told(log, code, model="coulomb_viscous", **asked):
    """Return what a fit says of one code; none where it says nothing."""
    return [one for one in identify(log, model, draws=0, blocks=0, **asked).best.diagnostics if one.code == code]


def test_every_parameter_that_trades_places_at_one_speed_is_named():
    (found,) = told(Run(0, (0.3,)).log(), "one_speed")
    assert set(found.numbers["names"]) == {"F_C", "F_v", "offset"}
    assert "F_v, F_C, offset cannot be told apart" in message(found)


def test_every_parameter_that_trades_places_in_one_direction_is_named_held_or_not():
    (found,) = told(Run(0, back=False).log(), "one_direction")
    assert set(found.numbers["names"]) == {"F_C", "offset"}


def test_a_parameter_that_was_told_trades_places_with_none():
    (found,) = told(Run(0, back=False).log(), "one_direction", offset=2.0)
    assert set(found.numbers["names"]) == {"F_C"}


def test_a_right_log_is_fitted_without_a_word():
    fit = identify(Run(0).log(), mass=MASS, draws=0, blocks=0).best
    assert [one.code for one in fit.diagnostics if "_" in one.code and one.code != "repeats_one_motion"] == []


def test_the_mass_that_is_asked_for_is_compared():
    (found,) = told(Run(0).log(), "mass_contradicts", mass=2.0 * MASS)
    assert found.numbers["ratio"] == pytest.approx(2.0, rel=0.03)
    assert "is 2 times the 12 kg that the log shows" in message(found)


def test_each_model_says_it_and_a_threshold_may_be_set():
    log = Run(0).log(effort=-Run(0).effort())
    every = identify(log, "coulomb,coulomb_viscous", draws=0, blocks=0).fits
    assert all("sign of effort seems reversed" in " ".join(warnings_of(fit)) for fit in every)
    assert told(log, "sign_reversed", settings={"reversed_work": 1.0}) == []


def test_what_a_fit_says_with_more_is_said_once():
    x = np.cumsum(np.sin(2.0 * np.pi * 1e-3 * np.arange(16_000))) * 1e-3
    v = np.gradient(x, 1e-3)
    log = Run(0).log(position=x, effort=12.0 * np.gradient(v, 1e-3) + 9.0 * np.sign(v) + 14.0 * v)
    codes = [one.code for one in identify(log, draws=0).best.diagnostics]
    assert "motion_repeats" in codes
    assert "repeats_one_motion" not in codes
