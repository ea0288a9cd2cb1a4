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
    rows = "".join(f"{a},{b!r},{c!r}\n" for a, b, c in zip(t.tolist(), q.tolist(), i.tolist(), strict=True))
    (tmp_path / "log.csv").write_text("t,q,i\n" + rows)
    return tmp_path / "log.csv"


@pytest.mark.parametrize("values", [str, lambda path: path, read_axis], ids=["text", "path", "axis"])
def test_an_axis_is_a_file_or_an_object(tmp_path, log_file, values):
    (tmp_path / "axis.toml").write_text(AXIS)
    log = read_log(log_file, values(tmp_path / "axis.toml"))
    assert (log.kind, log.sample_time, log.effort.unit) == ("rotational", pytest.approx(1e-3), "N*m")
    assert np.max(log.position.values) == pytest.approx(np.pi / 20, rel=1e-3)
    assert log.effort.values[0] == pytest.approx(5.0)  # -1 A, sign, 0.5 N*m/A, gear of 10


def test_a_bad_axis_file_is_named_before_the_log_is_read(tmp_path):
    (tmp_path / "axis.toml").write_text(AXIS.replace("gear_ratio", "gear"))
    with pytest.raises(InputError, match=r"axis\.toml: transmission\.gear: unknown key"):
        read_log(tmp_path / "no_such_log.csv", tmp_path / "axis.toml")
