"""The summary of an identification: levels in each unit of the drive, and numbers of the draws."""

from types import SimpleNamespace as Some

import numpy as np
import pytest

from bristle.core import Axis
from bristle.core.axis import Column
from bristle.report import summary as report
from bristle.report.summary import _described, _levels, _resampling


class Levels(Some):
    def _asdict(self):
        return vars(self)


def levels():
    known = {"inertia": 12.0, "forward": 7.0, "backward": 14.0, "constant": None, "deviation": 3.5}
    return Levels(**known, viscous_forward=70.0, viscous_backward=None)


def fit(**changes):
    known = {"plant": Some(kind="translational"), "friction": "f", "traces": Some(velocity=np.array([-0.5, 0.2])), "lag": 1e-3}
    return Some(**known | changes)


def test_levels_are_in_si_and_units_of_the_drive(monkeypatch):
    requested = []
    monkeypatch.setattr(report, "level_values", lambda fit: levels())
    monkeypatch.setattr(report, "reversal_distance", lambda friction, speed: requested.append((friction, speed)) or 4e-6)
    columns = {"position": Column("x", "mm", "m", 1.0), "effort": Column("u", "V", "V", 35.0)}
    reported = _levels(fit(), Axis(columns=columns))
    assert {name: reported[name] for name in vars(levels())} == vars(levels())
    assert (reported["reversal_distance"], reported["lag"], requested) == (4e-6, 1e-3, [("f", 0.5)])
    assert reported["units"]["mm"] == {"reversal_distance": pytest.approx(4e-3)}
    assert reported["units"]["V"] == {
        "forward": pytest.approx(0.2),
        "backward": pytest.approx(0.4),
        "constant": None,
        "deviation": pytest.approx(0.1),
    }
    assert _levels(fit(), None)["units"].keys() <= {"N", "mm/s"}
    monkeypatch.setattr(report, "level_values", lambda fit: None)
    assert _levels(fit(), None) is None


def test_estimate_has_its_reason():
    names = ("value", "unit", "std", "relative_std_percent", "robust_std", "interval_percent", "interval", "status")
    item = Some(name="a", description="level", reason=None, **{name: name for name in names})
    assert _described([item]) == {"a": {name: name for name in names} | {"note": "", "description": "level"}}


def test_summary_has_the_numbers_of_the_draws():
    assert _resampling(fit(resampling=None)) is None
    bands = {name: float(place) for place, name in enumerate(("noise", "unexplained", "lasting", "inflation"))}
    bands |= {"left_in_closed_loop": 5.0, "left_in_open_loop": 6.0, "count": 20}
    scatter = type("Scatter", (), {"_asdict": lambda self: {"value": 0.03}})()
    curve = ((0.0, 1.0, 0.9, 1.1), (1e-6, 2.0, 1.9, 2.1))
    custom = {"half_cycles": 30, "resolution": 1e-6, "curve": curve, "curve_from": "loops"}
    reported = _resampling(fit(resampling=Some(bands=Some(**bands), scatter=scatter, **custom)))
    assert reported["virgin_curve"] == {"x": [0.0, 1e-6], "force": [1.0, 2.0], "low": [0.9, 1.9], "high": [1.1, 2.1]}
    assert (reported["draws"], reported["noise"], reported["left_in_open_loop"]) == (20, 0.0, 6.0)
    assert (reported["scatter"], reported["virgin_curve_from"]) == ({"value": 0.03}, "loops")
