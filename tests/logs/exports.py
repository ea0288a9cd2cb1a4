"""Files as other programs write them: one motion, in many formats and dialects. Shares no code with the readers."""

from __future__ import annotations

import datetime
import json
from collections.abc import Callable, Iterator
from itertools import cycle
from pathlib import Path
from typing import NamedTuple

import numpy as np

RATE = 1000.0
RATED = 250.0  # N, for efforts in per mille
LATE = datetime.datetime(2025, 3, 14, 23, 59, 58)  # two seconds before midnight
TICKS = 133860042720000000  # of 100 ns, at the first sample
NANOSECONDS = 1_741_944_672_000_000_000  # since 1970
NOTHING_YET = "9221120237041090560"  # a NaN, as the number of its bits


class Motion(NamedTuple):
    """What was recorded, as the whole numbers that a drive stores: µm, µm/s, per mille of the rated force."""

    time_us: np.ndarray
    position_um: np.ndarray
    reference_um: np.ndarray
    velocity_um_s: np.ndarray
    torque: np.ndarray


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


def decimals(values: np.ndarray, places: int = 3) -> list[str]:
    """Whole numbers of units of the last place, written out."""
    return [
        f"{'-' if value < 0 else ''}{abs(value) // 10**places}.{abs(value) % 10**places:0{places}d}"
        for value in values.tolist()
    ]


def packed(values: list, step: int, start: int = 0) -> list:
    """A signal of a slower rate, its samples one below the other, and empty cells behind its last one."""
    kept = values[start::step]
    return kept + [""] * (len(values) - len(kept))


