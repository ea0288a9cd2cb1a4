"""From a file to a log: what is accepted, and what is refused by name."""

from __future__ import annotations

import dataclasses
import os
import re
from pathlib import Path
from unicodedata import normalize

import numpy as np
import pytest

from bristle.controllers import cascade
from bristle.core.axis import Column, Injected
from bristle.core.errors import InputError
from bristle.identification.preprocessing import smallest_step
from bristle.logs import checked, read_log
from bristle.logs.clock import clock_of
from bristle.report.messages import message

SAMPLE_TIME = 1e-3


def with_columns(axis, **columns):
    return dataclasses.replace(axis, columns={**axis.columns, **columns})


def test_a_log_is_the_same_from_every_kind_of_file(any_file, recording, axis):
    log = read_log(any_file, axis)
    assert len(log) == recording["t"].size
    assert log.segments == (slice(0, len(log)),)
    assert log.sample_time == pytest.approx(SAMPLE_TIME, rel=1e-9)
    assert (log.position.column, log.position.unit, log.effort.unit) == ("q", "m", "N")
    np.testing.assert_allclose(log.effort.values, recording["u"], rtol=1e-10, atol=1e-12)
    assert log.velocity is None
    assert log.notes == ()


def test_the_arrays_of_a_log_cannot_be_written(write, axis):
    log = read_log(write(), axis)
    for _, channel in log.channels():
        with pytest.raises(ValueError, match="read-only"):
            channel.values[0] = 1.0


def test_scale_unit_and_sign_of_a_column(write, axis, recording):
    axis = with_columns(axis, effort=Column("u", "mV", "V", -35.0), position=Column("q", "mm", "m"))
    log = read_log(write(), axis)
    np.testing.assert_allclose(log.effort.values, recording["u"] * 1e-3 * -35.0, rtol=1e-12)
    np.testing.assert_allclose(log.position.values, recording["q"] * 1e-3, rtol=1e-12)


def test_a_following_error_makes_the_reference(write, axis, recording):
    channels = {name: column for name, column in axis.columns.items() if name != "reference"}
    error = Column("r", "mm", "m", -1.0)
    log = read_log(write(), dataclasses.replace(axis, columns=channels | {"following_error": error}))
    np.testing.assert_allclose(log.reference.values, recording["q"] - 1e-3 * recording["r"], rtol=1e-12)
    assert any("the reference as position plus following error, which column r contains" in note for note in log.notes)
    both = read_log(write(), dataclasses.replace(axis, columns=dict(axis.columns) | {"following_error": error}))
    np.testing.assert_allclose(both.reference.values, recording["r"], rtol=1e-12)
    assert any("bristle ignores the following error in column r" in note for note in both.notes)


def test_units_of_the_log_apply_without_units_in_the_axis_file(tmp_path, write, axis, recording):
    path = write()
    path.write_text(path.read_text().replace("t,q,r,u", "t [s],q [mm],r [mm],u"))
    axis = with_columns(axis, position=Column("q", "", "m"), reference=Column("r [mm]", "mm", "m"))
    log = read_log(path, axis)
    np.testing.assert_allclose(log.position.values, recording["q"] * 1e-3, rtol=1e-12)


@pytest.mark.parametrize(
    ("head", "position", "words"),
    [
        ("t,q [mm],r,u", "q", "has another unit in the log than in the axis file; found 'mm'"),
        ("t,q [N],r,u", "q", "column 'q': has the wrong unit"),
        ("t,q,r,u", "Q", r"no column 'Q' .* allowed columns: t, q, r, u\. Did you mean 'q'\?"),
    ],
)
def test_columns_of_another_name_or_unit_are_refused(write, axis, head, position, words):
    path = write()
    path.write_text(path.read_text().replace("t,q,r,u", head))
    with pytest.raises(InputError, match=words):
        read_log(path, with_columns(axis, position=Column(position, "m", "m")))


