"""An effort between its samples, and records that repeat themselves."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from bristle.core import Axis
from bristle.core.errors import InputError
from bristle.core.status import Status
from bristle.logs.log import Channel, Log
from bristle.models.friction import viscous
from bristle.models.plants import inertia, oscillator
from bristle.simulation.recorded.open_loop import closes, finer, open_loop_of, period_of

pytestmark = pytest.mark.usefixtures("in_plain_python")

RATE, SIZE = 750.0, 1500


def multisine(t: np.ndarray, seed: int = 0) -> np.ndarray:
    """Whole periods of 2 s, from 5 to 150 Hz."""
    lines = np.arange(10, 300)
    phases = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, lines.size)
    return np.cos(np.pi * np.outer(t, lines) + phases).sum(axis=1)


def sweep(t: np.ndarray) -> np.ndarray:
    return np.sin(2.0 * np.pi * (20.0 * t + 5.0 * t * t))


SAMPLES = np.arange(SIZE) / RATE
BETWEEN = np.arange(4 * SIZE) / (4.0 * RATE)


def test_whole_periods_without_high_content_are_known_between_their_samples():
    np.testing.assert_allclose(
        finer(multisine(SAMPLES), 4, periodic=True), multisine(BETWEEN), atol=1e-9
    )


def test_a_record_that_does_not_repeat_is_known_but_for_its_ends():
    error = np.abs(finer(sweep(SAMPLES), 4, periodic=False) - sweep(BETWEEN))[:-3]
    assert np.max(error[400:-400]) < 1e-5
    assert np.max(error) < 5e-3
    # What rings where the ends are taken for neighbours.
    ringing = np.abs(finer(sweep(SAMPLES), 4, periodic=True) - sweep(BETWEEN))[:-3]
    assert np.max(ringing) > 3.0 * np.max(error)
    assert np.max(ringing[400:-400]) > 10.0 * np.max(error[400:-400])


@pytest.mark.parametrize("count", [2, 3, 5])
def test_equal_periods_are_found(count):
    t = np.arange(count * SIZE) / RATE
    assert period_of(np.tile(multisine(SAMPLES), count)) == SIZE
    assert period_of(multisine(t) + 1e-3 * np.random.default_rng(1).normal(size=t.size)) is None
    assert period_of(sweep(t)) is None


@pytest.mark.fast_cases(4)
@pytest.mark.parametrize("seed", range(20))
def test_one_period_closes_and_a_part_of_one_does_not(seed):
    period = multisine(SAMPLES, seed)
    start = 37 * seed
    assert closes(np.roll(period, start))
    assert not closes(np.roll(period, start)[: SIZE - 211])
    assert not closes(sweep(SAMPLES[: SIZE - seed]))


def record(effort, position=None):
    time = 1e-2 * np.arange(len(effort))
    position = np.zeros(time.size) if position is None else position
    channels = {
        "time": Channel(time, "s", "t"),
        "position": Channel(position, "m", "q"),
        "effort": Channel(np.asarray(effort, float), "N", "u"),
    }
    return Log(**channels, sample_time=1e-2, segments=(slice(0, time.size),))


@pytest.mark.parametrize(
    ("hold", "periodic", "fine", "kind"),
    [
        (None, False, [1.0, 1.0, 3.0, 3.0, 2.0, 2.0], "zero"),
        ("linear", False, [1.0, 2.0, 3.0, 2.5, 2.0, 2.0], "linear"),
        ("linear", True, [1.0, 2.0, 3.0, 2.5, 2.0, 1.5], "linear"),
    ],
)
def test_between_samples_an_effort_is_constant_or_linear(hold, periodic, fine, kind):
    loop = open_loop_of(record([1.0, 3.0, 2.0]), Axis(hold=hold, periodic=periodic), slice(0, 3), 2)
    assert loop.effort.tolist() == fine
    assert (loop.steps, loop.sample_time, loop.count, loop.periodic, loop.hold) == (
        2,
        1e-2,
        3,
        periodic,
        kind,
    )


def test_a_band_limited_effort_passes_through_its_samples():
    values = np.sin(0.3 * np.arange(40))
    for periodic in (False, True):
        loop = open_loop_of(
            record(values), Axis(hold="band_limited", periodic=periodic), slice(0, 40), 4
        )
        assert loop.effort[::4] == pytest.approx(values)
        assert (loop.hold, loop.effort.size) == ("linear", 160)


def test_a_record_of_equal_periods_is_reduced_to_a_period():
    period = np.array([1.0, -2.0, 3.0, 0.5, -1.0])
    loop = open_loop_of(record(np.tile(period, 4)), Axis(), slice(0, 20), 2)
    assert (loop.periodic, loop.count) == (True, 20)
    assert loop.effort.tolist() == np.repeat(period, 2).tolist()
    told_otherwise = open_loop_of(record(np.tile(period, 4)), Axis(periodic=False), slice(0, 20), 2)
    assert (told_otherwise.periodic, told_otherwise.effort.size) == (False, 40)


def test_a_record_whose_effort_and_position_close_is_a_period():
    wave = multisine(SAMPLES)
    for position, periodic in ((wave, True), (sweep(SAMPLES), False)):
        assert open_loop_of(record(wave, position), Axis(), slice(0, SIZE)).periodic is periodic
    assert open_loop_of(record(sweep(SAMPLES), wave), Axis(), slice(0, SIZE)).periodic is False


PLANT, FILM = inertia(M=2.0), viscous(F_v=50.0)


def test_a_motion_from_rest_has_a_position_at_each_sample():
    loop, t = (
        open_loop_of(record(np.full(30, 10.0)), Axis(periodic=False), slice(0, 30)),
        1e-2 * np.arange(30),
    )
    position, status = loop.position(PLANT, FILM)
    # 2 v' = 10 - 50 v
    assert position == pytest.approx(0.2 * (t - 0.04 * (1.0 - np.exp(-25.0 * t))), abs=1e-5)
    assert loop.position(PLANT, FILM, np.full(30, 4.0))[0] == pytest.approx(0.6 * position)
    assert status is Status.OK


@pytest.mark.parametrize(
    ("effort", "axis", "steps", "known"),
    [
        (np.full(30, 1e120), Axis(periodic=False), (), 1),
        (np.tile([1e120, -1e120], 15), Axis(), (2,), 0),
    ],
)
def test_a_motion_that_is_lost_has_no_position_from_there_on_or_as_a_whole_if_it_repeats(
    effort, axis, steps, known
):
    position, status = open_loop_of(record(effort), axis, slice(0, 30), *steps).position(
        PLANT, FILM
    )
    assert (status, position.size) == (Status.NOT_FINITE, 30)
    assert np.flatnonzero(np.isfinite(position)).tolist() == list(range(known))


def test_a_motion_that_repeats_is_run_until_it_does():
    wave = 10.0 * np.sin(2.0 * np.pi * np.arange(10) / 10.0)
    # On a spring: the start is forgotten.
    spring = oscillator(M=2.0, c=0.0, k=400.0)
    loop = open_loop_of(record(np.tile(wave, 3)), Axis(), slice(0, 30), 4)
    position, status = loop.position(spring, FILM)
    assert (loop.effort.size, position.size, status) == (40, 30, Status.OK)
    assert position[10:20] == pytest.approx(position[:10])
    omega = 20.0 * np.pi
    amplitude = 10.0 / abs(400.0 - 2.0 * omega**2 + 50.0j * omega)
    assert np.ptp(position[:10]) == pytest.approx(2.0 * amplitude, rel=0.1)
    assert abs(np.mean(position[:10])) < 0.1 * amplitude


@pytest.mark.parametrize(
    ("settles_after", "leads"), [(0, [1]), (1, [1, 2]), (3, [1, 2, 4]), (99, [1, 2, 4, 8, 16])]
)
def test_a_motion_is_run_in_for_twice_as_many_periods_until_it_repeats_and_sixteen_at_most(
    monkeypatch, settles_after, leads
):
    requested, period = [], np.array([0.0, 1.0, 0.0, -1.0])

    def run(plant, friction, effort, dt, *, hold):
        assert np.array_equal(effort[4:], effort[:-4])
        requested.append((effort.size - 1) // 4 - 1)
        periods = np.arange(effort.size) // 4
        position = np.tile(period, effort.size)[: effort.size] + np.where(
            periods > settles_after, 0.0, 1e-5 * periods
        )
        return SimpleNamespace(position=position, status=Status.OK)

    monkeypatch.setitem(open_loop_of.__globals__, "run_open_loop", run)
    position, _ = open_loop_of(
        record(np.tile([1.0, 3.0, 2.0, -4.0], 3)), Axis(), slice(0, 12), 1
    ).position(PLANT, FILM)
    assert requested == leads
    assert position == pytest.approx(np.tile(period, 3), abs=2e-4)


@pytest.mark.parametrize("size", [8, 10, 12, 13])
def test_an_offset_of_a_record_does_not_change_its_period(size):
    values = np.tile([1.0, -2.0, 3.0, 0.5], 4)[:size]
    assert period_of(values + 1e4) == period_of(values) == (4 if size % 4 == 0 else None)


@pytest.mark.parametrize(
    ("effort", "size"),
    [
        (np.full(100, 3.0), None),  # a constant
        ([1.0, 2.0, 1.0], None),
        ([1.0, 1.0, 1.0, 1.0], None),
        ([1.0, 2.0, 3.0, 4.0, 5.0], None),
        ([1.0, 2.0, 1.0, 2.0], 2),  # the shortest
        ([1.0, 2.0, 5.0, 1.0, 2.0, 5.0], 3),  # the longest, half of the record
        ([1.0, 2.0, 5.0, 1.0, 2.0, 5.0 + 1e-6], None),
        ([1.0, 2.0, 5.0, 1.0, 2.0, 5.0 + 1e-9], 3),
    ],
)
def test_a_period_is_found_if_it_repeats(effort, size):
    assert period_of(np.array(effort)) == size


WAVE = np.sin(2.0 * np.pi * np.arange(200) / 50.0)


@pytest.mark.parametrize(
    ("record", "does"),
    [
        (WAVE, True),
        (WAVE[:192], False),
        (np.sin(2.0 * np.pi * np.arange(191) / 191.0), False),
        (np.sin(2.0 * np.pi * np.arange(192) / 192.0), True),
        (np.ones(400), False),
    ],
)
def test_a_record_that_is_short_or_still_does_not_close(record, does):
    assert bool(closes(record)) is does


def test_an_open_loop_needs_a_recorded_effort():
    with pytest.raises(InputError, match="log: has no effort to apply"):
        open_loop_of(replace(record([1.0, 2.0, 3.0]), effort=None), Axis(), slice(0, 3))


@pytest.mark.parametrize(
    ("effort", "axis", "periods"),
    [
        (np.arange(9.0), Axis(periodic=False), {}),
        (np.tile([1.0, -2.0, 3.0, 0.5], 4), Axis(), {"periods": 4.0}),
    ],
)
def test_the_initial_condition_is_reported(effort, axis, periods):
    diagnostic = open_loop_of(record(effort), axis, slice(0, len(effort))).diagnostic
    assert dict(diagnostic.numbers) == periods
    assert periods or diagnostic.code == "start_of_contact"
