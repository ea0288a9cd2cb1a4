"""Which column is which channel: by numbers, where names do not tell."""

import numpy as np
import pytest

from bristle.logs.roles import (
    candidate_of,
    correlation,
    explained,
    pulls_as_a_link,
    rate_of,
    roles_of,
    roughness,
    slope,
    time_among,
)
from bristle.logs.table import Table

TIME = 1e-3 * np.arange(4000)
PHASE = 2.0 * np.pi * TIME
POSITION = 0.1 * np.sin(PHASE) + 0.03 * np.sin(2.7 * PHASE)
VELOCITY = 0.1 * 2.0 * np.pi * np.cos(PHASE) + 0.03 * 2.7 * 2.0 * np.pi * np.cos(2.7 * PHASE)
SPEEDS = [("mm", 1e3, "mm/s"), ("mm", 6e4, "mm/min"), ("rev", 60.0, "rpm"), ("rev", 1.0, "rev/s")]
EFFORT = 5.0 * np.sign(VELOCITY) + 2.0 * VELOCITY


def roles(**columns):
    units = {name: column[1] for name, column in columns.items() if isinstance(column, tuple)}
    values = {
        name: column[0] if isinstance(column, tuple) else column for name, column in columns.items()
    }
    return roles_of(Table(values, units, names=tuple(values)))


def units_of(result):
    return {name: role.unit for name, role in result.channels.items()}


@pytest.mark.parametrize(
    ("time", "rate"), [(TIME, 3.0), (None, 3e-3), (TIME[:-1], 3e-3), (np.zeros(TIME.size), 3e-3)]
)
def test_the_rate_of_a_signal_is_taken_over_time_and_else_over_samples(time, rate):
    assert rate_of(3.0 * TIME, time)[20:-20] == pytest.approx(rate)


NOISE = np.random.default_rng(1).standard_normal(TIME.size)


@pytest.mark.parametrize(
    ("measure", "signals", "value"),
    [
        (slope, (POSITION, 7.0 - 3.0 * POSITION), pytest.approx(-3.0)),
        (slope, (np.ones(9), np.arange(9.0)), 0.0),
        (roughness, (POSITION,), pytest.approx(0.05, abs=0.05)),
        # Of white noise: root of 6 over root of 2
        (roughness, (NOISE,), pytest.approx(3.0**0.5, rel=0.05)),
        (roughness, (np.ones(30),), np.inf),
        (explained, (EFFORT, POSITION), pytest.approx(1.0, abs=0.05)),
        (explained, (NOISE, POSITION), pytest.approx(0.0, abs=0.02)),
        (explained, (np.ones(TIME.size), POSITION), pytest.approx(1.0)),
        (correlation, (POSITION, 7.0 - 3.0 * POSITION), pytest.approx(-1.0)),
        (correlation, (1e-200 * POSITION, 1e200 * POSITION), pytest.approx(1.0)),
        (correlation, (np.arange(20.0), np.arange(20.0)), pytest.approx(1.0)),
        (correlation, (np.arange(19.0), np.arange(19.0)), 0.0),
        (correlation, (POSITION, POSITION[:-1]), 0.0),
        (correlation, (POSITION, np.ones(POSITION.size)), 0.0),
        (correlation, (np.ones(POSITION.size), POSITION), 0.0),
        (correlation, (POSITION, -1e200 * POSITION), pytest.approx(-1.0)),
        (correlation, (POSITION, np.where(TIME == 0.005, np.nan, POSITION)), 0.0),
        (slope, (np.where(TIME == 0.005, np.nan, POSITION), POSITION), 0.0),
    ],
)
def test_measures_of_signals_are_those_of_their_shape(measure, signals, value):
    assert measure(*signals) == value


ANGLE = 20.0 * POSITION + 0.5
NARROW, WIDE = (size * (POSITION - POSITION.min()) / np.ptp(POSITION) for size in (0.99, 1.6))


