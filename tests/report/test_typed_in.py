"""Values of an identification for a drive, in units of the drive."""

from types import SimpleNamespace as Some

import pytest
from tests.report import known
from tests.report.known import estimate

from bristle.core import Axis
from bristle.core.axis import Column
from bristle.report import identification as report
from bristle.report.identification import _for_the_drive
from bristle.report.model_tables import values_to_enter


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
    assert entered(constant=2.0)[1]["Constant force"] == ("2 N",)
    assert "Friction forward, F+" not in entered(forward=None)[1]
    assert entered(item=fit(kind="rotational"))[1]["Mass or inertia"] == ("12 kg·m²",)


def test_unidentified_mass_is_not_reported(entered):
    assert "Mass or inertia" not in entered(item=fit(mass="unidentifiable"))[1]


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
