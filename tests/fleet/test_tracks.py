"""Tracks: axes by folder or pattern, an observation a day, what is watched unasked, what is left out."""

from types import SimpleNamespace as Some

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.fleet import tracks as module
from bristle.fleet.tracks import DAY, Rows, pattern_of, rows_in, tracks_of

ABOUT = {
    "friction.F_C": {"role": "parameter", "unit": "N", "stands_for": "level"},
    "plant.M": {"role": "parameter", "unit": "kg"},
    "scatter": {"role": "fit", "unit": "", "stands_for": "scatter"},
}


def rows(count=12, axis="x", per_day=2, **columns):
    value = 5.0 + 0.1 * np.arange(count)
    usual = {
        "status": np.full(count, "ok"),
        "friction.F_C": value,
        "friction.F_C.lower": value - 0.196,
        "friction.F_C.upper": value + 0.196,
        "friction.F_C.status": np.full(count, "identified"),
        "plant.M": np.ones(count),
        "plant.M.status": np.full(count, "held"),
        "scatter": np.full(count, 0.02),
        "scatter.lower": np.full(count, 0.015),
        "scatter.upper": np.full(count, 0.03),
        "temperature": np.full(count, np.nan),
    }
    time = DAY * (20000.25 + np.arange(count) // per_day + 0.3 * (np.arange(count) % per_day))
    return Rows((axis,) * count, ("log",) * count, time, usual | columns, ABOUT)


def track(quantity="friction.F_C", **columns):
    return next((track for track in tracks_of(rows(**columns)) if track.quantity == quantity), None)


def test_logs_of_a_day_are_one_observation_weighted_by_their_intervals():
    upper = rows().columns["friction.F_C"] + 0.196
    upper[1] = upper[1] + 0.392  # an interval twice as wide
    found = track(**{"friction.F_C.upper": upper})
    assert found.time.size == 6
    weights = np.array([1.0, 0.25])
    assert found.value[0] == pytest.approx(weights @ [5.0, 5.1] / weights.sum())
    assert found.std[0] == pytest.approx(0.1 / np.sqrt(1.25), rel=1e-4)
    assert found.std[1] == pytest.approx(0.1 / np.sqrt(2.0), rel=1e-4)
    assert np.floor(found.time[0]) == 20000.0


def test_what_is_watched_unasked_is_what_wears():
    assert [found.quantity for found in tracks_of(rows())] == ["friction.F_C", "scatter"]
    assert track("scatter").value == pytest.approx(np.log(0.02))
    assert track("scatter").std[0] == pytest.approx(0.015 / 3.92 / 0.02 / np.sqrt(2.0), rel=1e-3)


def test_a_column_that_is_asked_for_is_watched_and_another_one_refused():
    assert [found.quantity for found in tracks_of(rows(), ["scatter"])] == ["scatter"]
    with pytest.raises(InputError, match=r"is no quantity of this fleet.*Did you mean 'friction.F_C'"):
        tracks_of(rows(), ["friction.F_c"])


def test_failed_and_unidentified_logs_say_nothing():
    status = np.full(12, "ok")
    status[0] = "refused"
    identified = np.full(12, "identified")
    identified[2:4] = "unidentifiable"
    found = track(status=status, **{"friction.F_C.status": identified})
    assert found.time.size == 5
    assert found.value[0] == pytest.approx(5.1)
    identified[:8] = "unidentifiable"
    assert track(**{"friction.F_C.status": identified}) is None


def test_the_temperature_is_taken_along_where_nearly_every_log_has_one():
    warm = 290.0 + np.arange(12.0)
    assert track(temperature=warm).temperature == pytest.approx(290.5 + 2.0 * np.arange(6))
    warm[3] = np.nan
    assert track(temperature=warm).time.size == 6
    warm[5:9] = np.nan
    assert track(temperature=warm).temperature is None
    assert track(temperature=np.full(12, 293.0)).temperature is None


def test_what_came_before_a_date_is_left_out():
    assert track().time.size == 6
    assert tracks_of(rows(count=24), since=DAY * 20005.0)[0].time[0] > 20005.0


def fleet(monkeypatch, logs, folders=None, stamps=None):
    count = len(logs)
    columns = {
        "log": np.array(logs),
        "folder": np.array(folders or ["hall"] * count),
        "time_of_log": np.array(stamps or ["NaT"] * count, "datetime64[us]"),
        "status": np.full(count, "ok"),
    }
    described = {"logs": [], "model": "coulomb", "kind": "translational", "columns": ABOUT}
    monkeypatch.setattr(module, "_stores_in", lambda folder: iter([folder]))
    monkeypatch.setattr(module, "runs_in", lambda store: Some(described=described, columns=columns, count=count))


def test_the_axis_of_a_log_is_its_folder_or_what_a_pattern_says(monkeypatch):
    fleet(monkeypatch, ["b.csv", "a.csv"], ["y", "x"], ["2026-03-02", "2026-03-01"])
    found = rows_in(["f"])
    assert (found.axis, found.log) == (("x", "y"), ("a.csv", "b.csv"))
    fleet(monkeypatch, ["z_02.03.2026_2026-03-02.csv", "y_2026-03-01T06-00.csv"])
    found = rows_in(["f"], axis_from=r"/(?P<axis>.)_.*?(?P<date>2026-03[-T0-9]+)")
    assert found.axis == ("y", "z")
    assert np.diff(found.time) == pytest.approx(18.0 * 3600.0)
    fleet(monkeypatch, ["b.csv", "a.csv"])
    assert rows_in(["f"]).time is None
    assert rows_in(["f"]).log == ("b.csv", "a.csv")


@pytest.mark.parametrize(
    ("pattern", "message"),
    [
        ("(", "is no regular expression"),
        ("(?P<name>.)", "has no group called axis"),
        ("(?P<axis>q)", "does not fit the pattern"),
        ("(?P<axis>h)(?P<date>a)", "is no date"),
    ],
)
def test_a_pattern_that_does_not_serve_is_refused(monkeypatch, pattern, message):
    fleet(monkeypatch, ["b.csv"])
    with pytest.raises(InputError, match=message):
        rows_in(["f"], axis_from=pattern)
    assert pattern_of(None) is None


def test_a_folder_that_is_no_fleet_is_refused(tmp_path):
    with pytest.raises(InputError, match="holds no fleet"):
        rows_in([tmp_path])
    with pytest.raises(InputError, match="there is no such folder"):
        rows_in([tmp_path / "gone"])
