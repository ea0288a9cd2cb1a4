"""What a proposed axis file says of a log, line by line."""

import math

import numpy as np
import pytest

from bristle.files import proposal
from bristle.files.axis import read_axis
from bristle.files.proposal import FILL_IN, missing_of, propose_axis
from bristle.logs.roles import Role, Roles
from bristle.logs.table import Table


def written(folder, header, *columns, before="", name="stage.csv"):
    """A log with these columns."""
    rows = [",".join(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True)]
    path = folder / name
    path.write_text("\n".join([*before.splitlines(), header, *rows]) + "\n", encoding="utf-8")
    return path


T = 0.001 * np.arange(2000)
TURN = 2.0 * math.pi * T
POSITION, VELOCITY = 20.0 * np.sin(TURN), 40.0 * math.pi * np.cos(TURN)
FRICTION = 3.0 * np.tanh(VELOCITY) - 5.0 * np.sin(TURN)


def test_a_log_with_units_gives_a_complete_proposal(tmp_path):
    item = propose_axis(
        written(tmp_path, "time [s],position [mm],force [N]", T, POSITION, FRICTION)
    )
    assert (item.missing, item.axis.kind) == ((), "translational")
    lines = item.text.splitlines()
    assert lines[0].startswith("# Proposed by bristle from stage.csv")
    assert {
        'name = "stage"',
        'kind = "translational"',
        'position = { column = "position", unit = "mm" }',
    } <= set(lines)
    # The position has no clear step, and nothing is open or unused.
    assert [
        word for word in ("Fill in", "[encoder]", "timing", "unused") if word in item.text
    ] == []
    assert not any("is taken as 1 in SI" in note for note in item.notes)


def test_unknown_values_must_be_filled_in(tmp_path):
    item = propose_axis(written(tmp_path, "time,position,current [A]", T, POSITION, FRICTION))
    assert {"columns.position.unit", "effort.constant"} <= set(item.missing)
    for line in (
        f"# Fill in the question marks ({', '.join(item.missing)}), then inspect the log with this file.",
        '# kind = "translational" or "rotational": the unit of the position decides',
        'constant = "?"  # force or torque per A, such as "61.2 N/A"',
    ):
        assert line in item.text
    assert {f"{key} is unknown: bristle assumes 1 in SI units" for key in item.missing} <= set(
        item.notes
    )


@pytest.mark.parametrize(
    ("head", "columns", "part"),
    [
        (
            "time [s],position [mm],force [N]",
            (T, 0.05 * np.round(POSITION / 0.05), FRICTION),
            '\n\n# [encoder]\n# resolution = "0.05 mm"  # smallest step of the position',
        ),
        (
            "time [s],velocity,torque [Nm]",
            (T, VELOCITY, FRICTION),
            "the unit of the velocity decides",
        ),
        (
            "time [s],speed [Hz],torque [Nm]",
            (T, VELOCITY, FRICTION),
            'unit = "rev/s" }  # the file states Hz: check that these are turns',
        ),
        (
            "time [s],position [deg],current [A]",
            (T, POSITION, FRICTION),
            'constant = "?"  # torque per A, such as "0.12 N*m/A"',
        ),
        # Before the unit of the effort.
        ("time [s],position [deg],force [N]", (T, POSITION, FRICTION), 'kind = "rotational"'),
        (
            "position [mm],force [N]",
            (POSITION, FRICTION),
            'sample_time = "?"  # time between samples, such as "1 ms"',
        ),
        (
            "dt;2 ms\nts;1 ms\nposition [mm],force [N]",
            (POSITION, FRICTION),
            "the log states 'dt: 2 ms'; the log states 'ts: 1 ms'",
        ),
        (
            "dt;2 ms\ntime [s],position [mm],force [N]",
            (np.floor(T), POSITION, FRICTION),
            'sample_time = "0.002 s"',
        ),
        (
            "time [s],position [mm],force [N],spare",
            (T, POSITION, FRICTION, np.ones_like(T)),
            "\n# unused columns: spare\n",
        ),
    ],
)
def test_open_values_are_asked_for_or_shown(tmp_path, head, columns, part):
    assert part in propose_axis(written(tmp_path, head, *columns)).text


@pytest.mark.parametrize(
    ("unit", "is_link"), [("position [deg],torque [Nm]", True), ("position [mm],force [N]", False)]
)
def test_an_effort_that_depends_on_the_angle_suggests_a_link(tmp_path, unit, is_link):
    angle = 120.0 * np.sin(TURN)
    torque = 4.0 * np.sin(np.radians(angle)) + 0.05 * np.tanh(VELOCITY)
    item = propose_axis(written(tmp_path, f"time [s],{unit}", T, angle, torque))
    remark = 'gravity = "link"  # the effort depends on sine and cosine of the angle'
    assert (remark in item.text, item.axis.gravity) == (is_link, is_link)


SHORT = T[:500], 60.0 * np.sin(1.1 * TURN[:500]) + 40.0 * np.sin(1.7 * TURN[:500])
SPEED = np.gradient(SHORT[1], SHORT[0])


