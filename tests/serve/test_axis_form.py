"""The axis file as a form: what a person changes is changed, all else of it stays."""

import tomllib

import pytest

from bristle.core.content import Content
from bristle.core.errors import InputError
from bristle.files import read_axis
from bristle.files.axis_form import edited, form_of

TEXT = """# Proposed by bristle.
schema = 1
name = "x"

[columns]
time = { column = "t", unit = "s" }  # its name
position = { column = "x", unit = "mm" }
effort = { column = "i", unit = "A", sign = -1 }  # moves like the acceleration

[effort]
constant = "?"  # force or torque for one A

# columns that are not used: z
"""


def test_an_edit_changes_one_field_and_keeps_the_rest():
    text = edited(TEXT, {"effort.constant": "61 N/A", "columns.position.unit": "um", "kind": "translational"})
    assert tomllib.loads(text) == tomllib.loads(TEXT) | {
        "kind": "translational",
        "effort": {"constant": "61 N/A"},
        "columns": tomllib.loads(TEXT)["columns"] | {"position": {"column": "x", "unit": "um"}},
    }
    for kept in ("# Proposed by bristle.", "# its name", "# columns that are not used: z", "# moves like the accel"):
        assert kept in text
    assert read_axis(text.encode()).columns["effort"].scale == -61.0


def test_a_column_is_added_changed_and_removed():
    text = edited(TEXT, {"columns.velocity.column": "v", "columns.velocity.unit": "mm/s", "columns.effort.column": "j"})
    columns = tomllib.loads(text)["columns"]
    assert columns["velocity"] == {"column": "v", "unit": "mm/s"}
    assert columns["effort"]["column"] == "j"
    assert "moves like" not in text  # that was said of another column
    gone = edited(text, {"columns.velocity.column": None, "columns.velocity.unit": None, "limits.jerk": None})
    assert "velocity" not in tomllib.loads(gone)["columns"]
    assert tomllib.loads(edited("schema = 1\n", {"limits.velocity": "1 m/s"}))["limits"] == {"velocity": "1 m/s"}


SHORT = """schema = 1
[columns]
time = 1
position = "x"  # its name
effort = { column = "i", unit = "N" }
"""


@pytest.mark.parametrize(
    ("edits", "position"),
    [
        ({"columns.position.unit": "mm"}, {"column": "x", "unit": "mm"}),
        ({"columns.position.sign": -1}, {"column": "x", "sign": -1}),
        ({"columns.position.column": "y", "columns.position.unit": "m"}, {"column": "y", "unit": "m"}),
        ({"columns.position.column": None}, None),
    ],
)
def test_the_short_form_of_a_column_is_shown_and_changed_as_the_long_one(edits, position):
    shown = form_of(Content("axis.toml", SHORT.encode()))["tables"]["columns"]
    assert shown == {"time": {"column": "column_1"}, "position": {"column": "x"}, "effort": {"column": "i", "unit": "N"}}
    columns = tomllib.loads(edited(SHORT, edits))["columns"]
    assert columns.pop("position", None) == position
    assert columns == {"time": 1, "effort": {"column": "i", "unit": "N"}}  # nobody changed those


@pytest.mark.parametrize(
    ("edits", "words"),
    [
        ({"a.b.c.d": 1}, "is not a key"),
        ({"columns..x": 1}, "is not a key"),
        ({"columns": []}, "text or a number"),
        ({"schema.x": 1}, "is not a table"),
    ],
)
def test_an_unknown_key_of_an_axis_file_is_refused(edits, words):
    with pytest.raises(InputError, match=words):
        edited(TEXT, edits)
    with pytest.raises(InputError, match="not valid TOML"):
        edited("=", {})


def test_a_form_shows_gaps_and_remarks():
    form = form_of(Content("axis.toml", TEXT.encode()))
    assert form["missing"] == ["effort.constant"]
    assert form["remarks"]["columns.effort"] == "moves like the acceleration"
    assert form["remarks"]["effort.constant"].startswith("force or torque")
