"""A log and the axis file that explains it."""

from __future__ import annotations

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.files.arguments import read_log
from bristle.files.axis import read_axis

AXIS = """
schema = 1
kind = "rotational"
[columns]
time = { column = "t", unit = "ms" }
position = { column = "q", unit = "deg", side = "motor" }
effort = { column = "i", unit = "A", sign = -1 }
[effort]
torque_constant = "0.5 N*m/A"
[transmission]
gear_ratio = 10
"""


@pytest.fixture
def log_file(tmp_path):
    t = np.arange(300.0)
    q, i = 90 * np.sin(t / 40), -np.cos(t / 40) - 0.01 * t
    rows = "".join(
        f"{a},{b!r},{c!r}\n" for a, b, c in zip(t.tolist(), q.tolist(), i.tolist(), strict=True)
    )
    (tmp_path / "log.csv").write_text("t,q,i\n" + rows)
    return tmp_path / "log.csv"


@pytest.mark.parametrize(
    "values", [str, lambda path: path, read_axis], ids=["text", "path", "axis"]
)
def test_an_axis_is_a_file_or_an_object(tmp_path, log_file, values):
    (tmp_path / "axis.toml").write_text(AXIS)
    log = read_log(log_file, values(tmp_path / "axis.toml"))
    assert (log.kind, log.sample_time, log.effort.unit) == (
        "rotational",
        pytest.approx(1e-3),
        "N*m",
    )
    assert np.max(log.position.values) == pytest.approx(np.pi / 20, rel=1e-3)
    assert log.effort.values[0] == pytest.approx(5.0)  # -1 A, sign, 0.5 N*m/A, gear of 10


def test_a_bad_axis_file_is_named_before_the_log_is_read(tmp_path):
    (tmp_path / "axis.toml").write_text(AXIS.replace("gear_ratio", "gear"))
    with pytest.raises(InputError, match=r"axis\.toml: transmission\.gear: unknown key"):
        read_log(tmp_path / "no_such_log.csv", tmp_path / "axis.toml")


PARTS = {
    "speed": 'schema = 1\nkind = "rotational"\n[columns]\ntime = "time"\nvelocity = { column = "speed", unit = "rev/s" }\n',
    "silent": 'schema = 1\n[columns]\nposition = { column = "x", unit = "mm" }\n',
    "timed": 'schema = 1\n[columns]\nposition = { column = "x", unit = "mm" }\n[timing]\nsample_time = "2 ms"\n',
    "stamped": 'schema = 1\n[columns]\ntime = "time"\nposition = { column = "x", unit = "mm" }\n[timing]\nsample_time = "2 ms"\n',
    "role": 'schema = 1\n[columns]\nposition = { column = "time", unit = "mm" }\n',
}


@pytest.mark.parametrize(
    ("head", "axis", "step", "factor", "note"),
    [
        (
            "time [s],speed [Hz]",
            "speed",
            2.0,
            2.0 * np.pi,
            "column speed has the unit 'Hz' in the log, but rev/s in the axis file",
        ),
        (
            "Sample Period: 4 ms\ntime,x",
            "timed",
            0.002,
            1e-3,
            "states a sample time of 0.004 s, but the axis file gives 0.002 s",
        ),
        (
            "time [s],x",
            "stamped",
            0.002,
            1e-3,
            "rises by 2 s per sample by its unit in the log, but sample_time in the axis file is",
        ),
        ("Sample Period: 4 ms\nn,x", "silent", 0.004, 1e-3, ""),
        # The axis file decides which column is the position.
        ("Sample Period: 4 ms\nx,time", "role", 0.004, 1e-3, ""),
        (
            "Sample rate: 500 Hz\ntime,x",
            "silent",
            None,
            0.0,
            'column = "time", unit = "s" } in .columns., or sample_time = "0.002 s"',
        ),
        (
            "Sample time: 2 ms\nTrace cycle: 4 ms\nn,x",
            "silent",
            None,
            0.0,
            "'Sample time: 2 ms' states, or sample_time = \"0.004 s\"",
        ),
    ],
)
def test_the_axis_file_outranks_the_log_which_answers_where_it_is_silent(
    head, axis, step, factor, note
):
    values = np.sin(np.arange(300.0) / 20.0)
    content = "\n".join(
        [head, *(f"{2.0 * k},{x!r}" for k, x in enumerate(values.tolist())), ""]
    ).encode()
    if step is None:
        with pytest.raises(InputError, match=note):
            read_log(content, read_axis(PARTS[axis].encode()))
        return
    log = read_log(content, read_axis(PARTS[axis].encode()))
    assert (log.sample_time, note in " ".join(log.notes)) == (pytest.approx(step), True)
    np.testing.assert_allclose((log.velocity or log.position).values, factor * values, rtol=1e-9)
