"""Logs from data frames, data sets and dictionaries; a log as an array, a table, a few lines."""

import copy
import pickle
import subprocess
import sys
from dataclasses import fields

import numpy as np
import pint
import pytest

import bristle as br
from bristle.core import Axis, Column, InputError
from bristle.logs.log import CHANNELS, Channel, Log, table_of

COUNT = 400
T = np.arange(COUNT) * 2e-3
DATA = {
    "time": T,
    "position": 0.01 * np.sin(9.0 * T),
    "effort": 5.0 * np.cos(9.0 * T) + np.sin(31.0 * T),
    "velocity": 0.09 * np.cos(9.0 * T),
    "reference": 0.0101 * np.sin(9.0 * T),
    "load": 1.0 + 0.1 * T,
    "temperature": 293.0 + T,
}


def with_pandas(data):
    return pytest.importorskip("pandas").DataFrame(data)


def with_xarray(data):
    fixed = {name: ("time", values) for name, values in data.items() if name != "time"}
    return pytest.importorskip("xarray").Dataset(fixed, coords={"time": data["time"]})


def with_index(data, index):
    return with_pandas(data).drop(columns="time").set_index(index)


def dates(data):
    pandas = pytest.importorskip("pandas")
    return pandas.Timestamp("2026-11-20") + pandas.to_timedelta(data["time"], unit="s")


TABLES = {
    "dictionary": dict,
    "lists": lambda data: {name: values.tolist() for name, values in data.items()},
    "pandas": with_pandas,
    "pandas, time as index": lambda data: with_pandas(data).set_index("time"),
    "pandas, dates as index": lambda data: with_index(data, dates(data)),
    "polars": lambda data: pytest.importorskip("polars").DataFrame(data),
    "polars, lazy": lambda data: pytest.importorskip("polars").LazyFrame(data),
    "xarray": with_xarray,
    "pyarrow": lambda data: pytest.importorskip("pyarrow").table(data),
    "record array": lambda data: np.rec.fromarrays(list(data.values()), names=",".join(data)),
}


@pytest.mark.parametrize("make", TABLES.values(), ids=TABLES)
def test_any_table_of_columns_is_a_log(make):
    log = Log.from_columns(make(DATA))
    assert (len(log), log.sample_time, log.kind) == (COUNT, pytest.approx(2e-3), "translational")
    for name, values in DATA.items():
        assert np.allclose(getattr(log, name), values, rtol=1e-12, atol=1e-12), name
    assert log.notes == ()


def test_it_is_the_log_that_a_file_of_the_same_columns_is(tmp_path):
    rows = "\n".join(
        ",".join(map(repr, row))
        for row in zip(*(DATA[item].tolist() for item in DATA), strict=True)
    )
    (tmp_path / "log.csv").write_text(",".join(DATA) + "\n" + rows + "\n")
    names = {name: Column(name, "", "") for name in DATA}
    from_file = br.read_log(tmp_path / "log.csv", Axis(columns=names))
    log = Log.from_columns(DATA)
    assert all(np.array_equal(getattr(log, name), getattr(from_file, name)) for name in DATA)


def test_only_needed_columns_are_read_and_the_others_are_listed():
    log = Log.from_columns(
        {"t": T, "x": DATA["position"], "Force": DATA["effort"], "v": T, "note": ["a"] * COUNT}
    )
    assert (log.effort.values.tolist(), log.velocity) == (DATA["effort"].tolist(), None)
    assert log.notes == (
        "bristle uses column t as the time",
        "bristle uses column x as the position",
        "bristle uses column Force as the effort",
        "unused columns: v, note",
    )


@pytest.mark.parametrize("more", [{"Position": T, "EFFORT": T}, {"x": T, "force": T}])
def test_of_several_usual_names_that_of_the_channel_is_taken(more):
    for columns in (DATA | more, more | DATA):
        log = Log.from_columns(columns)
        assert np.array_equal([log.position, log.effort], [DATA["position"], DATA["effort"]])


def test_known_inputs_come_and_go():
    log = Log.from_columns(DATA | {"injected.extra": 0.1 * np.sin(50.0 * T)})
    assert [item.column for item in log.injected] == ["extra"]
    assert np.array_equal(log.injected_effort, 0.1 * np.sin(50.0 * T))


