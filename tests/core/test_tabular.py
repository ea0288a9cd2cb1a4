"""Signals as tables: the same numbers in each, with their units; libraries that are not there are named."""

import json
import sys
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from bristle.core import InputError, MissingExtraError
from bristle.core.status import Status
from bristle.core.tabular import SIGNALS, Tabular, plain, ranged

T = np.arange(5) * 0.1


@dataclass(frozen=True)
class Result(Tabular):
    time: np.ndarray
    friction: np.ndarray
    position: np.ndarray | None = None
    velocity: np.ndarray | None = None
    table: Any = None
    status: Status = Status.OK
    kind: str = "rotational"


FOUND = Result(
    T, 2.0 * T, velocity=np.zeros(3), table={"a": (1, np.float64(2.0))}, status=Status.NOT_FINITE
)


def test_plain_data_is_plain():
    message = FOUND.to_dict()
    assert json.loads(json.dumps(message)) == message
    assert message["signals"] == {"time": T.tolist(), "friction": (2.0 * T).tolist()}
    assert message["units"] == {"time": "s", "friction": "N*m"}
    assert (message["status"], message["table"], message["kind"]) == (
        Status.NOT_FINITE.sentence,
        {"a": [1, 2.0]},
        "rotational",
    )
    assert "velocity" not in message


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (slice(2, 5), [2, 5]),
        (np.arange(3), [0, 1, 2]),
        (np.int64(3), 3),
        (float("nan"), None),
        (np.array([1.0, np.inf]), [1.0, None]),
        (True, True),
        (None, None),
        ({1: (2, "x")}, {"1": [2, "x"]}),
    ],
)
def test_each_value_has_a_plain_form(value, expected):
    assert plain(value) == expected


def test_a_data_frame_has_the_numbers_and_their_units():
    pytest.importorskip("pandas")
    frame = FOUND.to_dataframe()
    assert list(frame.columns) == ["time", "friction"]
    assert np.array_equal(frame["friction"], FOUND.friction)
    assert frame.attrs["units"] == {"time": "s", "friction": "N*m"}
    frame["friction"] = 0.0
    assert FOUND.friction[1] > 0.0


def test_a_data_set_has_units_and_names_for_its_axes():
    pytest.importorskip("xarray")
    result = FOUND.to_xarray()
    assert np.array_equal(result["friction"].values, FOUND.friction)
    assert np.array_equal(result["time"].values, T)
    assert result["friction"].attrs == {
        "units": "N*m",
        "long_name": SIGNALS["friction"].description,
    }
    assert result["time"].attrs["units"] == "s"
    assert result.attrs == {"kind": "rotational", "status": Status.NOT_FINITE.sentence}
    result["friction"][:] = 0.0
    assert FOUND.friction[1] > 0.0


@pytest.mark.parametrize(("name", "call"), [("pandas", "to_dataframe"), ("xarray", "to_xarray")])
def test_a_missing_library_is_named_with_the_command_to_install_it(name, call, monkeypatch):
    monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(
        MissingExtraError, match=rf"{call}\(\): needs {name}.* Type: pip install {name}"
    ) as caught:
        getattr(FOUND, call)()
    assert isinstance(caught.value, InputError)


@pytest.mark.parametrize(
    ("values", "unit", "text"),
    [
        ([np.nan, 1e-6, 2e-6], "m", "1.000 to 2.000 µm, 1 not finite"),
        ([np.nan], "m", "no finite number"),
        ([20.0] * 3, "N", "20.00 N"),
    ],
)
def test_a_range_has_a_suitable_unit(values, unit, text):
    assert ranged(np.array(values), unit) == text
