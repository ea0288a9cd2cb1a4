"""Files that would make a reader loop, crash, take all memory, or read what was not named."""

from __future__ import annotations

import io
import os
import signal
import struct
import subprocess
import sys
import time
import zipfile
import zlib
from pathlib import Path

import numpy as np
import pytest
import scipy.io
from tests.logs.conftest import WRITERS

from bristle.core.content import SIZE_LIMIT
from bristle.core.errors import InputError
from bristle.logs import apart, read_log
from bristle.logs.readers import read_table
from bristle.logs.table import ALL, NONE, columns_named, columns_of

h5py = pytest.importorskip("h5py")
SMALL = 100_000  # [byte]


# What lies in other files is never looked for.


def h5(path: Path, *contents) -> Path:
    """A file with what each of these writes into it, such as `data_set("t", values)`."""
    with h5py.File(path, "w") as file:
        for content in contents:
            content(file)
    return path


def data_set(name: str, *arguments, **options):
    return lambda file: file.create_dataset(name, *arguments, **options)


def linked(name: str, link):
    return lambda file: file.__setitem__(name, link)


@pytest.fixture
def secret(tmp_path) -> Path:
    path = tmp_path / "secret"
    path.write_bytes(np.arange(2000.0).tobytes())
    h5(tmp_path / "other.h5", data_set("x", data=np.arange(2000.0)))
    return path


def virtual(secret):
    layout = h5py.VirtualLayout((500,), float)
    layout[:] = h5py.VirtualSource(str(secret.with_name("other.h5")), "x", (2000,))[:500]
    return lambda file: file.create_virtual_dataset("x", layout)


@pytest.mark.parametrize(
    "make",
    [
        lambda secret: data_set("x", (500,), float, external=[(str(secret), 0, 4000)]),
        virtual,
        lambda secret: linked("x", h5py.ExternalLink(str(secret.with_name("other.h5")), "x")),
        lambda secret: linked("deep/y", h5py.ExternalLink(str(secret.with_name("other.h5")), "/")),
    ],
    ids=["external", "virtual", "linked", "linked group"],
)
def test_numbers_in_other_files_are_refused(tmp_path, here, secret, make):
    path = h5(tmp_path / "log.h5", data_set("t", data=np.arange(500.0)), make(secret))
    with pytest.raises(
        InputError,
        match=r"(the numbers of .* are in other files|a link to another file, but bristle reads)",
    ):
        read_table(path)


def test_links_in_the_file_itself_are_left_alone_and_circles_end(tmp_path, here):
    path = h5(
        tmp_path / "log.h5",
        data_set("run/t", data=np.arange(50.0)),
        linked("run/soft", h5py.SoftLink("/run/t")),
        lambda file: file.__setitem__("run/again", file["run"]),
        linked("run/gone", h5py.SoftLink("/nowhere")),
    )
    assert list(read_table(path).columns) == ["t"]


# What a file announces is looked at before it is read.


def npy(shape: tuple[int, ...], descr: str = "<f8", data: bytes = b"") -> bytes:
    head = (
        repr({"descr": descr, "fortran_order": False, "shape": shape}).encode().ljust(117) + b"\n"
    )
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head + data


def zipped(members: dict[str, bytes], kind: int = zipfile.ZIP_DEFLATED) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", kind) as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return out.getvalue()


def parquet_of(rows: int, columns: int = 1) -> bytes:
    pyarrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    out = io.BytesIO()
    zeros = pyarrow.array(np.zeros(rows))
    parquet.write_table(pyarrow.table({f"x{k}": zeros for k in range(columns)}), out)
    return out.getvalue()


MAT = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM"


def mat_bomb(size: int) -> bytes:
    packed = zlib.compress(struct.pack("<II", 14, size) + bytes(size), 9)
    return MAT + struct.pack("<II", 15, len(packed)) + packed


def mat_of_cells(depth: int) -> bytes:
    """A cell with a name that holds a cell, and so on."""
    cell = struct.pack("<IIII", 6, 8, 1, 0) + struct.pack("<IIii", 5, 8, 1, 1)
    inner, named = (
        cell + struct.pack("<II", 1, 0),
        cell + struct.pack("<II", 1, 1) + b"a" + bytes(7),
    )
    body = b"".join(
        struct.pack("<II", 14, len(inner) * (level + 1) + 8 * level) + inner
        for level in range(depth - 2, -1, -1)
    )
    return MAT + struct.pack("<II", 14, len(named) + len(body)) + named + body


