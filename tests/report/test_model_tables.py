"""Tables of an identified model: significant digits and readable units."""

import math
from types import SimpleNamespace as Some

import numpy as np
import pytest
from hypothesis import given, strategies as st
from tests.report import known

from bristle import friction, plants
from bristle.core import Axis, Column
from bristle.identification import HeldOut, Settings
from bristle.report import identification as report, model_tables, summary as summary_module
from bristle.report.table import (
    Quantity,
    Table,
    capital,
    fixed,
    interval_text,
    length_text,
    percent_text,
    short_text,
    span_text,
    stiffness_text,
)


def estimate(name="F_C", value=8.0, unit="N", **changes):
    """An estimate with a standard error of 1 % and an interval of twice that."""
    known = {
        "name": name,
        "value": value,
        "unit": unit,
        "description": "sliding",
        "status": "identified",
        "std": 0.01 * abs(value),
    }
    known |= {
        "relative_std_percent": 1.0,
        "interval": (0.98 * value, 1.02 * value),
        "interval_percent": 2.0,
        "is_rough": False,
    }
    return Some(**known | changes)


def fit(*estimates, **changes):
    known = {
        "resampling": None,
        "estimates": estimates,
        "combinations": (),
        "name": "coulomb",
        "effective": (),
        "doubted": (),
    }
    known |= {
        "with_constant": (),
        "plant": plants.inertia(M=12.0),
        "friction": friction.coulomb(F_C=8.0),
    }
    return Some(**known | changes)


def row_of(*estimates, **changes):
    """The first row of the table, by column head."""
    table = model_tables.parameter_table(fit(*estimates, **changes))
    return dict(zip(table.heads, table.rows[0], strict=True))


def test_parameter_has_two_digits_of_its_standard_error():
    assert row_of(estimate()) == {
        "Parameter": "F_C",
        "Meaning": "sliding",
        "Value": "8.000",
        "Standard error": "± 0.080",
        "95 % interval": "7.84 to 8.16",
        "Unit": "N",
        "Standard error [%]": "1.0",
        "95 % interval [%]": "± 2.0",
    }


def test_numbers_of_a_parameter_share_a_scaled_unit():
    row = row_of(estimate("v_S", 2e-3, "m/s"))
    assert [row[key] for key in ("Value", "Standard error", "95 % interval", "Unit")] == [
        "2.000",
        "± 0.020",
        "1.960 to 2.040",
        "mm/s",
    ]


@pytest.mark.parametrize(
    ("item", "changes", "value"),
    [
        (estimate(), {"resampling": Some()}, "8.00"),
        (estimate(std=math.inf, relative_std_percent=math.inf), {}, "8.00"),
    ],
)
def test_standard_errors_are_reported_without_intervals(item, changes, value):
    row = row_of(item, **changes)
    assert (row["Value"], {"Standard error", "Standard error [%]"} & set(row)) == (value, set())


@pytest.mark.parametrize(("half", "value"), [(0.0, "8.000"), (1e-9, "8.000000")])
def test_interval_without_width_has_a_thousandth_of_a_percent(half, value):
    row = row_of(
        estimate(
            std=None,
            relative_std_percent=None,
            interval=(8.0 - half, 8.0 + half),
            interval_percent=10.0 * half,
        )
    )
    assert (row["Value"], row["95 % interval"], row["95 % interval [%]"]) == (
        value,
        "8.000000, to the last digit",
        "< 0.001",
    )


@pytest.mark.parametrize(
    ("ends", "unit", "interval"),
    [
        ((-2.0, 4.0), "N", "−2.0 to 4.0"),
        ((-4.0, 2.0), "N", "−4.0 to 2.0"),
        ((-4.0, 2e-3), "N", "−4.0 to 0.0"),
        ((-2e-3, 4.0), "N", "0.0 to 4.0"),
        ((1e-3, 4.0), "mN", "0 to 4000"),
        ((-4.0, -1e-3), "mN", "−4000 to 0"),
    ],
)
def test_small_value_has_the_unit_of_its_interval(ends, unit, interval):
    row = row_of(
        estimate(
            value=1e-3, std=None, relative_std_percent=None, interval=ends, interval_percent=3e5
        )
    )
    assert (row["Unit"], row["95 % interval"], row["95 % interval [%]"]) == (
        unit,
        interval,
        "> 1000",
    )


