"""Values of an identification for a drive, in units of the drive."""

from types import SimpleNamespace as Some

import numpy as np
import pytest
from tests.report import known
from tests.report.known import estimate

from bristle.core import Axis
from bristle.core.axis import Column
from bristle.report import identification as report
from bristle.report import summary as summary_module
from bristle.report.identification import _for_the_drive
from bristle.report.model_tables import values_to_enter
from bristle.report.summary import _described, _levels, _resampling


def levels(**changes):
    usual = {"inertia": 12.0, "forward": 8.0, "backward": 9.0, "constant": 0.0, "deviation": 0.5}
    return Some(**usual | {"viscous_forward": 30.0, "viscous_backward": 30.0} | changes)


def fit(status="identified", *diagnostics, mass=None, kind="translational"):
    estimates = [estimate("M", 12.0, mass or status), estimate("F_C", 8.0, status), estimate("F_v", 0.0, "held")]
    return known.fit(*estimates, kind=kind, velocity=(-0.5, 0.2), diagnostics=diagnostics)


@pytest.fixture
def entered(monkeypatch):
    """The values to enter, for given levels."""

    def rows(axis=None, item=None, **changes):
        monkeypatch.setattr("bristle.report.model_tables.level_values", lambda fit: levels(**changes))
        table = values_to_enter(item or fit(), axis)
        return table.caption, {row[0]: tuple(row[1:]) for row in table.rows}

    return rows


def test_levels_are_by_direction_with_the_viscous_part(entered):
    caption, rows = entered()
    assert caption == "Values to enter into the drive: at most 500 mN below the steady friction, never above it"
    assert rows == {
        "Friction forward, F+": ("8 N",),
        "Friction backward, F−": ("9 N",),
        "Viscous friction forward": ("30 N·s/m",),
        "Viscous friction backward": ("30 N·s/m",),
        "Mass or inertia": ("12 kg",),
    }


@pytest.mark.parametrize(
    ("options", "name", "value"),
    [
        ({"constant": 2.0}, "Constant force", ("2 N",)),
        ({"forward": None}, "Friction forward, F+", None),
        ({"item": fit(kind="rotational")}, "Mass or inertia", ("12 kg·m²",)),
        ({"item": fit(mass="unidentifiable")}, "Mass or inertia", None),
    ],
)
def test_a_value_is_reported_if_it_is_known(entered, options, name, value):
    assert entered(**options)[1].get(name) == value


def test_units_of_the_drive_are_first(entered):
    columns = {"position": Column("x", "mm", "m", 1.0), "effort": Column("u", "V", "V", 35.0)}
    _, rows = entered(Axis(columns=columns))
    assert rows["Friction forward, F+"] == (f"{8.0 / 35.0:.3f} V", "8 N")


@pytest.mark.parametrize(("deviation", "words"), [(8.9e-6, "follow the model"), (9.1e-6, "deviate from the model by 9.1 µN at most")])
def test_straight_lines_follow_the_model_within_rounding(deviation, words, monkeypatch):
    monkeypatch.setattr(report, "largest_deviation", lambda fit, table: deviation)
    lead, block = _for_the_drive(fit(), [(-0.1, -9.0), (0.1, 8.0)], None)
    assert f"Straight lines between the rows {words}." in lead
    assert block.content.rows[0][0] == "1"
    assert block.further == ("The same table in SI units, to be copied:", "velocity [m/s],effort [N]\n-0.1,-9\n0.1,8")


# --- The summary of an identification: known_levels in each unit of the drive, and numbers of the draws


class Levels(Some):
    def _asdict(self):
        return vars(self)


def known_levels():
    known = {"inertia": 12.0, "forward": 7.0, "backward": 14.0, "constant": None, "deviation": 3.5}
    return Levels(**known, viscous_forward=70.0, viscous_backward=None)


def fitted(**changes):
    known = {"plant": Some(kind="translational"), "friction": "f", "traces": Some(velocity=np.array([-0.5, 0.2])), "lag": 1e-3}
    return Some(**known | changes)


def test_levels_are_in_si_and_units_of_the_drive(monkeypatch):
    requested = []
    monkeypatch.setattr(summary_module, "level_values", lambda fitted: known_levels())
    monkeypatch.setattr(summary_module, "reversal_distance", lambda friction, speed: requested.append((friction, speed)) or 4e-6)
    columns = {"position": Column("x", "mm", "m", 1.0), "effort": Column("u", "V", "V", 35.0)}
    reported = _levels(fitted(), Axis(columns=columns))
    assert {name: reported[name] for name in vars(known_levels())} == vars(known_levels())
    assert (reported["reversal_distance"], reported["lag"], requested) == (4e-6, 1e-3, [("f", 0.5)])
    assert reported["units"]["mm"] == {"reversal_distance": pytest.approx(4e-3)}
    assert reported["units"]["V"] == {
        "forward": pytest.approx(0.2),
        "backward": pytest.approx(0.4),
        "constant": None,
        "deviation": pytest.approx(0.1),
    }
    assert _levels(fitted(), None)["units"].keys() <= {"N", "mm/s"}
    monkeypatch.setattr(summary_module, "level_values", lambda fitted: None)
    assert _levels(fitted(), None) is None


def test_estimate_has_its_reason():
    names = ("value", "unit", "std", "relative_std_percent", "robust_std", "interval_percent", "interval", "status")
    item = Some(name="a", description="level", reason=None, **{name: name for name in names})
    assert _described([item]) == {"a": {name: name for name in names} | {"note": "", "description": "level"}}


def test_summary_has_the_numbers_of_the_draws():
    assert _resampling(fitted(resampling=None)) is None
    bands = {name: float(place) for place, name in enumerate(("noise", "unexplained", "lasting", "inflation"))}
    bands |= {"left_in_closed_loop": 5.0, "left_in_open_loop": 6.0, "count": 20}
    scatter = type("Scatter", (), {"_asdict": lambda self: {"value": 0.03}})()
    curve = ((0.0, 1.0, 0.9, 1.1), (1e-6, 2.0, 1.9, 2.1))
    custom = {"half_cycles": 30, "resolution": 1e-6, "curve": curve, "curve_from": "loops"}
    reported = _resampling(fitted(resampling=Some(bands=Some(**bands), scatter=scatter, **custom)))
    assert reported["virgin_curve"] == {"x": [0.0, 1e-6], "force": [1.0, 2.0], "low": [0.9, 1.9], "high": [1.1, 2.1]}
    assert (reported["draws"], reported["noise"], reported["left_in_open_loop"]) == (20, 0.0, 6.0)
    assert (reported["scatter"], reported["virgin_curve_from"]) == ({"value": 0.03}, "loops")
