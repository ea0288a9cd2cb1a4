"""A model on a log: errors, doubts, and what is left unexplained, numbers by hand."""

from dataclasses import replace

import numpy as np
import pytest

from bristle import controllers, friction
from bristle.core import Axis, InputError
from bristle.core.status import Status
from bristle.identification.result import Bands
from bristle.logs.log import Channel, Log
from bristle.models.plants import inertia
from bristle.prediction import predict
from bristle.prediction.predict import (
    MODES,
    OF_TREATMENT,
    _prediction,
    effort_of_motion,
    rows_as_fitted,
    unexplained_force,
    with_doubts,
)
from bristle.simulation.recorded.closed_loop import START_SAMPLES

pytestmark = pytest.mark.usefixtures("in_plain_python")

DT = 2e-3
PLANT, MODEL = inertia(M=2.0), friction.coulomb_viscous(F_C=3.0, F_v=20.0)
TIME = DT * np.arange(3000)
VELOCITY, ACCELERATION = 0.05 * np.cos(4.0 * TIME), -0.2 * np.sin(4.0 * TIME)
EFFORT = 2.0 * ACCELERATION + 20.0 * VELOCITY + 3.0 * np.sign(VELOCITY)


def log_of(effort=EFFORT, **changes):
    position = 0.0125 * np.sin(4.0 * TIME)
    channels = {
        "time": Channel(TIME, "s", "t"),
        "position": Channel(position, "m", "q"),
        "effort": Channel(effort, "N", "u"),
    }
    return Log(
        **(
            channels
            | {
                "reference": Channel(0.999 * position, "m", "r"),
                "sample_time": DT,
                "segments": (slice(0, 3000),),
            }
            | changes
        )
    )


def test_modes_are_the_inverse_and_both_loops():
    assert MODES == ("inverse", "closed-loop", "open-loop")


def test_an_error_is_relative_and_in_the_unit_of_the_signal():
    force, off = np.array([3.0, 4.0]), np.array([3.0, 3.0])
    result = _prediction("inverse", log_of(), np.zeros(2), force, off, np.zeros(2), None)
    assert result.metrics == {
        "force_error_percent": pytest.approx(20.0),
        "force_rmse": pytest.approx(np.sqrt(0.5)),
        "force_unit": "N",
        "position_error_percent": None,
        "position_rmse": None,
        "position_unit": "m",
    }
    turning = _prediction(
        "inverse", log_of(kind="rotational"), np.zeros(2), force, None, force, off
    )
    assert (turning.metrics["force_unit"], turning.metrics["position_unit"]) == ("N*m", "rad")
    assert (turning.metrics["force_rmse"], turning.metrics["position_rmse"]) == (
        None,
        pytest.approx(np.sqrt(0.5)),
    )


def test_a_simulation_that_diverged_has_no_error():
    lost = _prediction(
        "open-loop",
        log_of(),
        np.zeros(2),
        np.ones(2),
        np.ones(2),
        np.ones(2),
        np.ones(2),
        Status.NOT_FINITE,
    )
    assert lost.metrics["force_error_percent"] is lost.metrics["position_rmse"] is None
    late = _prediction(
        "open-loop",
        log_of(),
        np.zeros(2),
        np.ones(2),
        np.ones(2),
        np.ones(2),
        np.ones(2),
        Status.SOLVE_INACCURATE,
    )
    assert late.metrics["position_rmse"] == 0.0


def doubts(percent, velocity_max=None, **changes):
    log = log_of(**changes)
    prediction = _prediction(
        "inverse", log, np.zeros(2), np.ones(2), np.zeros(2), np.ones(2), np.zeros(2)
    )
    metrics = dict(prediction.metrics) | {
        "force_error_percent": percent[0],
        "position_error_percent": percent[1],
    }
    return [
        (item.code, dict(item.numbers))
        for item in with_doubts(
            replace(prediction, metrics=metrics), log, None, velocity_max
        ).diagnostics
    ]


def worse(signal, percent):
    return [("worse_than_none", {"signal": signal, "percent": percent})]


# The largest mean speed over twenty samples is a little below 0.05 m/s; half more than the fitted speed is beyond it.
FASTEST = 0.05 * np.sin(4.0 * DT * 10.0) / (4.0 * DT * 10.0)


@pytest.mark.parametrize(
    ("percent", "velocity_max", "expected"),
    [
        ((99.0, 100.0), None, []),
        ((101.0, 50.0), None, worse("effort", 101.0)),
        ((101.0, 102.0), None, worse("position", 102.0)),
        ((None, 102.0), None, worse("position", 102.0)),
        ((1.0, 1.0), 0.034, []),
        (
            (1.0, 1.0),
            0.033,
            [("beyond_speed", {"speed": pytest.approx(FASTEST, rel=1e-4), "fitted_speed": 0.033})],
        ),
    ],
)
def test_a_prediction_worse_than_zero_or_beyond_the_fitted_speed_is_reported(
    percent, velocity_max, expected
):
    assert doubts(percent, velocity_max) == expected


