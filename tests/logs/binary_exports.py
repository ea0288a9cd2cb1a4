"""The motion of `exports` in files of other programs that are not text: MDF 4, MCAP, MATLAB, LabVIEW, HDF5."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import scipy.io
from tests.logs.exports import RATED, UNIT, Export, Motion

FORCE = {"columns.effort.unit": "N"}
START = 1_741_944_672_000_000_000  # ns since 1970


def _numbers(m: Motion) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time in s, position in mm, force in N."""
    return m.time_us / 1e6, m.position_um / 1e3, m.torque * RATED / 1e3


Write = Callable[[Path, Motion], Path]
Groups = list[tuple[str, list[tuple]]]


def mf4(name: str, version: str, compression: int, groups: Callable[[Motion], Groups]) -> Write:
    """A writer of groups of signals, each with its samples, times, unit, name, and conversion."""

    def write(folder: Path, m: Motion) -> Path:
        asammdf = pytest.importorskip("asammdf")
        with asammdf.MDF(version=version) as file:
            for group, signals in groups(m):
                file.append([asammdf.Signal(*signal) for signal in signals], acq_name=group)
            return Path(file.save(folder / name, compression=compression, overwrite=True))

    return write


def one_group(m: Motion) -> Groups:
    t, x, f = _numbers(m)
    return [("", [(x, t, "mm", "Lageistwert"), (f, t, "N", "Kraftistwert")])]


def two_rates(m: Motion) -> Groups:
    t, x, f = _numbers(m)
    return [("2ms", [(f[::2], t[::2], "N", "Force")]), ("1ms", [(x, t, "mm", "Position")])]


def converted(m: Motion) -> Groups:
    """Whole numbers of the bus, with a conversion each."""
    t, _, _ = _numbers(m)
    position = (m.position_um.astype(np.int32), t, "mm", "ActPos", {"a": 1e-3, "b": 0.0})
    return [("", [position, (m.torque.astype(np.int16), t, "N", "ActTrq", {"a": 0.25, "b": 0.0})])]