def test_known_inputs(write, axis, recording):
    pulses = np.where(np.arange(recording["t"].size) % 200 < 100, 5.0, 0.0)
    known = (Injected("pulses", 2.0, optional=True), Injected("absent", 1.0, optional=True))
    axis = dataclasses.replace(axis, injected=known)
    log = read_log(write(pulses=pulses), axis)
    np.testing.assert_array_equal(log.injected_effort, 2.0 * pulses)
    assert log.notes == ("optional column absent is not in this log",)
    (note,) = read_log(write(Pulses_1=pulses), axis).notes[:1]
    assert note == "optional column pulses is not in this log. If its name is 'Pulses_1', write this name in the axis file"
    assert read_log(write(), axis).injected == ()
    required = dataclasses.replace(axis, injected=(Injected("pulses", 2.0),))
    with pytest.raises(InputError, match="no column 'pulses'"):
        read_log(write(), required)


def test_a_known_input_that_was_never_on_is_no_constant_channel(write, axis, recording):
    axis = dataclasses.replace(axis, injected=(Injected("pulses", 2.0),))
    assert np.all(read_log(write(pulses=np.zeros(recording["t"].size)), axis).injected_effort == 0)


@pytest.mark.parametrize("column", ["t", "q", "u"])
@pytest.mark.parametrize(("value", "said"), [(np.nan, "has NaN"), (np.inf, "has an infinite value")])
def test_values_that_are_not_finite_are_named(write, axis, recording, column, value, said):
    values = recording[column].copy()
    values[[123, 500]] = value
    at = "sample 123" if column == "t" else r"sample 123 \(t = 0\.123 s\)"
    with pytest.raises(InputError, match=rf"column '{column}': {said}.* in 2 samples.* {at}"):
        read_log(write(**{column: values}), axis)


@pytest.mark.parametrize("column", ["q", "u", "r"])
def test_a_constant_channel_is_refused(write, axis, recording, column):
    with pytest.raises(InputError, match=f"column '{column}': is constant"):
        read_log(write(**{column: np.full(recording["t"].size, 0.7)}), axis)


def test_a_short_log_is_refused(write, axis, recording):
    path = write()
    path.write_text("\n".join(path.read_text().split("\n")[:100]) + "\n")
    with pytest.raises(InputError, match=r"is too short .* found 99, allowed at least 100"):
        read_log(path, axis)


@pytest.mark.parametrize("share", [0.9, 0.7, 0.5])
@pytest.mark.parametrize("limit", [None, 1000.0])
def test_a_clipped_effort_is_reported(write, axis, recording, share, limit):
    axis = dataclasses.replace(axis, effort_limit=limit)
    top = share * np.max(recording["u"])
    assert clipped_at(read_log(write(u=np.minimum(recording["u"], top)), axis), axis) == pytest.approx(top)


def test_an_effort_at_its_known_limit_is_reported(write, axis, recording):
    limited = dataclasses.replace(axis, effort_limit=40.0)
    log = read_log(write(u=np.clip(recording["u"], -40.0, 40.0)), limited)
    assert abs(clipped_at(log, limited)) == pytest.approx(40.0)


def clipped_at(log, axis):
    """Return where a log is told to be clipped; None where it is not."""
    return next((result.numbers["level"] for result in checked(log, axis) if result.code == "clipped"), None)


def exceeded(log):
    return [(finding.code, finding.numbers.get("key")) for finding in log.findings if finding.code.startswith("beyond")]


def test_an_effort_beyond_its_limit_is_read_with_a_finding(write, axis):
    limited = dataclasses.replace(axis, effort_limit=10.0)
    log = read_log(write(), limited)
    assert exceeded(log) == [("beyond_limit", "[effort] limit")]
    (result,) = [result for result in checked(log, limited) if result.code == "beyond_limit"]
    assert message(result).startswith("the effort reaches 75")
    assert "[effort] limit of the axis file is 10 N" in message(result)
    assert exceeded(read_log(write(), dataclasses.replace(axis, effort_limit=100.0))) == []
    largest = float(np.max(np.abs(log.effort.values)))  # five per cent above the limit are no finding
    assert [exceeded(read_log(write(), dataclasses.replace(axis, effort_limit=largest / over))) == [] for over in (1.04, 1.06)] == [
        True,
        False,
    ]


