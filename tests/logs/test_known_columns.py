"""Known columns: given and identified coefficients, units, and columns of a second table."""

from __future__ import annotations

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.files.axis import axis_text, read_axis
from bristle.identification import identify
from bristle.logs.readers import read_log

TIME = np.arange(2000) * 1e-3
POSITION = 0.05 * np.sin(2 * np.pi * 1.1 * TIME) + 0.02 * np.sin(2 * np.pi * 2.3 * TIME)
VELOCITY, ACCELERATION = np.gradient(POSITION, TIME), np.gradient(np.gradient(POSITION, TIME), TIME)
PRESSURE = 3e5 + 1e5 * np.sin(2 * np.pi * 0.7 * TIME)  # [Pa]
TENSION = np.cos(2 * np.pi * 1.7 * TIME)
EFFORT = (
    12.0 * ACCELERATION
    + 8.0 * np.sign(VELOCITY)
    + 30.0 * VELOCITY
    + 2e-5 * PRESSURE
    + 4.0 * TENSION
)
AXIS = """
schema = 1
kind = "translational"
[columns]
time = { column = "t", unit = "s" }
position = { column = "x", unit = "m" }
effort = { column = "u", unit = "N" }
"""


def written(place, head, *columns):
    np.savetxt(
        place, np.stack(columns, axis=1), delimiter=",", header=head, comments="", fmt="%.12g"
    )
    return place


@pytest.fixture
def log(tmp_path):
    return written(tmp_path / "log.csv", "t,x,u,p [mbar]", TIME, POSITION, EFFORT, PRESSURE / 100.0)


@pytest.fixture
def second(tmp_path):
    """A table at another rate, that begins before the log and ends after it."""
    times = np.arange(-0.01, 2.01, 0.004)
    return written(
        tmp_path / "belt.csv", "t [ms],belt tension", 1e3 * times, np.cos(2 * np.pi * 1.7 * times)
    )


def axis_file(folder, *entries):
    (folder / "axis.toml").write_text(AXIS + "".join(f"[[known]]\n{entry}\n" for entry in entries))
    return read_axis(folder / "axis.toml")


def fitted(log, axis):
    fit = identify(
        read_log(log, axis), "coulomb_viscous", axis=axis, method="inverse_dynamics", draws=0
    ).fits[0]
    return {name: estimate.value for name, estimate in fit.parameters.items()}, fit.error_percent


def test_a_coefficient_refers_to_the_unit_of_the_axis_file(tmp_path, log, second):
    axis = axis_file(
        tmp_path, 'column = "p"\nunit = "bar"', 'column = "belt tension"\nfile = "belt.csv"'
    )
    values, error = fitted(log, axis)
    # 2 N for 1 bar
    assert (values["known_p"], values["known_belt_tension"]) == pytest.approx((2.0, 4.0), rel=0.01)
    assert error < 3.0


@pytest.mark.parametrize(
    ("coefficient", "held", "is_right"), [('"0.004 kN"', 4.0, True), ("-4.0", -4.0, False)]
)
def test_a_given_coefficient_is_held_and_explains_its_part(
    tmp_path, log, second, coefficient, held, is_right
):
    entries = (
        'column = "p"\nunit = "bar"\ncoefficient = "2 N"',
        f'column = "belt tension"\nfile = "belt.csv"\ncoefficient = {coefficient}',
    )
    values, error = fitted(log, axis_file(tmp_path, *entries))
    assert (values["known_belt_tension"], values["known_p"]) == (held, 2.0)
    assert values["M"] == pytest.approx(12.0, rel=0.01)
    assert error < 1.0 if is_right else error > 8.0


def test_a_table_of_the_results_names_the_second_table_by_its_full_path(tmp_path, log, second):
    axis = axis_file(tmp_path, 'column = "belt tension"\nfile = "belt.csv"\ncoefficient = "4 N"')
    assert axis.regressors[0].file == str(second)
    again = read_axis(axis_text(axis))
    assert again.regressors == axis.regressors


def test_a_log_without_times_uses_its_sample_time(tmp_path, second):
    written(tmp_path / "timeless.csv", "x,u", POSITION, EFFORT)
    text = (
        AXIS.replace('time = { column = "t", unit = "s" }\n', "")
        + '[timing]\nsample_time = "1 ms"\n'
    )
    (tmp_path / "timeless.toml").write_text(
        text + '[[known]]\ncolumn = "belt tension"\nfile = "belt.csv"\n'
    )
    recorded = read_log(tmp_path / "timeless.csv", read_axis(tmp_path / "timeless.toml"))
    assert recorded.regressors[0].values == pytest.approx(TENSION, abs=1e-3)


def test_a_second_table_may_end_a_rounded_sample_before_the_log_and_must_cover_its_span(
    tmp_path, log, second
):
    rounded = np.minimum(TIME, TIME[-1] - 4e-4)
    written(tmp_path / "belt.csv", "t,belt tension", rounded, TENSION)
    axis = axis_file(tmp_path, 'column = "belt tension"\nfile = "belt.csv"')
    assert read_log(log, axis).regressors[0].values == pytest.approx(TENSION, abs=1e-2)
    written(tmp_path / "belt.csv", "t,belt tension", TIME[:-500], TENSION[:-500])
    (tmp_path / "axis.toml").write_text(
        (tmp_path / "axis.toml").read_text() + '[log]\nspan = ["0 s", "1 s"]\n'
    )
    assert read_log(log, read_axis(tmp_path / "axis.toml")).time.values[-1] < 1.0


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ('column = "belt"\nfile = "belt.csv"', r"has no column 'belt'"),
        ('column = "belt tension"\nfile = "short.csv"', r"ends within the log"),
        (
            'column = "belt tension"\nfile = "timeless.csv"',
            r"needs a column of time in both tables",
        ),
        ('column = "p"\nunit = "barr"', "is not a unit"),
    ],
)
def test_a_second_table_must_cover_the_log_and_a_unit_exist(tmp_path, log, second, entry, message):
    written(tmp_path / "short.csv", "t,belt tension", TIME[:-500], TENSION[:-500])
    written(tmp_path / "timeless.csv", "a,belt tension", TENSION, TENSION)
    with pytest.raises(InputError, match=message):
        read_log(log, axis_file(tmp_path, entry))