@pytest.mark.parametrize(
    ("effort", "angle", "pulls"),
    [
        (EFFORT + 20.0 * np.sin(ANGLE), ANGLE, True),
        (EFFORT + 20.0 * np.cos(ANGLE), ANGLE, True),
        (EFFORT, ANGLE, False),
        (EFFORT + 20.0 * ANGLE, ANGLE, False),
        (EFFORT + 20.0 * np.sin(3.0 * POSITION), 3.0 * POSITION, False),  # [rad]
        ((EFFORT + 20.0 * np.sin(ANGLE))[:79], ANGLE[:79], False),
        (EFFORT[:-1], ANGLE, False),
        (EFFORT + 1e3 * np.cos(NARROW), NARROW, False),  # less than a radian
        (EFFORT + 1e3 * np.cos(WIDE), WIDE, True),
    ],
)
def test_a_link_pulls_with_sine_and_cosine_of_its_angle_over_a_wide_range(effort, angle, pulls):
    assert pulls_as_a_link(effort, angle) == pulls


def test_columns_are_identified_by_names_with_the_units_of_the_file():
    result = roles(
        t=(TIME, "s"),
        pos=(1e3 * POSITION, "mm"),
        vel=(VELOCITY, "m/s"),
        force=(EFFORT, "N"),
        possoll=(1e3 * POSITION + 0.01, "mm"),
    )
    assert units_of(result) == {
        "time": "s",
        "position": "mm",
        "velocity": "m/s",
        "reference": "mm",
        "effort": "N",
    }
    assert (
        [result.channels[name].column for name in ("position", "reference")],
        result.rivals,
    ) == (["pos", "possoll"], ())


@pytest.mark.parametrize(("factor", "unit"), [(1.0, "m"), (1e3, "mm"), (1e6, "um")])
def test_a_recorded_velocity_determines_the_unit_of_the_position(factor, unit):
    result = roles(
        time=(TIME, "s"),
        position=factor * POSITION,
        velocity=(VELOCITY, "m/s"),
        force=(EFFORT, "N"),
    )
    assert units_of(result)["position"] == unit
    assert result.channels["position"].unit_source == "velocity"


@pytest.mark.parametrize(
    ("unit", "factor", "own"),
    [("mm", 1e3, "mm/s"), ("mm", 6e4, "mm/min"), ("rev", 60.0, "rpm"), ("rev", 1.0, "rev/s")],
)
def test_the_position_determines_the_unit_of_a_velocity(unit, factor, own):
    position = POSITION * (1e3 if unit == "mm" else 1.0)
    result = roles(
        time=(TIME, "s"),
        position=(position, unit),
        velocity=factor * VELOCITY,
        torque=(EFFORT, "N*m"),
    )
    assert units_of(result)["velocity"] == own
    other = roles(
        time=(TIME, "s"),
        position=(position, unit),
        velocity=1.5 * factor * VELOCITY,
        torque=(EFFORT, "N*m"),
    )
    assert "velocity" not in other.channels


def test_unnamed_columns_are_identified_by_their_motion():
    result = roles(ch1=TIME, ch2=POSITION, ch3=EFFORT + 1e-4 * NOISE)
    assert {name: (role.column, role.reason) for name, role in result.channels.items()} == {
        "time": ("ch1", "it rises evenly"),
        "position": ("ch2", "it is the smoothest"),
        "effort": ("ch3", "it follows the motion"),
    }
    assert roles(ch1=TIME, ch2=POSITION, ch3=NOISE).channels.keys() == {"time"}


def test_the_speed_alone_is_the_motion_where_no_position_is():
    result = roles(time=(TIME, "s"), speed=(VELOCITY, "m/s"), force=(EFFORT, "N"))
    assert units_of(result) == {"time": "s", "velocity": "m/s", "effort": "N"}


@pytest.mark.parametrize(
    ("name", "effort", "unit", "unit_source"),
    [
        ("motor current", EFFORT, "A", "its name"),
        ("voltage", EFFORT, "V", "its name"),
        ("torque", np.round(100.0 * EFFORT), "‰", "drive"),
        ("torque", np.round(10.0 * EFFORT), "", "rated"),
        ("torque", np.round(1000.0 * EFFORT), "", ""),
        ("torque", EFFORT, "", ""),
    ],
)
def test_the_unit_of_an_effort_follows_from_its_name_or_integers(name, effort, unit, unit_source):
    role = roles(**{"time": (TIME, "s"), "position": (POSITION, "m"), name: effort}).channels[
        "effort"
    ]
    assert (role.unit, role.unit_source) == (unit, unit_source)


