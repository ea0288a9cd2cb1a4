"""Stamps of a log become an even grid: order, bursts, lost rows, gaps, delays."""

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.logs.clock import (
    EVERY,
    Order,
    clock_of,
    median_step,
    order_of,
    samples_between,
    without_repeats,
)

EVEN = 0.01 * np.arange(200)
REPEATED = "1 time stamp repeats the previous time stamp: bristle interpolates between the neighbouring time stamps"


def grid_of(stamps, **passed):
    return clock_of(np.asarray(stamps), "log.csv", **passed)


@pytest.mark.parametrize(
    ("stamps", "step"),
    [
        (
            EVEN + 2e-3 * np.random.default_rng(1).standard_normal(200),
            pytest.approx(0.01, rel=0.03),
        ),
        (np.round(0.0013 * np.arange(2000), 3), pytest.approx(0.0013, rel=0.05)),
        (np.array([0.0, 0.5]), 0.5),
        (np.append(EVEN, 100.0), pytest.approx(0.01)),
    ],
)
def test_the_usual_step_is_neither_that_of_jitter_nor_of_rounding(stamps, step):
    assert median_step(stamps) == step


def with_exchanged(*places):
    """Stamps of which some have changed places with the next one."""
    rows = np.arange(200)
    for place in places:
        rows[[place, place + 1]] = [place + 1, place]
    return EVEN[rows]


def fallen_back(rows):
    """Stamps of which the clock falls back by so many rows, and then goes on."""
    return np.concatenate([EVEN[:100], EVEN[100 - rows : 100] - 0.004, EVEN[100:]])


@pytest.mark.parametrize(
    ("stamps", "note"),
    [
        (EVEN[::-1], "bristle reversed the rows"),
        (with_exchanged(50), "1 row was out of order: bristle sorted the rows by time"),
        (with_exchanged(50, 80), "2 rows were out of order: bristle sorted the rows by time"),
        (with_exchanged(*range(0, 96, 2)), "48 rows were out of order"),  # less than a quarter
    ],
)
def test_rows_out_of_order_are_sorted_with_a_note(stamps, note):
    order = order_of(stamps, "log")
    assert order.stamps.tolist() == stamps[order.rows].tolist() == EVEN.tolist()
    assert note in order.notes[0]
    assert order_of(EVEN, "log").rows is EVERY


@pytest.mark.parametrize(
    ("stamps", "note"),
    [
        # A clock that does not recover within 32 rows began anew.
        (fallen_back(20), "1 row was out of order"),
        (fallen_back(31), "1 row was out of order"),
        (fallen_back(32), "restarts"),
        (fallen_back(60), "restarts"),
        (np.tile(EVEN[:40], 51), "as 51 consecutive recordings"),
    ],
)
def test_a_clock_that_falls_back_began_anew_or_had_a_row_out_of_order(stamps, note):
    assert note in order_of(stamps, "log").notes[0]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: order_of(np.full(9, 3.0), "log"), "does not advance: all its values are 3 s"),
        (
            lambda: order_of(np.random.default_rng(1).permutation(EVEN), "log"),
            r"is not in order: \d+ of its 199 steps go backward",
        ),
        # More than a quarter.
        (lambda: order_of(with_exchanged(*range(0, 104, 2)), "log"), "is not in order"),
        (lambda: order_of(np.tile(EVEN[:40], 52), "log"), "is not in order: 51 of its"),
        (
            lambda: without_repeats(Order(EVERY, np.repeat(np.arange(4.0), 3)), None, 5, "log"),
            "has only 4 different time stamps in 12 rows",
        ),
        (
            lambda: grid_of(EVEN, delay=1.95),
            r"has fewer than 10 evenly spaced samples in sequence after a shift by the delay of 1\.95 s",
        ),
        (
            lambda: grid_of(EVEN, sample_time=0.0102),
            r"has a time step of 0\.01 s, unlike sample_time in the axis file",
        ),
        (lambda: grid_of(1e-11 * EVEN), "Correct the unit of the time column"),
        (lambda: grid_of(1e12 * EVEN), "Correct the unit of the time column"),
    ],
)
def test_stamps_that_make_no_grid_are_refused(call, words):
    with pytest.raises(InputError, match=words):
        call()


