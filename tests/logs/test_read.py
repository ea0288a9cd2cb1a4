"""From a file to a log: what is accepted, and what is refused by name."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path
from unicodedata import normalize

import numpy as np
import pytest
import scipy.io
from tests.examples.data import measured

from bristle.core.axis import Axis, Column, Injected
from bristle.core.errors import InputError
from bristle.files.arguments import read_log as read_with_axis_file
from bristle.identification.preprocessing import smallest_step
from bristle.logs import checked, read_log
from bristle.logs.clock import clock_of
from bristle.models.controllers import cascade
from bristle.report.messages import message

SAMPLE_TIME = 1e-3
EMPS = Path(__file__).parents[2] / "examples" / "emps" / "axis.toml"


def with_columns(axis, **columns):
    return dataclasses.replace(axis, columns={**axis.columns, **columns})


def without_column(axis, name, **described):
    return dataclasses.replace(
        axis,
        columns={key: column for key, column in axis.columns.items() if key != name},
        **described,
    )


@pytest.fixture
def read(write, axis, recording):
    """Write the recording with some columns changed and read it by an axis file with other entries; return the log and its axis."""

    def read(changed=lambda recording: {}, described=None):
        of_log = (
            described(axis)
            if callable(described)
            else dataclasses.replace(axis, **(described or {}))
        )
        return read_log(write(**changed(recording)), of_log), of_log

    return read


def test_a_log_is_the_same_from_every_kind_of_file(any_file, recording, axis):
    log = read_log(any_file, axis)
    assert (len(log), log.segments, log.sample_time) == (
        1200,
        (slice(0, 1200),),
        pytest.approx(SAMPLE_TIME, rel=1e-9),
    )
    assert (log.position.column, log.position.unit, log.effort.unit, log.velocity, log.notes) == (
        "q",
        "m",
        "N",
        None,
        (),
    )
    np.testing.assert_allclose(log.effort.values, recording["u"], rtol=1e-10, atol=1e-12)


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
    log = read_log(
        write(), dataclasses.replace(axis, columns=channels | {"following_error": error})
    )
    np.testing.assert_allclose(
        log.reference.values, recording["q"] - 1e-3 * recording["r"], rtol=1e-12
    )
    assert any(
        "the reference as position plus following error, which column r contains" in note
        for note in log.notes
    )
    both = read_log(
        write(), dataclasses.replace(axis, columns=dict(axis.columns) | {"following_error": error})
    )
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
        ("t,q [N],r,u", "q", "column 'q': has the wrong unit; found 'N'"),
        ("t,q,r,u", "Q", r"no column 'Q' .* allowed columns: t, q, r, u\. Did you mean 'q'\?"),
    ],
)
def test_columns_of_another_name_or_unit_are_refused(write, axis, head, position, words):
    path = write()
    path.write_text(path.read_text().replace("t,q,r,u", head))
    with pytest.raises(InputError, match=words):
        read_log(path, with_columns(axis, position=Column(position, "", "m")))


PULSES = np.where(np.arange(1200) % 200 < 100, 5.0, 0.0)


@pytest.mark.parametrize(
    ("column", "values", "known", "effort", "notes"),
    [
        (
            "pulses",
            PULSES,
            (Injected("pulses", 2.0, optional=True), Injected("absent", 1.0, optional=True)),
            2.0 * PULSES,
            ("optional column absent is not in this log",),
        ),
        (
            "Pulses_1",
            PULSES,
            (Injected("pulses", 2.0, optional=True),),
            0.0,
            (
                "optional column pulses is not in this log. If its name is 'Pulses_1', write this name in the axis file",
            ),
        ),
        # Never on, and no constant channel.
        ("pulses", 0.0 * PULSES, (Injected("pulses", 2.0),), 0.0, ()),
    ],
)
def test_known_inputs_are_added_up_and_may_be_missing(read, column, values, known, effort, notes):
    log, _ = read(lambda recording: {column: values}, {"injected": known})
    np.testing.assert_array_equal(log.injected_effort, effort)
    assert log.notes[: len(notes)] == notes


@pytest.mark.parametrize(
    ("changed", "described", "words"),
    [
        *(
            (
                {
                    column: lambda x, value=value: np.where(
                        np.isin(np.arange(1200), [123, 500]), value, x
                    )
                },
                {},
                rf"column '{column}': {said} {at}",
            )
            for column, at in (
                ("t", "sample 123"),
                ("q", r"sample 123 \(t = 0\.123 s\)"),
                ("u", r"sample 123 \(t = 0\.123 s\)"),
            )
            for value, said in (
                (np.nan, "has NaN.* in 2 samples.*"),
                (np.inf, "has an infinite value in 2 samples.*"),
            )
        ),
        *(
            ({column: lambda x: np.full(x.size, 0.7)}, {}, f"column '{column}': is constant")
            for column in ("q", "u", "r")
        ),
        (
            {"q": lambda x: np.minimum(x, 0.4)},
            {},
            r"column 'q': is saturated: it stops abruptly at 0\.4 m",
        ),
        (
            {"q": lambda x: np.minimum(x, 0.4)},
            lambda axis: without_column(axis, "reference"),
            r"column 'q': is saturated: it stops abruptly at 0\.4 m",
        ),
        (
            {"t": np.random.default_rng(2).permutation},
            {},
            r"column 't': is not in order: .* of its 1199 steps go backward",
        ),
        ({"t": np.ones_like}, {}, "column 't': does not advance: all its values are 1 s"),
        *(
            (
                {"t": lambda x, step=step: np.arange(x.size) * step},
                {},
                r"column 't': has a usual time step of .* allowed 1e-12 s to 1e\+09 s",
            )
            for step in (1e-320, 1e-13, 1e10)
        ),
        ({}, {"sample_time": 1e-6}, r"has a time step of 0\.001 s, .* allowed 1e-06 s"),
        ({}, {"delay": 5.0}, "after a shift by the delay of 5 s"),
        ({}, {"injected": (Injected("pulses", 2.0),)}, "no column 'pulses'"),
        (
            {},
            lambda axis: without_column(axis, "time"),
            r"Write in the axis file time = \{ column = \"t\", unit = \"s\" \} in \[columns\]",
        ),
    ],
)
def test_a_log_that_cannot_be_used_is_refused_with_its_column(read, changed, described, words):
    with pytest.raises(InputError, match=words):
        read(
            lambda recording: {name: change(recording[name]) for name, change in changed.items()},
            described,
        )


@pytest.mark.parametrize(
    ("changed", "described", "level"),
    [
        *(
            (
                lambda recording, share=share: {
                    "u": np.minimum(recording["u"], share * np.max(recording["u"]))
                },
                {"effort_limit": limit},
                None,
            )
            for share, limit in ((0.9, None), (0.7, 1000.0), (0.5, None))
        ),
        (
            lambda recording: {"u": np.clip(recording["u"], -40.0, 40.0)},
            {"effort_limit": 40.0},
            40.0,
        ),
        # A known input is added behind the limit of the controller.
        (
            lambda recording: {
                "u": np.clip(recording["u"], -40.0, 40.0) + 20.0 * PULSES,
                "pulses": PULSES,
            },
            {
                "controller": cascade(k_p=1.0, k_v=1.0, limit=40.0),
                "injected": (Injected("pulses", 20.0),),
            },
            40.0,
        ),
    ],
)
def test_a_clipped_effort_is_reported_with_its_level(read, changed, described, level):
    log, of_log = read(changed, described)
    assert abs(clipped_at(log, of_log)) == pytest.approx(
        np.max(log.effort.values) if level is None else level
    )


def clipped_at(log, axis):
    """Return where a log is told to be clipped; None where it is not."""
    return next(
        (result.numbers["level"] for result in checked(log, axis) if result.code == "clipped"), None
    )


def exceeded(log):
    return [
        (finding.code, finding.numbers.get("key"))
        for finding in log.findings
        if finding.code.startswith("beyond")
    ]


def laws(limit, **described):
    return {
        "controller": cascade(k_p=1.0, k_v=1.0, limit=limit),
        "injected": (Injected("pulses", 20.0),),
        **described,
    }


def pushed(recording):
    """Up to 75 N of its own, and 100 N of pulses."""
    return {"u": recording["u"] + 20.0 * PULSES, "pulses": PULSES}


@pytest.mark.parametrize(
    ("changed", "described", "expected"),
    [
        (lambda recording: {}, {"effort_limit": 10.0}, [("beyond_limit", "[effort] limit")]),
        (lambda recording: {}, {"effort_limit": 100.0}, []),
        # Five per cent above the limit are no finding.
        (
            lambda recording: {"u": 104.0 * recording["u"] / np.max(np.abs(recording["u"]))},
            {"effort_limit": 100.0},
            [],
        ),
        (
            lambda recording: {"u": 106.0 * recording["u"] / np.max(np.abs(recording["u"]))},
            {"effort_limit": 100.0},
            [("beyond_limit", "[effort] limit")],
        ),
        (lambda recording: {}, {"stroke": (0.0, 0.05)}, [("beyond_limit", None)]),
        (lambda recording: {}, {"stroke": (-0.1, 0.45)}, []),
        # Known inputs are added behind the limit of the controller, and before that of the drive.
        (pushed, laws(90.0), []),
        (pushed, laws(90.0, effort_limit=90.0), [("beyond_limit", "[effort] limit")]),
        (pushed, laws(40.0, effort_limit=300.0), [("beyond_limit", "[controller] limit")]),
    ],
)
def test_an_effort_and_a_position_beyond_their_limits_are_read_with_a_finding(
    read, changed, described, expected
):
    log, of_log = read(changed, described)
    assert exceeded(log) == expected
    assert {item.code for item in checked(log, of_log)} >= {code for code, _ in expected}


def test_a_finding_on_a_limit_names_its_key_and_value(read):
    log, of_log = read(described={"effort_limit": 10.0})
    (text,) = [message(result) for result in checked(log, of_log) if result.code == "beyond_limit"]
    assert text.startswith("the effort reaches 75")
    assert "[effort] limit of the axis file is 10 N" in text


def trapezoids(t):
    """Speeds of trapezoids against Coulomb friction, and the effort without noise."""
    speed = (
        0.1
        * np.clip(np.minimum(t % 0.5, 0.5 - t % 0.5) / 0.1, 0.0, 1.0)
        * np.where(t % 1.0 < 0.5, 1.0, -1.0)
    )
    return {
        "q": np.cumsum(speed) * SAMPLE_TIME,
        "u": 2.0 * np.gradient(speed, t) + 3.0 * np.sign(speed),
    }


@pytest.mark.parametrize(
    "changed",
    [
        lambda recording: {"u": np.round(recording["u"])},
        lambda recording: trapezoids(recording["t"]),
        lambda recording: {
            "u": np.where(recording["t"] < 0.2, 0.0, recording["u"] - recording["u"].min() + 1.0)
        },
    ],
    ids=["coarse", "constant stretches", "drive off"],
)
def test_an_effort_of_equal_values_is_not_taken_for_a_clipped_one(read, changed):
    assert clipped_at(*read(changed)) is None


@pytest.mark.parametrize(
    ("column", "step", "times", "told"),
    [
        ("q", 1e-4, 57.29578, True),
        ("q", 1e-4, 1 / 57.29578, True),
        ("q", 1e-4, 4.0, False),
        ("q", 1e-4, 1.0, False),
        # Of a fast axis, 184 steps lie between samples: digits of a text contradict no coarser resolution.
        ("r", 1e-5, 57.3, True),
        ("r", 1e-5, 1 / 57.3, False),
    ],
)
def test_steps_that_contradict_the_stated_resolution_are_reported(read, column, step, times, told):
    log, of_log = read(
        lambda recording: {"q": step * np.round(recording[column] / step)},
        {"resolution": step / times},
    )
    result = [
        message(item) for item in checked(log, of_log) if item.code == "resolution_contradicts"
    ]
    assert ["One radian has 57.3 degrees" in text for text in result] == [True] * told


def test_a_position_that_rests_at_its_extreme_is_legitimate(write, axis, recording):
    t = recording["t"]
    phase = np.clip((t % 0.6) / 0.2, 0.0, 1.0)  # a third of the time in motion, the rest at an end
    present = 0.5 * (1 - np.cos(np.pi * phase))
    position = np.round(np.where((t // 0.6) % 2 == 0, present, 1 - present), 6)
    effort = np.gradient(np.gradient(position, t), t) + np.random.default_rng(3).normal(
        0, 0.1, t.size
    )
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
    np.savetxt(
        tmp_path / "log.csv", rows, delimiter=",", header=head, comments="", encoding="utf-8"
    )
    requested = dataclasses.replace(
        axis,
        columns={
            "time": Column("t", "s", "s"),
            "position": Column(normalize(other, name), "m", "m"),
            "effort": Column("u", "N", "N"),
        },
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
        (
            np.insert(np.arange(1200), 600, 599),
            "1 row repeats the previous row: bristle uses each row once",
        ),
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
    return t + 0.8 * SAMPLE_TIME * np.isin(
        np.arange(t.size), np.random.default_rng(7).choice(t.size, 60, replace=False)
    )


@pytest.mark.parametrize(
    ("stamps", "note", "begins"),
    [
        (lambda t: np.where(t < 0.7, t, t - 0.7), "restarts at row 700", [0, 700]),
        (
            lambda t: np.where(np.arange(t.size) == 600, t[599], t),
            "between the neighbouring time stamps",
            [0],
        ),
        (
            late_at_random,
            "the position changes evenly: bristle treats the samples as evenly spaced",
            [0],
        ),
        *(
            (lambda t, rate=rate: np.floor(1e6 * t / rate) / 1e3, "rounded to 0.001 s", [0])
            for rate in (3000.0, 1500.0, 700.0, 300.0)
        ),
    ],
    ids=[
        "restarted",
        "not renewed",
        "late",
        "rounded 3000",
        "rounded 1500",
        "rounded 700",
        "rounded 300",
    ],
)
def test_stamps_of_a_faulty_clock_leave_the_samples_as_they_are(
    write, axis, recording, stamps, note, begins
):
    log = read_log(write(t=stamps(recording["t"])), axis)
    assert note in log.notes[0]
    assert [segment.start for segment in log.segments] == begins
    np.testing.assert_array_equal(log.position.values, recording["q"])
    assert log.findings == ()


def test_small_jitter_is_resampled_with_a_note(write, axis, recording):
    rng = np.random.default_rng(7)
    t = recording["t"] + rng.uniform(-0.09, 0.09, recording["t"].size) * SAMPLE_TIME
    w = 2 * np.pi / 0.6
    log = read_log(write(t=t, q=0.25 * (1 - np.cos(w * t))), axis)
    assert re.search(
        r"jitter by up to 8\..*\(19 of 20 stamps; the largest deviation is 9.*bristle resamples the log",
        log.notes[0],
    )
    assert np.ptp(np.diff(log.time.values)) < 1e-12
    exact = 0.25 * (1 - np.cos(w * log.time.values))
    assert np.max(np.abs(log.position.values - exact)) < 1e-9  # linear interpolation errs by 1e-6


@pytest.mark.parametrize(
    ("late", "note"),
    [
        (lambda t: 1e-3 * t * t, "bristle resamples"),  # a clock that drifts
        # Late samples
        (lambda t: np.select([t == 0.3, t == 0.301, t == 0.302], [1.9e-3, 1.2e-3, 0.5e-3]), ""),
    ],
)
def test_a_clock_that_drifts_and_late_samples_do_not_split_a_log(read, late, note):
    log, _ = read(lambda recording: {"t": recording["t"] + late(recording["t"])})
    assert len(log.segments) == 1
    assert note in " ".join(log.notes)


def test_a_single_outlying_stamp_is_reported_in_plain_numbers(write, axis, recording):
    t = recording["t"] + 0.02 * SAMPLE_TIME * np.random.default_rng(7).uniform(
        -1.0, 1.0, recording["t"].size
    )
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


def test_the_step_of_an_encoder_is_that_of_the_samples_as_they_were_recorded(
    write, axis, recording
):
    rng = np.random.default_rng(7)
    t = recording["t"] + rng.uniform(-0.2, 0.2, recording["t"].size) * SAMPLE_TIME
    step = 2.0**-18
    q = step * np.round(0.25 * (1 - np.cos(2 * np.pi / 0.6 * t)) / step)
    log = read_log(write(t=t, q=q), axis)
    assert (log.findings[0].code, log.position.step, smallest_step(log.position)) == (
        "resampled",
        step,
        step,
    )
    apart = np.diff(np.unique(log.position.values))
    assert apart[apart > 1e-12].min() < 0.1 * step


@pytest.mark.parametrize(("noise", "is_even"), [(3e-7, True), (5e-6, False)])
def test_stamps_are_only_taken_as_even_where_rows_explain_the_motion_far_better(noise, is_even):
    rng = np.random.default_rng(3)
    even = 1e-3 * np.arange(4000)
    position = 0.01 * np.sin(2.0 * np.pi * even) + noise * rng.standard_normal(even.size)
    clock = clock_of(even + 1e-4 * rng.uniform(-1.0, 1.0, even.size), "log", position=position)
    assert (clock.jitter is None) == is_even


def test_gaps_split_the_log(write, axis, recording):
    t = recording["t"].copy()
    t[400:] += 0.0123
    t[405:] += 0.1
    t[900:] += 2.0
    log = read_log(write(t=t), axis)
    assert log.segments == (slice(0, 400), slice(400, 895), slice(895, 1195))
    assert [
        note
        for note in log.notes
        if note.startswith("3 gaps") or "5 samples in segments shorter than 10" in note
    ] == list(log.notes[:2])
    np.testing.assert_allclose(log.time.values[log.segments[2]], t[900:], atol=1e-9)
    np.testing.assert_array_equal(log.position.values[log.segments[2]], recording["q"][900:])


def test_uneven_samples_are_resampled(write, axis, recording):
    t = np.cumsum(np.random.default_rng(1).exponential(1e-3, recording["t"].size))
    w = 2 * np.pi / 0.6
    log = read_log(write(t=t, q=0.25 * (1 - np.cos(w * t)), u=np.sin(w * t)), axis)
    exact = 0.25 * (1 - np.cos(w * log.time.values))
    assert (
        np.sqrt(np.mean((log.position.values - exact) ** 2))
        <= 1.5 * log.findings[0].numbers["position_error"]
    )
    assert "samples are unevenly spaced" in log.notes[-1]


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


def test_without_an_axis_usual_names_are_taken(write, recording):
    path = write()
    path.write_text(
        path.read_text().replace("t,q,r,u", "Time [ms],position [deg],other,Torque [mNm]")
    )
    log = read_log(path)
    assert (log.kind, log.reference) == ("rotational", None)
    np.testing.assert_allclose(
        [log.position, log.effort], [np.deg2rad(recording["q"]), recording["u"] * 1e-3], rtol=1e-12
    )


def has_reversed_effort(log):
    return "sign_reversed" in {remark.code for remark in checked(log)}


@pytest.mark.parametrize(
    ("factor", "weight", "is_reversed"), [(1.0, 0.0, False), (-1.0, 0.0, True), (1.0, 500.0, False)]
)
def test_the_sign_of_the_effort(read, factor, weight, is_reversed):
    log, _ = read(lambda recording: {"u": factor * recording["u"] + weight})
    assert has_reversed_effort(log) is is_reversed


@pytest.mark.measured
def test_the_measured_positioning_system():
    log = read_with_axis_file(measured("emps", "DATA_EMPS.mat"), EMPS)
    assert (len(log), log.segments, log.sample_time) == (
        24841,
        (slice(0, 24841),),
        pytest.approx(1e-3, rel=1e-6),
    )
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
    content = scipy.io.loadmat(measured("emps", "DATA_EMPS.mat"))
    content = {name: values for name, values in content.items() if not name.startswith("__")}
    scipy.io.savemat(
        tmp_path / "clipped.mat", {**content, column: np.clip(content[column], -bound, bound)}
    )
    return read_with_axis_file(tmp_path / "clipped.mat", EMPS)


@pytest.mark.measured
def test_the_measured_tribometer_rests_half_of_the_time_and_has_the_other_sign():
    columns = {
        "time": Column("Time", "", "s"),
        "position": Column("Position", "", "m"),
        "effort": Column("Friction", "", "N"),
    }
    log = read_log(measured("tribometer", "test_data_2.txt"), Axis(columns=columns))
    assert log.sample_time == pytest.approx(5e-3)
    steady = (log.time.values > 12) & (log.time.values < 205)
    assert np.ptp(log.position.values[steady]) == pytest.approx(229.6e-6, rel=0.01)
    assert has_reversed_effort(log)
    turned = Axis(columns={**columns, "effort": Column("Friction", "", "N", -1.0)})
    assert not has_reversed_effort(read_log(measured("tribometer", "test_data_2.txt"), turned))