def chosen_effort(*names):
    """The column that is the effort, of several that hold the same numbers: each a name with its unit."""
    columns = {name: (EFFORT, unit) if unit else EFFORT for name, unit in names}
    return roles(t=(TIME, "s"), q=(POSITION, "m"), **columns).channels["effort"].column


@pytest.mark.parametrize(
    ("chosen", "left"),
    [
        (("torque a", "N"), ("torque b", "A")),  # a force tells more than a current
        (("torque a", "N*m"), ("torque b", "%")),  # than a share of the rated effort
        (("torque a", "A"), ("torque b", "")),
        (("torque a", "%"), ("torque b", "")),
        (("torque a", ""), ("torque b", "V")),  # a voltage tells least
        # What was measured outdoes a step of units.
        (("torque actual", "A"), ("torque wanted", "N")),
        (("torque other", "A"), ("torque actual", "V")),  # and no more than that
        # What was asked for is behind a measured one in a lesser unit.
        (("torque other", "A"), ("torque demand", "N")),
        (("torque demand", "N"), ("torque other", "V")),  # and before a voltage
    ],
)
def test_the_effort_has_the_best_unit_and_is_measured(chosen, left):
    assert chosen_effort(chosen, left) == chosen_effort(left, chosen) == chosen[0]


def test_of_two_columns_of_the_same_name_the_effort_follows_the_motion():
    for order in ({"torque a": NOISE, "torque b": EFFORT}, {"torque b": EFFORT, "torque a": NOISE}):
        assert (
            roles(t=(TIME, "s"), q=(POSITION, "m"), **order).channels["effort"].column == "torque b"
        )


def test_the_effort_of_an_axis_is_that_with_its_number():
    columns = {"torque 1": (EFFORT, "N"), "torque 2": (EFFORT, "N")}
    for number in (1, 2):
        result = roles(t=(TIME, "s"), **{f"pos {number}": (POSITION, "m")}, **columns)
        assert result.channels["effort"].column == f"torque {number}"


@pytest.mark.parametrize(("share", "pulls"), [(0.2, False), (0.3, True)])
def test_a_link_is_seen_where_its_angle_explains_a_quarter_of_the_rest(share, pulls):
    angle = 2.0 * np.pi * TIME  # at one speed its sine is no inertia and no friction
    angle += 0.02 * np.sin(40.0 * TIME)
    # Noise of variance 1, a sine of half its square.
    amplitude = np.sqrt(2.0 * share / (1.0 - share))
    assert pulls_as_a_link(NOISE + amplitude * np.sin(angle), angle) == pulls


def time_column(first=("q", POSITION), sample_time=None, **columns):
    """The column of time among a position and others, and why; None where there is none."""
    values = dict([first]) | columns
    table = Table(values, {}, names=tuple(values), sample_time=sample_time)
    result = time_among(
        table,
        [column for name in values if (column := candidate_of(table, name, is_nameless=False))],
    )
    return result and (result[0].name, result[1])


STEPS = np.arange(4000.0)


@pytest.mark.parametrize(
    ("stamps", "is_time"),
    [
        (TIME, True),
        (np.floor(STEPS / 40) * 0.04, True),  # of a host, that halts for 40 samples
        (np.floor(STEPS / 60) * 0.06, False),  # fewer than 2 % of the steps rise
        (np.where(STEPS == 2000, -1.0, TIME), True),  # a single step back
        (np.floor(STEPS / 40) * 0.04 - (STEPS == 2000), False),  # halts, and steps back
        (-TIME, False),
    ],
)
def test_stamps_are_called_time_and_rise_mostly_or_never_fall(stamps, is_time):
    assert time_column(time=stamps) == (("time", "its name") if is_time else None)


UNEVEN = 1e-3 * np.cumsum(1.0 + 0.5 * np.random.default_rng(1).uniform(-1.0, 1.0, 4000))


