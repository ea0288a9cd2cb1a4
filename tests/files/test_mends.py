"""What a message proposes works when it is typed: each refusal is followed until the axis file is accepted."""

import re

import pytest

from bristle.core import InputError
from bristle.files.axis import axis_from

MOST = 5  # messages in a row
ENTRY = re.compile(r'[Ww]rite (?:.*?such as )?(\w+) = ("[^"]+"|[\d.]+)(?:.*?under \[([\w.]+)\])?')


def typed(data, error):
    """Return the tables with what the message says written into them."""
    match = ENTRY.search(error.mend) or re.search(
        r'such as (\w+) = ("[^"]+") under \[([\w.]+)\]', error.mend
    )
    assert match, str(error)
    key, value, table = match[1], match[2], match[3]
    place = data
    for name in (
        (table or error.path.rpartition(".")[0]).split(".") if (table or "." in error.path) else ()
    ):
        place = place.setdefault(name, {})
    place[key] = value.strip('"') if value.startswith('"') else float(value)
    return data


def table(**entries):
    base = {
        "schema": 1,
        "kind": "translational",
        "columns": {"position": {"column": "q", "unit": "mm"}},
    }
    for path, value in entries.items():
        keys = path.split("__")
        place = base
        for key in keys[:-1]:
            place = place.setdefault(key, {})
        if value is None:
            place.pop(keys[-1], None)
        else:
            place[keys[-1]] = value
    return base


@pytest.mark.parametrize(
    "data",
    [
        table(columns__effort={"column": "u", "unit": "%"}),
        table(columns__effort={"column": "u", "unit": "‰"}),
        table(columns__effort={"column": "u", "unit": "V"}),
        table(
            columns__effort={"column": "u", "unit": "A"},
            kind="rotational",
            columns__position={"column": "q"},
        ),
        table(columns__effort={"column": "u", "unit": "N*m"}),
        table(columns__position={"column": "q", "unit": "rev"}),
        table(columns__position={"column": "q", "unit": "count"}),
        table(
            columns__position={"column": "q", "unit": "deg"},
            kind="rotational",
            transmission={"gear_ratio": 50},
        ),
        table(kind=None, columns__position={"column": "q"}),
        table(columns__load={"column": "F", "unit": "N"}),
    ],
    ids=["%", "‰", "V", "A", "N*m", "rev", "count", "side", "kind", "load"],
)
def test_remedies_in_messages_are_accepted(data):
    text = [refusal(data)]
    for _ in range(MOST):
        data = typed(data, text[-1])
        following = refusal(data)
        if following is None:
            return
        assert str(following) not in map(str, text)
        text.append(following)
    pytest.fail(f"still refused: {text[-1]}")


def refusal(data):
    try:
        axis_from(data)
    except InputError as error:
        return error
    return None


def test_a_share_of_the_rated_effort_may_be_that_of_a_gain():
    data = table(
        kind="translational",
        columns__effort={"column": "u", "unit": "‰"},
        effort={"rated": "2.4 N*m"},
        transmission={"gear_ratio": 2, "lead": "10 mm"},
        controller={"model": "cascade", "k_p": "60 1/s", "k_v": "20 %*s/rad"},
    )
    axis = axis_from(data)
    # 1 % of 2.4 N*m for 1 rad/s of the motor, which moves the axis by 10 mm/(2 * 2 pi).
    assert axis.controller.values["k_v"] * axis.arm**2 == pytest.approx(0.2 * 2.4, rel=1e-12)
    assert axis.columns["effort"].unit == "‰"


@pytest.mark.parametrize(("unit", "kind"), [("mm", "translational"), ("deg", "rotational")])
def test_the_unit_of_the_position_decides_the_kind(unit, kind):
    assert axis_from(table(kind=None, columns__position={"column": "q", "unit": unit})).kind == kind


OF_DRIVE = {"column": "u", "unit": "A"}


@pytest.mark.parametrize(
    ("entries", "scale"),
    [
        ({"effort": {"constant": "61.2 N/A"}}, 61.2),
        (
            {"kind": "rotational", "columns__position": "q", "effort": {"constant": "0.12 N*m/A"}},
            0.12,
        ),
    ],
)
def test_a_constant_is_a_force_or_a_torque(entries, scale):
    assert axis_from(table(columns__effort=OF_DRIVE, **entries)).columns["effort"].scale == scale
