"""Stamps of a log become an even grid: order, bursts, lost rows, gaps, delays."""

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.logs.clock import Order, clock_of, median_step, order_of, samples_between, without_repeats

EVEN = 0.01 * np.arange(200)
REPEATED = "1 time stamp repeats the previous time stamp: bristle interpolates between the neighbouring time stamps"


def grid_of(stamps, **passed):
    return clock_of(np.asarray(stamps), "log.csv", **passed)


def test_the_usual_step_is_neither_that_of_jitter_nor_of_rounding():
    rng = np.random.default_rng(1)
    assert median_step(EVEN + 2e-3 * rng.standard_normal(200)) == pytest.approx(0.01, rel=0.03)
    assert median_step(np.round(0.0013 * np.arange(2000), 3)) == pytest.approx(0.0013, rel=0.05)
    assert median_step(np.array([0.0, 0.5])) == 0.5
    assert median_step(np.append(EVEN, 100.0)) == pytest.approx(0.01)


def test_ordered_rows_stay_and_newest_first_rows_are_reversed():
    assert order_of(EVEN, "log").rows is None
    turned = order_of(EVEN[::-1], "log")
    assert turned.rows.tolist() == list(range(199, -1, -1))
    assert turned.stamps.tolist() == EVEN.tolist()
    assert "bristle reversed the rows" in turned.notes[0]
    with pytest.raises(InputError, match="does not advance: all its values are 3 s"):
        order_of(np.full(9, 3.0), "log")


def test_a_row_out_of_place_is_sorted_and_no_order_is_refused():
    swapped = EVEN.copy()
    swapped[[50, 51]] = swapped[[51, 50]]
    order = order_of(swapped, "log")
    assert order.stamps.tolist() == EVEN.tolist()
    assert order.rows[49:53].tolist() == [49, 51, 50, 52]
    assert order.notes == ("1 row was out of order: bristle sorted the rows by time",)
    swapped[[80, 81]] = swapped[[81, 80]]
    assert order_of(swapped, "log").notes == ("2 rows were out of order: bristle sorted the rows by time",)
    with pytest.raises(InputError, match=r"is not in order: \d+ of its 199 steps go backward"):
        order_of(np.random.default_rng(1).permutation(EVEN), "log")


def test_a_restarted_clock_adds_a_pause_of_ten_samples():
    twice = np.concatenate([EVEN, EVEN[:100], EVEN[:100]])
    order = order_of(twice, "log")
    assert np.all(np.diff(order.stamps) > 0.0)
    assert order.stamps[200] - order.stamps[199] == pytest.approx(0.1)
    assert order.stamps[300] - order.stamps[299] == pytest.approx(0.1)
    assert order.notes == ("the clock restarts at row 200, 300: bristle reads the log as 3 consecutive recordings",)
    assert len(grid_of(twice).segments) == 3


def test_rows_that_repeat_all_are_left_out_and_stamps_that_repeat_lie_between():
    stamps = np.delete(np.insert(EVEN, 50, EVEN[49]), 51)
    assert stamps[49] == stamps[50]
    whole = np.zeros(stamps.size, dtype=bool)
    whole[50] = True
    left_out = without_repeats(Order(None, stamps), whole, 10, "log")
    assert left_out.stamps.size == stamps.size - 1
    assert 50 not in left_out.rows
    assert left_out.notes == ("1 row repeats the previous row: bristle uses each row once",)
    mended = without_repeats(Order(None, stamps), np.zeros(stamps.size, dtype=bool), 10, "log")
    assert mended.rows is None
    assert mended.stamps == pytest.approx(EVEN)
    assert mended.notes == (REPEATED,)
    untouched = Order(None, EVEN)
    assert without_repeats(untouched, None, 10, "log") is untouched
    with pytest.raises(InputError, match="has only 4 different time stamps in 12 rows"):
        without_repeats(Order(None, np.repeat(np.arange(4.0), 3)), None, 5, "log")


def test_a_burst_lies_on_the_side_where_time_is_left():
    early = EVEN.copy()
    early[20:24] = early[20]  # stamped as the first of four, the time behind it is free
    mended = without_repeats(Order(None, early), np.zeros(200, dtype=bool), 10, "log")
    assert mended.stamps == pytest.approx(EVEN)
    late = EVEN.copy()
    late[20:24] = late[23]
    assert without_repeats(Order(None, late), np.zeros(200, dtype=bool), 10, "log").stamps == pytest.approx(EVEN)
    last = EVEN.copy()
    last[-3:] = last[-1]
    assert without_repeats(Order(None, last), np.zeros(200, dtype=bool), 10, "log").stamps == pytest.approx(EVEN)
    first = EVEN.copy()
    first[:3] = first[0]
    spread = without_repeats(Order(None, first), np.zeros(200, dtype=bool), 10, "log").stamps
    assert spread[:4] == pytest.approx([-0.02, -0.01, 0.0, 0.03], abs=1e-9)  # it arrived where time is left on both sides


@pytest.mark.parametrize("lost", [1, 2, 3])
def test_up_to_three_rows_that_were_lost_on_end_are_bridged(lost):
    stamps = np.delete(EVEN, np.arange(80, 80 + lost))
    gaps, counts, notes = samples_between(stamps, 0.01)
    assert not gaps.any()
    assert counts[79] == 1.0 + lost
    assert counts.sum() == 199.0
    rows = "1 row is" if lost == 1 else f"{lost} rows are"
    assert notes == [f"{rows} missing, at most 3 consecutively: bristle interpolates"]
    clock = grid_of(stamps)
    assert clock.time == pytest.approx(EVEN)
    assert not clock.uniform
    assert clock.sampled(np.sin(stamps)) == pytest.approx(np.sin(EVEN), abs=1e-6)


