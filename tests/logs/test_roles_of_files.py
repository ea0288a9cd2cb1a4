"""Which column of a file is what, where its names tell little: one matrix, several axes, units that nobody knows."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
import scipy.io
from tests.logs.exports import RATED, motion

from bristle.core import InputError
from bristle.files.axis import read_axis
from bristle.files.proposal import propose_axis
from bristle.logs import read_log
from bristle.logs.readers import read_table
from bristle.logs.table import columns_named
from bristle.report.log import inspect_log

MOTION = motion(2.0)
TIME, POSITION, FORCE = MOTION.time_us / 1e6, MOTION.position_um / 1e6, MOTION.torque * RATED / 1e3
COLUMNS = {"time": TIME, "position": POSITION, "effort": FORCE}


def saved(folder, name, matrix, kind):
    path = folder / f"log.{kind}"
    write = scipy.io.savemat if kind == "mat" else lambda path, arrays: np.savez(path, **arrays)
    write(path, {name: matrix})
    return path


def proposed(path):
    return {channel: column.name for channel, column in propose_axis(path).axis.columns.items()}


@pytest.mark.parametrize(
    ("kind", "name", "order"),
    [
        *(("mat", "data", order) for order in permutations(COLUMNS)),
        ("mat", "M", ("effort", "position", "time")),
        ("mat", "u", ("position", "time", "effort")),
        ("npz", "x", ("position", "effort", "time")),
    ],
)
def test_the_columns_of_a_matrix_are_identified_in_any_order_and_name(tmp_path, order, kind, name):
    matrix = np.column_stack([COLUMNS[channel] for channel in order])
    called = [f"{name}[{k}]" if kind == "mat" else f"column_{k + 1}" for k in range(3)]
    assert proposed(saved(tmp_path, name, matrix, kind)) == dict(zip(order, called, strict=True))


ROWS = np.arange(TIME.size)


@pytest.mark.parametrize(
    ("columns", "expected"),
    [
        ([ROWS, FORCE, TIME, POSITION], {"time": "M[2]", "position": "M[3]", "effort": "M[1]"}),
        ([ROWS, FORCE, POSITION], {"position": "M[2]", "effort": "M[1]"}),
        # A reference that halts.
        ([POSITION, np.minimum(TIME, 1.99), FORCE], {"position": "M[0]", "effort": "M[2]"}),
    ],
)
def test_a_count_of_rows_and_a_reference_that_halts_are_no_time(tmp_path, columns, expected):
    path = saved(tmp_path, "M", np.column_stack(columns), "mat")
    assert proposed(path) == expected
    assert ("timing.sample_time" in propose_axis(path).missing) is ("time" not in expected)


def test_several_matrices_keep_their_names(tmp_path):
    path = tmp_path / "log.mat"
    both = {
        "pos": np.column_stack([POSITION, 2 * POSITION]),
        "torque": np.column_stack([FORCE, FORCE]),
        "t": TIME,
    }
    scipy.io.savemat(path, both)
    assert proposed(path) == {"time": "t", "position": "pos[0]", "effort": "torque[0]"}


POSITION_OF, TORQUE_OF = (
    "/Nck/!SD/nckServoDataActPos1stEnc64 [u1{} {}]",
    "/Nck/!SD/nckServoDataCmdTorque64 [u1{} {}]",
)


def trace(signals, *, xml, sep=","):
    """A trace of several axes: in text with its addresses as names, or in XML with signals that are described alike."""
    if not xml:
        rows = np.column_stack([TIME, *signals.values()])
        lines = [";".join(f"{cell:.6f}" for cell in row) for row in rows]
        return "\n".join(
            [";".join(["time [s]", *(name.replace(",", sep) for name in signals)]), *lines, ""]
        ).encode()
    heads = [
        f'<dataSignal id="f{k}" name="{name}" description="{"Moment" if "Torque" in name else "Lageistwert"}" '
        f'units="{"Nm" if "Torque" in name else "mm"}"/>'
        for k, name in enumerate(signals)
    ]
    rows = zip(TIME, *signals.values(), strict=True)
    taken = (" ".join(f'f{k}="{value:.6f}"' for k, value in enumerate(row)) for _, *row in rows)
    records = [f'<rec time="{t:.6f}" {values}/>' for t, values in zip(TIME, taken, strict=True)]
    body = "".join(
        [
            "<traceDataRoot><traceData><dataFrame>",
            *heads,
            *records,
            "</dataFrame></traceData></traceDataRoot>",
        ]
    )
    return body.encode()


ONE, THREE = ([POSITION_OF.format(",", axis), TORQUE_OF.format(",", axis)] for axis in (1, 3))


@pytest.mark.parametrize("xml", [True, False])
@pytest.mark.parametrize(
    ("names", "expected"),
    [
        ([THREE[1], *ONE, THREE[0]], ONE),
        ([ONE[1], *THREE, ONE[0]], THREE),
        ([ONE[0], *THREE], THREE),
        ([THREE[1], *ONE], ONE),
        ([THREE[1], ONE[0]], ONE[:1]),
    ],
    ids=[
        "all",
        "all, three first",
        "one without torque",
        "three without position",
        "none with both",
    ],
)
def test_position_and_torque_of_a_trace_are_those_of_one_axis(xml, names, expected):
    proposal = propose_axis(
        trace({name: FORCE if "Torque" in name else 1e3 * POSITION for name in names}, xml=xml)
    )
    columns = [
        column.name for channel, column in proposal.axis.columns.items() if channel != "time"
    ]
    assert [proposal.table.about.get(name, name) for name in columns] == expected
    assert not any("u1" in unit for unit in proposal.table.units.values())


@pytest.mark.parametrize("sep", [",", ";", " "])
def test_an_index_is_no_unit_and_optional_in_the_name_of_a_unique_column(sep):
    names = [POSITION_OF.format(sep, number) for number in (1, 3)]
    lines = [
        "\t".join(["time [s]", *names]),
        *(f"{t}\t{x}\t{-x}" for t, x in zip(TIME, POSITION, strict=True)),
        "",
    ]
    called = names[0].partition(" ")[0]
    table = read_table("\n".join(lines).encode(), choice=columns_named(["time", called]))
    assert (table.names, table.units, table.name_of(called)) == (
        ("time", *names),
        {"time": "s"},
        None,
    )
    lines = [line.rpartition("\t")[0] for line in lines]
    table = read_table("\n".join(lines).encode(), choice=columns_named(["time", called]))
    assert table.name_of(called) == names[0]
    np.testing.assert_array_equal(table.columns[names[0]], POSITION)


def text_log(position, effort, reference=None, time="s", speed=None):
    """A log with such units in its header."""
    columns = {
        f"time [{time}]": TIME,
        f"position [{position}]": POSITION,
        f"force [{effort}]": FORCE,
    }
    columns |= {f"position_ref [{reference}]": POSITION + 1e-6} if reference else {}
    columns |= {f"velocity [{speed}]": np.gradient(POSITION, TIME)} if speed else {}
    rows = [";".join(f"{cell:.9f}" for cell in row) for row in np.column_stack([*columns.values()])]
    return "\n".join([";".join(columns), *rows, ""]).encode()


def unit_lines(text):
    return {line.partition(" =")[0]: line for line in text.splitlines() if "column = " in line}


@pytest.mark.parametrize(
    ("units", "channel", "line"),
    [
        (
            {"position": "Skt", "effort": "bla"},
            "position",
            'unit = "?" }  # the file states the unknown unit "Skt"; unit of the',
        ),
        (
            {"position": "Skt", "effort": "bla"},
            "effort",
            'unit = "?" }  # the file states the unknown unit "bla"',
        ),
        (
            {"position": "Skt", "effort": "bla", "reference": "Skt"},
            "reference",
            'reference = { column = "position_ref" }  # in the unit of the position',
        ),
        # A reference in another unit that is not known is not taken for one.
        ({"position": "Skt", "effort": "N", "reference": "Dig"}, "reference", None),
        ({"position": "mm", "effort": "N", "reference": "Dig"}, "reference", None),
        (
            {"position": "mm", "effort": "N", "time": "Takte"},
            "time",
            '# the file states the unknown unit "Takte"',
        ),
        # A recorded velocity determines an unknown unit.
        (
            {"position": "Skt", "effort": "N", "speed": "m/s"},
            "position",
            'unit = "m" }  # unit from the velocity; the file states the unknown unit "Skt"',
        ),
    ],
)
def test_a_unit_that_is_not_known_is_asked_for_with_the_words_of_the_file(units, channel, line):
    lines = unit_lines(propose_axis(text_log(**units)).text)
    assert channel not in lines if line is None else line in lines[channel]


@pytest.mark.parametrize(
    ("log", "missing", "unknown"),
    [
        (
            text_log("Skt", "bla", reference="Skt"),
            ("columns.position.unit", "columns.effort.unit"),
            {"position": "Skt", "effort": "bla"},
        ),
        (text_log("mm", "N", time="Takte"), ("columns.time.unit",), {"time": "Takte"}),
        (
            text_log("mm", "Dig").replace(b"force", b"current"),
            ("columns.effort.unit",),
            {"effort": "Dig"},
        ),
        (text_log("Skt", "N", speed="m/s"), (), {}),
    ],
)
def test_an_unknown_unit_overrides_the_numbers_and_is_missing(log, missing, unknown):
    proposal = propose_axis(log)
    assert (proposal.missing, proposal.unknown) == (missing, unknown)
    assert "columns.position.unit is unknown: bristle assumes 1 in SI units" not in proposal.notes


@pytest.mark.parametrize("channel", ["position", "time"])
def test_a_log_in_an_unknown_unit_has_no_values_in_si(channel):
    inspected = inspect_log(
        text_log("Skt", "N") if channel == "position" else text_log("mm", "N", time="Takt")
    )
    summary = inspected.summary
    assert inspected.log is None
    assert (
        summary["problems"]
        == summary["channels"]
        == summary["passages"]
        == summary["diagnostics"]
        == []
    )
    assert {column["unit"] for column in summary["columns"]} & {"Skt", "Takt"}
    assert any(f"for the {channel}: bristle cannot convert it" in note for note in summary["notes"])


def test_a_channel_in_a_unit_that_is_not_known_is_left_out_of_a_log_that_is_usable_without_it():
    inspected = inspect_log(text_log("mm", "bla"))
    assert [channel["name"] for channel in inspected.summary["channels"]] == ["time", "position"]
    assert inspected.log is not None
    assert inspected.log.effort is None


def test_an_axis_file_defines_an_unknown_unit_that_is_refused_without_it():
    columns = 'time = "time"\nposition = { column = "position", unit = "mm" }\nreference = "position_ref"\n'
    axis = read_axis(f'schema = 1\nkind = "translational"\n[columns]\n{columns}'.encode())
    log = read_log(text_log("Skt", "bla", reference="Skt"), axis)
    np.testing.assert_allclose(log.position.values, 1e-3 * POSITION, atol=1e-12)
    np.testing.assert_allclose(log.reference.values, 1e-3 * (POSITION + 1e-6), atol=1e-12)
    assert (
        "column position has the unit 'Skt' in the log, but mm in the axis file: bristle uses mm"
        in log.notes
    )
    with pytest.raises(
        InputError, match="'position': has the wrong unit; found 'Skt', allowed m, or a unit"
    ):
        read_log(text_log("Skt", "N"))
