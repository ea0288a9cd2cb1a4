"""What small functions return, by examples."""

import numpy as np
import pytest

from bristle.logs.json_records import recognises
from bristle.logs.layout import why_no_number
from bristle.logs.log import is_table
from bristle.logs.passages import nesting
from bristle.logs.stamped_text import amount_in, names_beside_times, stated_period
from bristle.logs.table import axis_in, some_of, split_unit, without_index
from bristle.logs.turns import turning_points
from bristle.logs.words import (
    distinct,
    is_time,
    meaning_of,
    names_and_units,
    plain_unit,
    unit_in_name,
    without_part,
    words_of,
)


@pytest.mark.parametrize(
    ("call", "value"),
    [
        pytest.param(
            lambda: (why_no_number("1.234,5")[0], why_no_number("00:00:01.250")[0]),
            ("is a number with thousands separators", "is a time of day"),
            id="why_no_number",
        ),
        pytest.param(
            lambda: (is_table({"time": [0.0, 1.0]}), is_table("log.csv"), is_table([0.0, 1.0])),
            (True, False, False),
            id="is_table",
        ),
        pytest.param(
            lambda: (
                recognises(b'{"t": [0, 1]}', ""),
                recognises(b"[Header]", ""),
                recognises(b"[1, 2]", ""),
            ),
            (True, False, True),
            id="recognises JSON",
        ),
        pytest.param(
            lambda: (
                plain_unit("U/min"),
                plain_unit("Nm"),
                plain_unit("(None)"),
                plain_unit("0,1 %"),
                plain_unit("mm/s"),
            ),
            ("rpm", "N*m", "", "‰", "mm/s"),
            id="plain_unit",
        ),
        pytest.param(
            lambda: distinct(["q", "q", "q_2", "q"]),
            (
                ["q", "q_3", "q_2", "q_4"],
                [
                    f"columns 1 and {number} are called 'q': bristle takes the first one by this name, and the other one by '{name}'"
                    for number, name in ((2, "q_3"), (4, "q_4"))
                ],
            ),
            id="distinct",
        ),
        pytest.param(
            lambda: names_and_units(["position [um]", "effort", "time"], {"effort": "N"}),
            (["position", "effort", "time"], {"position": "um", "effort": "N"}, []),
            id="names_and_units",
        ),
        pytest.param(
            lambda: (nesting([0, 7, -7, 7, -7]), nesting([0, 7, 1, 5, 3, 4]), nesting([])),
            (2, 6, 0),
            id="nesting",
        ),
        pytest.param(
            lambda: (
                stated_period({"Abtastzeit [ms]": "0,25"}),
                stated_period({"Sample rate": "4 kHz"}),
                stated_period({"Date": "today"}),
            ),
            (0.00025, 0.00025, None),
            id="stated_period",
        ),
        pytest.param(
            lambda: (
                amount_in("Nennmoment [Nm]", "2,4"),
                amount_in("Rated torque", "2.4 Nm"),
                amount_in("Device", "AX5000"),
            ),
            ((2.4, "N*m"), (2.4, "N*m"), None),
            id="amount_in",
        ),
        pytest.param(
            lambda: names_beside_times(("ActPos", "column_2", "ActTorque", "column_4")),
            ("column_1", "ActPos", "column_3", "ActTorque"),
            id="names_beside_times",
        ),
        pytest.param(lambda: some_of(["t", "u", "y"], 2), "t, u and 1 more", id="some_of"),
        pytest.param(
            lambda: (
                split_unit("position [um]"),
                split_unit("vir"),
                split_unit("nckServoDataActPos1stEnc64 [u1, 3]"),
            ),
            (("position", "um"), ("vir", ""), ("nckServoDataActPos1stEnc64 [u1, 3]", "")),
            id="split_unit",
        ),
        pytest.param(
            lambda: (
                split_unit("actual position / mm"),
                split_unit("velocity[rad/s]"),
                split_unit("F (N)"),
            ),
            (("actual position", "mm"), ("velocity", "rad/s"), ("F", "N")),
            id="split_unit-2",
        ),
        pytest.param(
            lambda: (
                without_index("/Nck/!SD/nckServoDataActCurr64 [u1, 3]"),
                without_index("pos[0]"),
                without_index("pos [mm]"),
            ),
            ("/Nck/!SD/nckServoDataActCurr64", "pos", "pos [mm]"),
            id="without_index",
        ),
        pytest.param(
            lambda: (
                axis_in("/Nck/!SD/nckServoDataActCurr64 [u1, 3]"),
                axis_in("/DriveVsa/Drive/r0080[u3]"),
            ),
            (("1", "3"), None),
            id="axis_in",
        ),
        pytest.param(
            lambda: turning_points(np.array([0.0, 1.0, 2.0, 1.9, 2.1, 0.0, 1.0]), 0.2),
            [4, 5],
            id="turning_points",
        ),
        pytest.param(
            lambda: (words_of("Axis1.fActPosition"), words_of("Lage_Istwert"), words_of("x-soll")),
            (["axis", "f", "act", "position"], ["lage", "istwert"], ["x", "soll"]),
            id="words_of",
        ),
        pytest.param(
            lambda: (
                meaning_of("Lageistwert").role,
                meaning_of("ActTorque").role,
                meaning_of("Schleppabstand").role,
            ),
            ("position", "effort", "error"),
            id="meaning_of",
        ),
        pytest.param(
            lambda: (meaning_of("positionssollwert")[:2], meaning_of("drehzahl_soll")[:2]),
            (("position", True), ("velocity", True)),
            id="meaning_of-2",
        ),
        pytest.param(
            lambda: (meaning_of("ch3", "position").role, meaning_of("ch3", "position").sure),
            ("position", 0.5 * meaning_of("position").sure),
            id="meaning_of-3",
        ),
        pytest.param(
            lambda: (
                without_part("sollweg"),
                without_part("wegist"),
                without_part("posactual"),
                without_part("poscmd"),
            ),
            ("weg", "weg", "pos", "pos"),
            id="without_part",
        ),
        pytest.param(
            lambda: (is_time("timestamp"), is_time("Zeit"), is_time("t_ms"), is_time("position")),
            (True, True, True, False),
            id="is_time",
        ),
        pytest.param(
            lambda: (
                unit_in_name("pos_mm"),
                unit_in_name("phi deg"),
                unit_in_name("speed_rad_s"),
                unit_in_name("torque"),
            ),
            ("mm", "deg", "rad/s", ""),
            id="unit_in_name",
        ),
        pytest.param(
            lambda: (unit_in_name("pos_nm"), unit_in_name("torque_nm"), unit_in_name("ref_nm")),
            ("nm", "N*m", ""),
            id="unit_in_name-2",
        ),
    ],
)
def test_small_functions_match_their_examples(call, value):
    assert call() == value