@pytest.mark.parametrize(
    ("value", "low", "unit"),
    [(0.5, -3.0, "mN"), (0.5, -0.1, "mN"), (0.3, -3.0, "N"), (0.3, -0.1, "N"), (0.3, 0.0, "mN")],
)
def test_value_below_a_tenth_of_its_interval_has_the_unit_of_the_interval(value, low, unit):
    assert row_of(estimate(value=value, std=None, interval=(low, 4.0)))["Unit"] == unit


def test_infinite_constant_parameter_is_left_out():
    endless = estimate("v_S", math.inf, "m/s", status="held")
    table = model_tables.parameter_table(
        fit(estimate(), endless, estimate("M", status="held"), estimate("F_v", status="at_edge"))
    )
    assert [(row[0], row[-1]) for row in table.rows] == [
        ("F_C", ""),
        ("M", "held constant"),
        ("F_v", "at the edge of its range"),
    ]
    assert table.caption == "Parameters of coulomb"


@pytest.mark.parametrize(
    ("item", "changes", "remark"),
    [
        (
            {},
            {"effective": ("F_C",), "doubted": ("F_C",), "with_constant": ("M",)},
            "effective; doubtful: see the warnings",
        ),
        ({}, {"with_constant": ("F_C",)}, "valid only with the given offset"),
        ({"is_rough": True}, {"effective": ("F_C",)}, "roughly identified; effective"),
        ({"status": "unidentifiable"}, {"effective": ("F_C",)}, "not identified"),
    ],
)
def test_remarks_of_a_parameter_are_joined(item, changes, remark):
    assert row_of(estimate(**item), **changes)["Remark"] == remark


def test_products_of_parameters_are_the_last_rows():
    table = model_tables.parameter_table(fit(estimate(), combinations=(estimate("a b", 3.0, "1"),)))
    assert [(row[0], row[table.heads.index("Unit")]) for row in table.rows] == [
        ("F_C", "N"),
        ("a b", "–"),
    ]


VOLTS = {"position": Column("x", "mm", "m", 1.0), "effort": Column("u", "V", "V", 35.0)}


def test_parameter_is_also_in_units_of_the_drive():
    axis = Axis(columns=VOLTS)
    assert model_tables.drive_values(
        fit(estimate(), estimate("F_v", math.inf, "N*s/m"), estimate("none")), axis
    ) == {"F_C": {"V": pytest.approx(8.0 / 35.0)}}
    table = model_tables.parameter_table(fit(estimate()), axis)
    assert dict(zip(table.heads, table.rows[0], strict=True))["In the drive's units"] == "0.2286 V"
    assert model_tables.drive_values(fit(estimate()), None) == {}


def model(name, error, held_out=(3.0, 4.0), status="identified", **changes):
    known = {
        "name": name,
        "error_percent": error,
        "condition_number": 12.345,
        "further": 0,
        "information": Some(aic=0.0, bic=1.234),
    }
    known |= {
        "held_out": held_out and HeldOut(held_out, sum(held_out) / 2, 0.7),
        "estimates": (estimate(), estimate("M", status=status)),
    }
    return Some(**known | changes)


def test_the_table_of_models_is_in_the_order_of_the_error_that_decides():
    fits = (
        model("chosen", 1.234),
        model("best", 2.0, (2.0, 3.2), "at_edge", further=3),
        model("last", 3.0, None, "held", information=None),
    )
    table = model_tables.comparison_table(Some(fits=fits))
    assert [row[:2] for row in table.rows] == [["best", ""], ["chosen", "yes"], ["last", ""]]
    assert table.rows[1] == [
        "chosen",
        "yes",
        "2",
        "3.50",
        "+0.900 ± 0.10",
        "1.23",
        "0",
        "1.23",
        "12.3",
        "–",
    ]
    assert (table.rows[0][2:5], table.rows[0][-1], table.rows[2][2:5]) == (
        ["5", "2.60", "0"],
        "M",
        ["1", "–", "–"],
    )
    assert "one standard error of the smallest" in table.caption
    short = model_tables.comparison_table(Some(fits=fits), details=False)
    assert short.heads == [
        head for head in table.heads if "above the best" not in head and "Condition" not in head
    ]


def test_without_held_out_blocks_the_table_of_models_names_the_error_of_the_fit_as_the_rule():
    table = model_tables.comparison_table(Some(fits=(model("a", 1.0, None), model("b", 2.0, None))))
    assert [row[0] for row in table.rows] == ["a", "b"]
    assert "error of the fit decides" in table.caption


STEPS = [(-0.1, -9.0), (-0.0, -8.0), (0.0, 8.0), (0.1, 9.0)]


