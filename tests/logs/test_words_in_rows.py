"""Words in a table are a column like any other: the numbers decide its layout, and whether its rows name their joint."""

import numpy as np
import pytest

from bristle.files.axis import axis_from
from bristle.files.proposal import propose_axis
from bristle.logs import read_log
from bristle.logs.readers import read_table
from bristle.logs.roles import roles_of

TIME = np.round(np.arange(600) * 1e-3, 6)
X, V = np.round(0.1 * np.sin(12.0 * TIME), 6), np.round(1.2 * np.cos(12.0 * TIME), 6)
U = np.round(5.0 * np.sign(V) + 0.3 * np.sin(900.0 * TIME), 6)
STATES, EVENTS = ["auto"] * 200 + ["hand"] * 400, ["GO", *[""] * 498, "HIT", *[""] * 100]
PHRASES = ["mode 2" if v > 0 else "mode 3" for v in V]
WIDE = {"time": TIME, "position[mm]": X, "force[N]": U}


def written(columns, separator=",", comma=False, stripped="\n"):
    rows = zip(
        *(
            [cell if isinstance(cell, str) else f"{cell:.9g}" for cell in column]
            for column in columns.values()
        ),
        strict=True,
    )
    lines = [
        separator.join(cell.replace(".", ",") if comma else cell for cell in row).rstrip(stripped)
        for row in rows
    ]
    return "\n".join([separator.join(columns), *lines, ""]).encode()


@pytest.mark.parametrize("place", range(4))
@pytest.mark.parametrize(
    ("words", "dialect"),
    [
        (STATES, (",",)),
        (EVENTS, ("\t",)),
        (EVENTS, ("\t", False, "\t")),
        (PHRASES, ("\t", True)),
        (STATES, (" ", True)),
        (EVENTS, (";", True)),
    ],
)
def test_words_in_any_place_leave_the_numbers_as_they_are(place, words, dialect):
    columns = list(WIDE.items())
    table = read_table(
        written(dict([*columns[:place], ("state", words), *columns[place:]]), *dialect)
    )
    np.testing.assert_array_equal(
        [table.columns[name] for name in ("time", "position", "force")], [TIME, X, U]
    )
    assert (table.units["position"], list(table.texts), table.notes) == (
        "mm",
        ["state"],
        ("bristle ignores columns of text: state",),
    )


def long_form(order, shift=0.0):
    """A table with the rows of two joints: the wrist moves against the elbow, later by `shift` [s]."""
    joints = {
        "elbow": (TIME, X, V, U + 30.0 * np.sin(900.0 * TIME)),
        "wrist": (TIME + shift, 0.3 - 0.4 * X, -0.4 * V, -0.2 * U),
    }
    rows = [
        (k * TIME.size + i if order == "blocks" else i, name, *signals)
        for k, name in enumerate(joints)
        for i, signals in enumerate(zip(*joints[name], strict=True))
    ]
    _, names, *signals = zip(*sorted(rows, key=lambda row: row[0]), strict=True)
    return dict(
        zip(
            ("time", "position", "joint", "velocity", "effort"),
            (signals[0], signals[1], names, *signals[2:]),
            strict=True,
        )
    )


@pytest.mark.parametrize(("order", "shift"), [("by time", 0.0), ("by time", 2e-4), ("blocks", 0.0)])
@pytest.mark.parametrize("remark", [False, True])
def test_rows_that_name_their_joint_are_split_by_it_and_its_effort_stays_with_its_position(
    order, shift, remark
):
    columns = long_form(order, shift)
    columns |= (
        {
            "turn": [
                f"{'up' if v > 0 else 'down'} {name}"
                for v, name in zip(columns["velocity"], columns["joint"], strict=True)
            ]
        }
        if remark
        else {}
    )
    table = read_table(written(columns, ";"))
    np.testing.assert_allclose(
        [table.columns[f"wrist.{name}"] for name in ("position", "effort")],
        [0.3 - 0.4 * X, -0.2 * U],
        atol=1e-8,
    )
    assert (
        "column joint names the signal of each row: bristle splits the table into elbow, wrist"
        in table.notes
    )
    assert not any("joint" in note for note in table.notes if note.startswith("bristle ignores"))
    channels = roles_of(table).channels
    assert len({channels[name].column.split(".")[0] for name in ("position", "effort")}) == 1


@pytest.mark.parametrize("void", ["", "nan"])
def test_rows_before_the_first_value_of_a_channel_and_after_the_last_are_left_out_with_a_note(
    void, tmp_path
):
    path = tmp_path / "log.csv"
    path.write_bytes(written({**WIDE, "force[N]": [void] * 5 + U.tolist()[5:-3] + [void] * 3}))
    log = read_log(path, propose_axis(path).axis)
    np.testing.assert_allclose(log.effort.values, U[5:-3], rtol=1e-12)
    assert "bristle ignores 8 samples at the ends, where column force has no values" in log.notes


def test_the_axis_file_states_the_unit_of_time_and_late_decimals_may_have_commas():
    rows = {
        **WIDE,
        "position[mm]": [""] * 50 + X.tolist()[50:],
        "force[N]": [""] * 40 + U.tolist()[40:],
    }
    late = read_table(written(rows | {"time": np.arange(600)}, ";", True))
    np.testing.assert_array_equal(late.columns["position"][50:], X[50:])
    columns = {
        "time": {"column": "time", "unit": "ms"},
        "position": {"column": "elbow.position", "unit": "m"},
    }
    axis = axis_from({"schema": 1, "kind": "translational", "columns": columns})
    assert read_log(written(long_form("by time")), axis).sample_time == pytest.approx(1e-6)