JOINT_STATE = """std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
HEADER = JOINT_STATE.partition("=" * 80)[2]
FLOAT = "std_msgs/Header header\nfloat64 data\n" + "=" * 80 + HEADER


def _stamp(us: int) -> dict[str, object]:
    ns = START + 1000 * int(us)
    return {"stamp": {"sec": ns // 10**9, "nanosec": ns % 10**9}, "frame_id": ""}


def mcap_ros(
    name: str, kind: str, definition: str, messages: Callable[..., dict[str, dict]], late: int = 0
) -> Write:
    """A writer of the messages of each sample by topic, received so many nanoseconds after their stamps."""

    def write(folder: Path, m: Motion) -> Path:
        ros = pytest.importorskip("mcap_ros2.writer")
        with (folder / name).open("wb") as file:
            writer = ros.Writer(file)
            schema = writer.register_msgdef(kind, definition)
            for us, *sample in zip(m.time_us, *_numbers(m)[1:], strict=True):
                for topic, content in messages(*sample).items():
                    message = {"header": _stamp(us)} | content
                    writer.write_message(
                        topic=topic,
                        schema=schema,
                        log_time=START + 1000 * int(us) + late,
                        publish_time=0,
                        message=message,
                    )
            writer.finish()
        return folder / name

    return write


def of_joints(position: float, effort: float) -> dict[str, dict]:
    state = {
        "name": ["rail", "lift"],
        "position": [position, 0.0],
        "velocity": [],
        "effort": [effort, 0.0],
    }
    return {"/joint_states": state}


def mcap_json(folder: Path, m: Motion) -> Path:
    plain = pytest.importorskip("mcap.writer")
    path = folder / "json.mcap"
    _, x, f = _numbers(m)
    with path.open("wb") as file:
        writer = plain.Writer(file)
        writer.start()
        schema = writer.register_schema(name="axis", encoding="jsonschema", data=b"{}")
        channel = writer.register_channel(topic="axis", message_encoding="json", schema_id=schema)
        for us, position, effort in zip(m.time_us, x, f, strict=True):
            content = json.dumps(
                {"position_mm": position, "force_nm": 0.0, "force": effort}
            ).encode()
            stamp = START + 1000 * int(us)
            writer.add_message(channel_id=channel, log_time=stamp, publish_time=stamp, data=content)
        writer.finish()
    return path


def matlab_structure(folder: Path, m: Motion) -> Path:
    t, x, f = _numbers(m)
    scipy.io.savemat(folder / "run.mat", {"log": {"time": t, "pos_mm": x, "force": f}, "Ts": 1e-3})
    return folder / "run.mat"


def matlab_matrix(folder: Path, m: Motion) -> Path:
    scipy.io.savemat(
        folder / "matrix.mat", {"data": np.column_stack(_numbers(m))}, do_compression=True
    )
    return folder / "matrix.mat"


def matlab_73(folder: Path, m: Motion) -> Path:
    file = hdf5(
        "new.mat",
        lambda t, x, f: {
            "run/t": (t[None], {}),
            "run/Lage": (x[None], {}),
            "run/Kraft": (f[None], {}),
        },
        userblock_size=512,
    )
    path = file(folder, m)
    path.write_bytes(b"MATLAB 7.3 MAT-file" + path.read_bytes()[19:])
    return path


def hdf5(name: str, content: Callable[..., dict[str, tuple]], **options: int) -> Write:
    """A writer of data sets by their paths, each with its attributes."""

    def write(folder: Path, m: Motion) -> Path:
        h5py = pytest.importorskip("h5py")
        with h5py.File(folder / name, "w", **options) as file:
            for path, (values, attributes) in content(*_numbers(m)).items():
                file[path] = values
                file[path].attrs.update(attributes)
        return folder / name

    return write


def _tdms(
    path: Path, group: str, *segments: list[tuple[str, np.ndarray, dict[str, object]]]
) -> Path:
    """Write channels with their properties, a piece of each in each segment."""
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(str(path)) as writer:
        for channels in segments:
            writer.write_segment(
                [
                    nptdms.RootObject({"Operator": "lab"}),
                    *(nptdms.ChannelObject(group, *channel) for channel in channels),
                ]
            )
    return path


def tdms_two_rates(folder: Path, m: Motion) -> Path:
    _, x, f = _numbers(m)
    return _tdms(
        folder / "rates.tdms",
        "axis",
        [
            ("Position", x, {"wf_increment": 1e-3, "unit_string": "mm"}),
            ("Force", f[::2], {"wf_increment": 2e-3, "unit_string": "N"}),
        ],
    )


def tdms_waveforms(folder: Path, m: Motion) -> Path:
    """Two waveforms of one rate."""
    _, x, f = _numbers(m)
    return _tdms(
        folder / "waveforms.tdms",
        "Log",
        [
            ("ActPos", x, {"wf_increment": 1e-3, "NI_UnitDescription": "mm"}),
            ("ActForce", f, {"wf_increment": 1e-3, "NI_UnitDescription": "N"}),
        ],
    )


def tdms_own_time(folder: Path, m: Motion) -> Path:
    """A time beside the channels, in pieces as they were recorded."""
    t, x, f = _numbers(m)
    return _tdms(
        folder / "pieces.tdms",
        "Messung",
        *(
            [
                (name, values[part], {"unit_string": unit})
                for name, unit, values in (("Zeit", "s", t), ("Weg", "mm", x), ("Kraft", "N", f))
            ]
            for part in np.array_split(np.arange(t.size), 7)
        ),
    )


def hdf5_records(folder: Path, m: Motion) -> Path:
    """Rows of named numbers, compressed."""
    h5py = pytest.importorskip("h5py")
    rows = np.rec.fromarrays(_numbers(m), names="time_s,position_mm,force_N")
    with h5py.File(folder / "records.h5", "w") as file:
        file.create_dataset("log", data=rows, compression="gzip", chunks=(512,))
    return folder / "records.h5"


BINARY = {
    "MF4, one group": Export(mf4("one.mf4", "4.10", 0, one_group)),
    "MF4, two rates": Export(mf4("two.mf4", "4.11", 2, two_rates), exact=False),
    "MF4, converted": Export(mf4("converted.dat", "4.10", 1, converted)),
    "MCAP, joints": Export(
        mcap_ros("joints.mcap", "sensor_msgs/msg/JointState", JOINT_STATE, of_joints, 7777),
        UNIT | FORCE,
    ),
    "MCAP, topics": Export(
        mcap_ros(
            "topics.mcap",
            "bench_msgs/msg/Stamped",
            FLOAT,
            lambda x, f: {"/axis/position": {"data": x}, "/axis/force": {"data": f}},
        ),
        UNIT | FORCE,
    ),
    "MCAP, JSON": Export(mcap_json, FORCE),
    "MAT, structure": Export(matlab_structure, FORCE),
    "MAT, matrix": Export(matlab_matrix, UNIT | FORCE),
    "MAT 7.3": Export(matlab_73, UNIT | FORCE),
    "TDMS, two rates": Export(tdms_two_rates, exact=False),
    "TDMS, waveforms": Export(tdms_waveforms),
    "TDMS, own time": Export(tdms_own_time),
    "HDF5": Export(
        hdf5(
            "messung.h5",
            lambda t, x, f: {
                "Messung/Zeit": (t, {"unit": "s"}),
                "Messung/Weg": (x, {"unit": "mm"}),
                "Messung/Kraft": (f, {"unit": "N"}),
            },
        )
    ),
    "HDF5, records": Export(hdf5_records),
    "HDF5, rate": Export(
        hdf5(
            "rate.hdf5",
            lambda t, x, f: {
                "sample_time": (1e-3, {}),  # a number beside the channels
                "actual_position": (x, {"units": np.bytes_("mm")}),
                "motor_force": (f, {"units": np.bytes_("N")}),
            },
        )
    ),
}
