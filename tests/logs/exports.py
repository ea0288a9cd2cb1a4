"""Files as other programs write them: one motion, in many formats and dialects. Shares no code with the readers."""

from __future__ import annotations

import datetime
import json
from collections.abc import Callable
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple

import numpy as np

RATE = 1000.0
RATED = 250.0  # N, for efforts in per mille
LEAD = 0.3141592653589793  # m, on axes that are told in degrees


class Motion(NamedTuple):
    """What was recorded, as the whole numbers that a drive stores: µm, µm/s, per mille of the rated force."""

    time_us: np.ndarray
    position_um: np.ndarray
    reference_um: np.ndarray
    velocity_um_s: np.ndarray
    torque: np.ndarray

    def every(self, step: int, start: int = 0) -> Motion:
        return Motion(*(values[start::step] for values in self))


def motion(seconds: float = 4.0) -> Motion:
    """A slide to and fro at several speeds, with Coulomb friction and inertia."""
    rng = np.random.default_rng(11)
    count = round(seconds * RATE)
    t = np.arange(count) / RATE
    x = 0.08 * np.sin(2 * np.pi * 0.7 * t) + 0.03 * np.sin(2 * np.pi * 1.9 * t + 0.4)
    v = np.gradient(x, t)
    a = np.gradient(v, t)
    force = 12.0 * a + 40.0 * v + 18.0 * np.tanh(v / 2e-3) + rng.normal(0.0, 0.3, count)
    reference = x + 2e-4 * np.sign(v) * np.minimum(1.0, np.abs(v) / 0.05)
    return Motion(
        np.round(1e6 * t).astype(int),
        np.round(1e6 * x).astype(int),
        np.round(1e6 * reference).astype(int),
        np.round(1e6 * v).astype(int),
        np.round(1e3 * force / RATED).astype(int),
    )


def decimal(whole: int, places: int, comma: bool = False) -> str:
    """A whole number of units of the last place, written out."""
    sign, digits = ("-" if whole < 0 else ""), str(abs(int(whole))).rjust(places + 1, "0")
    text = f"{sign}{digits[:-places]}.{digits[-places:]}" if places else f"{sign}{digits}"
    return text.replace(".", ",") if comma else text


def mm(values: np.ndarray, comma: bool = False) -> list[str]:
    return [decimal(value, 3, comma) for value in values]


def newton(values: np.ndarray, comma: bool = False) -> list[str]:
    return [decimal(int(value) * round(RATED), 3, comma) for value in values]


SCOPE_KEYS = (
    "SymbolComment",
    "Data-Type",
    "SampleTime[ms]",
    "VariableSize",
    "SymbolBased",
    "IndexGroup",
    "IndexOffset",
    "SymbolName",
    "NetID",
    "Port",
    "Offset",
    "ScaleFactor",
    "BitMask",
    "Unit",
    "Unit ScaleFactor",
    "Unit Offset",
)


def scope_text(
    channels: list[tuple[str, list[str], list[str], dict[str, str]]],
    delimiter: str = "\t",
    end: str = "\r\n",
    *,
    full: bool = True,
    facts: bool = True,
    eof: bool = False,
) -> str:
    lines = []
    if facts:
        lines += [
            f"Name{delimiter}Scope Project",
            f"File{delimiter}C:\\scope\\machine.svdx",
            f"Starttime of export{delimiter}133860042720000000{delimiter}Friday, 14. March 2025{delimiter}09:31:12.000",
            f"Endtime of export{delimiter}133860043119990000{delimiter}Friday, 14. March 2025{delimiter}09:31:52.000",
            "",
            "",
        ]
    lines.append(delimiter.join(f"Name{delimiter}{name}" for name, *_ in channels))
    for key in SCOPE_KEYS if full else ():
        lines.append(delimiter.join(f"{key}{delimiter}{about.get(key, '')}" for *_, about in channels))
    if full:
        lines.append("")
    longest = max(len(times) for _, times, _, _ in channels)
    for row in range(longest):
        cells = []
        for _, times, values, _ in channels:
            cells += [times[row], values[row]] if row < len(times) else ["", ""]
        lines.append(delimiter.join(cells))
    if eof:
        lines.append("EOF")
    return end.join(lines) + end


