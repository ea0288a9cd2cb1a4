"""Logs of halsampler of LinuxCNC: names from HAL files, lost samples, and the sample time that no file states."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from bristle.core.content import Content
from bristle.core.errors import InputError
from bristle.files.axis import axis_from
from bristle.logs.catalogue import format_of
from bristle.logs.halsampler import signals_of
from bristle.logs.readers import read_log, read_table

RECORDED = Path(__file__).parent / "linuxcnc"  # by halsampler of LinuxCNC 2.9
COUNT = 300
T = 1e-3 * np.arange(COUNT)
X, F = 20.0 * np.sin(9.0 * T), 8.0 * np.sign(np.cos(9.0 * T)) + 0.3 * np.sin(40.0 * T)
AXIS = {
    "schema": 1,
    "kind": "translational",
    "columns": {
        "position": {"column": "column_1", "unit": "mm"},
        "effort": {"column": "column_2", "unit": "N"},
    },
}
TIMED = AXIS | {"timing": {"sample_time": "1 ms"}}


def text_of(*columns, tagged=False, kept=None):
    """Return what halsampler prints: six decimals for numbers, none for integers, a blank behind each."""
    rows = []
    for k in range(COUNT) if kept is None else kept:
        cells = [
            f"{column[k]}" if np.issubdtype(column.dtype, np.integer) else f"{column[k]:f}"
            for column in columns
        ]
        rows.append(" ".join([*([str(k)] if tagged else []), *cells, ""]))
    return "\n".join([*rows, ""])


COUNTER = np.arange(7, COUNT + 7)
PLAIN = text_of(X, F)


def test_a_recorded_file_has_the_names_of_the_signals():
    for name, columns in (("plain.txt", 5), ("tagged.txt", 6)):
        table = read_table(RECORDED / name)
        assert (table.format, len(table.numbers)) == ("halsampler", columns)
        assert list(table.columns) == ["x-pos-cmd", "x-pos-fb", "x-effort", "x-enable"]
        assert "bristle names the columns by the signals in axis_x.hal" in table.notes
        # A first-order lag behind a sine of 5 Hz.
        command, position = table.columns["x-pos-cmd"], table.columns["x-pos-fb"]
        assert position[1:] == pytest.approx(
            position[:-1] + 0.3 * (command[1:] - position[:-1]), abs=3e-6
        )


def test_the_sample_time_is_that_of_the_axis_file_and_never_invented(tmp_path):
    (tmp_path / "log.txt").write_text(PLAIN, encoding="ascii")
    log = read_log(tmp_path / "log.txt", axis_from(TIMED))
    assert log.sample_time == 1e-3
    assert log.position.values == pytest.approx(1e-3 * X, abs=1e-9)
    with pytest.raises(
        InputError,
        match=r"no column of time and no sample time.*sample_time = .1 ms. under \[timing\]",
    ):
        read_log(tmp_path / "log.txt", axis_from(AXIS))
    tagged = text_of(X, F, tagged=True)
    as_time = AXIS["columns"] | {
        "time": {"column": "column_1", "unit": "s"},
        "position": {"column": "column_2", "unit": "mm"},
    }
    with pytest.raises(InputError, match=r"counts the rows and is no time.*sample_time = .1 ms."):
        read_log(tagged.encode(), axis_from(AXIS | {"columns": as_time}))


@pytest.mark.parametrize("tagged", [False, True])
@pytest.mark.parametrize("begin", ["", "overrun\n"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_columns_are_numbered_without_a_hal_file(tagged, begin, end):
    table = read_table((begin + text_of(X, F, COUNTER, tagged=tagged)).replace("\n", end).encode())
    first = 2 if tagged else 1
    assert (table.format, list(table.columns)) == (
        "halsampler",
        [f"column_{first}", f"column_{first + 1}"],
    )
    assert table.columns[f"column_{first}"] == pytest.approx(X, abs=1e-6)
    assert any("no sample is lost" in note for note in table.notes)


def without(*lost):
    """Numbers of the rows but for some."""
    return [k for k in range(COUNT) if k not in lost]


ONE, MANY, BACK = (
    without(120),
    without(*range(120, 137)),
    [*range(COUNT // 2), *range(COUNT // 2 - 4, COUNT)],
)


@pytest.mark.parametrize(("tagged", "kind"), [(True, int), (False, int), (False, float)])
@pytest.mark.parametrize(
    ("kept", "words"),
    [
        (ONE, "line 121, column_[13]: lost 1 samples in 1 place"),
        (MANY, "line 121, column_[13]: lost 17 samples in 1 place"),
        (without(120, *range(200, 205)), "lost 6 samples in 2 places"),
        (without(*range(120, 137), *range(200, 205)), "lost 22 samples in 2 places"),
        (BACK, "jumps back"),
    ],
)
def test_a_gap_of_tags_or_of_a_counter_is_refused_with_the_lost_samples(tagged, kind, kept, words):
    columns = (X, F) if tagged else (X, F, COUNTER.astype(kind))
    with pytest.raises(InputError, match=words):
        read_table(text_of(*columns, tagged=tagged, kept=kept).encode())


ROWS = PLAIN.splitlines(keepends=True)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (
            RECORDED / "late.txt",
            r"late\.txt: line 16, column_3: lost 234 samples in 1 place\. Record again with a larger depth",
        ),
        (
            "".join([*ROWS[:100], "overrun\n", *ROWS[100:]]).encode(),
            "line 101: lost samples before this line, an unknown number; found 'overrun'",
        ),
        (
            "".join([*ROWS[:250], "1.000000 \n", *ROWS[250:]]).encode(),
            r"line 251: is not a row of halsampler; found '1\.000000 '",
        ),
    ],
)
def test_an_overrun_and_a_damaged_row_are_refused_with_their_line(given, words):
    with pytest.raises(InputError, match=words):
        read_table(given)


def test_a_counter_may_begin_again_at_32_bits_and_behind_an_old_row():
    table = read_table(text_of(X, F, (COUNTER + 2**32 - 100) % 2**32).encode())
    assert table.columns["column_1"].size == COUNT
    old = COUNTER.copy()
    old[0] -= 5
    table = read_table(text_of(X, F, old).encode())
    assert table.columns["column_1"] == pytest.approx(X[1:], abs=1e-6)
    assert any("the first row is an old one" in note for note in table.notes)


def test_whole_numbers_that_do_not_count_stay_columns():
    encoder = np.round(1e3 * X).astype(int)
    table = read_table(text_of(encoder, F, (X > 0.0).astype(int)).encode())
    assert list(table.columns) == ["column_1", "column_2", "column_3"]


def test_a_truncated_last_row_is_left_out_with_a_note():
    table = read_table(PLAIN[:-9].encode())
    assert table.columns["column_1"].size == COUNT - 1
    assert any("the file ends within a row" in note for note in table.notes)


def test_a_grid_of_six_decimals_in_metres_is_reported():
    notes = read_table(text_of(1e-3 * X, F).encode()).notes
    assert [
        note
        for note in notes
        if re.match(r"column_1 has a grid of 1e-06.*1 um, too coarse for pre-sliding", note)
    ]
    assert not any("grid" in note for note in read_table(PLAIN.encode()).notes)


@pytest.mark.parametrize(
    "text",
    [
        PLAIN.replace(" \n", "\n"),
        PLAIN.replace(" ", ","),
        "t x \n" + PLAIN,
        re.sub(r"(\.\d{5})\d", r"\1", PLAIN),
    ],
)
def test_other_text_is_left_to_the_reader_of_text(text):
    assert format_of(text.encode(), ".txt").name == "csv"


# --- HAL files ----------------------------------------------------------------------------------------------------


def test_nets_and_links_of_pins_are_read():
    text = (
        "loadrt sampler depth=4096,100 cfg=fff,ub\n# net wrong => sampler.0.pin.2\nnet pos-cmd joint.0.motor-pos-cmd => sampler.0.pin.0\n"
        "net pos-fb \\\n  <= axis.0.position sampler.0.pin.1 other.in # why\nlinkps sampler.1.pin.0 rows\nlinksp ready sampler.1.pin.1\n"
    )
    assert signals_of(text) == {
        0: (3, {0: "pos-cmd", 1: "pos-fb"}),
        1: (2, {0: "rows", 1: "ready"}),
    }


FIRST = "net pos => sampler.0.pin.0\nnet effort => sampler.0.pin.1\n"
OTHER = "net other => sampler.0.pin.0\n"


@pytest.mark.parametrize(
    ("files", "names"),
    [
        ({"a.hal": FIRST}, ["pos", "effort"]),
        ({"a.hal": FIRST, "b.hal": OTHER}, ["column_1", "column_2"]),
        ({"a.hal": FIRST, "run.hal": OTHER}, ["other", "column_2"]),
        (
            {"a.hal": FIRST, "run.hal": "loadrt sampler cfg=fff\nnet third => sampler.0.pin.2\n"},
            ["column_1", "column_2"],
        ),
    ],
)
def test_the_hal_file_of_the_same_name_wins_and_different_ones_name_nothing(tmp_path, files, names):
    for name, text in (files | {"run.txt": PLAIN}).items():
        (tmp_path / name).write_text(text, encoding="ascii")
    table = read_table(tmp_path / "run.txt")
    assert list(table.columns) == names
    assert (
        "samplers in a.hal, b.hal have different signals: bristle numbers the columns"
        in table.notes
    ) is ("b.hal" in files)


def test_an_upload_with_the_name_of_a_file_is_not_named_by_its_folder(tmp_path):
    for name in ("axis_x.hal", "plain.txt"):
        shutil.copy(RECORDED / name, tmp_path)
    upload = Content(tmp_path / "plain.txt", text_of(X, F, X, F, X).encode())
    assert "column_1" in read_table(upload).columns
    assert "x-pos-cmd" in read_table(tmp_path / "plain.txt").columns


def test_signals_of_a_hal_file_are_names_of_the_axis_file(tmp_path):
    for name in ("axis_x.hal", "tagged.txt"):
        shutil.copy(RECORDED / name, tmp_path)
    columns = {
        "position": {"column": "x-pos-fb", "unit": "mm"},
        "effort": {"column": "x-effort", "unit": "N"},
    }
    log = read_log(tmp_path / "tagged.txt", axis_from(TIMED | {"columns": columns}))
    assert log.position.values[:2] == pytest.approx([23.558e-6, 63.584e-6])
    assert log.sample_time == 1e-3
