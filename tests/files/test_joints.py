"""Axis files with a table for each joint: common entries, own entries, numbers in names, and paths."""

from pathlib import Path

import pytest

from bristle.core.content import Content
from bristle.core.errors import InputError
from bristle.files.axis import axis_from
from bristle.files.joints import joints_in

COMMON = """
schema = 1
kind = "rotational"
[columns]
position = { column = "q{joint}", unit = "deg" }
effort = { column = "u{joint}", unit = "N*m" }
[timing]
sample_time = "1 ms"
[limits]
stroke = ["-1 rad", "1 rad"]
"""


def joints(text, name="joints.toml"):
    return joints_in(Content(Path(name), text.encode()))


def test_the_number_of_a_joint_stands_in_all_texts():
    axes = {
        name: axis_from(table)
        for name, table in joints(COMMON + "[[joint]]\n[[joint]]\nname = 'elbow'").items()
    }
    assert list(axes) == ["joint_1", "elbow"]
    assert [(axis.name, axis.columns["effort"].name) for axis in axes.values()] == [
        ("joint_1", "u1"),
        ("elbow", "u2"),
    ]


def test_an_entry_of_a_joint_replaces_only_the_same_entry():
    text = (
        COMMON
        + "[[joint]]\n[joint.limits]\nvelocity = '2 rad/s'\n[[joint]]\n[joint.limits]\nstroke = [0.0, 2.0]"
    )
    first, second = (axis_from(table) for table in joints(text).values())
    assert (first.stroke, first.velocity_limit) == ((-1.0, 1.0), 2.0)
    assert (second.stroke, second.velocity_limit) == ((0.0, 2.0), None)


def test_a_second_table_is_beside_the_file_of_the_joints(tmp_path):
    text = COMMON + "[[known]]\ncolumn = 'p'\nfile = 'valve.csv'\n[[joint]]\n"
    known = joints(text, str(tmp_path / "joints.toml"))["joint_1"]["known"]
    assert known[0]["file"] == str(tmp_path / "valve.csv")


def test_a_file_of_one_axis_has_no_joints():
    assert joints(COMMON) == {}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "[[joint]]\nname = 'a'\n[[joint]]\nname = 'a'",
            r"joint\[1\].name: must be a word that no other joint has",
        ),
        ("[[joint]]\nname = '../a'", r"joint\[0\].name: must be a word"),
        ("[joint]\nname = 'a'", r"joint: must be a list of tables"),
        ("[[joint]]\nname = 3", r"joint\[0\].name"),
    ],
)
def test_names_that_no_folder_could_have_are_refused(text, message):
    with pytest.raises(InputError, match=message):
        joints(COMMON + text)


ARRAYS = COMMON.replace("q{joint}", "y[{joint0}]").replace("u{joint}", "u[{joint1}]")


def test_columns_of_arrays_count_from_a_stated_number():
    axes = [axis_from(table) for table in joints(ARRAYS + "[[joint]]\n[[joint]]\n").values()]
    assert [(axis.columns["position"].name, axis.columns["effort"].name) for axis in axes] == [
        ("y[0]", "u[1]"),
        ("y[1]", "u[2]"),
    ]


@pytest.mark.parametrize(
    "names", [("a1", "a2", "a3"), ("a0", "a1", "a2"), ("turn", "lift", "twist")]
)
def test_names_may_count_from_0_or_1(names):
    tables = joints(COMMON + "".join(f"[[joint]]\nname = '{name}'\n" for name in names))
    assert [axis_from(table).columns["effort"].name for table in tables.values()] == [
        "u1",
        "u2",
        "u3",
    ]


@pytest.mark.parametrize(
    ("common", "names", "message"),
    [
        (
            COMMON.replace("u{joint}", "u[{joint}]"),
            ("a1",),
            r"joint\[0\].name: uses \[\{joint\}\].*write \[\{joint0\}\]",
        ),
        (COMMON, ("a1", "a3"), r"joint\[1\].name: is the table of joint 2.*'a3'"),
        (COMMON, ("a0", "a2"), r"joint\[1\].name: is the table of joint 2.*'a2'"),
        (COMMON, ("a2", "a3"), r"joint\[0\].name: is the table of joint 1.*'a2'"),
        (ARRAYS, ("a1", "a3"), r"joint\[1\].name: is the table of joint 2"),
    ],
)
def test_a_joint_that_would_have_the_columns_of_another_joint_is_refused(common, names, message):
    with pytest.raises(InputError, match=message):
        joints(common + "".join(f"[[joint]]\nname = '{name}'\n" for name in names))


def test_a_joint_with_its_own_columns_may_have_any_name():
    own = COMMON.replace('"q{joint}"', '"q"').replace('"u{joint}"', '"u"')
    assert list(joints(own + "[[joint]]\nname = 'a3'\n")) == ["a3"]