def test_a_restarted_clock_adds_a_pause_of_ten_samples():
    twice = np.concatenate([EVEN, EVEN[:100], EVEN[:100]])
    order = order_of(twice, "log")
    steps = np.diff(order.stamps)
    assert steps[[199, 299]] == pytest.approx(0.1)
    assert np.delete(steps, [199, 299]) == pytest.approx(0.01)
    assert order.notes == (
        "the clock restarts at row 200, 300: bristle reads the log as 3 consecutive recordings",
    )
    assert len(grid_of(twice).segments) == 3


def test_rows_that_repeat_all_are_left_out_and_stamps_that_repeat_lie_between():
    stamps = np.delete(np.insert(EVEN, 50, EVEN[49]), 51)
    left_out = without_repeats(Order(EVERY, stamps), np.arange(stamps.size) == 50, 10, "log")
    assert left_out.rows.tolist() == np.delete(np.arange(stamps.size), 50).tolist()
    assert left_out.notes == ("1 row repeats the previous row: bristle uses each row once",)
    mended = without_repeats(Order(EVERY, stamps), np.zeros(stamps.size, dtype=bool), 10, "log")
    assert (mended.rows.tolist(), mended.notes) == (list(range(EVEN.size)), (REPEATED,))
    assert mended.stamps == pytest.approx(EVEN)
    untouched = Order(EVERY, EVEN)
    assert without_repeats(untouched, None, 10, "log") is untouched
    few = Order(EVERY, np.repeat(np.arange(4.0), 3))
    assert without_repeats(few, np.zeros(12, dtype=bool), 4, "log").stamps.size == 12


@pytest.mark.parametrize(
    ("burst", "arrived", "begin"),
    [
        (slice(20, 24), 20, EVEN[:24]),  # stamped as the first of four, the time behind it is free
        (slice(20, 24), 23, EVEN[:24]),
        (slice(-3, None), -1, EVEN),
        (slice(0, 3), 0, [-0.02, -0.01, 0.0, 0.03]),  # it arrived where time is left on both sides
    ],
)
def test_a_burst_lies_on_the_side_where_time_is_left(burst, arrived, begin):
    stamps = EVEN.copy()
    stamps[burst] = stamps[arrived]
    spread = without_repeats(Order(EVERY, stamps), np.zeros(200, dtype=bool), 10, "log").stamps
    assert spread[: len(begin)] == pytest.approx(begin, abs=1e-9)


@pytest.mark.parametrize("lost", [1, 2, 3])
def test_up_to_three_rows_that_were_lost_on_end_are_bridged(lost):
    stamps = np.delete(EVEN, np.arange(80, 80 + lost))
    gaps, counts, notes = samples_between(stamps, 0.01)
    assert (gaps.any(), counts[79], counts.sum()) == (False, 1.0 + lost, 199.0)
    rows = "1 row is" if lost == 1 else f"{lost} rows are"
    assert notes == [f"{rows} missing, at most 3 consecutively: bristle interpolates"]
    clock = grid_of(stamps)
    assert (clock.time, clock.uniform) == (pytest.approx(EVEN), False)
    assert clock.sampled(np.sin(stamps)) == pytest.approx(np.sin(EVEN), abs=1e-6)


def test_more_rows_that_were_lost_are_a_gap():
    stamps = np.delete(EVEN, np.arange(80, 84))
    gaps, counts, notes = samples_between(stamps, 0.01)
    assert np.flatnonzero(gaps).tolist() == [79]
    assert (counts[79], notes) == (1.0, [])
    clock = grid_of(stamps)
    assert clock.segments == (slice(0, 80), slice(80, 196))
    assert (
        "1 gap in the time stamps (after 0.79 s): bristle splits the log into 2 segments"
        in clock.notes
    )
    assert clock.time[80] == pytest.approx(0.84)
    short = np.delete(EVEN, [*range(80, 90), *range(95, 110)])
    clock = grid_of(short)
    assert len(clock.segments) == 2
    assert "bristle ignores 5 samples in segments shorter than 10 samples" in clock.notes


