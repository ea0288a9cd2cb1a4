"""A table becomes a log: its time base, a position that is the integral of a speed, and the part within a span."""

from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

from bristle.core.axis import Axis, Cogging, Column, Injected, KnownColumn
from bristle.core.errors import InputError
from bristle.logs.assembly import record_of, within
from bristle.logs.table import Table

COUNT, DT = 400, 0.01
TIME = DT * np.arange(COUNT)
POSITION, EFFORT = np.sin(2.0 * TIME), np.cos(3.0 * TIME)
SPEED = 2.0 * np.cos(2.0 * TIME)
COLUMNS = {"position": Column("q", "", "m"), "effort": Column("u", "", "N")}


def recorded(columns, axis=None, of_file=None, **stated):
    """The log of a table with these columns; each channel has the column of its own name unless an axis says more."""
    axis = axis or Axis(
        columns={name: column for name, column in COLUMNS.items() if column.name in columns},
        **stated,
    )
    return record_of(Table(columns, {}, names=tuple(columns), sample_time=of_file), axis)


STATED = "the log states a sample time of 0.01 s, but the axis file gives 0.02 s: bristle uses the axis file"


@pytest.mark.parametrize(
    ("of_axis", "of_file", "expected", "notes"),
    [
        (None, DT, DT, ()),
        (DT, None, DT, ()),
        (1.009 * DT, DT, 1.009 * DT, ()),
        (2.0 * DT, DT, 2.0 * DT, (STATED,)),
    ],
)
def test_without_a_time_column_the_sample_time_of_the_axis_file_outranks_that_of_the_log(
    of_axis, of_file, expected, notes
):
    log = recorded({"q": POSITION, "u": EFFORT}, of_file=of_file, sample_time=of_axis)
    assert (log.sample_time, log.time.column) == (pytest.approx(expected), "")
    assert log.time.values[:3] == pytest.approx([0.0, expected, 2.0 * expected])
    assert tuple(note for note in log.notes if "sample time" in note) == notes


def by_speed(stamps=TIME, speed=SPEED, *, reference=None, **stated):
    """The log of a speed alone, and of a reference where there is one."""
    columns = {"time": Column("t", "", "s"), "velocity": Column("v", "", "m/s")}
    values = {"t": stamps, "v": speed}
    if reference is not None:
        columns["reference"], values["r"] = Column("r", "", "m"), reference
    return recorded(values, Axis(columns=columns, **stated))


def test_a_position_that_was_not_recorded_is_the_integral_of_the_speed():
    log = by_speed()
    # Trapezoids of steps of 0.01 s.
    assert log.position.values == pytest.approx(np.sin(2.0 * TIME), abs=2e-4)
    assert log.position.values[1] == pytest.approx(0.5 * DT * (SPEED[0] + SPEED[1]))
    assert (log.position.unit, log.position.column, log.position.step) == (
        "m",
        "v",
        pytest.approx(log.velocity.step * DT),
    )
    assert (
        "the log has no position: bristle integrates the velocity in column v from position 0. The true start is unknown, "
        "and an offset of the velocity makes the position drift. Results that depend on position are meaningless"
    ) in log.notes


def test_an_integrated_position_begins_at_a_recorded_reference():
    log = by_speed(reference=3.0 + POSITION)
    assert log.position.values == pytest.approx(3.0 + np.sin(2.0 * TIME), abs=2e-4)
    assert any("from the first value of the reference" in note for note in log.notes)


def test_an_integrated_position_continues_after_a_gap():
    stamps = TIME + np.where(np.arange(COUNT) >= 250, 7.0, 0.0)
    log = by_speed(stamps, np.full(COUNT, 2.0) + 1e-3 * SPEED)
    assert [(segment.start, segment.stop) for segment in log.segments] == [(0, 250), (250, 400)]
    assert np.diff(log.position.values[249:252]) == pytest.approx([0.0, 2.0 * DT], rel=1e-3)