def test_known_inputs_are_added_behind_the_limit_of_the_controller_and_before_that_of_the_drive(write, axis, recording):
    pulses = np.where(np.arange(recording["t"].size) % 200 < 100, 5.0, 0.0)
    both = write(u=recording["u"] + 20.0 * pulses, pulses=pulses)  # up to 75 N of its own and 100 N of pulses
    axis = dataclasses.replace(axis, injected=(Injected("pulses", 20.0),))
    within, without = (cascade(k_p=1.0, k_v=1.0, limit=limit) for limit in (90.0, 40.0))
    assert exceeded(read_log(both, dataclasses.replace(axis, controller=within))) == []
    of_drive = dataclasses.replace(axis, controller=within, effort_limit=90.0)
    assert exceeded(read_log(both, of_drive)) == [("beyond_limit", "[effort] limit")]
    of_law = dataclasses.replace(axis, controller=without, effort_limit=300.0)
    assert exceeded(read_log(both, of_law)) == [("beyond_limit", "[controller] limit")]
    clipped = write(u=np.clip(recording["u"], -40.0, 40.0) + 20.0 * pulses, pulses=pulses)
    text = dataclasses.replace(axis, controller=without)
    assert abs(clipped_at(read_log(clipped, text), text)) == pytest.approx(40.0)


def trapezoids(t):
    """Speeds of trapezoids against Coulomb friction, and the effort without noise."""
    speed = 0.1 * np.clip(np.minimum(t % 0.5, 0.5 - t % 0.5) / 0.1, 0.0, 1.0) * np.where(t % 1.0 < 0.5, 1.0, -1.0)
    return {"q": np.cumsum(speed) * SAMPLE_TIME, "u": 2.0 * np.gradient(speed, t) + 3.0 * np.sign(speed)}


@pytest.mark.parametrize(
    "changed",
    [
        lambda recording: {"u": np.round(recording["u"])},
        lambda recording: trapezoids(recording["t"]),
        lambda recording: {"u": np.where(recording["t"] < 0.2, 0.0, recording["u"] - recording["u"].min() + 1.0)},
    ],
    ids=["coarse", "constant stretches", "drive off"],
)
def test_an_effort_of_equal_values_is_not_taken_for_a_clipped_one(write, axis, recording, changed):
    assert clipped_at(read_log(write(**changed(recording)), axis), axis) is None


def test_a_position_beyond_the_stroke_is_read_with_a_finding(write, axis):
    assert exceeded(read_log(write(), dataclasses.replace(axis, stroke=(0.0, 0.05)))) == [("beyond_limit", None)]
    assert exceeded(read_log(write(), dataclasses.replace(axis, stroke=(-0.1, 0.45)))) == []


@pytest.mark.parametrize(("times", "told"), [(57.29578, True), (1 / 57.29578, True), (4.0, False), (1.0, False)])
def test_steps_that_contradict_the_stated_resolution_are_reported(write, axis, recording, times, told):
    step = 1e-4
    described = dataclasses.replace(axis, resolution=step / times)
    log = read_log(write(q=step * np.round(recording["q"] / step)), described)
    result = [item for item in checked(log, described) if item.code == "resolution_contradicts"]
    assert bool(result) == told
    if told:
        assert "One radian has 57.3 degrees" in message(result[0])


@pytest.mark.parametrize(("share", "told"), [(1 / 57.3, True), (57.3, False)])
def test_steps_of_a_fast_axis_contradict_a_finer_resolution_and_digits_of_a_text_no_coarser_one(write, axis, recording, share, told):
    step = 1e-5  # 184 of them lie between samples
    described = dataclasses.replace(axis, resolution=step * share)
    log = read_log(write(q=step * np.round(recording["r"] / step)), described)
    assert ("resolution_contradicts" in [item.code for item in checked(log, described)]) == told


@pytest.mark.parametrize("with_reference", [True, False])
def test_a_clipped_position_is_refused(write, axis, recording, with_reference):
    columns = {name: axis.columns[name] for name in axis.columns if with_reference or name != "reference"}
    clipped = np.minimum(recording["q"], 0.4)
    with pytest.raises(InputError, match=r"column 'q': is saturated: it stops abruptly at 0\.4 m"):
        read_log(write(q=clipped), dataclasses.replace(axis, columns=columns))