MOVING = np.abs(VELOCITY) > 0.02
PULSED = log_of(EFFORT + np.where((TIME > 2.0) & (TIME < 3.0), 1.0, 0.0))
PARTED = log_of(
    EFFORT + np.where(TIME > 3.0, 1.0, 0.0), segments=(slice(0, 1200), slice(1600, 3000))
)
# 3 s of rest under an effort, with an axis that keeps its rests.
RESTED = replace(
    log_of(np.full(3000, 1.7)),
    position=Channel(0.0125 * (1.0 - np.cos(4.0 * np.maximum(TIME - 3.0, 0.0))), "m", "q"),
)


@pytest.mark.parametrize(
    ("log", "axis", "rows", "force", "tolerance"),
    [
        (PULSED, Axis(cutoff=60.0), MOVING & (TIME > 2.1) & (TIME < 2.9), 1.0, 0.05),
        (PULSED, Axis(cutoff=60.0), MOVING & (TIME > 4.0) & (TIME < 5.5), 0.0, 0.05),
        (PULSED, Axis(cutoff=60.0), [0, -1], 0.0, 0.0),
        (PARTED, Axis(cutoff=60.0), slice(1200, 1600), 0.0, 0.0),
        (PARTED, Axis(cutoff=60.0), MOVING & (TIME > 3.5) & (TIME < 5.9), 1.0, 0.05),
        (PARTED, Axis(cutoff=60.0), MOVING & (TIME > 0.1) & (TIME < 2.3), 0.0, 0.05),
        (RESTED, Axis(resolution=1e-6, held=True), slice(100, 1300), 0.0, 0.0),
    ],
)
def test_an_unexplained_force_has_the_rate_of_the_log_and_is_in_its_stretch(
    log, axis, rows, force, tolerance
):
    left = unexplained_force(PLANT, MODEL, log, axis)
    assert left.shape == TIME.shape
    assert left[rows] == pytest.approx(force, abs=tolerance)
    assert np.max(np.abs(left)) > 0.5


def test_the_effort_of_a_motion_is_that_of_inertia_and_friction():
    effort = effort_of_motion(
        PLANT, MODEL, {"time": TIME, "position": log_of().position.values}, None, {"cutoff": 60.0}
    )
    inside = (np.abs(VELOCITY) > 0.02) & (TIME > 0.2) & (TIME < 5.8)
    assert effort.shape == TIME.shape
    assert effort[inside] == pytest.approx(EFFORT[inside], abs=0.1)


def test_the_effort_of_a_motion_lags_by_the_delay_of_the_treatment_and_of_the_axis():
    columns = {"time": TIME, "position": log_of().position.values}
    inside = (np.abs(VELOCITY) > 0.02) & (TIME > 0.2) & (TIME < 5.5)
    prompt = effort_of_motion(PLANT, MODEL, columns, Axis(), {"cutoff": 60.0})
    late = effort_of_motion(
        PLANT, MODEL, columns, Axis(delay=10.0 * DT), {"cutoff": 60.0, "delay": 5.0 * DT}
    )
    assert late[15:][inside[:-15]] == pytest.approx(prompt[:-15][inside[:-15]], abs=1e-3)


def test_rows_are_treated_as_in_the_identification():
    log = log_of()
    plain, late = (
        rows_as_fitted(log, None, {"cutoff": 60.0, "delay": delay}, 1)
        for delay in (None, 10.0 * DT)
    )
    assert plain.cutoff == 60.0
    assert plain.decimation == 1
    assert rows_as_fitted(log, None, {"cutoff": 60.0}, 3).decimation == 3
    size = min(plain.effort.size, late.effort.size)
    assert not np.allclose(plain.effort[:size], late.effort[:size], atol=1e-3)


def test_a_model_of_another_kind_of_axis_is_refused():
    with pytest.raises(
        InputError,
        match=r"model: is of another kind of axis than the log; found '?rotational.*allowed '?translational",
    ):
        predict(
            inertia(M=2.0, kind="rotational"),
            friction.coulomb(F_C=1.0, kind="rotational"),
            log_of(),
        )
    with pytest.raises(InputError, match="log: has no effort to compare with or to apply"):
        predict(PLANT, MODEL, replace(log_of(), effort=None))