@pytest.mark.parametrize(
    ("first", "columns", "column"),
    [
        (("b", TIME), {"q": POSITION}, "b"),
        (("b", STEPS), {"q": POSITION}, None),  # a number of a row
        (("b", 2.0 * STEPS), {"q": POSITION}, "b"),
        (("b", UNEVEN), {"q": POSITION}, None),
        (("b", np.minimum(TIME, 3.9)), {"q": POSITION}, "b"),  # the first column may halt
        (("q", POSITION), {"b": np.minimum(TIME, 3.9)}, None),
        (("q", POSITION), {"b": TIME}, "b"),
        (("index", TIME), {"q": POSITION}, "index"),
        (("q", POSITION), {"index": TIME}, None),
        (("q", POSITION), {"force": TIME}, None),
    ],
)
def test_an_unnamed_column_that_rises_evenly_is_time(first, columns, column):
    result = time_column(first, **columns)
    assert result == (None if column is None else (column, "it rises evenly"))
    assert time_column(first, sample_time=1e-3, **columns) is None


def test_a_column_is_a_candidate_from_twenty_numbers_on_and_its_gaps_are_filled():
    table = Table(
        {"a": np.r_[np.nan, np.arange(19.0)], "b": np.arange(19.0), "c": np.full(20, np.nan)},
        {},
        names=("a", "b", "c"),
    )
    assert candidate_of(table, "a", is_nameless=True).values[:3].tolist() == [9.0, 0.0, 1.0]
    assert candidate_of(table, "b", is_nameless=True) is None
    assert candidate_of(table, "c", is_nameless=True) is None


@pytest.mark.parametrize(
    ("size", "about", "unit", "unit_source"),
    [
        (7, "", "", ""),
        (8, "", "", "rated"),
        (300, "", "", "rated"),
        (301, "", "‰", "drive"),
        (4000, "", "‰", "drive"),
        (4001, "", "", ""),
        (100, "INT16", "", "rated"),
        (101, "INT16", "‰", "drive"),
        (3, "a UINT8 of the drive", "", "rated"),
        (3, "a HINT16", "", ""),
    ],
)
def test_whole_numbers_of_a_drive_are_per_mille_or_a_share_of_the_rated_effort(
    size, about, unit, unit_source
):
    effort = np.round(size * EFFORT / np.max(np.abs(EFFORT)))
    columns = {"t": TIME, "q": POSITION, "torque": effort}
    role = roles_of(
        Table(columns, {"t": "s", "q": "m"}, names=tuple(columns), about={"torque": about})
    ).channels["effort"]
    assert (role.unit, role.unit_source) == (unit, unit_source)


@pytest.mark.parametrize(
    ("position", "unit"),
    [
        (np.round(100.0 * POSITION / np.max(np.abs(POSITION))), ""),
        (np.round(101.0 * POSITION / np.max(np.abs(POSITION))), "count"),
        (1e5 * POSITION, ""),
    ],
)
def test_whole_numbers_of_a_position_beyond_a_hundred_are_counts(position, unit):
    assert (
        units_of(roles(t=(TIME, "s"), position=position, force=(EFFORT, "N")))["position"] == unit
    )


@pytest.mark.parametrize(
    "name", ["load position", "scale", "linear scale", "x_table", "Tischlage", "pos_load"]
)
@pytest.mark.parametrize("unit", ["mm", ""])
def test_a_second_encoder_is_proposed_beside_that_of_the_motor(name, unit):
    table = 1e3 * POSITION + 0.02 * np.tanh(VELOCITY / 0.01)
    columns = {
        "t": (TIME, "s"),
        name: (table, unit) if unit else table,
        "motor position": (1e3 * POSITION, "mm"),
        "force": (EFFORT, "N"),
    }
    result = roles(**columns)
    assert units_of(result) == {"time": "s", "position": "mm", "load_position": "mm", "effort": "N"}
    assert [
        result.channels[channel].column for channel in ("position", "load_position", "effort")
    ] == ["motor position", name, "force"]


def test_a_column_that_moves_otherwise_or_alone_is_no_second_encoder():
    motor = {"t": (TIME, "s"), "motor position": (1e3 * POSITION, "mm"), "force": (EFFORT, "N")}
    others = {
        "scale": [(1e3 * np.sin(3.0 * PHASE), "mm"), (POSITION, "A"), 5e3 * POSITION],
        "table position setpoint": [(1e3 * POSITION, "mm")],
    }
    for name, columns in others.items():
        assert all(
            "load_position" not in roles(**motor, **{name: column}).channels for column in columns
        )
    alone = roles(t=(TIME, "s"), scale_position=(1e3 * POSITION, "mm"), force=(EFFORT, "N"))
    assert units_of(alone) == {"time": "s", "position": "mm", "effort": "N"}