def test_the_kind_of_axis_is_given_or_follows_from_the_unit():
    assert Log.from_columns(DATA, kind="rotational").effort.unit == "N*m"
    frame = with_pandas(DATA)
    frame.attrs["units"] = {"position": "deg", "effort": "mN*m"}
    log = Log.from_columns(frame)
    assert log.kind == "rotational"
    assert np.allclose(
        [log.position, log.effort], [np.deg2rad(DATA["position"]), 1e-3 * DATA["effort"]]
    )


def test_quantities_with_units_are_converted():
    unit = pint.UnitRegistry()
    log = Log.from_columns(DATA | {"position": 1e3 * DATA["position"] * unit.mm})
    assert np.allclose(log.position, DATA["position"])
    with pytest.raises(InputError, match="position"):
        Log.from_columns(DATA | {"position": DATA["position"] * unit.N})


def test_a_log_without_time_takes_a_sample_time():
    data = {name: values for name, values in DATA.items() if name != "time"}
    assert Log.from_columns(data, sample_time="2 ms").sample_time == 2e-3
    with pytest.raises(InputError, match="no column of time"):
        Log.from_columns(data)


def test_an_axis_assigns_the_columns():
    axis = Axis(
        columns={"time": Column("t", "ms", "s"), "position": Column("q", "mm", "m", scale=-1.0)}
    )
    log = Log.from_columns({"t": 1e3 * T, "q": 1e3 * DATA["position"], "effort": T}, axis=axis)
    assert (np.allclose(log.position, -DATA["position"]), log.effort) == (True, None)
    # One that names no columns, but says what it is, leaves them to their names.
    assert (
        Log.from_columns(DATA, axis=Axis(kind="rotational", resolution=1e-6)).effort.unit == "N*m"
    )
    with pytest.raises(
        InputError, match=r"kind: differs from the kind of the axis; found 'translational'"
    ):
        Log.from_columns(DATA, axis=Axis(kind="rotational"), kind="translational")


class Evil:
    columns = ("time", "position")

    def __getitem__(self, name):
        raise RuntimeError("no")


NAN = np.where(np.arange(COUNT) == 7, np.nan, DATA["position"])
BAD = {
    "no table": (
        5,
        r"columns: is not a table of columns; found 5\. Give a data frame or a dictionary",
    ),
    "an array": (T, "columns: is not a table of columns"),
    "no columns": ({}, "columns: has no position column"),
    "a typing error": (
        {"time": T, "postion": T},
        r"found 'time, postion', allowed names: time, position.*mean 'position'\?",
    ),
    "text": (DATA | {"position": ["a"] * COUNT}, r"column 'position': holds no numbers; found 'a'"),
    "an odd one": (
        DATA | {"effort": [*[1.0] * 9, None, "x"]},
        r"column 'effort': has no number at sample 10",
    ),
    "NaN": (
        DATA | {"position": NAN},
        r"column 'position': has NaN \(not a number\) in 1 sample, the first at sample 7 \(t = 0.014 s\)",
    ),
    "two dimensions": (
        DATA | {"effort": np.outer(T, T)},
        r"column 'effort': must be 1-D; found 'an array of shape",
    ),
    "lengths": (DATA | {"effort": T[:300]}, r"different numbers of samples \(.*effort: 300"),
    "no order": (
        DATA | {"time": np.random.default_rng(0).permutation(T)},
        "column 'time': is not in order",
    ),
    "constant": (DATA | {"effort": np.ones(COUNT)}, r"column 'effort': is constant \(1 N\)"),
    "short": ({name: item[:50] for name, item in DATA.items()}, "is too short"),
    "masked": (DATA | {"effort": np.ma.masked_equal(T, 0.0)}, "column 'effort': has masked values"),
    "complex": (DATA | {"effort": 1j * T}, "column 'effort': holds no numbers"),
    "a table that raises": (Evil(), r"columns: cannot be read \(RuntimeError: no\)"),
    "no samples": ({"time": [], "position": []}, "too short"),
}


@pytest.mark.parametrize(("given", "said"), BAD.values(), ids=BAD)
def test_unusable_columns_are_refused_by_name(given, said):
    with pytest.raises(InputError, match=said) as caught:
        Log.from_columns(given)
    assert "\n" not in str(caught.value)