def cells(m: Motion) -> Iterator[dict[str, object]]:
    """The cells of each sample, by name: time t, position x, reference r, velocity v, force f; ct, cx and so on have a decimal comma."""
    ticks = [TICKS + 10 * t for t in m.time_us.tolist()]
    columns = {
        "t": decimals(m.time_us, 6),
        "ms": decimals(m.time_us),
        "x": decimals(m.position_um),
        "r": decimals(m.reference_um),
        "v": decimals(m.velocity_um_s),
        "f": decimals(m.torque * round(RATED)),
    }
    columns |= {
        f"c{name}": [cell.replace(".", ",") for cell in column] for name, column in columns.items()
    }
    columns |= {
        "torque": m.torque.tolist(),
        "whole_ms": (m.time_us // 1000).tolist(),
        "milli": (m.time_us // 1000 % 1000).tolist(),
        "tick": ticks,
        "ns": [NANOSECONDS + 1000 * t for t in m.time_us.tolist()],
        "date": [LATE + datetime.timedelta(microseconds=t) for t in m.time_us.tolist()],
        "t_half": packed(columns["t"], 2),
        "f_half": packed(columns["f"], 2),
        "t_quarter": packed(columns["t"], 4),
        "f_quarter": packed(columns["f"], 4),
        "tick_half": packed(ticks, 2, 4),
        "torque_half": packed(m.torque.tolist(), 2, 4),
        "f_changed": [
            f if f != before else NOTHING_YET
            for before, f in zip([None, *columns["f"]], columns["f"], strict=False)
        ],
    }
    return (dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True))


class Text(NamedTuple):
    """A file of text: the lines above its samples, those of a sample, which may take turns, and the lines below."""

    name: str
    head: list[str]
    rows: str | tuple[str, ...]
    foot: tuple[str, ...] = ()
    encoding: str = "utf-8"
    end: str = "\n"

    def __call__(self, folder: Path, m: Motion) -> Path:
        head = [line.format(count=m.time_us.size) for line in self.head]
        rows = cycle([self.rows] if isinstance(self.rows, str) else self.rows)
        lines = [
            *head,
            *(row.format_map(cell) for row, cell in zip(rows, cells(m), strict=False)),
            *self.foot,
        ]
        return _written(
            folder / self.name, "".join(line + self.end for line in lines), self.encoding
        )


def _written(path: Path, text: str, encoding: str = "utf-8") -> Path:
    path.write_bytes(text.encode(encoding))
    return path


def scope(delimiter: str, *channels: tuple[str, str, str, str, str]) -> list[str]:
    """The lines above the samples of a scope, a column of time and a column of values for each channel."""
    keys = {
        "Name": [channel[0] for channel in channels],
        "SymbolComment": ["" for _ in channels],
        "Data-Type": [channel[1] for channel in channels],
        "SampleTime[ms]": [channel[2] for channel in channels],
        "VariableSize": ["8" for _ in channels],
        "SymbolBased": ["True" for _ in channels],
        "IndexGroup": ["" for _ in channels],
        "IndexOffset": ["" for _ in channels],
        "SymbolName": [channel[3] for channel in channels],
        "NetID": ["5.12.34.56.1.1" for _ in channels],
        "Port": ["501" for _ in channels],
        "Offset": ["0" for _ in channels],
        "ScaleFactor": ["1" for _ in channels],
        "BitMask": ["0xffffffffffffffff" for _ in channels],
        "Unit": [channel[4] for channel in channels],
        "Unit ScaleFactor": ["1" for _ in channels],
        "Unit Offset": ["0" for _ in channels],
    }
    facts = (
        ("Name", "Scope Project"),
        ("File", "C:\\scope\\machine.svdx"),
        ("Starttime of export", "133860042720000000", "Friday, 14. March 2025", "09:31:12.000"),
        ("Endtime of export", "133860043119990000", "Friday, 14. March 2025", "09:31:52.000"),
    )
    lines = [
        delimiter.join(f"{key}{delimiter}{value}" for value in values)
        for key, values in keys.items()
    ]
    return [*map(delimiter.join, facts), "", "", *lines, ""]


def records(folder: Path, m: Motion) -> Path:
    entries = [
        {
            "timestamp": float(cell["t"]),
            "position": float(cell["x"]),
            "goal_position": float(cell["r"]),
            "force": float(cell["f"]),
            "torque_enable": True,
        }
        for cell in cells(m)
    ]
    return _written(
        folder / "records.json",
        json.dumps({"mass": 0.2, "motor": "hls", "nested": {"kp": 30}, "entries": entries}),
    )


def columns(folder: Path, m: Motion) -> Path:
    data = {
        "units": {"t": "ms", "Lage": "mm", "Kraft": "N"},
        "t": [float(cell["ms"]) for cell in cells(m)],
        "Lage": [float(cell["x"]) for cell in cells(m)],
        "Kraft": [float(cell["f"]) for cell in cells(m)],
    }
    return _written(
        folder / "columns.json", json.dumps(data, indent=1, ensure_ascii=False), "utf-8-sig"
    )


def json_lines(folder: Path, m: Motion) -> Path:
    rows = (
        {
            "time": cell["date"].isoformat() + "+00:00",
            "axis": {"pos_mm": float(cell["x"]), "torque_permille": cell["torque"]},
        }
        for cell in cells(m)
    )
    return _written(folder / "lines.jsonl", "".join(json.dumps(row) + "\n" for row in rows))


class Export(NamedTuple):
    """A writer, what a person fills in, and whether the effort was recorded as often as the position."""

    write: Callable[[Path, Motion], Path]
    filled: dict[str, str] = {}  # noqa: RUF012
    exact: bool = True


UNIT, FORCE = {"columns.position.unit": "mm"}, {"columns.effort.unit": "N"}
RATED_FORCE = {"effort.rated": f"{RATED:.0f} N"}
ENCODER = "/Nck/!SD/nckServoDataActPos1stEnc64 [u1{} 1]"
FRAME_END = ("</dataFrame></traceData></traceDataRoot>",)
EXPORTS = {
    "twincat, full": Export(
        Text(
            "scope_full.csv",
            scope(
                "\t",
                ("ActPos", "REAL64", "1", "Axes.X.ToPlc.ActPos", "(None)"),
                ("SetPos", "REAL64", "1", "Axes.X.ToPlc.SetPos", "(None)"),
                ("ActTorque", "INT16", "1", "Axes.X.ToPlc.ActTorque", "(None)"),
            ),
            "{whole_ms}\t{cx}\t{whole_ms}\t{cr}\t{whole_ms}\t{torque}",
            encoding="utf-8-sig",
            end="\r\n",
        ),
        UNIT | RATED_FORCE,
    ),
    # The torque is recorded at half the rate, and four milliseconds later.
    "twincat, rates": Export(
        Text(
            "scope_rates.csv",
            scope(
                ";",
                ("ActTorque", "INT16", "2", "Axis 1.ActTorque", "(None)"),
                ("ActPos", "REAL64", "1", "Axis 1.ActPos", "mm"),
            ),
            "{tick_half};{torque_half};{tick};{x}",
            foot=("EOF",),
        ),
        RATED_FORCE,
        exact=False,
    ),
    "twincat, names": Export(
        Text(
            "scope_names.txt",
            ["Name\tIstposition\tName\tIstmoment"],
            "{ms}\t{x}\t{ms}\t{torque}",
            encoding="utf-16",
            end="\r\n",
        ),
        UNIT | RATED_FORCE,
    ),
    # A single column of time for all channels of one sample time.
    "twincat, groups": Export(
        Text(
            "scope_groups.csv",
            [
                "Name\tScope",
                "File\tx.svdx",
                "",
                "Name\tAxis_ActPos\tAxis_ActVelo\tAxis_ActTorque",
                "SampleTime[ms]\t1\t1\t1",
                "Unit\tmm\tmm/s\t‰",
                "",
            ],
            "{cms}\t{cx}\t{cv}\t{torque}",
            end="\r\n",
        ),
        RATED_FORCE,
    ),
    # Without times: the sample time stands in the header, and no cell below its key.
    "twincat, no times": Export(
        Text(
            "scope_no_times.csv",
            [
                "Name\tScope",
                "",
                "Name\tActPos\tActTorque",
                "Data-Type\tREAL64\tINT16",
                "SampleTime[ms]\t1\t1",
                "Unit\tmm\t(None)",
                "",
            ],
            "{cx}\t{torque}",
            end="\r\n",
        ),
        RATED_FORCE,
    ),
    # Names above the times, nothing above the values.
    "twincat, bare names": Export(
        Text(
            "scope_bare.csv",
            ["ActPos\t\tActTorque\t"],
            "{whole_ms}\t{cx}\t{whole_ms}\t{torque}",
            end="\r\n",
        ),
        UNIT | RATED_FORCE,
    ),
    "drive, German": Export(
        Text(
            "trace.csv",
            [
                "Gerät;AX5112;",
                "Seriennummer;0012345;",
                "Datum;14.03.2025 09:31:12;",
                f"Nennkraft;{RATED:.0f} N;",
                "Abtastzeit;1 ms;",
                "",
                "Zeit [ms];Lageistwert [mm];Lagesollwert [mm];Geschwindigkeit [mm/s];Moment [‰]",
            ],
            "{cms};{cx};{cr};{cv};{torque}",
            encoding="cp1252",
            end="\r\n",
        )
    ),
    "drive, no time": Export(
        Text(
            "recorder.csv",
            [
                "Device,AKD-P00606",
                "Sample time [ms],1",
                f"Rated force,{RATED:.0f} N",
                "PL.FB (mm),PL.CMD (mm),Force (N)",
            ],
            "{x},{r},{f}",
            encoding="utf-8-sig",
        )
    ),
    "drive, units row": Export(
        Text(
            "units_row.txt",
            [
                "Trace of axis Y",
                "Time\tPosition actual value\tPosition demand value\tForce actual",
                "s\tmm\tmm\tN",
            ],
            "{t}\t{x}\t{r}\t{f}",
            encoding="utf-16",
            end="\r\n",
        )
    ),
    "no header": Export(Text("bare.dat", [], "{t} {x} {f}"), UNIT | FORCE),
    "units behind strokes": Export(Text("iupac.csv", ["t/s,x/mm,F/N"], "{t},{x},{f}")),
    "dates": Export(
        Text(
            "dates.csv",
            ["Timestamp;Weg in mm;Kraft in N"],
            "{date:%d.%m.%Y %H:%M:%S},{milli:03d};{cx};{cf}",
            encoding="latin-1",
            end="\r\n",
        )
    ),
    "LabVIEW": Export(
        Text(
            "log.lvm",
            [
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
                "Samples\t{count}\t{count}\t",
                "Date\t2025/03/14\t2025/03/14\t",
                "Time\t09:31:12,1\t09:31:12,1\t",
                "Y_Unit_Label\tmm\tN\t",
                "X_Dimension\tTime\tTime\t",
                "X0\t0,0E+0\t0,0E+0\t",
                "Delta_X\t1,000000E-3\t1,000000E-3\t",
                "***End_of_Header***\t\t\t",
                "X_Value\tPosition\tForce\tComment",
            ],
            "{ct}\t{cx}\t{cf}\t",
            encoding="cp1252",
            end="\r\n",
        )
    ),
    # A time beside each channel, and a decimal point.
    "LabVIEW, times": Export(
        Text(
            "columns.lvm",
            [
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
                "Samples\t4000\t\t2000\t",
                "Date\t2025/03/14\t\t2025/03/14\t",
                "Time\t09:31:12.1\t\t09:31:12.1\t",
                "Y_Unit_Label\tmm\t\tN\t",
                "X_Dimension\tTime\t\tTime\t",
                "X0\t0.0000000000000000E+0\t\t0.0000000000000000E+0\t",
                "Delta_X\t0.001000\t\t0.002000\t",
                "***End_of_Header***\t\t\t\t",
                "X_Value\tPosition\tX_Value\tForce\tComment",
            ],
            "{t}\t{x}\t{t_half}\t{f_half}\t",
            encoding="cp1252",
            end="\r\n",
        ),
        exact=False,
    ),
    # Samples alone, separated by commas: their times are in the header.
    "LabVIEW, no times": Export(
        Text(
            "plain.lvm",
            [
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
                "Samples,{count},{count},",
                "Date,2025/03/14,2025/03/14,",
                "Time,09:31:12.1,09:31:12.1,",
                "Y_Unit_Label,mm,N,",
                "X_Dimension,Time,Time,",
                "X0,0.0E+0,0.0E+0,",
                "Delta_X,1.000000E-3,1.000000E-3,",
                "***End_of_Header***,,,",
                "X_Value,Position,Force,Comment",
            ],
            ",{x},{f},",
            encoding="cp1252",
            end="\r\n",
        )
    ),
    # Decimal commas between commas, each cell in quotation marks.
    "quoted": Export(
        Text("quoted.csv", ['"Zeit [s]","Weg [mm]","Kraft [N]"'], '"{ct}","{cx}","{cf}"')
    ),
    # Times in ns since 1970, which a number of double precision cannot hold.
    "long ago": Export(
        Text(
            "ctrlx.csv",
            ["sep=;", "timestamp;axs/X/actual/position [mm];axs/X/actual/force [N]"],
            "{ns};{x};{f}",
        )
    ),
    "pairs": Export(
        Text(
            "pairs.csv",
            ["time_pos;pos [mm];time_force;force [N]"],
            "{t};{x};{t_quarter};{f_quarter}",
        ),
        exact=False,
    ),
    "sparse": Export(
        Text("sparse.csv", ["timestamp,position_mm,force_N"], ("{t},{x},{f}", *4 * ["{t},{x},"])),
        exact=False,
    ),
    "records": Export(records, UNIT | FORCE),
    "columns": Export(columns),
    "lines": Export(json_lines, RATED_FORCE),
    "SINUMERIK": Export(
        Text(
            "trace.xml",
            [
                '<?xml version="1.0" encoding="UTF-8"?>',
                "<traceDataRoot><traceData><dataFrame>",
                '<frameHeader startTime="2025-03-14T09:31:12" stopInc="0"/>',
                '<dataSignal id="f1" key="1" name="/Nck/!SD/nckServoDataActPos1stEnc64[u1,1]" '
                'description="Lageistwert Messsystem 1 X1 (64 bit)" units="mm" interval="1" datapointCount="4000"/>',
                '<dataSignal id="f2" key="2" name="/DriveVsa/r80" description="Kraftistwert X1" units="N" interval="2"/>',
            ],
            ('<rec time="{t}" f1="{x}" f2="{f}"/>', '<rec time="{t}" f1="{x}"/>'),
            FRAME_END,
        ),
        exact=False,
    ),
    # Signals without a description, in a name space, all at one rate, on a single line.
    "SINUMERIK, no names": Export(
        Text(
            "session.xml",
            [
                '<?xml version="1.0" encoding="utf-8"?>',
                '<tr:traceDataRoot xmlns:tr="http://www.example.org/trace"><tr:traceData><tr:dataFrame>',
                '<tr:frameHeader startTime="2025-03-14T09:31:12" stopInc="0"/>',
                '<tr:dataSignal id="a" name="/Nck/!SD/nckServoDataActPos1stEnc64[u1,1]" units="mm"/>',
                '<tr:dataSignal id="b" name="/DriveVsa/Force r80[u1,1]" units="N"/>',
            ],
            '<tr:rec time="{t}" a="{x}" b="{f}"/>',
            ("</tr:dataFrame></tr:traceData></tr:traceDataRoot>",),
            end="",
        )
    ),
    # A signal that is written only where it changes.
    "SINUMERIK, changes": Export(
        Text(
            "changes.xml",
            [
                "<traceDataRoot><traceData><dataFrame>",
                '<dataSignal id="f1" description="Position actual value X1" units="mm"/>',
                '<dataSignal id="f2" description="Force actual value X1" units="N"/>',
            ],
            '<rec time="{t}" f1="{x}" f2="{f_changed}"/>',
            FRAME_END,
        )
    ),
    # Columns named by their addresses, commas between them.
    "SINUMERIK, text": Export(
        Text(
            "trace.csv",
            [f"time [s],{ENCODER.format(';')},/DriveVsa/Force r80 [u1; 1]"],
            "{t},{x},{f}",
        ),
        UNIT | FORCE,
    ),
    # A plus before each address, no time but the interval above, German numbers.
    "SINUMERIK, text without time": Export(
        Text(
            "trace.csv",
            [
                "SINUMERIK Operate",
                "Sampling time [ms];1",
                f"+{ENCODER.format(',')};+/DriveVsa/Force r80 [u1, 1]",
            ],
            "{cx};{cf}",
            encoding="cp1252",
            end="\r\n",
        ),
        UNIT | FORCE,
    ),
    # A signal of the drive at half the rate, empty in between, in quotes.
    "SINUMERIK, text, slow": Export(
        Text(
            "trace.csv",
            [f'"Time [s]";"{ENCODER.format(",")}";"/DriveVsa/Force r80 [u1, 1]"'],
            ("{t};{x};{f}", "{t};{x};"),
        ),
        UNIT | FORCE,
        exact=False,
    ),
    "EPICS, dates": Export(
        Text(
            "archive.txt",
            [],
            "XF:01-Mtr:X:Pos-RBV {date:%Y-%m-%d %H:%M:%S.%f} {x}\nXF:01-Mtr:X:Force-I {date:%Y-%m-%d %H:%M:%S.%f} {f}",
        ),
        UNIT | FORCE,
    ),
    "EPICS, seconds": Export(
        Text(
            "archive.csv",
            ["# name, seconds, value, severity"],
            "axis:position,{t},{x},NO_ALARM\naxis:force,{t},{f},NO_ALARM",
        ),
        UNIT | FORCE,
    ),
    # All samples of one channel, and then those of the other.
    "EPICS, states": Export(
        lambda folder, m: _written(
            folder / "monitor.txt",
            "".join(
                f"{name}\t{cell['date']:%Y-%m-%d\t%H:%M:%S.%f}\t{cell[kind]}\tHIGH MINOR\r\n"
                for name, kind in (("BL1:AXIS:LAGE", "x"), ("BL1:AXIS:KRAFT", "f"))
                for cell in cells(m)
            ),
        ),
        UNIT | FORCE,
    ),
}
