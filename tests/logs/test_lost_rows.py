"""Rows that a recorder lost, and stamps that a host repeats: no row is dropped, no clock runs otherwise."""

import numpy as np
import pytest

from bristle.logs.clock import clock_of

DT, COUNT = 1e-3, 12_000
TIME = DT * np.arange(COUNT)


def place(t):
    return 0.02 * np.sin(3.0 * t) + 0.004 * np.sin(17.0 * t)


def kept(seed, share):
    keep = np.random.default_rng(seed).random(COUNT) > share
    keep[[0, -1]] = True
    return keep


def burst(seed, jitter=0.0, share=0.02):
    """Return stamps of a host: late by chance, and those of a burst all as it arrives."""
    rng, k = np.random.default_rng(seed), 0
    stamps = TIME + jitter * DT * rng.standard_normal(COUNT)
    while k < COUNT - 5:
        count = int(rng.integers(2, 5)) if rng.random() < share else 1
        if count > 1:
            stamps[k : k + count] = TIME[k + count - 1] + 0.1 * DT * rng.random()
        k += count
    return np.maximum.accumulate(np.round(stamps, 6))


def result(stamps, x):
    return clock_of(stamps, "log.csv", position=x, repeats=np.append(False, np.diff(x) == 0.0))


@pytest.mark.parametrize("jitter", [0.0, 0.12])
@pytest.mark.parametrize("share", [0.002, 0.02])
def test_stamps_of_a_host_in_bursts_lose_no_row_and_keep_the_clock(jitter, share):
    keep, stamps = kept(3, share), burst(4, jitter)
    clock = result(stamps[keep], place(TIME[keep]))
    assert len(clock.segments) == 1
    assert clock.stamps.size == keep.sum()
    # 1.2e-3 off where such rows were dropped
    assert clock.sample_time == pytest.approx(DT, rel=2e-4)
    shifts = np.linspace(-0.5 * DT, 0.5 * DT, 101)
    error = min(
        np.sqrt(np.mean((clock.sampled(place(TIME[keep])) - place(clock.time + shift)) ** 2))
        for shift in shifts
    )
    assert error < 2e-5


LATE = DT * np.array([7.7, 7.2, 6.4, 5.7, 4.9, 4.1, 3.3, 2.6, 1.8, 1.0, 0.8, 0.5, 0.2])


@pytest.mark.parametrize(
    ("rows", "late"),
    [([700, 2500, 2501], DT * np.array([0.9, 1.9, 0.95])), (np.arange(5000, 5013), LATE)],
)
def test_late_rows_are_no_lost_rows(rows, late):
    stamps = TIME.copy()
    stamps[rows] += late
    clock = result(stamps, place(TIME))
    assert clock.sample_time == pytest.approx(DT, rel=1e-9)
    assert clock.time.size == COUNT
    assert not any("missing" in note for note in clock.notes)


def test_a_stretch_that_was_sampled_half_as_often_is_bridged():
    stamps = np.delete(TIME, 401 + 2 * np.arange(180))
    clock = result(stamps, place(stamps))
    assert clock.notes == ("180 rows are missing, at most 3 consecutively: bristle interpolates",)
    np.testing.assert_allclose(clock.sampled(place(stamps)), place(TIME), atol=2e-9)


def test_even_samples_behind_a_step_of_their_clock_are_not_interpolated():
    stamps = np.delete(TIME, 600)
    stamps[600:] -= 0.1 * DT
    clock = result(stamps, place(stamps))
    assert clock.uniform
    assert [segment.stop - segment.start for segment in clock.segments] == [600, COUNT - 601]
    np.testing.assert_array_equal(clock.sampled(place(stamps)), place(stamps))


@pytest.mark.parametrize("equal", [2, 10])
def test_a_time_whose_stamps_repeat_is_the_time_of_a_proposal(tmp_path, equal):
    from bristle.logs.readers import read_table
    from bristle.logs.roles import roles_of

    t = 1e-3 * np.arange(2000)
    stamps = t[::equal].repeat(equal)[: t.size]
    path = tmp_path / "host.csv"
    np.savetxt(
        path,
        np.column_stack([stamps, place(t), np.sin(3 * t)]),
        delimiter=",",
        comments="",
        header="time [s],position [m],force [N]",
    )
    assert roles_of(read_table(path)).channels["time"].column == "time"
