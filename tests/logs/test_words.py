"""What names of columns and units mean."""

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.logs.table import Table
from bristle.logs.words import (
    distinct,
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
def test_a_name_means_a_role_and_whether_the_signal_was_asked_for_or_measured(name, role, reference, actual):
    meaning = meaning_of(name)
    assert (meaning.role, meaning.reference, meaning.actual) == (role, reference, actual)


def test_a_unit_after_a_slash_does_not_affect_the_role():
    for name in ("position/m", "position/s", "torque/Nm", "velocity/V"):
        assert meaning_of(name) == meaning_of(name.partition("/")[0])


def test_long_words_are_surer_than_letters_and_own_words_than_words_around():
    assert meaning_of("position").sure == meaning_of("X_Value").sure == 1.0
    assert meaning_of("iq").sure == pytest.approx(0.7)
    assert meaning_of("u").sure == pytest.approx(0.4)
    assert meaning_of("xpositionx").sure == pytest.approx(0.8)
    assert meaning_of("position.ch3").sure == pytest.approx(0.8)
    assert meaning_of("ch3", "position").sure == pytest.approx(0.5)
    assert meaning_of("torque", "position").role == "effort"


def test_times_are_called_so_and_are_never_asked_for():
    assert [name for name in ("t", "time", "elapsed", "time setpoint", "q", "tt") if is_time(name)] == ["t", "time", "elapsed"]


@pytest.mark.parametrize(
    ("written", "unit"),
    [
        *(("[mm]", "mm"), ("( Nm )", "N*m"), ("nm", "nm"), ("NM", "N*m"), ("u", ""), ("U", "rev"), ("u/min", "rpm"), ("-", "")),
        *(("°/s", "deg/s"), ("(a)(b)", "(a)(b)"), ("parsec", "parsec"), ("INC", "count"), ("IN", "inch")),
    ],
)
def test_units_are_written_in_one_way(written, unit):
    assert plain_unit(written) == unit


def test_a_unit_ends_a_name_behind_a_stroke():
    names = ("v_mm_s", "v_u_min", "v_U_MIN", "v rev sec", "x_m", "t_ms", "x_µm", "q", "x_unit", "a_s", "mm")
    assert [unit_in_name(name) for name in names] == ["mm/s", "rpm", "rpm", "rev/s", "m", "ms", "um", "", "", "s", ""]


def test_a_different_unit_in_a_name_is_found_and_the_same_unit_is_not():
    assert other_unit_in("pos_mm", "m") == "mm"
    assert other_unit_in("pos_mm", "mm") == other_unit_in("pos", "m") == other_unit_in("pos_mm", "parsnip") == ""
    assert other_unit_in("pos_mm", "N") == "mm"
    assert other_unit_in("speed_rpm", "rev/min") in ("", "rpm")


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


def test_umlauts_and_capitals_part_words():
    assert words_of("Größe_Ähnlich") == ["groesse", "aehnlich"]
    assert words_of("IDPos2nm") == ["id", "pos", "nm"]
    assert words_of("vité") == ["vite"]
    assert without_part("ist") == "ist"
    assert without_part("xpos") == "xpos"


def test_duplicate_names_become_unique():
    names, notes = distinct(["q", "q", "q_2", "q"])
    assert names == ["q", "q_3", "q_2", "q_4"]
    assert [note.partition(" is called")[0] for note in notes] == ["column 2", "column 4"]


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
    assert name.isprintable()
    assert plain.units == {time: "s"}
    assert plain.names == (time, name)
    assert (plain.stamps, plain.about, plain.numbers) == ({name: time}, {name: "position"}, {"column_2": name})
    assert plain.notes[0] == "before"
    assert len(plain.notes) == 3
    assert all(text.isprintable() for text in (*plain.texts, *plain.notes))
    tidy = Table({time: np.arange(3.0)}, {time: "sek"}, names=(time,))
    assert with_plain_names(tidy).units == {time: "s"}
    assert with_plain_names(tidy).notes == ()