BOMBS = {
    "an npy of no numbers": lambda: npy((10**12,)),
    "an npy of many dimensions": lambda: npy((10**6, 10**6)),
    "an npy of long numbers": lambda: npy((10,), "V2000000000"),
    "an npy of a negative size": lambda: npy((-1,)),
    "an npz that unpacks to much": lambda: zipped({"x.npy": npy((50_000,), data=bytes(400_000))}),
    "an npz of many that unpack to much": lambda: zipped(
        {f"x{k}.npy": npy((9000,), data=bytes(72_000)) for k in range(9)}
    ),
    "an npz in an npz": lambda: zipped({"x.npy": zipped({"x.npy": npy((5,), data=bytes(40))})}),
    "a parquet of runs": lambda: parquet_of(60_000),
    "a parquet of many columns": lambda: parquet_of(2_000, 20),
    "a mat that unpacks to much": lambda: mat_bomb(1_000_000),
    "a mat of cells in cells": lambda: mat_of_cells(100_000),
    "a text of more cells than fit": lambda: b"t,x\n" + b"1,2\n" * 20_000,
}


@pytest.mark.parametrize("name", BOMBS)
def test_content_that_unpacks_above_the_limit_is_refused(name, here):
    data = BOMBS[name]()
    limit = SMALL if name != "a mat of cells in cells" else SIZE_LIMIT
    with pytest.raises(InputError, match=r"more than the limit|damaged|too deep|objects|no column"):
        read_table(data, size_limit=max(limit, len(data)))


def test_a_data_set_that_announces_more_than_fits_is_not_read(tmp_path, here):
    path = h5(tmp_path / "log.h5", data_set("x", (10**12,), float, chunks=(1000,)))
    with pytest.raises(InputError, match=r"has 8 TB, more"):
        read_table(path)


def test_the_limit_applies_to_the_columns_read(tmp_path, here):
    path = h5(
        tmp_path / "log.h5",
        data_set("t", data=np.arange(500.0)),
        data_set("video", (10**9,), "u1", chunks=(10**6,)),
    )
    assert set(read_table(path, choice=columns_named(["t"])).columns) == {"t"}
    assert read_table(path, choice=NONE).has("video")
    with pytest.raises(InputError, match="more than the limit"):
        read_table(path, choice=ALL)


@pytest.mark.slow
@pytest.mark.parametrize("kind", sorted(WRITERS))
def test_only_the_columns_of_the_axis_are_read_and_all_are_known(tmp_path, recording, axis, kind):
    path = WRITERS[kind](tmp_path / f"log.{kind}", recording | {"odd": recording["t"]})
    table = read_table(path, choice=columns_of(axis))
    assert (set(table.columns), set(table.names) >= {"odd", *recording}) == (set(recording), True)
    np.testing.assert_allclose(table.columns["u"], recording["u"], rtol=1e-11)
    assert set(read_table(path, choice=columns_of(None)).columns) == {"t", "q"}
    assert read_log(path).position.column == "q"


@pytest.mark.parametrize("kind", sorted(WRITERS))
def test_a_missing_column_is_reported_with_the_present_ones(tmp_path, here, recording, axis, kind):
    path = WRITERS[kind](
        tmp_path / f"log.{kind}", {"pos" if k == "q" else k: v for k, v in recording.items()}
    )
    with pytest.raises(InputError, match=r"has no column 'q'.*allowed .*pos"):
        read_log(path, axis)


# Native code is on its own: what it does there does not happen here.


def with_reader(monkeypatch, tmp_path, body: str) -> Path:
    """Let HDF5 files be read by something else, in the process of its own only."""
    (tmp_path / "h5py.py").write_text(body)
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "log.h5").write_bytes(b"\x89HDF rest")
    return tmp_path / "log.h5"


