"""The motion of `exports` in files of other programs that are not text: MDF 4, MCAP, MATLAB, LabVIEW, HDF5."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from tests.logs.exports import RATED, UNIT, Export, Motion

FORCE = {"columns.effort.unit": "N"}
START = 1_741_944_672_000_000_000  # ns since 1970


def _numbers(m: Motion) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time in s, position in mm, force in N."""
    return m.time_us / 1e6, m.position_um / 1e3, m.torque * RATED / 1e3


def mf4_one_group(folder: Path, m: Motion) -> Path:
    asammdf = pytest.importorskip("asammdf")
    t, x, f = _numbers(m)
    with asammdf.MDF(version="4.10") as file:
        file.append([asammdf.Signal(x, t, name="Lageistwert", unit="mm"), asammdf.Signal(f, t, name="Kraftistwert", unit="N")])
        return Path(file.save(folder / "one.mf4", compression=0, overwrite=True))


def mf4_two_rates(folder: Path, m: Motion) -> Path:
    asammdf = pytest.importorskip("asammdf")
    t, x, f = _numbers(m)
    with asammdf.MDF(version="4.11") as file:
        file.append([asammdf.Signal(f[::2], t[::2], name="Force", unit="N")], acq_name="2ms")
        file.append([asammdf.Signal(x, t, name="Position", unit="mm")], acq_name="1ms")
        return Path(file.save(folder / "two.mf4", compression=2, overwrite=True))


def mf4_converted(folder: Path, m: Motion) -> Path:
    """Whole numbers of the bus, with a conversion each."""
    asammdf = pytest.importorskip("asammdf")
    t, _, _ = _numbers(m)
    with asammdf.MDF(version="4.10") as file:
        file.append(
            [
                asammdf.Signal(m.position_um.astype(np.int32), t, "mm", "ActPos", conversion={"a": 1e-3, "b": 0.0}),
                asammdf.Signal(m.torque.astype(np.int16), t, "N", "ActTrq", conversion={"a": 0.25, "b": 0.0}),
            ]
        )
        return Path(file.save(folder / "converted.dat", compression=1, overwrite=True))


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


def mcap_joints(folder: Path, m: Motion) -> Path:
    ros = pytest.importorskip("mcap_ros2.writer")
    path = folder / "joints.mcap"
    _, x, f = _numbers(m)
    with path.open("wb") as file:
        writer = ros.Writer(file)
        schema = writer.register_msgdef("sensor_msgs/msg/JointState", JOINT_STATE)
        for us, position, effort in zip(m.time_us, x, f, strict=True):
            writer.write_message(
                topic="/joint_states",
                schema=schema,
                log_time=START + 1000 * int(us) + 7777,
                publish_time=0,
                message={
                    "header": _stamp(us),
                    "name": ["rail", "lift"],
                    "position": [position, 0.0],
                    "velocity": [],
                    "effort": [effort, 0.0],
                },
            )
        writer.finish()
    return path


def mcap_topics(folder: Path, m: Motion) -> Path:
    ros = pytest.importorskip("mcap_ros2.writer")
    path = folder / "topics.mcap"
    _, x, f = _numbers(m)
    with path.open("wb") as file:
        writer = ros.Writer(file)
        schema = writer.register_msgdef("bench_msgs/msg/Stamped", FLOAT)
        for us, position, effort in zip(m.time_us, x, f, strict=True):
            for topic, value in (("/axis/position", position), ("/axis/force", effort)):
                writer.write_message(
                    topic=topic,
                    schema=schema,
                    log_time=START + 1000 * int(us),
                    publish_time=0,
                    message={"header": _stamp(us), "data": value},
                )
        writer.finish()
    return path


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
            content = json.dumps({"position_mm": position, "force_nm": 0.0, "force": effort}).encode()
            stamp = START + 1000 * int(us)
            writer.add_message(channel_id=channel, log_time=stamp, publish_time=stamp, data=content)
        writer.finish()
    return path


def matlab_structure(folder: Path, m: Motion) -> Path:
    import scipy.io

    t, x, f = _numbers(m)
    path = folder / "run.mat"
    scipy.io.savemat(path, {"log": {"time": t, "pos_mm": x, "force": f}, "Ts": 1e-3})
    return path


