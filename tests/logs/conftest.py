"""A small log of our own making, written as every kind of file that is read."""

from __future__ import annotations

import sys
from pathlib import Path
from pkgutil import resolve_name

import numpy as np
import pytest
import scipy.io

from bristle.core.axis import Axis, Column
from bristle.logs import apart
from bristle.logs.table import damage_refused

SAMPLE_TIME = 1e-3
COUNT = 1200
MASS, F_C, F_V = 2.0, 3.0, 20.0


@pytest.fixture
def recording() -> dict[str, np.ndarray]:
    """Half a metre there and back, twice: time [s], position [m], reference [m], effort [N]."""
    rng = np.random.default_rng(5)
    t = SAMPLE_TIME * np.arange(COUNT)
    w = 2 * np.pi / 0.617
    x = 0.25 * (1 - np.cos(w * t))
    v, a = 0.25 * w * np.sin(w * t), 0.25 * w**2 * np.cos(w * t)
    u = MASS * a + F_C * np.sign(v) + F_V * v + rng.normal(0, 0.05, COUNT)
    return {"t": t, "q": np.round(x, 5), "r": x + 1e-5, "u": u}


@pytest.fixture
def here(monkeypatch):
    """Binary files are read in this process, without the start of another: for tests of what is in them."""

    def read_here(reader, data, request):
        try:
            with damage_refused(request.source):
                return resolve_name(reader)(data, request)
        finally:
            # Where each read collects remarks as if it were the only one.
            if "nptdms.log" in sys.modules:
                sys.modules["nptdms.log"].log_manager.console_handler.filters.clear()

    monkeypatch.setattr(apart, "read_apart", read_here)


@pytest.fixture
def axis() -> Axis:
    return Axis(
        name="bench",
        columns={
            "time": Column("t", "s", "s"),
            "position": Column("q", "m", "m"),
            "reference": Column("r", "m", "m"),
            "effort": Column("u", "N", "N"),
        },
    )


def csv_text(recording: dict[str, np.ndarray], form: str = "%.12g") -> str:
    rows = zip(*recording.values(), strict=True)
    lines = [",".join(recording), *(",".join(form % cell for cell in row) for row in rows)]
    return "\n".join(lines) + "\n"


def write_csv(path: Path, recording: dict[str, np.ndarray]) -> Path:
    path.write_text(csv_text(recording))
    return path


def write_mat(path: Path, recording: dict[str, np.ndarray], *, compressed: bool = True) -> Path:
    columns = {name: values.reshape(-1, 1) for name, values in recording.items()}
    scipy.io.savemat(path, {**columns, "gain": 35.0}, do_compression=compressed)
    return path


def write_tdms(
    path: Path, recording: dict[str, np.ndarray], units: dict[str, str] | None = None
) -> Path:
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(path) as writer:
        # Two segments, as a stream has many.
        for half in (slice(0, COUNT // 2), slice(COUNT // 2, None)):
            writer.write_segment(
                [
                    nptdms.ChannelObject(
                        "axis",
                        name,
                        values[half],
                        {"unit_string": units[name]} if units and name in units else {},
                    )
                    for name, values in recording.items()
                ]
            )
    return path


def write_hdf5(path: Path, recording: dict[str, np.ndarray], group: str = "run") -> Path:
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        for name, values in recording.items():
            file[f"{group}/{name}"] = values.reshape(-1, 1)
    return path


def write_npz(path: Path, recording: dict[str, np.ndarray]) -> Path:
    np.savez_compressed(path, **recording)
    return path


def write_parquet(path: Path, recording: dict[str, np.ndarray]) -> Path:
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    parquet.write_table(pyarrow.table(recording), path)
    return path


WRITERS = {
    "csv": write_csv,
    "mat": write_mat,
    "tdms": write_tdms,
    "h5": write_hdf5,
    "npz": write_npz,
    "parquet": write_parquet,
}


@pytest.fixture(params=sorted(WRITERS))
def any_file(request, recording, tmp_path, here):
    """The same recording as each kind of file."""
    return WRITERS[request.param](tmp_path / f"log.{request.param}", recording)


@pytest.fixture
def write(tmp_path, recording):
    """Write a CSV of the recording with some columns changed, and return its path."""

    def written(name: str = "log.csv", form: str = "%.17g", **changes):
        path = tmp_path / name
        path.write_text(csv_text({**recording, **changes}, form))
        return path

    return written