def test_a_cut_off_beyond_nyquist_is_lowered_to_two_fifths_of_the_sampling():
    fast = predict(PLANT, MODEL, log_of(), Axis(cutoff=250.0, decimation=1))
    first, *_, last = fast.diagnostics
    assert (first.code, dict(first.numbers)) == (
        "filtered",
        {"wanted": 250.0, "cutoff": pytest.approx(200.0)},
    )
    assert dict(last.numbers)["cutoff"] == pytest.approx(200.0)
    carried = predict(PLANT, MODEL, log_of(), Axis(cutoff=240.0, decimation=1))
    assert [item.code for item in carried.diagnostics if "wanted" in dict(item.numbers)] == []


def test_a_loop_prediction_has_the_samples_of_every_long_stretch():
    log = log_of(segments=(slice(0, 300), slice(300, 338), slice(400, 600)))
    axis = Axis(controller=controllers.cascade(k_p=30.0, k_v=200.0))
    opened = predict(PLANT, MODEL, log, axis, "open-loop")
    # Of each stretch the first twenty samples go, and of the second one no more than twenty are left.
    assert opened.time == pytest.approx(np.concatenate([TIME[20:300], TIME[420:600]]))
    assert opened.effort_predicted is None
    assert [item.code for item in opened.diagnostics].count("short_stretch") == 1
    assert START_SAMPLES == 20
    closed = predict(PLANT, MODEL, log, axis, "closed-loop")
    assert closed.time == pytest.approx(np.concatenate([TIME[:300], TIME[300:338], TIME[400:600]]))
    assert closed.effort_predicted.shape == closed.time.shape
    with pytest.raises(
        InputError, match=r"log: no stretch of the log is long enough.*allowed > 40 samples"
    ):
        predict(PLANT, MODEL, log_of(segments=(slice(0, 30),)), axis, "open-loop")


def test_a_static_map_is_simulated_with_the_presliding_distance_of_the_axis():
    result = predict(
        PLANT, MODEL, log_of(segments=(slice(0, 200),)), Axis(presliding=1e-5), "open-loop"
    )
    reported = [
        dict(item.numbers) for item in result.diagnostics if item.code == "presliding_distance"
    ]
    assert reported == [{"distance": 1e-5}]
    plain = predict(PLANT, MODEL, log_of(segments=(slice(0, 200),)), Axis(), "open-loop")
    assert not np.array_equal(plain.position_predicted, result.position_predicted)


def test_a_given_lag_overrides_that_of_the_axis():
    axis = Axis(controller=controllers.cascade(k_p=30.0, k_v=200.0), lag=0.02)
    log = log_of(segments=(slice(0, 200),))
    of_axis, same, prompt = (
        predict(PLANT, MODEL, log, axis, "closed-loop", lag=lag).position_predicted
        for lag in (None, 0.02, 0.0)
    )
    assert of_axis.tolist() == same.tolist()
    assert not np.array_equal(of_axis, prompt)


@pytest.mark.parametrize("name", ["smoothing", "slow", "position_smoothing"])
def test_filters_of_a_treatment_are_any_positive_amounts(name):
    unit, supplied = ("Hz", 2.0) if name == "slow" else ("ms", 2e-3)
    assert OF_TREATMENT[name](f"2 {unit}", name, "translational") == pytest.approx(supplied)
    if name != "smoothing":
        with pytest.raises(InputError, match=name):
            OF_TREATMENT[name](-1.0, name, "translational")


def test_bands_are_around_the_prediction_stretch_by_stretch(monkeypatch):
    bands, stretches = object.__new__(Bands), []

    def widths(bands, plant, friction, run, stretch):
        stretches.append(stretch.samples)
        return np.full(run.position.size, 1.0 * len(stretches)), np.full(
            run.position.size, -1.0 * len(stretches)
        )

    monkeypatch.setitem(with_doubts.__globals__, "simulated_widths", widths)
    monkeypatch.setitem(
        with_doubts.__globals__,
        "half_width",
        lambda bands, plant, friction, dataset: np.full(dataset.time.size, 7.0),
    )
    log = log_of(segments=(slice(0, 100), slice(300, 400)))
    axis = Axis(controller=controllers.cascade(k_p=30.0, k_v=200.0), decimation=1)
    opened, closed = (
        predict(PLANT, MODEL, log, axis, mode, bands=bands) for mode in ("open-loop", "closed-loop")
    )
    assert stretches == [slice(20, 100), slice(320, 400), slice(0, 100), slice(300, 400)]
    assert opened.position_half_width.tolist() == [1.0] * 80 + [2.0] * 80
    assert opened.half_width is None
    assert closed.position_half_width.tolist() == [3.0] * 100 + [4.0] * 100
    assert closed.half_width.tolist() == [-3.0] * 100 + [-4.0] * 100
    inverse = predict(PLANT, MODEL, log_of(), axis, bands=bands)
    assert set(inverse.half_width) == {7.0}
    plain = predict(PLANT, MODEL, log, axis, "closed-loop")
    assert plain.half_width is plain.position_half_width is None