@pytest.mark.skipif(os.name != "posix", reason="limits of POSIX")
@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("import os, signal\nos.kill(os.getpid(), signal.SIGSEGV)", "crashed with signal 11"),
        ("raise RuntimeError('odd file')", "odd file"),
        ("import os\nos._exit(3)", "damaged"),
        pytest.param("while True: pass", "takes too long", marks=pytest.mark.slow),
        ("import os, signal\nos.kill(os.getpid(), signal.SIGXCPU)", "takes too long"),
        (
            "import resource\nraise OSError(f'has {resource.getrlimit(resource.RLIMIT_CPU)[0]} s of the processor')",
            "has 1 s of the processor",
        ),
        ("x = bytes(30 * 2**30)", "MemoryError|damaged"),
        ("print('chatter' * 100_000); raise OSError('odd')", "odd"),
        ("import time\ntime.sleep(60)", "takes too long"),
    ],
)
def test_a_reader_that_loops_crashes_or_takes_all_memory_is_a_damaged_file(
    monkeypatch, tmp_path, body, words
):
    monkeypatch.setattr(apart, "SECONDS", 1.0)
    monkeypatch.setattr(apart, "PATIENCE", 4.0 if "while" in body else 2.0)
    path = with_reader(monkeypatch, tmp_path, body)
    began = time.monotonic()
    with pytest.raises(InputError, match=words) as caught:
        read_table(path)
    assert time.monotonic() - began < 45.0  # the longest of them sleeps for sixty
    assert caught.value.path == str(path)


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGKILL])
def test_a_looping_reader_does_not_outlive_its_caller(monkeypatch, tmp_path, number):
    path = with_reader(
        monkeypatch,
        tmp_path,
        "import os\nopen('pid', 'w').write(str(os.getpid()))\nwhile True: pass",
    )
    code = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
    code += "from bristle.logs import apart; apart.SECONDS = 3.0\n"
    code += "import sys; from bristle.cli.main import main; sys.exit(main(['log', 'log.h5', '--out', 'run']))"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])}
    process = subprocess.Popen(
        [sys.executable, "-c", code], cwd=path.parent, env=environment, stderr=subprocess.PIPE
    )
    until = time.monotonic() + 30.0
    while not (tmp_path / "pid").exists() or not (tmp_path / "pid").read_text():
        assert time.monotonic() < until
        time.sleep(0.02)
    reader = int((tmp_path / "pid").read_text())
    process.send_signal(number)
    process.communicate(timeout=60)
    assert process.returncode == (-9 if number == signal.SIGKILL else 128 + number)
    # Whoever is killed cannot end the reader; its own limit does.
    until = time.monotonic() + (30.0 if number == signal.SIGKILL else 20.0)
    while time.monotonic() < until and is_running(reader):
        time.sleep(0.1)
    assert not is_running(reader)
    assert not list(tmp_path.glob("run*"))


def is_running(number: int) -> bool:
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_a_plugin_that_a_file_asks_for_is_not_loaded_and_the_current_folder_is_not_searched(
    tmp_path, monkeypatch
):
    assert apart.ENVIRONMENT["HDF5_PLUGIN_PRELOAD"] == "::"
    path = h5(tmp_path / "log.h5", data_set("t", data=np.arange(50.0)))
    (tmp_path / "json.py").write_text("open('ran', 'w')\n")
    monkeypatch.chdir(tmp_path)
    read_table(path)
    assert not (tmp_path / "ran").exists()


# Flipped bytes: nothing but a table or a message.


def test_an_encrypted_archive_is_refused_without_names_of_library_objects(tmp_path):
    path = tmp_path / "log.npz"
    np.savez(path, time=np.arange(9.0), position=np.arange(9.0))
    data = bytearray(path.read_bytes())
    data[6] |= 1
    data[data.find(b"PK\1\2") + 8] |= 1
    path.write_bytes(data)
    with pytest.raises(
        InputError, match="is truncated or damaged, or in an unsupported format"
    ) as caught:
        read_table(path)
    assert "<" not in str(caught.value)