def test_drive_table_has_a_row_for_each_side_of_rest():
    table = model_tables.drive_rows(STEPS, "translational")
    assert table.heads == ["Entry", "Velocity [mm/s]", "Friction force [N]"]
    assert table.rows == [
        ["1", "−100.00", "−9.000"],
        ["2", "−0", "−8.000"],
        ["3", "+0", "8.000"],
        ["4", "100.00", "9.000"],
    ]
    assert model_tables.drive_rows([(0.0123456, 8.76543)], "translational").rows == [
        ["1", "12.346", "8.765"]
    ]
    assert model_tables.drive_rows(STEPS, "rotational").heads == [
        "Entry",
        "Velocity [mrad/s]",
        "Friction torque [N·m]",
    ]
    in_volts = model_tables.drive_rows(STEPS, "translational", Axis(columns=VOLTS))
    assert in_volts.heads == ["Entry", "Velocity [mm/s]", "Friction force [N]", "[V]"]
    assert [row[in_volts.heads.index("[V]")] for row in in_volts.rows] == [
        "−0.2571",
        "−0.2286",
        "0.2286",
        "0.2571",
    ]


def test_changed_thresholds_are_listed_with_their_defaults():
    assert model_tables.changed_settings(Settings()) is None
    table = model_tables.changed_settings(Settings.of({"usable_error": 12.5}))
    ((name, value, default, *_),) = table.rows
    assert (name, value) == ("usable_error", "12.5")
    assert float(default) == Settings().usable_error


def test_certificate_is_reported_with_its_uses():
    handed = {
        "well_posed": Some(passed=True, value=None, threshold=None, unit="1", advice="fine"),
        "drift": Some(passed=False, value=2e-6, threshold=1e-9, unit="m", advice="take another"),
        "closure": Some(passed=None, value=None, threshold=None, unit="1", advice=""),
    }
    rows = model_tables.certificate_table("lugre", handed).rows
    assert [row[:4] for row in rows] == [
        ["well_posed", "passed", "", ""],
        ["drift", "FAILED", "2 µm", "1 nm"],
        ["closure", "does not apply", "", ""],
    ]
    assert rows[1][4:] == ["take another", "a simulation of an axis that holds a load"]


# --- Tables of text


@given(
    values=st.lists(st.floats(-1e3, 1e3).filter(lambda v: abs(v) > 1e-9), min_size=1, max_size=8)
)
def test_cells_of_a_column_have_the_same_decimals(values):
    column = Quantity.of("m", values)
    cells = [column.cell(value) for value in values]
    assert len({len(cell.partition(".")[2]) for cell in cells}) == 1
    top = max(values, key=abs)
    read = float(column.cell(top).replace("−", "-")) / column.scale.factor
    assert abs(read - top) <= 0.006 * abs(top)


@pytest.mark.parametrize(("digits", "cell"), [(2, "3.1"), (3, "3.14"), (4, "3.142"), (5, "3.1416")])
def test_largest_number_of_a_column_has_the_requested_digits(digits, cell):
    column = Quantity.of("m", [3.14159e-3, 1e-4, math.inf], digits)
    assert (column.head("Way"), column.cell(3.14159e-3)) == ("Way [mm]", cell)


def test_column_of_zeros_has_the_plain_unit():
    column = Quantity.of("m", [])
    assert (column.scale.unit, column.step, column.cell(0.0)) == ("m", 0.0, "0")


def is_number(*cells):
    """Whether a column of these cells is one of numbers."""
    return Table("t", ["a"], [[cell] for cell in cells]).is_number(0)