def about(kind: str, period: str, symbol: str, unit: str = "(None)") -> dict[str, str]:
    return {
        "Data-Type": kind,
        "SampleTime[ms]": period,
        "VariableSize": "8",
        "SymbolBased": "True",
        "SymbolName": symbol,
        "NetID": "5.12.34.56.1.1",
        "Port": "501",
        "Offset": "0",
        "ScaleFactor": "1",
        "BitMask": "0xffffffffffffffff",
        "Unit": unit,
        "Unit ScaleFactor": "1",
        "Unit Offset": "0",
    }


def twincat_full(folder: Path, m: Motion) -> Path:
    ms = [decimal(t, 3, True).removesuffix(",000") for t in m.time_us]
    text = scope_text(
        [
            ("ActPos", ms, mm(m.position_um, True), about("REAL64", "1", "Axes.X.ToPlc.ActPos")),
            ("SetPos", ms, mm(m.reference_um, True), about("REAL64", "1", "Axes.X.ToPlc.SetPos")),
            ("ActTorque", ms, [str(item) for item in m.torque], about("INT16", "1", "Axes.X.ToPlc.ActTorque")),
        ]
    )
    return _written(folder / "scope_full.csv", text, "utf-8-sig")


def twincat_rates(folder: Path, m: Motion) -> Path:
    first = 133860042720000000
    slow = m.every(2, 4)
    text = scope_text(
        [
            (
                "ActTorque",
                [str(first + 10 * t) for t in slow.time_us],
                [str(item) for item in slow.torque],
                about("INT16", "2", "Axis 1.ActTorque"),
            ),
            ("ActPos", [str(first + 10 * t) for t in m.time_us], mm(m.position_um), about("REAL64", "1", "Axis 1.ActPos", "mm")),
        ],
        ";",
        "\n",
        eof=True,
    )
    return _written(folder / "scope_rates.csv", text, "utf-8")


def twincat_names(folder: Path, m: Motion) -> Path:
    ms = [decimal(t, 3) for t in m.time_us]
    text = scope_text(
        [("Istposition", ms, mm(m.position_um), {}), ("Istmoment", ms, [str(item) for item in m.torque], {})], full=False, facts=False
    )
    return _written(folder / "scope_names.txt", text, "utf-16")


def twincat_groups(folder: Path, m: Motion) -> Path:
    """One column of time for all channels of one sample time."""
    lines = [
        "Name\tScope",
        "File\tx.svdx",
        "",
        "Name\tAxis_ActPos\tAxis_ActVelo\tAxis_ActTorque",
        "SampleTime[ms]\t1\t1\t1",
        "Unit\tmm\tmm/s\t‰",
        "",
    ]
    lines += [
        "\t".join(row)
        for row in zip(
            (decimal(t, 3, True) for t in m.time_us), mm(m.position_um, True), mm(m.velocity_um_s, True), map(str, m.torque), strict=True
        )
    ]
    return _written(folder / "scope_groups.csv", "\r\n".join(lines) + "\r\n", "utf-8")


def twincat_no_times(folder: Path, m: Motion) -> Path:
    """Exported without time lines: the sample time stands in the header, and no cell below its key."""
    lines = ["Name\tScope", "", "Name\tActPos\tActTorque", "Data-Type\tREAL64\tINT16", "SampleTime[ms]\t1\t1", "Unit\tmm\t(None)", ""]
    lines += [f"{x}\t{f}" for x, f in zip(mm(m.position_um, True), m.torque, strict=True)]
    return _written(folder / "scope_no_times.csv", "\r\n".join(lines) + "\r\n", "utf-8")


