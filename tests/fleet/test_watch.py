"""The watch: alarms in time, rarely for nothing, with onset and size; the temperature is no change."""

import numpy as np
import pytest
from benchmarks.lives import lived
from benchmarks.watch import RATE, false_alarms, first_alarm, in_time, verdicts_on
from tests.fleet.conftest import AXIS, OPTIONS, write_log

from bristle.core.errors import InputError
from bristle.fleet import identify_each, watch
from bristle.fleet.false_alarms import FalseAlarms
from bristle.fleet.tracks import Track
from bristle.fleet.watched import verdict_on

DAYS = 120


def track(values, temperature=None, std=None):
    count = len(values)
    return Track(
        "x",
        "friction.F_C",
        "N",
        20000.0 + np.arange(count),
        np.asarray(values),
        np.full(count, 0.05) if std is None else std,
        temperature,
        True,
    )


def level(seed, temperature=None, count=DAYS):
    values = 5.0 + 0.05 * np.random.default_rng(seed).standard_normal(count)
    return values if temperature is None else values - 0.02 * (temperature - 293.0)


def season(count=DAYS):
    return 293.0 + 8.0 * np.sin(np.arange(count) / 20.0)


def test_a_drift_is_told_with_onset_and_size():
    values = level(1)
    values[60:] += 0.01 * np.arange(1, 61)
    alarm = verdict_on(track(values), RATE).alarm
    assert alarm.course == "drift"
    assert 20060.0 < alarm.at < 20085.0
    assert alarm.onset_interval[0] <= 20060.0 <= alarm.onset_interval[1]
    assert alarm.onset_interval[1] - alarm.onset_interval[0] < 30.0
    assert alarm.change_interval[0] < 0.6 < alarm.change_interval[1]
    assert alarm.change_interval[1] - alarm.change_interval[0] < 0.1
    assert alarm.change_percent == pytest.approx(12.0, abs=1.5)


def test_a_step_is_told_with_onset_and_size():
    values = level(2)
    values[60:] -= 0.2
    alarm = verdict_on(track(values), RATE).alarm
    assert alarm.course == "step"
    assert alarm.at <= 20066.0
    assert alarm.onset == 20060.0
    assert alarm.change_interval[0] < -0.2 < alarm.change_interval[1]


def test_the_temperature_is_no_change_and_its_coefficient_is_found_beside_one():
    warm = season()
    assert verdict_on(track(level(3, warm), warm), RATE).alarm is None
    assert verdict_on(track(level(3, warm)), RATE).alarm is not None
    values = level(3, warm)
    values[70:] += 0.2
    verdict = verdict_on(track(values, warm), RATE)
    assert verdict.alarm.onset == pytest.approx(20070.0, abs=1.0)
    low, high = verdict.temperature_interval
    assert low < -0.02 < high
    assert high - low < 0.01
    assert np.std(verdict.level[:70]) < 0.06 < np.std(values[:70])


def test_one_log_that_went_wrong_is_no_change():
    values = level(4)
    values[[50, 80]] += 5.0
    assert verdict_on(track(values), RATE).alarm is None


def test_days_with_wide_intervals_count_less():
    values, std = level(5), np.full(DAYS, 0.05)
    values[60:] += np.where(np.arange(60) % 2, 0.0, 0.2)
    std[60::2] = 1.0
    assert verdict_on(track(values), RATE).alarm is not None
    assert verdict_on(track(values, std=std), RATE).alarm is None


def test_neighbours_that_are_alike_are_told():
    rng = np.random.default_rng(6)
    values = np.zeros(DAYS)
    for i in range(1, DAYS):
        values[i] = 0.7 * values[i - 1] + rng.standard_normal()
    assert verdict_on(track(values), FalseAlarms(1.0, 1e4, "days")).alike == pytest.approx(0.7, abs=0.2)
    assert verdict_on(track(level(7)), RATE).alike is None


def test_lives_that_wear_alarm_before_a_third_of_it(errors):
    assert sum(in_time(seed, errors) for seed in range(5)) >= 4


def test_healthy_lives_hardly_ever_do(errors):
    alarms, days = false_alarms(range(1000, 1006), errors)
    assert days > 1000.0
    assert alarms <= 4  # of one in a thousand days: more than six in a hundred such tests would be a lie


def test_every_quantity_of_an_axis_has_its_share_of_the_rate(errors):
    verdicts = verdicts_on({"a": lived(3, 60)}, errors, 3)["a"]
    assert [verdict.track.quantity for verdict in verdicts] == ["friction.F_C", "friction.F_v", "scatter"]
    alone = verdict_on(verdicts[0].track, RATE)
    assert verdicts[0].threshold > alone.threshold
    assert first_alarm(verdicts) is None


@pytest.fixture(scope="module")
def fleet(tmp_path_factory):
    """Two axes, a log a day for sixteen days; one of them rises by four parts in a hundred from the twelfth on."""
    folder = tmp_path_factory.mktemp("fleet")
    for name in ("steady", "worn"):
        for day in range(1, 19):
            rng = np.random.default_rng((day, name == "worn"))
            warm = 293.0 + 4.0 * rng.standard_normal()
            wear = 1.15 if name == "worn" and day >= 12 else 1.0
            size = 5.0 * wear * (1.0 - 0.004 * (warm - 293.0)) * (1.0 + 0.01 * rng.standard_normal())
            write_log(folder / "logs" / name / f"2026-03-{day:02d}.csv", size, temperature=warm, seed=day, rows=1500)
    identify_each([folder / "logs"], folder / "out", axis=AXIS, workers=1, **OPTIONS)
    return folder / "out"


def test_from_logs_to_an_alarm(fleet):
    watched = watch(fleet)
    (verdict,) = [verdict for verdict in watched.alarms if verdict.track.quantity == "friction.F_C"]
    assert verdict.track.axis == "worn"
    assert np.datetime64(int(verdict.alarm.onset), "D") == np.datetime64("2026-03-12")
    assert verdict.alarm.change_percent == pytest.approx(15.0, abs=3.0)
    assert verdict.temperature_interval[0] < -0.02 < verdict.temperature_interval[1]
    assert {verdict.track.axis for verdict in watch(fleet.parent).alarms} == {"worn"}  # the folder that holds it
    assert watch(fleet, since=86400.0 * 20524.0).alarms == ()  # the twelfth of March


def test_a_rate_in_days_needs_logs_that_say_when(fleet):
    pattern = "(?P<axis>steady|worn)/"
    assert watch(fleet, axis_from=pattern).rows.time is not None
    with pytest.raises(InputError, match="is no rate"):
        watch(fleet, false_alarms="now and then")