@pytest.mark.parametrize(
    ("motion", "effort", "is_named"),
    [
        ((T, POSITION), 3.0 * np.tanh(VELOCITY), False),
        ((T, POSITION), -3.0 * np.tanh(VELOCITY), True),
        # No motion that is closed.
        (SHORT, 0.02 * np.gradient(SPEED, SHORT[0]) + 3.0 * np.tanh(SPEED), False),
    ],
)
def test_an_effort_that_takes_work_out_of_the_axis_is_turned(tmp_path, motion, effort, is_named):
    item = propose_axis(written(tmp_path, "time [s],position [mm],force [N]", *motion, effort))
    assert [
        "sign = -1" in item.text,
        "takes work out of the axis" in item.text,
        item.axis.columns["effort"].scale < 0.0,
    ] == 3 * [is_named]


def test_header_lines_provide_constants(tmp_path):
    facts = "torque constant;0.25 Nm/A\nlead;10 mm\n"
    item = propose_axis(
        written(tmp_path, "time [s],position [mm],current [A]", T, POSITION, FRICTION, before=facts)
    )
    assert item.missing == ()
    assert item.text.endswith(
        '[effort]\nconstant = "0.25 N*m/A"\n\n[transmission]\nlead = "10 mm"\n'
    )
    # 2 pi / 10 mm of 0.25 N m are 157 N.
    assert item.axis.columns["effort"].scale == pytest.approx(157.0796, rel=1e-6)
    nought = propose_axis(
        written(
            tmp_path,
            "time [s],position [mm],current [A]",
            T,
            POSITION,
            FRICTION,
            before="lead;0 mm\n",
        )
    )
    assert ("effort.constant" in nought.missing, 'lead = "0' in nought.text) == (True, False)


@pytest.mark.parametrize(
    ("effort", "kind", "missing"),
    [("force [N]", "translational", ("transmission.lead",)), ("torque [Nm]", "rotational", ())],
)
def test_counts_per_turn_with_a_force_suggest_a_screw(tmp_path, effort, kind, missing):
    log = written(
        tmp_path,
        f"time [s],position [count],{effort}",
        T,
        1e3 * POSITION,
        FRICTION,
        before="counts per rev;4096\n",
    )
    item = propose_axis(log)
    assert "counts_per_rev = 4096" in item.text
    assert (item.axis.kind, item.missing) == (kind, missing)


def test_a_reference_follows_the_unit_of_the_position():
    tables = {
        "columns": {
            name: {"column": name, "unit": FILL_IN}
            for name in ("position", "reference", "following_error")
        }
    }
    assert missing_of(tables) == ["columns.position.unit"]
    tables["columns"]["position"]["unit"] = "mm"
    assert missing_of(tables) == ["columns.reference.unit", "columns.following_error.unit"]


@pytest.mark.parametrize(
    ("tables", "turns"),
    [
        ({"encoder": {"counts_per_rev": 4096}}, True),
        ({"effort": {"rated": "2.4 N*m"}}, True),
        ({"effort": {"rated": "120 N"}}, False),
        ({"effort": {"constant": "0.12 N*m/A"}}, True),
        ({"effort": {"constant": "61.2 N/A"}}, False),
        ({"columns": {"effort": {"unit": "mN*m"}}}, True),
        ({"columns": {"effort": {"unit": "kN"}}}, False),
        ({"columns": {"effort": {"unit": "A"}}}, None),
        ({"effort": {"rated": FILL_IN}, "columns": {"effort": {"unit": FILL_IN}}}, None),
        ({}, None),
    ],
)
def test_a_torque_or_counts_per_turn_suggest_a_rotational_drive(tables, turns):
    assert proposal._turns({"columns": {}} | tables) is turns


def test_missing_units_are_assumed_to_be_si():
    tables = {
        "columns": {
            "position": {"column": "x", "unit": FILL_IN},
            "velocity": {"column": "v", "unit": FILL_IN},
            "effort": {"column": "i", "unit": "mA"},
        },
        "effort": {"constant": FILL_IN},
        "encoder": {"resolution": FILL_IN},
        "timing": {"sample_time": FILL_IN},
        "transmission": {"lead": "5 mm"},
    }
    assumed = proposal._assumed(tables)
    assert {name: entry["unit"] for name, entry in assumed["columns"].items()} == {
        "position": "m",
        "velocity": "m/s",
        "effort": "mA",
    }
    assert {
        name: assumed[name] for name in ("kind", "effort", "encoder", "timing", "transmission")
    } == {
        "kind": "translational",
        "effort": {"constant": "1 N/A"},
        "encoder": {"resolution": "1 m"},
        "timing": {"sample_time": "1 s"},
        "transmission": {"lead": "5 mm"},
    }
    turning = proposal._assumed(tables | {"encoder": {"counts_per_rev": 4096}})
    assert (
        turning["kind"],
        turning["columns"]["position"]["unit"],
        turning["effort"]["constant"],
    ) == ("rotational", "rad", "1 N*m/A")
    assert tables["columns"]["position"]["unit"] == FILL_IN