def test_a_late_row_moves_itself_alone_and_a_pause_of_no_whole_sample_is_a_gap():
    late = EVEN + 0.006 * (np.arange(200) == 60)
    gaps, counts, notes = samples_between(late, 0.01)
    assert (gaps.any(), counts.max(), notes) == (False, 1.0, [])
    paused = EVEN + 0.025 * (np.arange(200) >= 100)
    assert np.flatnonzero(samples_between(paused, 0.01)[0]).tolist() == [99]


@pytest.mark.parametrize(
    ("delay", "first", "count"),
    [(0.0, 0.0, 200), (0.03, 0.0, 197), (-0.03, 0.03, 197), (0.025, 0.0, 197)],
)
def test_the_grid_lies_where_an_effort_that_is_late_was_recorded_too(delay, first, count):
    clock = grid_of(EVEN, delay=delay)
    assert clock.time.size == count
    assert clock.time[0] == pytest.approx(first)
    assert clock.sampled(EVEN, delay) == pytest.approx(clock.time + delay, abs=1e-9)
    assert clock.sampled(3.0 * EVEN) == pytest.approx(3.0 * clock.time, abs=1e-9)


@pytest.mark.parametrize("stated", [0.01, 0.01005])
def test_the_sample_time_of_the_axis_file_is_that_of_the_stamps(stated):
    assert grid_of(EVEN, sample_time=stated).sample_time == pytest.approx(0.01)


def test_rounded_stamps_belong_to_even_samples():
    clock = grid_of(np.round(0.0013 * np.arange(4000), 3))
    assert (clock.sample_time, clock.uniform) == (pytest.approx(0.0013, rel=1e-3), True)
    assert any("time stamps are rounded to 0.001 s" in note for note in clock.notes)


def test_the_error_of_resampling_is_that_of_every_second_sample():
    clock = grid_of(EVEN)
    slow, fast = np.sin(2.0 * np.pi * EVEN), np.sin(2.0 * np.pi * 20.0 * EVEN)
    assert clock.error_of(3.0 * EVEN) == pytest.approx(0.0, abs=1e-9)
    assert clock.error_of(slow) < 1e-4 < 0.05 < clock.error_of(fast)
    assert clock.error_of(2.0 * fast) == pytest.approx(2.0 * clock.error_of(fast))
    noise = np.random.default_rng(1).standard_normal(200)
    assert 1.0 < clock.error_of(noise) < 1.6


def test_rows_are_taken_in_their_order():
    clock = grid_of(EVEN[::-1])
    assert clock.sampled(np.arange(200.0)) == pytest.approx(np.arange(199.0, -1.0, -1.0))
    assert clock.error_of(EVEN[::-1]) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("lost", "is_bridged"), [(18, True), (19, False)])
def test_rows_are_bridged_where_a_tenth_is_missing_at_most(lost, is_bridged):
    stamps = np.delete(EVEN, 5 + 8 * np.arange(lost))
    gaps, counts, _ = samples_between(stamps, 0.01)
    assert np.count_nonzero(counts > 1.0) == (lost if is_bridged else 0)
    assert np.count_nonzero(gaps) == (0 if is_bridged else lost)


@pytest.mark.parametrize(
    ("sample_times", "kept"),
    [((1e-3, 2e-3), 2e-3), ((1e-3, 1e-2, 1e-3), 1e-2), ((1e-2, 1e-3), 1e-2)],
)
def test_a_sample_time_that_changes_is_told_and_the_grid_is_that_of_the_longest_part(
    sample_times, kept
):
    stamps = np.cumsum(np.repeat(sample_times, 400))
    clock = clock_of(stamps, "log.csv")
    assert (clock.sample_time, len(clock.segments)) == (pytest.approx(kept), 1)
    assert (
        f"the sample time changes ({sample_times[0]:g} s until {stamps[399]:.6g} s, {sample_times[1]:g} s until"
        in clock.notes[0]
    )
    np.testing.assert_allclose(
        clock.sampled(np.sin(9.0 * stamps)), np.sin(9.0 * clock.time), atol=2e-3
    )