def matlab_matrix(folder: Path, m: Motion) -> Path:
    import scipy.io

    path = folder / "matrix.mat"
    scipy.io.savemat(path, {"data": np.column_stack(_numbers(m))}, do_compression=True)
    return path


def matlab_73(folder: Path, m: Motion) -> Path:
    h5py = pytest.importorskip("h5py")
    path = folder / "new.mat"
    t, x, f = _numbers(m)
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in (("t", t), ("Lage", x), ("Kraft", f)):
            file[f"run/{name}"] = values[None]
    content = bytearray(path.read_bytes())
    content[:19] = b"MATLAB 7.3 MAT-file"
    path.write_bytes(content)
    return path


def _tdms(path: Path, group: str, *segments: list[tuple[str, np.ndarray, dict[str, object]]]) -> Path:
    """Write channels with their properties, a piece of each in each segment."""
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(str(path)) as writer:
        for channels in segments:
            writer.write_segment([nptdms.RootObject({"Operator": "lab"}), *(nptdms.ChannelObject(group, *channel) for channel in channels)])
    return path


def tdms_two_rates(folder: Path, m: Motion) -> Path:
    _, x, f = _numbers(m)
    return _tdms(
        folder / "rates.tdms",
        "axis",
        [("Position", x, {"wf_increment": 1e-3, "unit_string": "mm"}), ("Force", f[::2], {"wf_increment": 2e-3, "unit_string": "N"})],
    )


def hdf5_german(folder: Path, m: Motion) -> Path:
    h5py = pytest.importorskip("h5py")
    path = folder / "messung.h5"
    t, x, f = _numbers(m)
    with h5py.File(path, "w") as file:
        for name, unit, values in (("Zeit", "s", t), ("Weg", "mm", x), ("Kraft", "N", f)):
            file.create_dataset(f"Messung/{name}", data=values).attrs["unit"] = unit
    return path


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
            [(name, values[part], {"unit_string": unit}) for name, unit, values in (("Zeit", "s", t), ("Weg", "mm", x), ("Kraft", "N", f))]
            for part in np.array_split(np.arange(t.size), 7)
        ),
    )


def hdf5_records(folder: Path, m: Motion) -> Path:
    """Rows of named numbers, compressed."""
    h5py = pytest.importorskip("h5py")
    path = folder / "records.h5"
    rows = np.rec.fromarrays(_numbers(m), names="time_s,position_mm,force_N")
    with h5py.File(path, "w") as file:
        file.create_dataset("log", data=rows, compression="gzip", chunks=(512,))
    return path


def hdf5_rate(folder: Path, m: Motion) -> Path:
    """Channels at the root, the sample time a number beside them."""
    h5py = pytest.importorskip("h5py")
    path = folder / "rate.hdf5"
    _, x, f = _numbers(m)
    with h5py.File(path, "w") as file:
        file["sample_time"] = 1e-3
        for name, unit, values in (("actual_position", "mm", x), ("motor_force", "N", f)):
            file.create_dataset(name, data=values).attrs["units"] = np.bytes_(unit)
    return path


BINARY = {
    "MF4, one group": Export(mf4_one_group),
    "MF4, two rates": Export(mf4_two_rates, exact=False),
    "MF4, converted": Export(mf4_converted),
    "MCAP, joints": Export(mcap_joints, UNIT | FORCE),
    "MCAP, topics": Export(mcap_topics, UNIT | FORCE),
    "MCAP, JSON": Export(mcap_json, FORCE),
    "MAT, structure": Export(matlab_structure, FORCE),
    "MAT, matrix": Export(matlab_matrix, UNIT | FORCE),
    "MAT 7.3": Export(matlab_73, UNIT | FORCE),
    "TDMS, two rates": Export(tdms_two_rates, exact=False),
    "TDMS, waveforms": Export(tdms_waveforms),
    "TDMS, own time": Export(tdms_own_time),
    "HDF5": Export(hdf5_german),
    "HDF5, records": Export(hdf5_records),
    "HDF5, rate": Export(hdf5_rate),
}