@pytest.mark.parametrize(
    ("kind", "count", "first"),
    [
        ("csv", 60, 0),
        ("mat", 150, 0),
        ("npz", 150, 0),
        # In a process of their own.
        ("h5", 1, 8),
        ("tdms", 1, 8),
        *(pytest.param(kind, 8, 8, marks=pytest.mark.slow) for kind in ("h5", "parquet", "tdms")),
    ],
)
def test_flipped_bytes_give_a_table_or_a_message(tmp_path, recording, kind, count, first):
    small = {name: values[:40] for name, values in recording.items()}
    data = WRITERS[kind](
        tmp_path / f"log.{kind}", recording if kind == "tdms" else small
    ).read_bytes()
    chance = np.random.default_rng(7)
    for _ in range(count):
        flipped = bytearray(data)
        for at in chance.integers(
            first, len(data) if first == 0 else min(len(data), 2000), chance.integers(1, 4)
        ):
            flipped[at] ^= 1 << chance.integers(8)
        try:
            read_table(io.BytesIO(flipped), size_limit=50_000_000)
        except InputError as error:
            assert "\n" not in str(error)[:50]  # noqa: PT017


# Odd content.


def test_odd_types_are_left_out_with_a_note(tmp_path):
    def units(file):
        file["t"].attrs.update({"unit": np.zeros(100), "units": "s"})
        file["q"].attrs["unit"] = [b"km", b"mm"]

    odd = {
        "opaque": np.zeros(50, dtype="V7"),
        "complex": np.zeros(50, dtype=complex),
        "pairs": np.zeros(50, dtype=[("a", float, (3,)), ("b", "S3")]),
        "empty": h5py.Empty(float),
    }
    numbers = (data_set(name, data=np.arange(50.0)) for name in ("t", "q"))
    table = read_table(
        h5(
            tmp_path / "log.h5",
            *numbers,
            *(data_set(name, data=values) for name, values in odd.items()),
            units,
        )
    )
    assert (sorted(table.columns), table.units) == (["q", "t"], {"t": "s"})
    assert "bristle ignores the unit of q, because it is not text" in table.notes
    assert {note.split()[2].strip(",") for note in table.notes if "holds no column" in note} == set(
        odd
    )


def test_a_sample_time_that_is_text_is_ignored_with_a_note(tmp_path, here):
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(tmp_path / "log.tdms") as writer:
        for name, step in (("x", "1 ms"), ("y", float("nan")), ("z", -1.0)):
            writer.write_segment(
                [nptdms.ChannelObject("a", name, np.arange(20.0), {"wf_increment": step})]
            )
    table = read_table(tmp_path / "log.tdms")
    assert (
        table.sample_time,
        sum("the sample time of channel" in note for note in table.notes),
    ) == (None, 3)


def test_opaque_objects_of_matlab_are_no_columns(tmp_path):
    scipy.io.savemat(
        tmp_path / "log.mat",
        {"t": np.arange(5.0), "cells": np.array([[1, "a"], ["b", 2]], dtype=object)},
    )
    assert set(read_table(tmp_path / "log.mat").columns) == {"t"}


def test_two_columns_of_the_same_name_are_noted(tmp_path, here):
    table = read_table(b"t,q,q,q_2\n" + b"1,2,3,4\n" * 3)
    assert {name: values[0] for name, values in table.columns.items()} == {
        "t": 1,
        "q": 2,
        "q_3": 3,
        "q_2": 4,
    }
    assert table.notes == (
        "columns 2 and 3 are called 'q': bristle takes the first one by this name, and the other one by 'q_3'",
    )
    pyarrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    parquet.write_table(
        pyarrow.table([[1.0, 2.0], [3.0, 4.0]], names=["q", "q"]), tmp_path / "log.parquet"
    )
    table = read_table(tmp_path / "log.parquet")
    assert {name: values[0] for name, values in table.columns.items()} == {"q": 1.0, "q_2": 3.0}
    assert "bristle takes the first one by this name" in table.notes[0]


def test_control_characters_in_names_are_noted_and_in_units_removed():
    table = read_table("t,po\x1b[31ms [m\x07m],\u202egpj\n".encode() + b"1,2,3\n" * 3)
    assert (set(table.columns), table.units) == ({"t", "po [31ms", "gpj"}, {})
    assert [note.isprintable() for note in table.notes] == 3 * [True]
