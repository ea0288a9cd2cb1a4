"""What names of columns and units mean."""

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.logs.table import Table
from bristle.logs.words import (
    is_time,
    meaning_of,
    other_unit_in,
    plain_unit,
    unit_in_name,
    unit_of_time,
    with_plain_names,
    without_part,
    words_of,
)


@pytest.mark.parametrize(
    ("name", "role", "reference", "actual"),
    [
        ("Lageistwert", "position", False, True),
        ("position actual", "position", False, True),
        ("Axis 1.Position.Setpoint", "position", True, False),
        ("drive::torque command", "effort", True, False),
        ("MotorTemperature", "temperature", False, False),
        ("download", "", False, False),
        ("rated speed", "velocity", False, False),
        ("following error", "error", False, False),
        ("enable", "status", False, False),
        ("X_Value", "time", False, False),
        ("acceleration", "acceleration", False, False),
        ("position/mm", "position", False, False),
        ("speed m/s", "velocity", False, False),
        ("hello", "", False, False),
        ("pos nm", "position", False, False),
        ("force nm", "effort", False, False),
    ],
)
def test_a_name_means_a_role_and_whether_the_signal_was_asked_for_or_measured(
    name, role, reference, actual
):
    meaning = meaning_of(name)
    assert (meaning.role, meaning.reference, meaning.actual) == (role, reference, actual)


@pytest.mark.parametrize(
    ("name", "values", "unit"),
    [
        ("t_us", np.arange(9.0), "us"),
        ("t", 1e-3 * np.arange(9.0), "s"),
        ("t", np.arange(9.0), "ms"),
        ("t", 0.04 * np.arange(9.0), "s"),
        ("t", 1.7e9 + np.arange(9.0), "s"),
        ("t", 1.7e12 + np.arange(9.0), "ms"),
        ("t", 1.7e15 + np.arange(9.0), "us"),
        ("t", 1.7e18 + np.arange(9.0), "ns"),
        ("t_mm", np.arange(9.0), "ms"),
        ("t", np.zeros(0), "s"),
        ("t", np.ones(1), "s"),
    ],
)
def test_the_unit_of_stamps_follows_from_name_or_count(name, values, unit):
    assert unit_of_time(name, values) == unit


def sure(name, around=""):
    return meaning_of(name, around).sure


@pytest.mark.parametrize(
    ("call", "given", "value"),
    [
        # Long words are surer than letters, and own words than words around.
        (sure, ("position",), 1.0),
        (sure, ("X_Value",), 1.0),
        (sure, ("iq",), pytest.approx(0.7)),
        (sure, ("u",), pytest.approx(0.4)),
        (sure, ("xpositionx",), pytest.approx(0.8)),
        (sure, ("position.ch3",), pytest.approx(0.8)),
        (sure, ("ch3", "position"), pytest.approx(0.5)),
        (meaning_of, ("torque", "position"), meaning_of("torque")),
        # A unit behind a stroke does not affect the meaning.
        (meaning_of, ("position/m",), meaning_of("position")),
        (meaning_of, ("position/s",), meaning_of("position")),
        (meaning_of, ("torque/Nm",), meaning_of("torque")),
        (meaning_of, ("velocity/V",), meaning_of("velocity")),
        (is_time, ("t",), True),
        (is_time, ("time",), True),
        (is_time, ("elapsed",), True),
        (is_time, ("time setpoint",), False),
        (is_time, ("q",), False),
        (is_time, ("tt",), False),
        (plain_unit, ("[mm]",), "mm"),
        (plain_unit, ("( Nm )",), "N*m"),
        (plain_unit, ("nm",), "nm"),
        (plain_unit, ("NM",), "N*m"),
        (plain_unit, ("u",), ""),
        (plain_unit, ("U",), "rev"),
        (plain_unit, ("u/min",), "rpm"),
        (plain_unit, ("-",), ""),
        (plain_unit, ("°/s",), "deg/s"),
        (plain_unit, ("(a)(b)",), "(a)(b)"),
        (plain_unit, ("parsec",), "parsec"),
        (plain_unit, ("INC",), "count"),
        (plain_unit, ("IN",), "inch"),
        (unit_in_name, ("v_mm_s",), "mm/s"),
        (unit_in_name, ("v_u_min",), "rpm"),
        (unit_in_name, ("v_U_MIN",), "rpm"),
        (unit_in_name, ("v rev sec",), "rev/s"),
        (unit_in_name, ("x_m",), "m"),
        (unit_in_name, ("t_ms",), "ms"),
        (unit_in_name, ("x_µm",), "um"),
        (unit_in_name, ("a_s",), "s"),
        (unit_in_name, ("q",), ""),
        (unit_in_name, ("x_unit",), ""),
        (unit_in_name, ("mm",), ""),
        (other_unit_in, ("pos_mm", "m"), "mm"),
        (other_unit_in, ("pos_mm", "mm"), ""),
        (other_unit_in, ("pos_mm", "parsnip"), ""),
        (other_unit_in, ("pos_mm", "N"), "mm"),
        (other_unit_in, ("pos", "m"), ""),
        # Umlauts and capitals part words.
        (words_of, ("Größe_Ähnlich",), ["groesse", "aehnlich"]),
        (words_of, ("IDPos2nm",), ["id", "pos", "nm"]),
        (words_of, ("vité",), ["vite"]),
        (without_part, ("ist",), "ist"),
        (without_part, ("xpos",), "xpos"),
    ],
)
def test_names_and_units_have_one_meaning(call, given, value):
    assert call(*given) == value


def test_names_that_cannot_be_printed_are_taken_without_control_characters_everywhere():
    odd, time = "q\x1b[31m", "t"
    table = Table(
        {time: np.arange(3.0), odd: np.ones(3)},
        {time: "s", odd: "\x07m"},
        texts={"a\x00": InputError("is text")},
        names=(time, odd),
        notes=("before",),
        stamps={odd: time},
        about={odd: "position"},
        numbers={"column_2": odd},
    )
    plain = with_plain_names(table)
    (name,) = set(plain.columns) - {time}
    assert (plain.units, plain.names) == ({time: "s"}, (time, name))
    assert (plain.stamps, plain.about, plain.numbers) == (
        {name: time},
        {name: "position"},
        {"column_2": name},
    )
    assert (plain.notes[0], len(plain.notes)) == ("before", 3)
    assert all(text.isprintable() for text in (name, *plain.texts, *plain.notes))
    tidy = with_plain_names(Table({time: np.arange(3.0)}, {time: "sek"}, names=(time,)))
    assert (tidy.units, tidy.notes) == ({time: "s"}, ())
