"""The log judges the simulated loop: logs of axes by another simulator, with what is told of them right and wrong."""

from dataclasses import replace

import numpy as np
import pytest
from tests.prediction.foreign_axis import TABLE, VERTICAL, moves, recorded

import bristle as br
from bristle import controllers
from bristle.core import Axis
from bristle.identification.settings import Settings
from bristle.logs.log import Channel
from bristle.prediction.following import following_of
from bristle.prediction.loop import loop_of
from bristle.report.messages import message
from bristle.simulation import simulate

AXES = {"vertical": VERTICAL, "table": TABLE}


def told(axis, **changed):
    law = {name: getattr(axis, name) for name in ("k_p", "k_v", "k_i", "k_ff")}
    return Axis(
        controller=controllers.cascade(**(law | changed)), resolution=axis.count, offset="identify", held=True
    )  # fmt: skip


@pytest.fixture(scope="module", params=AXES)
def judged(request):
    axis = AXES[request.param]
    log = recorded(axis, moves())
    return axis, log, br.identify(log, "lugre", axis=told(axis), draws=0, blocks=0)


@pytest.fixture(scope="module")
def vertical():
    log = recorded(VERTICAL, moves())
    return log, br.identify(log, "lugre", axis=told(VERTICAL), draws=0, blocks=0)


def followed(found, log, axis):
    best = found.best
    return following_of(log, simulate(loop_of(best.plant, best.friction, log, axis, cutoff=100.0)))


def test_measured_and_simulated_following_error_agree(judged):
    _, log, found = judged
    told_of = found.outcome.summary["following_error"]
    error = log.reference.values - log.position.values
    settled = error[round(0.05 * error.size) :]
    assert told_of["measured"]["peak_to_peak"] == pytest.approx(np.ptp(settled), rel=1e-9)
    assert told_of["measured"]["rms"] == pytest.approx(np.sqrt(np.mean(settled**2)), rel=1e-9)
    for name, measured in told_of["measured"].items():
        assert told_of["simulated"][name] == pytest.approx(measured, rel=0.05)
        assert told_of["compensated"][name] < 0.2 * measured
    assert not any(one["code"] == "loop-contradicts" for one in found.outcome.summary["diagnostics"])


@pytest.mark.parametrize(("wrong", "expected"), [
    ({"k_p": 1.6 * 60.0}, [("k_p", 1.0 / 1.6)]),
    ({"k_v": 2.0 * 8000.0, "k_i": 2.0 * 2e5}, [("position", 0.5), ("effort", 2.0)]),
])  # fmt: skip
def test_a_wrong_number_of_the_law_is_named(vertical, wrong, expected):
    log, found = vertical
    following = followed(found, log, told(VERTICAL, **wrong))
    numbers = following.contradiction.numbers
    assert numbers["suspects"] == tuple(name for name, _ in expected)
    assert numbers["factors"] == pytest.approx([factor for _, factor in expected], rel=0.03)
    assert numbers["measured"] == following.measured.peak_to_peak
    assert numbers["simulated"] == following.simulated.peak_to_peak
    assert following.as_data()["compensated"] is None


def test_a_delay_of_the_loop_is_named(vertical):
    _, found = vertical
    following = followed(found, recorded(VERTICAL, moves(), delay=4), told(VERTICAL))
    assert following.contradiction.numbers["suspects"] == ("delay",)
    assert following.contradiction.numbers["factors"] == (4.0,)
    assert "a delay of four samples in the loop" in message(following.contradiction)


@pytest.mark.parametrize(("samples", "name"), [(3.0, "reference_later"), (-3.0, "reference_earlier")])
def test_a_reference_that_is_recorded_at_another_time_is_named(vertical, samples, name):
    log, found = vertical
    place = np.arange(len(log))
    moved = Channel(np.interp(place + samples, place, log.reference.values), "m", "r")
    following = followed(found, replace(log, reference=moved), told(VERTICAL))
    assert following.contradiction.numbers["suspects"] == (name,)
    assert following.contradiction.numbers["factors"] == pytest.approx([3e-3], rel=0.05)


def test_what_no_number_explains_is_not_explained(vertical):
    log, found = vertical
    swung = 1e-4 * np.sin(300.0 * log.time.values)
    odd = replace(log, position=Channel(log.position.values + swung, "m", "q"))
    best, axis = found.best, told(VERTICAL)
    experiment = loop_of(best.plant, best.friction, log, axis, cutoff=100.0)
    following = following_of(odd, simulate(experiment))
    assert following.contradiction.numbers["suspects"] == ()
    assert "No one number explains it" in message(following.contradiction)


def test_the_threshold_is_a_setting(vertical):
    log, found = vertical
    best, axis = found.best, told(VERTICAL, k_p=1.1 * VERTICAL.k_p)
    simulation = simulate(loop_of(best.plant, best.friction, log, axis, cutoff=100.0))
    assert following_of(log, simulation).contradiction is None
    strict = Settings.of({"loop_differs": 0.02})
    assert following_of(log, simulation, strict).contradiction is not None


def test_a_contradicted_loop_promises_nothing(vertical):
    log, _ = vertical
    found = br.identify(log, "lugre", axis=told(VERTICAL, k_p=2.0 * VERTICAL.k_p), draws=0, blocks=0)
    summary, page = found.outcome.summary, found.outcome.page
    assert summary["following_error"]["compensated"] is None
    doubt = next(one for one in summary["diagnostics"] if one["code"] == "loop-contradicts")
    assert doubt["message"] in summary["warnings"]
    assert "No gain is promised" in page
    assert "lowers the following error" not in page
    assert "feedforward" not in page.split("Table for the drive")[0].split("Parameters</h2>")[0]


def test_without_a_controller_the_log_tells_its_own_following_error(vertical):
    log, _ = vertical
    found = br.identify(
        log, "coulomb_viscous", axis=Axis(resolution=VERTICAL.count, offset="identify"), draws=0, blocks=0
    )
    told_of = found.outcome.summary["following_error"]
    assert told_of["simulated"] is None
    assert told_of["measured"]["peak_to_peak"] > 0.0
    assert "In the log, the following error is" in found.outcome.page


@pytest.mark.parametrize("first", [0, 1500])
def test_the_simulated_loop_starts_where_the_log_does(vertical, first):
    """An empty integral would let the axis drop by its weight; a motion under way goes on."""
    _, found = vertical
    log = recorded(VERTICAL, moves(), first=first)
    best = found.best
    experiment = loop_of(best.plant, best.friction, log, told(VERTICAL), cutoff=100.0)
    recorded_loop = simulate(experiment).variants["as_recorded"]
    early = slice(0, 100)
    off = recorded_loop.measured[early] - log.position.values[early]
    assert np.max(np.abs(off)) < 4e-6
    empty = replace(experiment.variants[0], start=replace(experiment.variants[0].start, effort=None))
    dropped = simulate(replace(experiment, variants=(empty,))).variants["as_recorded"]
    assert np.max(np.abs(dropped.measured[early] - log.position.values[early])) > 1e-5


def test_the_prediction_of_the_closed_loop_holds_the_weight(vertical):
    log, found = vertical
    prediction = br.predict(found.best.plant, found.best.friction, log, told(VERTICAL), "closed-loop")
    assert np.max(np.abs(prediction.position - prediction.position_predicted)[:300]) < 1e-6
