"""A part of a log, and what surrounds an axis: load and temperature."""

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.files import read_axis, read_log

AXIS = """
schema = 1
kind = "translational"

[log]
span = ["2 s", "6 s"]
start = "cycle"

[columns]
time = { column = "t", unit = "s" }
position = { column = "x", unit = "mm" }
effort = { column = "F", unit = "N" }
load = { column = "N", unit = "kN" }
temperature = { column = "T", unit = "degC" }

[plant]
nominal_load = "500 N"
"""


@pytest.fixture
def bench(tmp_path):
    t = 0.01 * np.arange(1000)
    columns = [t, 10.0 * np.sin(t), np.cos(3.0 * t), 0.5 + 0.1 * np.sin(t), 20.0 + 0.0 * t]
    rows = [",".join(f"{item:.9g}" for item in row) for row in zip(*columns, strict=True)]
    (tmp_path / "log.csv").write_text("\n".join(["t,x,F,N,T", *rows]) + "\n")
    (tmp_path / "axis.toml").write_text(AXIS)
    return tmp_path


def test_load_is_over_its_nominal_value_and_temperature_in_kelvin_within_the_span(bench):
    axis = read_axis(bench / "axis.toml")
    log = read_log(bench / "log.csv", axis)
    assert axis.in_cycle
    assert log.time.values[[0, -1]] == pytest.approx([2.0, 5.99], abs=0.011)
    assert log.load.values == pytest.approx(1.0 + 0.2 * np.sin(log.time.values))
    assert log.temperature.values == pytest.approx(np.full(len(log), 293.15))
    assert (log.load.unit, log.temperature.unit) == ("1", "K")


@pytest.mark.parametrize(
    ("was", "now", "said"),
    [
        ('nominal_load = "500 N"', "", "plant.nominal_load: is missing"),
        ('nominal_load = "500 N"', 'nominal_load = "0 N"', "plant.nominal_load: must be positive"),
        ('unit = "kN"', 'unit = "kg"', "columns.load.unit"),
        ('unit = "degC"', 'unit = "m"', "columns.temperature.unit"),
        ('span = ["2 s", "6 s"]', 'span = ["6 s", "2 s"]', "log.span: must be in ascending order"),
        (
            'span = ["2 s", "6 s"]',
            'span = ["20 s", "60 s"]',
            "log.span: contains fewer than 10 samples",
        ),
        ('start = "cycle"', 'start = "loop"', "log.start"),
    ],
)
def test_a_span_outside_the_log_is_refused(bench, was, now, said):
    (bench / "axis.toml").write_text(AXIS.replace(was, now))
    with pytest.raises(InputError, match=said):
        read_log(bench / "log.csv", bench / "axis.toml")