@pytest.mark.parametrize(
    ("function", "arguments", "text"),
    [
        # A column of numbers is distinguished from words, and an empty one or one of dashes is left out.
        *(
            (is_number, cells, True)
            for cells in (["−1.5", "± 0.2"], ["–", "∞"], ["1.5e−7"], ["± 3 ± 0.1"], ["−∞"])
        ),
        *((is_number, cells, False) for cells in (["3 mm", "4"], ["1,5"], [""], ["3 N"], [])),
        (
            Table("t", ["a", "b", "c"], [["1", "", "x"], ["2", "", ""]]).without_empty_columns,
            (),
            ("t", ["a", "c"], [["1", "x"], ["2", ""]]),
        ),
        (
            Table("t", ["a", "b"], [["1", "–"], ["2", ""]]).without_empty_columns,
            (),
            ("t", ["a"], [["1"], ["2"]]),
        ),
        # Rows by head make a table.
        (
            Table.of,
            ("t", [{"a": "1", "b": "2"}, {"a": "3", "b": "4"}]),
            ("t", ["a", "b"], [["1", "2"], ["3", "4"]]),
        ),
        (Table.of, ("t", []), ("t", [], [])),
        # Very large and small half-widths have no digits.
        (model_tables._half, (None,), "–"),
        (model_tables._half, (math.inf,), "–"),
        (model_tables._half, (1000.0,), "1000"),
        (model_tables._half, (1001.0,), "> 1000"),
        (model_tables._half, (1e-3,), "0.0010"),
        (model_tables._half, (9e-4,), "< 0.001"),
        (model_tables._half, (3.14,), "3.1"),
        # Units of a drive are abbreviated.
        (model_tables._in_unit, (5.0, "% of rated"), "5.000 %"),
        (model_tables._in_unit, (5.0, "rpm of the motor"), "5.000 rpm"),
        (model_tables._in_unit, (5.0, "deg of the motor"), "5.000 deg (motor)"),
        (model_tables._in_unit, (5.0, "kg*m^2 at the motor"), "5 kg·m² (motor)"),
        # A drive table for copying is in SI.
        (
            model_tables.as_csv,
            (STEPS[2:], "translational"),
            "velocity [m/s],effort [N]\n0,8\n0.1,9",
        ),
        (
            model_tables.as_csv,
            ([(1 / 3, 2 / 3)], "rotational"),
            "velocity [rad/s],effort [N*m]\n0.333333,0.666667",
        ),
        # The smallest unit of lengths is the micrometre.
        (length_text, (0.0, "translational"), "0\u00a0m"),
        (length_text, (4.19e-7, "translational"), "0.419\u00a0µm"),
        (length_text, (-4.19e-7, "rotational"), "−0.419\u00a0µrad"),
        (length_text, (1e-6, "translational"), "1\u00a0µm"),
        (length_text, (2.5e-3, "rotational"), "2.5\u00a0mrad"),
        (fixed, (8.25, "N"), "8.25\u00a0N"),
        (short_text, (3.14159,), "3.14"),
        (percent_text, (12.345,), "12.3\u00a0%"),
        (span_text, ([3e-3, 1e-3, 2e-3], "m"), "1 mm to 3 mm"),
        (span_text, ([2e-3, 2e-3], "m"), "2 mm"),
        (interval_text, ("1", "2"), "1 to 2"),
        (interval_text, ("1", "1"), "1, to the last digit"),
        (stiffness_text, (5e7, "translational"), "50.0 N/µm"),
        (stiffness_text, (123.4, "rotational"), "123 N·m/rad"),
        # A sentence begins with a capital or with the name of the program.
        (capital, ("the log is short",), "The log is short"),
        (capital, ("bristle removed a delay",), "bristle removed a delay"),
        (capital, ("",), ""),
    ],
)
def test_short_texts_and_tables_of_numbers(function, arguments, text):
    assert function(*arguments) == text


# --- Values of an identification for a drive, in units of the drive


def levels(**changes):
    usual = {"inertia": 12.0, "forward": 8.0, "backward": 9.0, "constant": 0.0, "deviation": 0.5}
    return Some(**usual | {"viscous_forward": 30.0, "viscous_backward": 30.0} | changes)


def entered_fit(status="identified", *diagnostics, mass=None, kind="translational"):
    estimates = [
        known.estimate("M", 12.0, mass or status),
        known.estimate("F_C", 8.0, status),
        known.estimate("F_v", 0.0, "held"),
    ]
    return known.fit(*estimates, kind=kind, velocity=(-0.5, 0.2), diagnostics=diagnostics)


@pytest.fixture
def entered(monkeypatch):
    """The values to enter, for given levels."""

    def rows(axis=None, item=None, **changes):
        monkeypatch.setattr(
            "bristle.report.model_tables.level_values", lambda entered_fit: levels(**changes)
        )
        table = model_tables.values_to_enter(item or entered_fit(), axis)
        return table.caption, {row[0]: tuple(row[1:]) for row in table.rows}

    return rows


def test_levels_are_by_direction_with_the_viscous_part(entered):
    caption, rows = entered()
    assert (
        caption
        == "Values to enter into the drive: at most 500 mN below the steady friction, never above it"
    )
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
        ({"item": entered_fit(kind="rotational")}, "Mass or inertia", ("12 kg·m²",)),
        ({"item": entered_fit(mass="unidentifiable")}, "Mass or inertia", None),
    ],
)
def test_a_value_is_reported_if_it_is_known(entered, options, name, value):
    assert entered(**options)[1].get(name) == value