def test_a_position_that_rests_at_its_extreme_is_legitimate(write, axis, recording):
    t = recording["t"]
    phase = np.clip((t % 0.6) / 0.2, 0.0, 1.0)  # a third of the time in motion, the rest at an end
    present = 0.5 * (1 - np.cos(np.pi * phase))
    position = np.round(np.where((t // 0.6) % 2 == 0, present, 1 - present), 6)
    effort = np.gradient(np.gradient(position, t), t) + np.random.default_rng(3).normal(0, 0.1, t.size)
    log = read_log(write(q=position, r=position, u=effort), axis)
    assert np.mean(log.position.values == log.position.values.max()) > 0.3


def test_an_axis_that_brakes_and_sticks_is_not_saturated(write, axis, recording):
    """Steps of the position as recorded on an axis with friction: the last one before rest is no small one."""
    speed = 453.0 * np.ones(recording["t"].size)
    speed[400:412] = [450, 440, 420, 390, 350, 300, 258, 218, 163, 58, 0, 0]
    speed[412:700] = 0.0
    speed[700:] = -453.0 * np.minimum(np.arange(speed.size - 700) / 40.0, 1.0)
    position = 1e-7 * np.cumsum(speed)
    log = read_log(write(t=recording["t"], q=position, u=recording["u"]), axis)
    np.testing.assert_array_equal(log.position.values, position)


@pytest.mark.parametrize("form", ["NFC", "NFD"])
@pytest.mark.parametrize("other", ["NFC", "NFD"])
def test_a_name_with_an_accent_is_found_however_it_is_spelt(tmp_path, axis, recording, form, other):
    name = "K\u00e4fig"
    rows = np.column_stack([recording["t"], recording["q"], recording["u"]])
    head = f"t,{normalize(form, name)},u"
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header=head, comments="", encoding="utf-8")
    requested = dataclasses.replace(
        axis, columns={"time": Column("t", "s", "s"), "position": Column(normalize(other, name), "m", "m"), "effort": Column("u", "N", "N")}
    )
    log = read_log(tmp_path / "log.csv", requested)
    assert log.position.values.size == recording["t"].size


def exchanged(count):
    """Rows of which two pairs have changed places."""
    rows = np.arange(count)
    rows[[100, 101, 500, 502]] = rows[[101, 100, 502, 500]]
    return rows


@pytest.mark.parametrize(
    ("rows", "note"),
    [
        (np.insert(np.arange(1200), 600, 599), "1 row repeats the previous row: bristle uses each row once"),
        (exchanged(1200), "out of order: bristle sorted the rows by time"),
        (np.arange(1199, -1, -1), "bristle reversed the rows"),
    ],
    ids=["repeated", "out of order", "newest first"],
)
def test_rows_are_taken_once_and_in_order_with_a_note(write, axis, recording, rows, note):
    log = read_log(write(**{name: values[rows] for name, values in recording.items()}), axis)
    assert note in log.notes[0]
    np.testing.assert_array_equal(log.position.values, recording["q"])
    np.testing.assert_allclose(log.effort.values, recording["u"], rtol=1e-12)
    assert len(log.segments) == 1


def late_at_random(t):
    """Stamps of which one in twenty is late by most of a sample."""
    return t + 0.8 * SAMPLE_TIME * np.isin(np.arange(t.size), np.random.default_rng(7).choice(t.size, 60, replace=False))


@pytest.mark.parametrize(
    ("stamps", "note", "begins"),
    [
        (lambda t: np.where(t < 0.7, t, t - 0.7), "restarts at row 700", [0, 700]),
        (lambda t: np.where(np.arange(t.size) == 600, t[599], t), "between the neighbouring time stamps", [0]),
        (late_at_random, "the position changes evenly: bristle treats the samples as evenly spaced", [0]),
        *((lambda t, rate=rate: np.floor(1e6 * t / rate) / 1e3, "rounded to 0.001 s", [0]) for rate in (3000.0, 1500.0, 700.0, 300.0)),
    ],
    ids=["restarted", "not renewed", "late", "rounded 3000", "rounded 1500", "rounded 700", "rounded 300"],
)
def test_stamps_of_a_faulty_clock_leave_the_samples_as_they_are(write, axis, recording, stamps, note, begins):
    log = read_log(write(t=stamps(recording["t"])), axis)
    assert note in log.notes[0]
    assert [segment.start for segment in log.segments] == begins
    np.testing.assert_array_equal(log.position.values, recording["q"])
    assert log.findings == ()


def test_stamps_in_no_order_are_refused(write, axis, recording):
    mixed = np.random.default_rng(2).permutation(recording["t"])
    with pytest.raises(InputError, match=r"column 't': is not in order: .* of its 1199 steps go backward"):
        read_log(write(t=mixed), axis)
    with pytest.raises(InputError, match="column 't': does not advance: all its values are 1 s"):
        read_log(write(t=np.ones(recording["t"].size)), axis)


@pytest.mark.parametrize("step", [1e-320, 1e-13, 1e10])
def test_steps_of_time_that_no_axis_is_sampled_at_are_refused(write, axis, recording, step):
    with pytest.raises(InputError, match=r"column 't': has a usual time step of .* allowed 1e-12 s to 1e\+09 s"):
        read_log(write(t=np.arange(recording["t"].size) * step), axis)


def test_small_jitter_is_resampled_with_a_note(write, axis, recording):
    rng = np.random.default_rng(7)
    t = recording["t"] + rng.uniform(-0.09, 0.09, recording["t"].size) * SAMPLE_TIME
    w = 2 * np.pi / 0.6
    log = read_log(write(t=t, q=0.25 * (1 - np.cos(w * t))), axis)
    assert "jitter by up to 8." in log.notes[0]
    assert "(19 of 20 stamps; the largest deviation is 9" in log.notes[0]
    assert "bristle resamples the log" in log.notes[0]
    assert np.ptp(np.diff(log.time.values)) < 1e-12
    exact = 0.25 * (1 - np.cos(w * log.time.values))
    assert np.max(np.abs(log.position.values - exact)) < 1e-9  # linear interpolation errs by 1e-6


def test_a_single_outlying_stamp_is_reported_in_plain_numbers(write, axis, recording):
    t = recording["t"] + 0.02 * SAMPLE_TIME * np.random.default_rng(7).uniform(-1.0, 1.0, recording["t"].size)
    t[400:406] += np.array([5.0, 4.2, 3.4, 2.6, 1.8, 1.0]) * SAMPLE_TIME
    (text,) = (note for note in read_log(write(t=t), axis).notes if "jitter" in note)
    assert re.search(r"the largest deviation is \d{3} %\)", text), text


@pytest.mark.parametrize("share", [0.15, 0.3, 0.45])
def test_large_jitter_is_resampled_with_an_error_estimate(write, axis, recording, share):
    rng = np.random.default_rng(7)
    t = recording["t"] + rng.uniform(-share, share, recording["t"].size) * SAMPLE_TIME
    w = 2 * np.pi / 0.6
    log = read_log(write(t=t, q=0.25 * (1 - np.cos(w * t)), u=5 * np.sin(w * t)), axis)
    exact = 0.25 * (1 - np.cos(w * log.time.values))
    wrong = np.sqrt(np.mean((log.position.values - exact) ** 2))
    (result,) = log.findings
    assert (result.code, result.severity) == ("resampled", "warning")
    assert result.numbers["percent"] == pytest.approx(95 * share, rel=0.05)
    assert wrong <= result.numbers["position_error"] < 2e-6
    assert result.numbers["effort_error"] < 1e-4
    assert result in checked(log, axis)


def test_the_step_of_an_encoder_is_that_of_the_samples_as_they_were_recorded(write, axis, recording):
    rng = np.random.default_rng(7)
    t = recording["t"] + rng.uniform(-0.2, 0.2, recording["t"].size) * SAMPLE_TIME
    step = 2.0**-18
    q = step * np.round(0.25 * (1 - np.cos(2 * np.pi / 0.6 * t)) / step)
    log = read_log(write(t=t, q=q), axis)
    assert log.findings[0].code == "resampled"
    assert log.position.step == step
    assert smallest_step(log.position) == step
    apart = np.diff(np.unique(log.position.values))
    assert apart[apart > 1e-12].min() < 0.1 * step
    even = read_log(write(q=q), axis)
    assert even.position.step == step


def test_late_samples_do_not_split_a_log(write, axis, recording):
    t = recording["t"].copy()
    t[300:303] += [1.9e-3, 1.2e-3, 0.5e-3]
    assert len(read_log(write(t=t), axis).segments) == 1


@pytest.mark.parametrize(("noise", "is_even"), [(3e-7, True), (5e-6, False)])
def test_stamps_are_only_taken_as_even_where_rows_explain_the_motion_far_better(noise, is_even):
    rng = np.random.default_rng(3)
    even = 1e-3 * np.arange(4000)
    position = 0.01 * np.sin(2.0 * np.pi * even) + noise * rng.standard_normal(even.size)
    clock = clock_of(even + 1e-4 * rng.uniform(-1.0, 1.0, even.size), "log", position=position)
    assert (clock.jitter is None) == is_even


def test_a_clock_that_drifts_slowly_is_no_jitter(write, axis, recording):
    t = recording["t"] * (1 + 1e-3 * recording["t"])
    assert "bristle resamples" in read_log(write(t=t), axis).notes[0]


def test_gaps_split_the_log(write, axis, recording):
    t = recording["t"].copy()
    t[400:] += 0.0123
    t[405:] += 0.1
    t[900:] += 2.0
    log = read_log(write(t=t), axis)
    assert log.segments == (slice(0, 400), slice(400, 895), slice(895, 1195))
    assert log.notes[0].startswith("3 gaps")
    assert "5 samples in segments shorter than 10" in log.notes[1]
    np.testing.assert_allclose(log.time.values[log.segments[2]], t[900:], atol=1e-9)
    np.testing.assert_array_equal(log.position.values[log.segments[2]], recording["q"][900:])


def test_uneven_samples_are_resampled(write, axis, recording):
    t = np.cumsum(np.random.default_rng(1).exponential(1e-3, recording["t"].size))
    w = 2 * np.pi / 0.6
    log = read_log(write(t=t, q=0.25 * (1 - np.cos(w * t)), u=np.sin(w * t)), axis)
    exact = 0.25 * (1 - np.cos(w * log.time.values))
    assert np.sqrt(np.mean((log.position.values - exact) ** 2)) <= 1.5 * log.findings[0].numbers["position_error"]
    assert "samples are unevenly spaced" in log.notes[-1]


def test_without_a_column_of_time_the_sample_time_is_needed(write, axis, recording):
    columns = {name: column for name, column in axis.columns.items() if name != "time"}
    bare = dataclasses.replace(axis, columns=columns)
    with pytest.raises(InputError, match=r"sample_time = \"1 ms\" under \[timing\]"):
        read_log(write(), bare)
    log = read_log(write(), dataclasses.replace(bare, sample_time=2e-3))
    assert log.time.values[-1] == pytest.approx(2e-3 * (recording["t"].size - 1))
    assert log.time.column == ""


def test_a_time_column_of_another_rate_than_the_axis_file_is_refused(write, axis):
    with pytest.raises(InputError, match=r"has a time step of 0\.001 s, .* allowed 1e-06 s"):
        read_log(write(), dataclasses.replace(axis, sample_time=1e-6))


@pytest.mark.parametrize("samples", [3.0, 0.5, -2.0, -1.25])
def test_a_delay_of_the_effort_is_taken_out(write, axis, recording, samples):
    t = recording["t"]

    def effort(at):
        return 5 * np.sin(10 * at) + 0.3 * np.cos(31 * at)

    path = write(u=effort(t - samples * SAMPLE_TIME))
    log = read_log(path, dataclasses.replace(axis, delay=samples * SAMPLE_TIME))
    assert len(log) == t.size - int(np.ceil(abs(samples)))
    np.testing.assert_allclose(log.effort.values, effort(log.time.values), atol=1e-8)
    at = np.round(log.time.values / SAMPLE_TIME).astype(int)
    np.testing.assert_array_equal(log.position.values, recording["q"][at])
    assert "its delay in the axis file" in log.notes[-1]


def test_a_delay_longer_than_the_log_is_refused(write, axis):
    with pytest.raises(InputError, match="after a shift by the delay of 5 s"):
        read_log(write(), dataclasses.replace(axis, delay=5.0))


def test_columns_of_different_lengths_are_refused(tmp_path, recording, axis):
    import scipy.io

    path = tmp_path / "log.mat"
    scipy.io.savemat(path, {**recording, "u": recording["u"][:-7]})
    with pytest.raises(InputError, match=r"different numbers of samples .*u: 1193"):
        read_log(path, axis)


def test_without_an_axis_usual_names_are_taken(write, recording):
    path = write()
    path.write_text(path.read_text().replace("t,q,r,u", "Time [ms],position [deg],other,Torque [mNm]"))
    log = read_log(path)
    assert log.kind == "rotational"
    np.testing.assert_allclose(log.position.values, np.deg2rad(recording["q"]), rtol=1e-12)
    np.testing.assert_allclose(log.effort.values, recording["u"] * 1e-3, rtol=1e-12)
    assert log.reference is None


def has_reversed_effort(log):
    return "sign_reversed" in {remark.code for remark in checked(log)}


def test_the_sign_of_the_effort(write, axis, recording):
    assert not has_reversed_effort(read_log(write(), axis))
    assert has_reversed_effort(read_log(write(u=-recording["u"]), axis))
    assert not has_reversed_effort(read_log(write(u=recording["u"] + 500.0), axis))


def data_file(*parts: str) -> Path:
    folder = os.environ.get("BRISTLE_DATA")
    if not folder:
        pytest.skip("BRISTLE_DATA does not name the folder of measured logs")
    path = Path(folder, *parts)
    assert path.is_file(), f"BRISTLE_DATA is set, and {path} is missing"
    return path


@pytest.mark.measured
def test_the_measured_positioning_system():
    from bristle.files.arguments import read_log as read_with_axis_file

    axis = Path(__file__).parents[2] / "examples" / "emps" / "axis.toml"
    log = read_with_axis_file(data_file("emps", "DATA_EMPS.mat"), axis)
    assert len(log) == 24841
    assert log.sample_time == pytest.approx(1e-3, rel=1e-6)
    assert log.segments == (slice(0, 24841),)
    assert np.max(log.effort.values) == pytest.approx(145.47, abs=0.01)
    assert log.notes == ("optional column pulses_N is not in this log",)


@pytest.mark.measured
@pytest.mark.parametrize("bound", [2.5, 1.0])
def test_the_measured_positioning_system_with_a_clipped_effort(tmp_path, bound):
    log = positioning_system(tmp_path, "vir", bound)
    (cut,) = [result for result in checked(log) if result.code == "clipped"]
    assert abs(cut.numbers["level"]) == pytest.approx(35.1507 * bound, rel=1e-3)


@pytest.mark.measured
def test_the_measured_positioning_system_with_a_clipped_position(tmp_path):
    with pytest.raises(InputError, match="column 'qm': is saturated"):
        positioning_system(tmp_path, "qm", 0.2)


def positioning_system(tmp_path, column, bound):
    """Return the measured log with one of its columns cut off."""
    import scipy.io

    from bristle.files.arguments import read_log as read_with_axis_file

    content = scipy.io.loadmat(data_file("emps", "DATA_EMPS.mat"))
    content = {name: values for name, values in content.items() if not name.startswith("__")}
    scipy.io.savemat(tmp_path / "clipped.mat", {**content, column: np.clip(content[column], -bound, bound)})
    axis = Path(__file__).parents[2] / "examples" / "emps" / "axis.toml"
    return read_with_axis_file(tmp_path / "clipped.mat", axis)


@pytest.mark.measured
def test_the_measured_tribometer_rests_half_of_the_time_and_has_the_other_sign():
    from bristle.core.axis import Axis

    columns = {"time": Column("Time", "", "s"), "position": Column("Position", "", "m"), "effort": Column("Friction", "", "N")}
    log = read_log(data_file("tribometer", "test_data_2.txt"), Axis(columns=columns))
    assert log.sample_time == pytest.approx(5e-3)
    steady = (log.time.values > 12) & (log.time.values < 205)
    assert np.ptp(log.position.values[steady]) == pytest.approx(229.6e-6, rel=0.01)
    assert has_reversed_effort(log)
    turned = Axis(columns={**columns, "effort": Column("Friction", "", "N", -1.0)})
    assert not has_reversed_effort(read_log(data_file("tribometer", "test_data_2.txt"), turned))