def twincat_bare_names(folder: Path, m: Motion) -> Path:
    """Names above the times, nothing above the values."""
    ms = [str(t // 1000) for t in m.time_us]
    lines = ["ActPos\t\tActTorque\t"] + [f"{t}\t{x}\t{t}\t{f}" for t, x, f in zip(ms, mm(m.position_um, True), m.torque, strict=True)]
    return _written(folder / "scope_bare.csv", "\r\n".join(lines) + "\r\n", "utf-8")


def drive_german(folder: Path, m: Motion) -> Path:
    lines = [
        "Gerät;AX5112;",
        "Seriennummer;0012345;",
        "Datum;14.03.2025 09:31:12;",
        f"Nennkraft;{RATED:.0f} N;",
        "Abtastzeit;1 ms;",
        "",
        "Zeit [ms];Lageistwert [mm];Lagesollwert [mm];Geschwindigkeit [mm/s];Moment [‰]",
    ]
    lines += [
        ";".join(row)
        for row in zip(
            (decimal(t, 3, True) for t in m.time_us),
            mm(m.position_um, True),
            mm(m.reference_um, True),
            mm(m.velocity_um_s, True),
            map(str, m.torque),
            strict=True,
        )
    ]
    return _written(folder / "trace.csv", "\r\n".join(lines) + "\r\n", "cp1252")


def drive_without_time(folder: Path, m: Motion) -> Path:
    lines = ["Device,AKD-P00606", "Sample time [ms],1", f"Rated force,{RATED:.0f} N", "PL.FB (mm),PL.CMD (mm),Force (N)"]
    lines += [",".join(row) for row in zip(mm(m.position_um), mm(m.reference_um), newton(m.torque), strict=True)]
    return _written(folder / "recorder.csv", "\n".join(lines) + "\n", "utf-8-sig")


def drive_units_row(folder: Path, m: Motion) -> Path:
    lines = ["Trace of axis Y", "Time\tPosition actual value\tPosition demand value\tForce actual", "s\tmm\tmm\tN"]
    lines += [
        "\t".join(row)
        for row in zip((decimal(t, 6) for t in m.time_us), mm(m.position_um), mm(m.reference_um), newton(m.torque), strict=True)
    ]
    return _written(folder / "units_row.txt", "\r\n".join(lines) + "\r\n", "utf-16")


def headerless(folder: Path, m: Motion) -> Path:
    lines = [" ".join(row) for row in zip((decimal(t, 6) for t in m.time_us), mm(m.position_um), newton(m.torque), strict=True)]
    return _written(folder / "bare.dat", "\n".join(lines) + "\n", "ascii")


def stroke_units(folder: Path, m: Motion) -> Path:
    lines = ["t/s,x/mm,F/N"] + [
        ",".join(row) for row in zip((decimal(t, 6) for t in m.time_us), mm(m.position_um), newton(m.torque), strict=True)
    ]
    return _written(folder / "iupac.csv", "\n".join(lines) + "\n", "ascii")


def date_stamps(folder: Path, m: Motion) -> Path:
    start = datetime.datetime(2025, 3, 14, 23, 59, 58)
    lines = ["Timestamp;Weg in mm;Kraft in N"]
    for t, x, f in zip(m.time_us, mm(m.position_um, True), newton(m.torque, True), strict=True):
        stamp = start + datetime.timedelta(microseconds=int(t))
        lines.append(f"{stamp:%d.%m.%Y %H:%M:%S},{stamp.microsecond // 1000:03d};{x};{f}")
    return _written(folder / "dates.csv", "\r\n".join(lines) + "\r\n", "latin-1")


def labview(folder: Path, m: Motion) -> Path:
    lines = [
        "LabVIEW Measurement\t",
        "Writer_Version\t2",
        "Reader_Version\t2",
        "Separator\tTab",
        "Decimal_Separator\t,",
        "Multi_Headings\tNo",
        "X_Columns\tOne",
        "Time_Pref\tRelative",
        "Operator\tme",
        "Date\t2025/03/14",
        "Time\t09:31:12,123456",
        "***End_of_Header***\t",
        "\t",
        "Channels\t2\t\t",
        "Samples\t" + f"{m.time_us.size}\t{m.time_us.size}\t",
        "Date\t2025/03/14\t2025/03/14\t",
        "Time\t09:31:12,1\t09:31:12,1\t",
        "Y_Unit_Label\tmm\tN\t",
        "X_Dimension\tTime\tTime\t",
        "X0\t0,0E+0\t0,0E+0\t",
        "Delta_X\t1,000000E-3\t1,000000E-3\t",
        "***End_of_Header***\t\t\t",
        "X_Value\tPosition\tForce\tComment",
    ]
    lines += [
        "\t".join(row) + "\t"
        for row in zip((decimal(t, 6, True) for t in m.time_us), mm(m.position_um, True), newton(m.torque, True), strict=True)
    ]
    return _written(folder / "log.lvm", "\r\n".join(lines) + "\r\n", "cp1252")


def labview_columns(folder: Path, m: Motion) -> Path:
    """A time beside each channel, and a decimal point."""
    slow = m.every(2)
    lines = [
        "LabVIEW Measurement\t",
        "Writer_Version\t0.92",
        "Reader_Version\t1",
        "Separator\tTab",
        "Multi_Headings\tYes",
        "X_Columns\tMulti",
        "Time_Pref\tAbsolute",
        "Operator\tlab",
        "Date\t2025/03/14",
        "Time\t09:31:12.123456",
        "***End_of_Header***\t",
        "\t",
        "Channels\t2\t\t\t",
        f"Samples\t{m.time_us.size}\t\t{slow.time_us.size}\t",
        "Date\t2025/03/14\t\t2025/03/14\t",
        "Time\t09:31:12.1\t\t09:31:12.1\t",
        "Y_Unit_Label\tmm\t\tN\t",
        "X_Dimension\tTime\t\tTime\t",
        "X0\t0.0000000000000000E+0\t\t0.0000000000000000E+0\t",
        "Delta_X\t0.001000\t\t0.002000\t",
        "***End_of_Header***\t\t\t\t",
        "X_Value\tPosition\tX_Value\tForce\tComment",
    ]
    right = [f"{decimal(t, 6)}\t{f}" for t, f in zip(slow.time_us, newton(slow.torque), strict=True)]
    lines += [f"{decimal(t, 6)}\t{x}\t{force}\t" for t, x, force in zip_longest(m.time_us, mm(m.position_um), right, fillvalue="\t")]
    return _written(folder / "columns.lvm", "\r\n".join(lines) + "\r\n", "cp1252")


def labview_no_times(folder: Path, m: Motion) -> Path:
    """Samples alone, separated by commas: their times are in the header."""
    lines = [
        "LabVIEW Measurement",
        "Writer_Version,2",
        "Reader_Version,2",
        "Separator,Comma",
        "Decimal_Separator,.",
        "Multi_Headings,No",
        "X_Columns,No",
        "Time_Pref,Relative",
        "Operator,lab",
        "Date,2025/03/14",
        "Time,09:31:12.123456",
        "***End_of_Header***",
        "",
        "Channels,2,,",
        f"Samples,{m.time_us.size},{m.time_us.size},",
        "Date,2025/03/14,2025/03/14,",
        "Time,09:31:12.1,09:31:12.1,",
        "Y_Unit_Label,mm,N,",
        "X_Dimension,Time,Time,",
        "X0,0.0E+0,0.0E+0,",
        "Delta_X,1.000000E-3,1.000000E-3,",
        "***End_of_Header***,,,",
        "X_Value,Position,Force,Comment",
    ]
    lines += [f",{x},{f}," for x, f in zip(mm(m.position_um), newton(m.torque), strict=True)]
    return _written(folder / "plain.lvm", "\r\n".join(lines) + "\r\n", "cp1252")


def quoted(folder: Path, m: Motion) -> Path:
    """Decimal commas between commas, each cell in quotation marks."""
    lines = ['"Zeit [s]","Weg [mm]","Kraft [N]"'] + [
        f'"{decimal(t, 6, True)}","{x}","{f}"' for t, x, f in zip(m.time_us, mm(m.position_um, True), newton(m.torque, True), strict=True)
    ]
    return _written(folder / "quoted.csv", "\n".join(lines) + "\n", "utf-8")


def long_ago(folder: Path, m: Motion) -> Path:
    """Times in ns since 1970, which a number of double precision cannot hold."""
    lines = ["sep=;", "timestamp;axs/X/actual/position [mm];axs/X/actual/force [N]"]
    lines += [
        f"{1_741_944_672_000_000_000 + 1000 * int(t)};{x};{f}"
        for t, x, f in zip(m.time_us, mm(m.position_um), newton(m.torque), strict=True)
    ]
    return _written(folder / "ctrlx.csv", "\n".join(lines) + "\n", "utf-8")


def several_times(folder: Path, m: Motion) -> Path:
    slow = m.every(4)
    rows = ["time_pos;pos [mm];time_force;force [N]"]
    right = [f"{decimal(t, 6)};{f}" for t, f in zip(slow.time_us, newton(slow.torque), strict=True)]
    right += [";"] * (m.time_us.size - len(right))
    left = (f"{decimal(t, 6)};{x}" for t, x in zip(m.time_us, mm(m.position_um), strict=True))
    rows += [f"{item};{other}" for item, other in zip(left, right, strict=True)]
    return _written(folder / "pairs.csv", "\n".join(rows) + "\n", "utf-8")


def sparse(folder: Path, m: Motion) -> Path:
    rows = ["timestamp,position_mm,force_N"]
    for row, (t, x, f) in enumerate(zip(m.time_us, mm(m.position_um), newton(m.torque), strict=True)):
        rows.append(f"{decimal(t, 6)},{x},{f if row % 5 == 0 else ''}")
    return _written(folder / "sparse.csv", "\n".join(rows) + "\n", "utf-8")


def records(folder: Path, m: Motion) -> Path:
    entries = [
        {
            "timestamp": float(decimal(t, 6)),
            "position": float(decimal(x, 3)),
            "goal_position": float(decimal(r, 3)),
            "force": float(f),
            "torque_enable": True,
        }
        for t, x, r, f in zip(m.time_us, m.position_um, m.reference_um, newton(m.torque), strict=True)
    ]
    text = json.dumps({"mass": 0.2, "motor": "hls", "nested": {"kp": 30}, "entries": entries})
    return _written(folder / "records.json", text, "utf-8")


def columns(folder: Path, m: Motion) -> Path:
    data = {
        "units": {"t": "ms", "Lage": "mm", "Kraft": "N"},
        "t": [float(decimal(t, 3)) for t in m.time_us],
        "Lage": [float(item) for item in mm(m.position_um)],
        "Kraft": [float(item) for item in newton(m.torque)],
    }
    return _written(folder / "columns.json", json.dumps(data, indent=1, ensure_ascii=False), "utf-8-sig")


def json_lines(folder: Path, m: Motion) -> Path:
    start = datetime.datetime(2025, 3, 14, 9, 31, 12, tzinfo=datetime.UTC)
    lines = [
        json.dumps(
            {"time": (start + datetime.timedelta(microseconds=int(t))).isoformat(), "axis": {"pos_mm": float(x), "torque_permille": int(f)}}
        )
        for t, x, f in zip(m.time_us, mm(m.position_um), m.torque, strict=True)
    ]
    return _written(folder / "lines.jsonl", "\n".join(lines) + "\n", "utf-8")


def sinumerik(folder: Path, m: Motion) -> Path:
    slow = m.every(2)
    taken = dict(zip(slow.time_us.tolist(), slow.torque.tolist(), strict=True))
    parts = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        "<traceDataRoot><traceData><dataFrame>",
        '<frameHeader startTime="2025-03-14T09:31:12" stopInc="0"/>',
        '<dataSignal id="f1" key="1" name="/Nck/!SD/nckServoDataActPos1stEnc64[u1,1]" '
        'description="Lageistwert Messsystem 1 X1 (64 bit)" units="mm" interval="1" datapointCount="4000"/>',
        '<dataSignal id="f2" key="2" name="/DriveVsa/r80" description="Kraftistwert X1" units="N" interval="2"/>',
    ]
    for t, x in zip(m.time_us, mm(m.position_um), strict=True):
        second = f' f2="{decimal(taken[int(t)] * round(RATED), 3)}"' if int(t) in taken else ""
        parts.append(f'<rec time="{decimal(t, 6)}" f1="{x}"{second}/>')
    parts.append("</dataFrame></traceData></traceDataRoot>")
    return _written(folder / "trace.xml", "\n".join(parts), "utf-8")


def sinumerik_unnamed(folder: Path, m: Motion) -> Path:
    """Signals without a description, in a name space, all at one rate."""
    parts = [
        '<?xml version="1.0" encoding="utf-8"?>',
        '<tr:traceDataRoot xmlns:tr="http://www.example.org/trace"><tr:traceData><tr:dataFrame>',
        '<tr:frameHeader startTime="2025-03-14T09:31:12" stopInc="0"/>',
        '<tr:dataSignal id="a" name="/Nck/!SD/nckServoDataActPos1stEnc64[u1,1]" units="mm"/>',
        '<tr:dataSignal id="b" name="/DriveVsa/Force r80[u1,1]" units="N"/>',
    ]
    parts += [
        f'<tr:rec time="{decimal(t, 6)}" a="{x}" b="{f}"/>' for t, x, f in zip(m.time_us, mm(m.position_um), newton(m.torque), strict=True)
    ]
    parts.append("</tr:dataFrame></tr:traceData></tr:traceDataRoot>")
    return _written(folder / "session.xml", "".join(parts), "utf-8")


def sinumerik_changes(folder: Path, m: Motion) -> Path:
    """A signal that is written only where it changes: until then a NaN stands there, as the number of its bits."""
    parts = [
        "<traceDataRoot><traceData><dataFrame>",
        '<dataSignal id="f1" description="Position actual value X1" units="mm"/>',
        '<dataSignal id="f2" description="Force actual value X1" units="N"/>',
    ]
    before = None
    for t, x, f in zip(m.time_us, mm(m.position_um), newton(m.torque), strict=True):
        parts.append(f'<rec time="{decimal(t, 6)}" f1="{x}" f2="{"9221120237041090560" if f == before else f}"/>')
        before = f
    parts.append("</dataFrame></traceData></traceDataRoot>")
    return _written(folder / "changes.xml", "\n".join(parts), "utf-8")


ENCODER = "/Nck/!SD/nckServoDataActPos1stEnc64 [u1{} 1]"


def sinumerik_text(folder: Path, m: Motion) -> Path:
    """Columns named by their addresses, commas between them."""
    rows = [f"time [s],{ENCODER.format(';')},/DriveVsa/Force r80 [u1; 1]"]
    rows += [f"{decimal(t, 6)},{x},{f}" for t, x, f in zip(m.time_us, mm(m.position_um), newton(m.torque), strict=True)]
    return _written(folder / "trace.csv", "\n".join(rows) + "\n", "utf-8")


def sinumerik_plus(folder: Path, m: Motion) -> Path:
    """A plus before each address, no time but the interval above, German numbers."""
    rows = ["SINUMERIK Operate", "Sampling time [ms];1", f"+{ENCODER.format(',')};+/DriveVsa/Force r80 [u1, 1]"]
    rows += [f"{x};{f}" for x, f in zip(mm(m.position_um, comma=True), newton(m.torque, comma=True), strict=True)]
    return _written(folder / "trace.csv", "\r\n".join(rows) + "\r\n", "cp1252")


def sinumerik_slow(folder: Path, m: Motion) -> Path:
    """A signal of the drive at half the rate, empty in between, in quotes."""
    rows = [f'"Time [s]";"{ENCODER.format(",")}";"/DriveVsa/Force r80 [u1, 1]"']
    cells = zip(m.time_us, mm(m.position_um), newton(m.torque), strict=True)
    rows += [f"{decimal(t, 6)};{x};{f if i % 2 == 0 else ''}" for i, (t, x, f) in enumerate(cells)]
    return _written(folder / "trace.csv", "\n".join(rows) + "\n", "utf-8")


def epics_dates(folder: Path, m: Motion) -> Path:
    start = datetime.datetime(2025, 3, 14, 9, 31, 12)
    lines = []
    for t, x, f in zip(m.time_us, mm(m.position_um), newton(m.torque), strict=True):
        stamp = f"{start + datetime.timedelta(microseconds=int(t)):%Y-%m-%d %H:%M:%S.%f}"
        lines += [f"XF:01-Mtr:X:Pos-RBV {stamp} {x}", f"XF:01-Mtr:X:Force-I {stamp} {f}"]
    return _written(folder / "archive.txt", "\n".join(lines) + "\n", "ascii")


def epics_seconds(folder: Path, m: Motion) -> Path:
    lines = ["# name, seconds, value, severity"]
    for t, x, f in zip(m.time_us, mm(m.position_um), newton(m.torque), strict=True):
        lines += [f"axis:position,{decimal(t, 6)},{x},NO_ALARM", f"axis:force,{decimal(t, 6)},{f},NO_ALARM"]
    return _written(folder / "archive.csv", "\n".join(lines) + "\n", "ascii")


def epics_states(folder: Path, m: Motion) -> Path:
    start = datetime.datetime(2025, 3, 14, 9, 31, 12)
    lines = []
    for name, values in (("BL1:AXIS:LAGE", mm(m.position_um)), ("BL1:AXIS:KRAFT", newton(m.torque))):
        for t, value in zip(m.time_us, values, strict=True):
            stamp = f"{start + datetime.timedelta(microseconds=int(t)):%Y-%m-%d\t%H:%M:%S.%f}"
            lines.append(f"{name}\t{stamp}\t{value}\tHIGH MINOR")
    return _written(folder / "monitor.txt", "\r\n".join(lines) + "\r\n", "ascii")


def _written(path: Path, text: str, encoding: str) -> Path:
    path.write_bytes(text.encode(encoding))
    return path


class Export(NamedTuple):
    """A writer, what a person fills in, and whether the effort was recorded as often as the position."""

    write: Callable[[Path, Motion], Path]
    filled: dict[str, str] = {}  # noqa: RUF012
    exact: bool = True


UNIT, FORCE = {"columns.position.unit": "mm"}, {"columns.effort.unit": "N"}
RATED_FORCE = {"effort.rated": f"{RATED:.0f} N"}
EXPORTS = {
    "twincat, full": Export(twincat_full, UNIT | RATED_FORCE),
    "twincat, rates": Export(twincat_rates, RATED_FORCE, exact=False),
    "twincat, names": Export(twincat_names, UNIT | RATED_FORCE),
    "twincat, groups": Export(twincat_groups, RATED_FORCE),
    "twincat, no times": Export(twincat_no_times, RATED_FORCE),
    "twincat, bare names": Export(twincat_bare_names, UNIT | RATED_FORCE),
    "drive, German": Export(drive_german),
    "drive, no time": Export(drive_without_time),
    "drive, units row": Export(drive_units_row),
    "no header": Export(headerless, UNIT | FORCE),
    "units behind strokes": Export(stroke_units),
    "dates": Export(date_stamps),
    "LabVIEW": Export(labview),
    "LabVIEW, times": Export(labview_columns, exact=False),
    "LabVIEW, no times": Export(labview_no_times),
    "quoted": Export(quoted),
    "long ago": Export(long_ago),
    "pairs": Export(several_times, exact=False),
    "sparse": Export(sparse, exact=False),
    "records": Export(records, UNIT | FORCE),
    "columns": Export(columns),
    "lines": Export(json_lines, RATED_FORCE),
    "SINUMERIK": Export(sinumerik, exact=False),
    "SINUMERIK, no names": Export(sinumerik_unnamed),
    "SINUMERIK, changes": Export(sinumerik_changes),
    "SINUMERIK, text": Export(sinumerik_text, UNIT | FORCE),
    "SINUMERIK, text without time": Export(sinumerik_plus, UNIT | FORCE),
    "SINUMERIK, text, slow": Export(sinumerik_slow, UNIT | FORCE, exact=False),
    "EPICS, dates": Export(epics_dates, UNIT | FORCE),
    "EPICS, seconds": Export(epics_seconds, UNIT | FORCE),
    "EPICS, states": Export(epics_states, UNIT | FORCE),
}