def test_units_of_the_drive_are_first(entered):
    columns = {"position": Column("x", "mm", "m", 1.0), "effort": Column("u", "V", "V", 35.0)}
    _, rows = entered(Axis(columns=columns))
    assert rows["Friction forward, F+"] == (f"{8.0 / 35.0:.3f} V", "8 N")


@pytest.mark.parametrize(
    ("deviation", "words"),
    [(8.9e-6, "follow the model"), (9.1e-6, "deviate from the model by 9.1 µN at most")],
)
def test_straight_lines_follow_the_model_within_rounding(deviation, words, monkeypatch):
    monkeypatch.setattr(report, "largest_deviation", lambda entered_fit, table: deviation)
    lead, block = report._for_the_drive(entered_fit(), [(-0.1, -9.0), (0.1, 8.0)], None)
    assert f"Straight lines between the rows {words}." in lead
    assert block.content.rows[0][0] == "1"
    assert block.further == (
        "The same table in SI units, to be copied:",
        "velocity [m/s],effort [N]\n-0.1,-9\n0.1,8",
    )


# --- The summary of an identification: known_levels in each unit of the drive, and numbers of the draws


class Levels(Some):
    def _asdict(self):
        return vars(self)


def known_levels():
    known = {"inertia": 12.0, "forward": 7.0, "backward": 14.0, "constant": None, "deviation": 3.5}
    return Levels(**known, viscous_forward=70.0, viscous_backward=None)


def fit_in_summary(**changes):
    known = {
        "plant": Some(kind="translational"),
        "friction": "f",
        "traces": Some(velocity=np.array([-0.5, 0.2])),
        "lag": 1e-3,
    }
    return Some(**known | changes)


def test_levels_are_in_si_and_units_of_the_drive(monkeypatch):
    requested = []
    monkeypatch.setattr(summary_module, "level_values", lambda fit_in_summary: known_levels())
    monkeypatch.setattr(
        summary_module,
        "reversal_distance",
        lambda friction, speed: requested.append((friction, speed)) or 4e-6,
    )
    columns = {"position": Column("x", "mm", "m", 1.0), "effort": Column("u", "V", "V", 35.0)}
    reported = summary_module._levels(fit_in_summary(), Axis(columns=columns))
    assert {name: reported[name] for name in vars(known_levels())} == vars(known_levels())
    assert (reported["reversal_distance"], reported["lag"], requested) == (4e-6, 1e-3, [("f", 0.5)])
    assert reported["units"]["mm"] == {"reversal_distance": pytest.approx(4e-3)}
    assert reported["units"]["V"] == {
        "forward": pytest.approx(0.2),
        "backward": pytest.approx(0.4),
        "constant": None,
        "deviation": pytest.approx(0.1),
    }
    assert summary_module._levels(fit_in_summary(), None)["units"].keys() <= {"N", "mm/s"}
    monkeypatch.setattr(summary_module, "level_values", lambda fit_in_summary: None)
    assert summary_module._levels(fit_in_summary(), None) is None


def test_estimate_has_its_reason():
    names = (
        "value",
        "unit",
        "std",
        "relative_std_percent",
        "robust_std",
        "interval_percent",
        "interval",
        "status",
    )
    item = Some(name="a", description="level", reason=None, **{name: name for name in names})
    assert summary_module._described([item]) == {
        "a": {name: name for name in names} | {"note": "", "description": "level"}
    }


def test_summary_has_the_numbers_of_the_draws():
    assert summary_module._resampling(fit_in_summary(resampling=None)) is None
    bands = {
        name: float(place)
        for place, name in enumerate(("noise", "unexplained", "lasting", "inflation"))
    }
    bands |= {"left_in_closed_loop": 5.0, "left_in_open_loop": 6.0, "count": 20}
    scatter = type("Scatter", (), {"_asdict": lambda self: {"value": 0.03}})()
    curve = ((0.0, 1.0, 0.9, 1.1), (1e-6, 2.0, 1.9, 2.1))
    custom = {"half_cycles": 30, "resolution": 1e-6, "curve": curve, "curve_from": "loops"}
    reported = summary_module._resampling(
        fit_in_summary(resampling=Some(bands=Some(**bands), scatter=scatter, **custom))
    )
    assert reported["virgin_curve"] == {
        "x": [0.0, 1e-6],
        "force": [1.0, 2.0],
        "low": [0.9, 1.9],
        "high": [1.1, 2.1],
    }
    assert (reported["draws"], reported["noise"], reported["left_in_open_loop"]) == (20, 0.0, 6.0)
    assert (reported["scatter"], reported["virgin_curve_from"]) == ({"value": 0.03}, "loops")