@pytest.mark.parametrize(
    ("position", "velocity", "lead", "is_kept"),
    [
        ("mm", "mm/s", None, True),
        ("mm", "rpm", None, False),  # of the motor: how far a turn of it moves the axis nobody says
        ("mm", "rpm", "10 mm", True),
        ("deg", "rpm", None, True),
        ("count", "rpm", "10 mm", False),
        ("mm", "count/s", "10 mm", False),
        ("count", "count/s", None, True),
    ],
)
def test_a_velocity_is_kept_where_the_way_from_there_to_the_position_is_known(
    position, velocity, lead, is_kept
):
    columns = {"t": T, "q": POSITION, "v": VELOCITY, "u": FRICTION}
    table = Table(
        columns,
        {"u": "N*m" if position == "deg" else "N"},
        names=tuple(columns),
        facts={} if lead is None else {"lead": lead},
    )
    channels = {
        "position": Role("q", position, "header", "its name"),
        "velocity": Role("v", velocity, "header", "its name"),
    }
    tables = proposal._tables(
        table, Roles(channels | {"effort": Role("u", table.units["u"], "header", "its name")})
    )
    assert ("velocity" in tables["columns"]) is is_kept
    assert tables["columns"]["position"] == {"column": "q", "unit": position}


@pytest.mark.parametrize(
    ("channel", "unit", "unknown", "unit_source", "line"),
    [
        ("position", "mm", "", "header", 'position = { column = "c", unit = "mm" }'),
        (
            "position",
            "mm",
            "",
            "velocity",
            'position = { column = "c", unit = "mm" }  # unit from the velocity',
        ),
        (
            "reference",
            "?",
            "",
            "header",
            'reference = { column = "c" }  # in the unit of the position',
        ),
        ("reference", "mm", "", "header", 'reference = { column = "c", unit = "mm" }'),
        (
            "velocity",
            "?",
            "",
            "",
            'velocity = { column = "c", unit = "?" }  # unit of the numbers: mm/s, m/min, rad/s, deg/s or rpm',
        ),
        (
            "time",
            "?",
            "ticks",
            "",
            'time = { column = "c", unit = "?" }  # the file states the unknown unit "ticks"; unit of the numbers: s, ms, us or ns',
        ),
    ],
)
def test_a_column_is_written_with_the_grounds_of_its_unit(
    channel, unit, unknown, unit_source, line
):
    roles = Roles({channel: Role("c", unit.strip(FILL_IN), unit_source, "its name", unknown)})
    assert proposal._column_line(channel, {"column": "c", "unit": unit}, roles) == line


def test_guessed_columns_have_a_reason_and_reversed_efforts_a_remark():
    roles = Roles({"effort": Role("c", "N", "header", "it follows the motion")})
    line = proposal._column_line("effort", {"column": "c", "unit": "N", "sign": -1}, roles)
    assert line.endswith(
        "# it follows the motion; the recorded effort takes work out of the axis, so its sign is reversed"
    )


WORM = VELOCITY / 6.0  # speed of the load [rpm]
ASKED, KNOWN = ("effort.rated", "transmission.gear_ratio"), ("effort.rated",)


@pytest.mark.parametrize(
    ("head", "columns", "missing", "scales"),
    [
        ("angle [deg]", (POSITION,), ASKED, (1.0, 78.0)),  # of a worm of 60:1 and 1.3 N m
        ("angle [deg],motor speed [rpm]", (POSITION, -60.0 * WORM), KNOWN, (1.0, 78.0)),
        ("motor angle [deg],load speed [rpm]", (60.0 * POSITION, WORM), KNOWN, (1.0 / 60.0, 78.0)),
        ("motor speed [rpm],load speed [rpm]", (60.0 * WORM, WORM), KNOWN, (1.0 / 60.0, 78.0)),
        ("load speed [rpm],Motordrehzahl [U/min]", (WORM, 60.0 * WORM), KNOWN, (1.0 / 60.0, 78.0)),
        # A gear, or a speed in rev/s.
        ("angle [deg],speed [rpm]", (POSITION, 60.0 * WORM), ASKED, (1.0, 78.0)),
        # Of 10 mm a turn.
        (
            "position [mm],motor speed [rpm]",
            (POSITION, VELOCITY * 6.0),
            KNOWN,
            (1.0, 1.3 * 2.0 * math.pi / 0.01),
        ),
    ],
)
def test_the_gear_of_a_motor_is_asked_for_where_no_second_speed_shows_it(
    tmp_path, head, columns, missing, scales
):
    item = propose_axis(written(tmp_path, f"time [s],{head},torque [%]", T, *columns, FRICTION))
    assert item.missing == missing
    text = item.text.replace('rated = "?"', 'rated = "1.3 N*m"').replace(
        'gear_ratio = "?"', "gear_ratio = 60"
    )
    axis = read_axis(
        text.replace('unit = "deg" }', 'unit = "deg", side = "load" }')
        .replace('"rpm" }', '"rpm", side = "motor" }')
        .encode()
    )
    moved, effort = (
        axis.columns.get("position", axis.columns.get("velocity")),
        axis.columns["effort"],
    )
    assert (moved.scale, abs(effort.scale)) == pytest.approx(scales, rel=2e-3)
