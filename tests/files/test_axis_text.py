"""An axis comes back from the file that is written of it."""

from dataclasses import replace

import numpy as np
import pytest

from bristle.core.axis import Axis
from bristle.files.axis import axis_from, axis_text, read_axis
from bristle.logs import Channel
from bristle.logs.log import Log

BASE = {"schema": 1, "name": "stage", "kind": "translational"}
COLUMNS = {
    "time": {"column": "t", "unit": "ms"},
    "position": {"column": "q", "unit": "mm"},
    "effort": {"column": "u", "unit": "N"},
}


LINEAR = {
    "plant": {"mass": "95 kg", "offset": "-3 N"},
    "timing": {"sample_time": "0.5 ms", "delay": "250 us"},
    "limits": {"velocity": "300 mm/s", "stroke": ["0 mm", 0.25]},
    "encoder": {"resolution": "50 nm"},
    "identification": {"cutoff": "0.1 kHz", "decimation": 5, "rests": "keep"},
    "effort": {"lag": "300 us", "held": True, "limit": "200 N"},
    "injected": [
        {"column": "pulses", "gain": "2 N"},
        {"column": "more", "gain": 0.5, "optional": True},
    ],
    "known": [{"column": "wind (N)"}, {"column": "wind (N)", "name": "twice"}],
    "cogging": [{"turn": "motor", "harmonics": [6, 1, 6]}],
    "transmission": {"lead": "10 mm"},
    "controller": {"model": "cascade", "k_p": "80 1/s", "k_v": "4000 N*s/m"},
}
TURNING = {
    "kind": "rotational",
    "columns": COLUMNS
    | {
        "position": {"column": "q", "unit": "rad"},
        "effort": {"column": "i", "unit": "A", "sign": -1},
    },
    "effort": {"torque_constant": "0.5 N*m/A", "lag": "identify"},
    "plant": {"inertia": "4 kg*cm^2", "gravity": "link"},
    "log": {"start": "rest"},
    "cogging": [{"turn": "motor", "harmonics": "identify"}],
}
FORCE = {
    "columns": COLUMNS | {"effort": {"column": "i", "unit": "A", "optional": True}},
    "effort": {"force_constant": "61.2 N/A"},
    "log": {"start": "cycle"},
}


CASES = {
    "bare": {},
    "linear": LINEAR,
    "turning": TURNING,
    "force": FORCE,
    "delay": {"timing": {"delay": "identify"}},
}


@pytest.mark.parametrize("tables", CASES.values(), ids=CASES)
def test_an_axis_survives_a_round_trip(tables):
    axis = axis_from(BASE | {"columns": COLUMNS} | tables)
    text = axis_text(axis)
    assert text.startswith(b"# The axis of these results, in SI units.\nschema = 1\n")
    again = read_axis(text)
    assert (again, axis_text(again)) == (axis, text)


def test_an_existing_axis_file_is_kept():
    text = b'# of a person\nschema = 1\nname = "stage"\nkind = "translational"\n[columns]\nposition = "q"\neffort = "u"\n'
    axis = read_axis(text)
    assert axis_text(axis) == text
    heavier = axis_text(replace(axis, mass=5.0))
    assert (b"mass = 5" in heavier, b"of a person" in heavier) == (True, False)


def test_without_columns_those_of_the_log_are_named():
    log = Log(time=0.01 * np.arange(5), position=np.arange(5.0), effort=np.ones(5))
    text = axis_text(None, log)
    axis = read_axis(text)
    assert axis.kind == log.kind
    assert {name: column.base for name, column in axis.columns.items()} == {
        "time": "s",
        "position": "m",
        "effort": "N",
    }
    assert set(read_axis(axis_text(Axis(kind="translational", mass=3.0), log)).columns) == {
        "time",
        "position",
        "effort",
    }
    named = axis_from(BASE | {"columns": COLUMNS})
    assert axis_text(named, log) == axis_text(named)


def test_known_inputs_of_a_log_are_in_si_already(monkeypatch):
    channels = {"time": np.arange(3.0), "position": np.arange(3.0), "effort": np.ones(3)}
    log = Log(**channels)
    named = {
        "position": log.position,
        "effort": log.effort,
        "injected.pulses": Channel(np.ones(3), "N", "pulses"),
    }
    monkeypatch.setattr(Log, "channels", lambda self: iter(named.items()))
    axis = read_axis(axis_text(None, log))
    assert [(item.column, item.gain) for item in axis.injected] == [("injected.pulses", 1.0)]
    assert set(axis.columns) == {"position", "effort"}
