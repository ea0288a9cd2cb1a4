"""The log judges the simulated loop: logs of axes by another simulator, with what is told of them right and wrong."""

from dataclasses import replace

import numpy as np
import pytest
from tests.prediction.foreign_axis import TABLE, VERTICAL, moves, recorded

import bristle as br
from bristle import controllers, friction, plants
from bristle.core import Axis
from bristle.core.experiment import Experiment
from bristle.logs.log import Channel
from bristle.prediction.following import following_of, loop_of
from bristle.report.messages import message
from bristle.simulation import simulate

pytestmark = pytest.mark.slow

AXES = {"vertical": VERTICAL, "table": TABLE}


def reported(axis, **changed):
    law = {name: getattr(axis, name) for name in ("k_p", "k_v", "k_i", "k_ff")}
    return Axis(
        controller=controllers.cascade(**(law | changed)),
        resolution=axis.count,
        offset="identify",
        held=True,
    )


@pytest.fixture(scope="module")
def vertical():
    log = recorded(VERTICAL, moves())
    return log, br.identify(log, "lugre", axis=reported(VERTICAL), draws=0, blocks=0)


def followed(result, log, axis, judged=None):
    best = result.best
    return following_of(
        judged or log, simulate(loop_of(best.plant, best.friction, log, axis, {"cutoff": 100.0}))
    )


@pytest.mark.parametrize("axis", AXES.values(), ids=AXES)
def test_measured_and_simulated_following_error_agree(axis):
    log = recorded(axis, moves())
    result = br.identify(log, "lugre", axis=reported(axis), draws=0, blocks=0)
    told_of = result.outcome.summary["following_error"]
    error = log.reference.values - log.position.values
    settled = error[round(0.05 * error.size) :]
    assert told_of["measured"]["peak_to_peak"] == pytest.approx(np.ptp(settled), rel=1e-9)
    assert told_of["measured"]["rms"] == pytest.approx(np.sqrt(np.mean(settled**2)), rel=1e-9)
    share = result.outcome.identification.compensation.rule.gain
    assert share >= 0.6
    for name, measured in told_of["measured"].items():
        assert told_of["simulated"][name] == pytest.approx(measured, rel=0.05)
        assert told_of["compensated"][name] < (1.0 - share) * measured
    assert not any(
        item["code"] == "loop_contradicts" for item in result.outcome.summary["diagnostics"]
    )


def moved(log, samples):
    """The log with a reference of another time."""
    place = np.arange(len(log))
    return replace(
        log, reference=Channel(np.interp(place + samples, place, log.reference.values), "m", "r")
    )


def trembling(log):
    """The log with an error that no number explains."""
    return replace(
        log,
        position=Channel(log.position.values + 1e-4 * np.sin(300.0 * log.time.values), "m", "q"),
    )


@pytest.mark.parametrize(
    ("wrong", "log_of", "expected", "words"),
    [
        ({"k_p": 1.6 * 60.0}, None, {"k_p": 1.0 / 1.6}, ""),
        ({"k_v": 2.0 * 8000.0, "k_i": 2.0 * 2e5}, None, {"position": 0.5, "effort": 2.0}, ""),
        ({"k_ff": 0.0}, None, {"k_ff": 1.0}, "k_ff = 1"),  # the drive has 1
        (
            {},
            lambda log: recorded(VERTICAL, moves(), delay=4),
            {"delay": 4.0},
            "a delay of four samples in the loop",
        ),
        ({}, lambda log: moved(log, 3.0), {"reference_later": 3e-3}, ""),
        ({}, lambda log: moved(log, -3.0), {"reference_earlier": 3e-3}, ""),
        ({}, trembling, {}, "No single wrong gain"),
    ],
)
def test_a_wrong_number_of_the_loop_is_named(vertical, wrong, log_of, expected, words):
    log, result = vertical
    other = log_of(log) if log_of else log
    following = followed(
        result, log if log_of is trembling else other, reported(VERTICAL, **wrong), other
    )
    numbers = following.contradiction.numbers
    assert numbers["suspects"][: len(expected) or None] == tuple(expected)
    assert numbers["factors"][: len(expected)] == pytest.approx(list(expected.values()), rel=0.05)
    assert (numbers["measured"], numbers["simulated"]) == (
        following.measured.peak_to_peak,
        following.simulated.peak_to_peak,
    )
    assert words in message(following.contradiction)


def test_a_contradicted_loop_has_no_promised_gain(vertical):
    log, _ = vertical
    identification = br.identify(
        log, "lugre", axis=reported(VERTICAL, k_p=2.0 * VERTICAL.k_p), draws=0, blocks=0
    )
    summary, page = identification.outcome.summary, identification.outcome.page
    assert summary["following_error"]["compensated"] is None
    doubt = next(item for item in summary["diagnostics"] if item["code"] == "loop_contradicts")
    assert doubt["message"] in summary["warnings"]
    assert "bristle predicts no gain" in page
    assert "Following error as recorded, measured and simulated" in page


def mechanism(axis):
    """Return what the axis is made of, as the package tells it."""
    bristles = friction.find("lugre")(
        F_C=axis.coulomb,
        F_S=axis.static,
        v_S=axis.stribeck,
        sigma_0=axis.stiffness,
        sigma_1=axis.damping,
        sigma_2=axis.viscous,
        offset=axis.weight,
    )
    return plants.inertia(M=axis.mass), bristles


@pytest.mark.parametrize(("name", "first"), [("vertical", 0), ("vertical", 1500), ("table", 1500)])
def test_the_simulated_loop_starts_like_the_log(name, first):
    """A motion under way goes on, and an axis at rest does not drop by its weight."""
    axis = AXES[name]
    log = recorded(axis, moves(2.5), first=first)
    start = loop_of(*mechanism(axis), log, reported(axis), {"cutoff": 100.0}).variants[0]

    def off(variant):
        outcome = simulate(Experiment("start", "translational", (variant,))).variants["as_recorded"]
        return np.max(np.abs(outcome.measured - log.position.values)[:100])

    assert off(start) < 4e-6
    if axis.k_i:
        assert off(replace(start, start=replace(start.start, effort=None))) > 1e-5
    if first:
        assert off(replace(start, start=None)) > 1e-5