def test_more_rows_that_were_lost_are_a_gap():
    stamps = np.delete(EVEN, np.arange(80, 84))
    gaps, counts, notes = samples_between(stamps, 0.01)
    assert np.flatnonzero(gaps).tolist() == [79]
    assert (counts[79], notes) == (1.0, [])
    clock = grid_of(stamps)
    assert clock.segments == (slice(0, 80), slice(80, 196))
    assert "1 gap in the time stamps (after 0.79 s): bristle splits the log into 2 segments" in clock.notes
    assert clock.time[80] == pytest.approx(0.84)
    short = np.delete(EVEN, [*range(80, 90), *range(95, 110)])
    clock = grid_of(short)
    assert len(clock.segments) == 2
    assert "bristle ignores 5 samples in segments shorter than 10 samples" in clock.notes


def test_a_late_row_moves_itself_alone_and_a_pause_of_no_whole_sample_is_a_gap():
    late = EVEN.copy()
    late[60] += 0.006
    gaps, counts, notes = samples_between(late, 0.01)
    assert (gaps.any(), counts.max(), notes) == (False, 1.0, [])
    paused = EVEN.copy()
    paused[100:] += 0.025
    assert np.flatnonzero(samples_between(paused, 0.01)[0]).tolist() == [99]


@pytest.mark.parametrize(("delay", "first", "count"), [(0.0, 0.0, 200), (0.03, 0.0, 197), (-0.03, 0.03, 197), (0.025, 0.0, 197)])
def test_the_grid_lies_where_an_effort_that_is_late_was_recorded_too(delay, first, count):
    clock = grid_of(EVEN, delay=delay)
    assert clock.time.size == count
    assert clock.time[0] == pytest.approx(first)
    assert clock.sampled(EVEN, delay) == pytest.approx(clock.time + delay, abs=1e-9)
    assert clock.sampled(3.0 * EVEN) == pytest.approx(3.0 * clock.time, abs=1e-9)


def test_a_grid_needs_a_delay_shorter_than_the_log():
    with pytest.raises(InputError, match=r"has fewer than 10 evenly spaced samples in sequence after a shift by the delay of 1\.95 s"):
        grid_of(EVEN, delay=1.95)


def test_the_sample_time_of_the_axis_file_is_that_of_the_stamps():
    assert grid_of(EVEN, sample_time=0.01).sample_time == pytest.approx(0.01)
    assert grid_of(EVEN, sample_time=0.01005).sample_time == pytest.approx(0.01)
    with pytest.raises(InputError, match=r"has a time step of 0\.01 s, unlike sample_time in the axis file"):
        grid_of(EVEN, sample_time=0.0102)
    for factor in (1e-11, 1e12):
        with pytest.raises(InputError, match="Correct the unit of the time column"):
            grid_of(factor * EVEN)


def test_rounded_stamps_belong_to_even_samples():
    clock = grid_of(np.round(0.0013 * np.arange(4000), 3))
    assert clock.sample_time == pytest.approx(0.0013, rel=1e-3)
    assert any("time stamps are rounded to 0.001 s" in note for note in clock.notes)
    assert clock.uniform


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


@pytest.mark.parametrize(
    ("back", "said"), [(20, "1 row was out of order"), (31, "1 row was out of order"), (32, "restarts"), (60, "restarts")]
)
def test_a_clock_that_does_not_recover_within_32_rows_restarted(back, said):
    twice = np.concatenate([EVEN[:100], EVEN[100 - back : 100] - 0.004, EVEN[100:]])
    (note,) = order_of(twice, "log").notes
    assert said in note


@pytest.mark.parametrize(("count", "is_order"), [(51, True), (52, False)])
def test_a_clock_may_restart_fifty_times(count, is_order):
    stamps = np.tile(EVEN[:40], count)
    if is_order:
        assert f"as {count} consecutive recordings" in order_of(stamps, "log").notes[0]
    else:
        with pytest.raises(InputError, match="is not in order: 51 of its"):
            order_of(stamps, "log")


@pytest.mark.parametrize(("share", "is_order"), [(0.24, True), (0.26, False)])
def test_a_quarter_of_the_rows_may_be_out_of_order(share, is_order):
    stamps = EVEN.copy()
    for first in range(0, round(2 * share * 199), 2):
        stamps[[first, first + 1]] = stamps[[first + 1, first]]
    if is_order:
        assert order_of(stamps, "log").stamps.tolist() == EVEN.tolist()
    else:
        with pytest.raises(InputError, match="is not in order"):
            order_of(stamps, "log")


@pytest.mark.parametrize(("lost", "is_bridged"), [(18, True), (19, False)])
def test_rows_are_bridged_where_a_tenth_is_missing_at_most(lost, is_bridged):
    stamps = np.delete(EVEN, 5 + 8 * np.arange(lost))
    gaps, counts, _ = samples_between(stamps, 0.01)
    assert np.count_nonzero(counts > 1.0) == (lost if is_bridged else 0)
    assert np.count_nonzero(gaps) == (0 if is_bridged else lost)


def test_the_minimum_count_of_different_stamps_suffices():
    few = Order(None, np.repeat(np.arange(4.0), 3))
    assert without_repeats(few, np.zeros(12, dtype=bool), 4, "log").stamps.size == 12
    with pytest.raises(InputError, match="has only 4 different time stamps"):
        without_repeats(few, np.zeros(12, dtype=bool), 5, "log")