@pytest.mark.slow
def test_no_library_is_imported_for_a_dictionary():
    code = (
        "import sys, numpy as np, bristle as br\n"
        "t = np.arange(200) * 1e-3\n"
        "log = br.Log.from_columns({'time': t, 'position': np.sin(9 * t), 'effort': np.cos(9 * t)})\n"
        "repr(log), log._repr_html_(), log.to_dict()\n"
        "print({'pandas', 'polars', 'xarray'} & set(sys.modules))"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "set()"


# --- there and back ---------------------------------------------------------------------------------------------


@pytest.fixture(params=["translational", "rotational"])
def log(request):
    return Log.from_columns(DATA | {"injected.extra": 0.1 * np.sin(50.0 * T)}, kind=request.param)


@pytest.mark.parametrize("way", ["to_dataframe", "to_xarray", "signals"])
def test_a_log_survives_the_round_trip_through_a_table(log, way):
    if way != "signals":
        pytest.importorskip("pandas" if way == "to_dataframe" else "xarray")
    table = log.to_dict()["signals"] if way == "signals" else getattr(log, way)()
    again = Log.from_columns(table, kind=log.kind if way == "signals" else None)
    first, second = (
        [(name, item.unit, item.values.tolist()) for name, item in of.channels()]
        for of in (log, again)
    )
    assert (again.kind, second) == (log.kind, first)


def test_tables_of_a_log_carry_its_description(log):
    message = log.to_dict()
    assert message["units"]["effort"] == ("N" if log.kind == "translational" else "N*m")
    assert (message["segments"], message["sample_time"]) == ([[0, COUNT]], log.sample_time)
    first, *lines = repr(log).splitlines()
    assert first.startswith(f"Log of {COUNT} samples, 800 ms at 500 Hz, {log.kind}")
    assert any("position" in line for line in lines)
    assert len(lines) < 30
    assert log._repr_html_().count("<tr>") == len(message["signals"]) + 1


def test_a_log_travels(log):
    for other in (pickle.loads(pickle.dumps(log)), copy.deepcopy(log)):
        assert other.to_dict() == log.to_dict()


# --- a channel is its samples -----------------------------------------------------------------------------------


def test_a_channel_is_an_array_to_numpy():
    channel = Channel(DATA["position"], "m", "q")
    values = DATA["position"]
    assert np.asarray(channel) is channel.values
    assert np.array(channel) is not channel.values
    assert [np.asarray(channel, dtype=dtype).dtype for dtype in (None, np.float32)] == [
        float,
        np.float32,
    ]
    assert np.array_equal(np.gradient(channel, 2e-3), np.gradient(values, 2e-3))


def test_a_channel_supports_len_slices_and_arithmetic():
    channel, values = Channel(DATA["position"], "m", "q"), DATA["position"]
    assert list(channel) == values.tolist()
    assert (len(channel), channel[3], channel[::2].tolist()) == (
        COUNT,
        values[3],
        values[::2].tolist(),
    )
    for result, expected in (
        (channel * 1e3, values * 1e3),
        (1.0 - channel, 1.0 - values),
        (-channel, -values),
        (channel - channel, 0.0 * values),
        (np.abs(channel), np.abs(values)),
        (channel > 0.0, values > 0.0),
        (values * channel, values**2),
    ):
        assert isinstance(result, np.ndarray)
        assert np.array_equal(result, expected)


def test_channels_are_equal_only_if_identical():
    channel = Channel(T, "s", "t")
    assert [channel == other for other in (channel, Channel(T, "s", "t"))] == [True, False]
    assert len({channel, channel}) == 1


def test_a_channel_prints_in_a_line_and_works_as_an_array():
    channel = Channel(DATA["position"], "m", "q")
    assert repr(channel) == f"Channel({COUNT} samples, −10.000 to 10.000 mm, column 'q')"
    model = br.friction.coulomb(F_C=2.0)
    assert np.array_equal(
        br.response(model, channel, 2e-3), br.response(model, DATA["position"], 2e-3)
    )


def test_a_log_has_its_channels_as_fields_and_samples():
    assert {field.name for field in fields(Log)} >= CHANNELS.keys()
    with pytest.raises(InputError, match="no samples"):
        br.Log(time=[], position=[])


def test_plain_arrays_make_a_log_without_an_axis_and_texts_are_no_columns():
    assert br.Log(time=T, position=DATA["position"], effort=DATA["effort"]).position.unit == "m"
    table = table_of({"position": T, "remark": ["x"] * COUNT})
    assert (table.names, list(table.texts)) == (("position",), ["remark"])