@pytest.mark.parametrize(
    ("stated", "named"),
    [
        ({"kind": "rotational", "gravity": True}, "on position (gravity) are meaningless"),
        (
            {"kind": "rotational", "cogging": (Cogging("motor", 6.28, (6,)),)},
            "on position (cogging) are meaningless",
        ),
        (
            {"kind": "rotational", "gravity": True, "cogging": (Cogging("motor", 6.28, (6,)),)},
            "on position (gravity and cogging) are",
        ),
        ({"kind": "rotational"}, "on position are meaningless"),
    ],
)
def test_terms_of_the_position_are_meaningless_without_a_position(stated, named):
    columns = {"time": Column("t", "", "s"), "velocity": Column("v", "", "rad/s")}
    log = recorded({"t": TIME, "v": SPEED}, Axis(columns=columns, **stated))
    assert named in log.notes[-1]


@pytest.mark.parametrize(
    ("limit", "is_doubted"), [(1.0, True), (1.9, True), (1.96, False), (None, False)]
)
def test_a_unit_is_doubted_where_the_axis_moves_faster_than_its_limit_and_noise(limit, is_doubted):
    log = recorded({"q": POSITION, "u": EFFORT}, of_file=DT, velocity_limit=limit)
    # Over 20 samples the fastest speed of this sine is 1.98 m/s, and two hundredths beyond a limit are noise.
    assert any("faster than its limit of" in note for note in log.notes) is is_doubted


@pytest.mark.parametrize(
    ("jitter", "late", "is_told"), [(0.05, 0.0, False), (0.05, 0.3, True), (0.2, 0.0, True)]
)
def test_jitter_above_a_tenth_of_the_sample_time_is_a_warning(jitter, late, is_told):
    noise = np.random.default_rng(1).uniform(-jitter, jitter, COUNT)
    noise[200] += late
    columns = COLUMNS | {"time": Column("t", "", "s")}
    stamps = TIME + DT * noise
    rough = np.sin(2.0 * TIME) + 0.01 * np.random.default_rng(2).standard_normal(COUNT)
    log = recorded({"t": stamps, "q": rough, "u": EFFORT}, Axis(columns=columns))
    reported = [finding.numbers for finding in log.findings if finding.code == "resampled"]
    assert bool(reported) is is_told
    for numbers in reported:
        assert numbers["sample_time"] == pytest.approx(DT, rel=1e-3)
        assert (
            0.0
            < numbers["percent"]
            <= numbers["largest"]
            == pytest.approx(100.0 * np.max(np.abs(noise)), rel=0.2)
        )
        assert 0.005 < numbers["position_error"] < 0.05  # of its noise
        assert numbers["effort_error"] < 0.4 * numbers["position_error"]


def test_all_channels_of_a_log_and_its_segments_are_cut_to_a_span():
    extra = {
        "load": Column("n", "", "N"),
        "time": Column("t", "", "s"),
        "reference": Column("q", "", "m"),
    }
    stamps = TIME + np.where(np.arange(COUNT) >= 250, 1.0, 0.0)
    values = {
        "t": stamps,
        "q": POSITION,
        "u": EFFORT,
        "n": 1.0 + POSITION,
        "p": EFFORT,
        "k": POSITION,
    }
    axis = Axis(
        columns=COLUMNS | extra, injected=(Injected("p", 2.0),), regressors=(KnownColumn("k", "k"),)
    )
    log = recorded(values, axis)
    part = within(log, (1.0, 4.0))  # samples 100 to 300, for the second segment begins at 3.5 s
    assert [(segment.start, segment.stop) for segment in part.segments] == [(0, 150), (150, 200)]
    whole, kept = (
        [
            *item.injected,
            *item.regressors,
            item.time,
            item.position,
            item.effort,
            item.reference,
            item.load,
        ]
        for item in (log, part)
    )
    np.testing.assert_array_equal(kept, [channel[100:300] for channel in whole])
    assert part.notes == (*log.notes, "bristle uses only the samples from 1 to 4 s")
    assert [(s.start, s.stop) for s in within(log, (3.6, 4.0)).segments] == [(0, 40)]
    assert len(recorded(values, replace(axis, span=(1.0, 4.0)))) == 200


@pytest.mark.parametrize(("end", "is_enough"), [(1.095, True), (1.085, False)])
def test_a_span_holds_ten_samples_at_least(end, is_enough):
    log = recorded({"q": POSITION, "u": EFFORT}, of_file=DT)
    words = r"contains fewer than 10 samples of the log; found '0\.995 to 1\.085 s', allowed within 0 to 3\.99 s"
    with nullcontext() if is_enough else pytest.raises(InputError, match=words):
        assert len(within(log, (0.995, end))) == 10
