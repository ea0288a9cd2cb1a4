"""Does a file of `bristle export` push the wrong way? Three axes of another simulator, each file read as a drive does.

Each axis moves from point to point with dwells, over the distances that the file states. What a drive computes from the
text of each file is written here, from the documents of the drives, and not taken from the package. A move whose error
is larger than without compensation counts, unless the promise of the file leaves it out.
"""

from __future__ import annotations

import csv
import ctypes
import json
import math
import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.coverage import Share
from benchmarks.rigs import Gains, Recorded, Rig, motion
from benchmarks.timing import BRISTLE

__all__ = ["pushes"]

WORSE = 1.05
SHORTEST, DWELL, BEFORE = 0.1, 0.2, 0.15  # [s]
MODELS = ("stribeck+asymmetry", "lugre+asymmetry", "maxwell_slip+asymmetry")
Drive = Callable[[np.ndarray, float], np.ndarray]


@dataclass(frozen=True)
class Machine:
    """An axis, its gains, and what its drive counts in.

    `lead` is the travel for one turn of the screw [m], `ratio` the turns of the motor for one of the screw, `rated` its
    rated torque [N*m]; without a lead, `rated` is a force [N]. `constant` is the effort of a unit of the log [N].
    """

    rig: Rig
    fast: float
    lead: float = 0.0
    ratio: float = 1.0
    rated: float = 1.0
    unit: str = "N"
    constant: float = 1.0
    told: str = ""

    @property
    def gains(self) -> Gains:
        """Gains for a velocity loop of this bandwidth, as the log was recorded: without velocity fed forward."""
        return Gains(
            0.25 * self.fast, self.rig.mass * self.fast, 0.1 * self.rig.mass * self.fast**2
        )

    @property
    def torque(self) -> float:
        """Force on the table for one newton metre at the motor, or 1 [N]."""
        return 2.0 * math.pi * self.ratio / self.lead if self.lead else 1.0

    @property
    def percent(self) -> float:
        """Force for one percent of rated [N]."""
        return 0.01 * self.rated * self.torque

    def written(self, folder: Path, reference: np.ndarray) -> None:
        """Write log and axis file."""
        gains, record, t = (
            self.gains,
            self.rig.run(self.gains, reference),
            self.rig.dt * np.arange(reference.size),
        )
        columns = np.column_stack([t, record.position, reference, record.effort / self.constant])
        np.savetxt(folder / "log.csv", columns, "%.10g", ",", header="t,q,r,u", comments="")
        (folder / "axis.toml").write_text(
            'schema = 1\nkind = "translational"\n[columns]\ntime = { column = "t", unit = "s" }\n'
            'position = { column = "q", unit = "m" }\nreference = { column = "r", unit = "m" }\n'
            f'effort = {{ column = "u", unit = "{self.unit}" }}\n'
            f'[encoder]\nresolution = "{self.rig.resolution:g} m"\n[plant]\noffset = "identify"\n'
            '[controller]\nmodel = "cascade"\n'
            f'k_p = "{gains.k_p:.9g} 1/s"\nk_v = "{gains.k_v:.9g} N*s/m"\nk_i = "{gains.k_i:.9g} N/m"\n'
            f'[effort]\nheld = true\nlag = "{self.rig.lag:.9g} s"\n{self.told}',
            encoding="utf-8",
        )


MACHINES = {
    "screw": Machine(
        Rig(
            60.0,
            90.0,
            110.0,
            5e-3,
            400.0,
            8e-6,
            cogging=4.0,
            dt=5e-4,
            lag=4e-4,
            scale=np.array([1.06, 0.94]),
        ),
        250.0,
        0.010,
        2.0,
        1.2,
        told='rated = "1.2 N*m"\n[transmission]\nlead = "10 mm"\ngear_ratio = 2.0\n',
    ),
    "linear motor": Machine(
        Rig(12.0, 20.0, 24.0, 3e-3, 60.0, 4e-6, dt=1e-3, scale=np.array([0.92, 1.08])),
        180.0,
        rated=400.0,
        unit="A",
        constant=61.2,
        told='force_constant = "61.2 N/A"\nrated = "400 N"\n',
    ),
    "vertical": Machine(
        Rig(150.0, 210.0, 240.0, 8e-3, 900.0, 1.5e-5, gravity=450.0, dt=1e-3, lag=8e-4, delay=1),
        150.0,
        0.020,
        1.0,
        8.0,
        told='rated = "8 N*m"\n[transmission]\nlead = "20 mm"\n',
    ),
}


def pushes() -> Iterator[Share]:
    """Count the moves on which a file pushes the wrong way without saying so."""
    for name, machine in MACHINES.items():
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            machine.written(folder, motion(machine.rig, 14.0, 31, 0.02, 0.05))
            for model in MODELS:
                asked = (
                    "--axis",
                    "axis.toml",
                    "--model",
                    model,
                    "--draws",
                    "0",
                    "--force",
                    "--out",
                    "found",
                )
                _bristle(folder, "identify", "log.csv", *asked)
                for target, (arguments, read) in TARGETS.items():
                    yield _judged(f"{name}, {model}, {target}", machine, folder, arguments, read)


def _bristle(folder: Path, *arguments: str) -> dict[str, Any] | None:
    """Return what a command prints as JSON; None where it refuses."""
    ran = subprocess.run(
        [BRISTLE, *arguments, "--json"], cwd=folder, capture_output=True, text=True, check=False
    )
    if ran.returncode == 2 and "makes the error larger" in ran.stderr:
        return None
    if ran.returncode:
        raise RuntimeError(ran.stderr)
    return json.loads(ran.stdout)


def _judged(
    name: str, machine: Machine, folder: Path, arguments: tuple[str, ...], read: Any
) -> Share:
    shutil.rmtree(folder / "out", ignore_errors=True)
    written = _bristle(folder, "export", *arguments, "--out", "out")
    if written is None:
        return Share(f"no wrong push: {name}", 100.0, 100.0, 100.0, 0, "refused")
    effect = written["effect"]
    # These moves last 0.1 s or longer: they are slow ones.
    slow = [claim["least_distance"] for claim in effect["claims"] or () if claim["slowest_move"]]
    least = min(slow, default=math.inf)
    ahead, rig = effect["samples_ahead"], machine.rig
    drive = None if read is None else read(folder / "out", machine)
    law = Law(folder / "out", rig.dt) if read is None else None
    kept, told = [], []
    for move in (one for one in effect["along"] if one["motion"] == "moves"):
        x = moves(move["distance"], rig.dt, 0.05, ahead)
        desired = x[: x.size - ahead]
        inertia = rig.mass * np.gradient(np.gradient(desired, rig.dt), rig.dt)
        # The loop that files state has velocity and inertia fed forward.
        gains = replace(machine.gains, k_ff=1.0)
        without = _error(rig, rig.run(gains, desired, inertia))
        if drive is not None:
            with_it = _error(rig, rig.run(gains, desired, inertia + drive(x, rig.dt)[ahead:]))
        else:
            with_it = _error(rig, rig.follow(law.along(x, desired.size), desired))
        kept.append(move["distance"] < least * (1.0 - 1e-9) or with_it <= WORSE * without)
        told.append(
            f"{1e6 * without:.3g} -> {1e6 * with_it:.3g} um"
            + (" (stated in the file)" * (move["distance"] < least))
        )
    return Share(
        f"no wrong push: {name}",
        100.0 * float(np.mean(kept)),
        100.0,
        100.0,
        len(kept),
        "; ".join(told),
    )


def _error(rig: Rig, record: Recorded) -> float:
    return float(np.ptp((record.reference - record.position)[round(0.5 * BEFORE / rig.dt) :]))


def moves(distance: float, dt: float, speed: float, ahead: int) -> np.ndarray:
    """Return positions from rest to rest: on, on, back, back, on, back, by fifth-order legs with dwells between."""
    duration = max(SHORTEST, 1.9 * distance / speed)
    s = np.arange(1, math.ceil(duration / dt) + 1) * dt / duration
    s = np.minimum(s, 1.0)
    leg = np.concatenate(
        [distance * s**3 * (10.0 - 15.0 * s + 6.0 * s**2), np.full(round(DWELL / dt), distance)]
    )
    parts, at = [np.zeros(round(BEFORE / dt))], 0.0
    for way in (1, 1, -1, -1, 1, -1):
        parts.append(at + way * leg)
        at += way * distance
    return np.append(np.concatenate(parts), np.full(ahead, at))


# --- drives -----------------------------------------------------------------------------------------------------------


def _text(folder: Path, end: str) -> str:
    return next(path for path in sorted(folder.iterdir()) if path.name.endswith(end)).read_text(
        encoding="utf-8"
    )


def _table_rows(text: str) -> list[list[str]]:
    return list(csv.reader(line for line in text.splitlines() if line and not line.startswith("#")))


def _velocity(x: np.ndarray, dt: float) -> np.ndarray:
    """Return the velocity of the step that ends at each position; a billionth of a micrometre is none."""
    v = np.diff(x, prepend=x[0]) / dt
    return np.where(np.abs(v) * dt < 1e-15, 0.0, v)


def _last_way(v: np.ndarray) -> np.ndarray:
    way, last = np.zeros(v.size), 0.0
    for k, value in enumerate(v):
        last = math.copysign(1.0, value) if value else last
        way[k] = last
    return way


def _unit(machine: Machine, unit: str) -> float:
    """Return what an effort in a unit of a drive is on the table [N]."""
    named = {
        "N": 1.0,
        "N*m at the motor": machine.torque,
        "% of rated": machine.percent,
        "A": machine.constant,
    }
    return named[unit]


def of_table(folder: Path, machine: Machine) -> Drive:
    """Interpolate over the velocity; at rest by the rule that the head states."""
    text = _text(folder, "_drive.csv")
    (head, *rows), values = _table_rows(text), []
    speed, effort = (re.search(r"\[(.*)\]", column)[1] for column in head)
    per = {"rpm of the motor": machine.lead / machine.ratio / 60.0, "mm/min": 1e-3 / 60.0}[speed]
    values = np.array([[float(v) * per, float(u) * _unit(machine, effort)] for v, u in rows])
    signs = np.array([-1.0 if v.startswith("-") else 1.0 for v, _ in rows])
    rest = re.search(r"at rest \(velocity 0\): output the (entry|mean)", text)
    held = rest[1] == "entry"
    below, above = values[signs < 0], values[signs > 0]

    def drive(x: np.ndarray, dt: float) -> np.ndarray:
        v = _velocity(x, dt)
        forward, backward = np.interp(v, *above.T), np.interp(v, *below.T)
        middle = 0.5 * (above[0, 1] + below[-1, 1])
        way = _last_way(v)
        resting = (
            np.where(way > 0, above[0, 1], np.where(way < 0, below[-1, 1], middle))
            if held
            else middle
        )
        return np.where(v > 0.0, forward, np.where(v < 0.0, backward, resting))

    return drive


def of_levels(folder: Path, machine: Machine) -> Drive:
    """Take gravity, levels and viscous friction in the last unit that the file has; at rest gravity."""
    text = _text(folder, ".csv")
    rows = _table_rows(text)[1:]
    levels = {
        name: float(amount) * _unit(machine, unit)
        for name, amount, unit, _ in rows
        if name in ("gravity", "F+", "F-")
    }
    viscous = {
        name: float(amount) for name, amount, unit, _ in rows if name[0] == "D" and unit == "N*s/m"
    }
    held = "last direction" in text

    def drive(x: np.ndarray, dt: float) -> np.ndarray:
        v = _velocity(x, dt)
        way = _last_way(v) if held else np.sign(v)
        level = np.where(way > 0, levels["F+"], np.where(way < 0, -levels["F-"], 0.0))
        return levels["gravity"] + level + np.where(v > 0, viscous["D+"], viscous["D-"]) * v

    return drive


def of_tf5200(folder: Path, machine: Machine) -> Drive:
    """Follow P-COMP-00041 to 00047: a curve over speed, decaying before a reversal and built up behind it."""
    rows = dict(
        line.split()[:2]
        for line in _text(folder, ".txt").splitlines()
        if line.startswith("frict_comp.")
    )
    number = {key.removeprefix("frict_comp."): float(value) for key, value in rows.items()}
    count = int(number["table_entries"])
    speeds = np.array([1e-6 * number[f"table[{i}].in"] for i in range(count)])
    forces = np.array([0.1 * machine.percent * number[f"table[{i}].out"] for i in range(count)])
    cycles, distance = int(number["reversal_lookahead"]), 1e-7 * number["position_delay"]

    def drive(x: np.ndarray, dt: float) -> np.ndarray:
        v = _velocity(x, dt)
        way = _last_way(v)
        weight = np.ones(x.size)
        for turn in [k for k in range(1, x.size) if way[k] != way[k - 1]]:
            for before in range(max(0, turn - cycles), turn):
                weight[before] = min(weight[before], (turn - before) / (cycles + 1.0))
            for after in range(turn, x.size):
                gone = abs(x[after] - x[turn - 1])
                if gone >= distance:
                    break
                weight[after] = gone / distance
        return way * weight * np.interp(np.abs(v), speeds, forces)

    return drive


def of_ax8000(folder: Path, machine: Machine) -> Drive:
    """Slip a spring at the static friction, and add the dynamic factor times the velocity of the motor."""
    values = {row[0]: float(row[1]) for row in _table_rows(_text(folder, ".csv"))[1:]}
    # Of the motor, for 1 m [rad]
    turn = 2.0 * math.pi * machine.ratio / machine.lead if machine.lead else 1.0
    static, dynamic, spring = (values.get(f"0x3144:0{place}", 0.0) for place in (2, 3, 1))

    def drive(x: np.ndarray, dt: float) -> np.ndarray:
        v = turn * _velocity(x, dt)
        torque, bent = np.zeros(x.size), 0.0
        for k in range(1, x.size):
            bent = (
                min(static, max(-static, bent + spring * v[k] * dt))
                if spring
                else (math.copysign(static, v[k]) if v[k] else bent)
            )
            torque[k] = bent + dynamic * v[k]
        return torque * turn

    return drive


def of_c(folder: Path, machine: Machine) -> Drive:
    """Compile the source, and take its command in the unit of the drive."""
    header = _text(folder, ".h")
    unit = float(re.search(r"AXIS_X_POSITION_UNIT \((.*?)\)", header)[1])
    effort = _unit(machine, re.search(r"the command in (.*?)\. \*/", header)[1])
    run = _compiled(
        folder,
        '#include "axis_x.h"\nvoid run(const double *x, int n, double dt, double *out)\n{\n    static axis_x axis;\n'
        "    axis_x_start(&axis);\n    for (int i = 0; i < n; ++i) out[i] = axis_x_command(&axis, x[i], dt);\n}\n",
    ).run

    def drive(x: np.ndarray, dt: float) -> np.ndarray:
        place, out, pointer = (
            np.ascontiguousarray(x / unit),
            np.empty(x.size),
            ctypes.POINTER(ctypes.c_double),
        )
        run(place.ctypes.data_as(pointer), x.size, ctypes.c_double(dt), out.ctypes.data_as(pointer))
        return out * effort

    return drive


def _compiled(folder: Path, text: str) -> ctypes.CDLL:
    """Return the source with a caller as a library, of a name that the process has not loaded before."""
    (folder / "run.c").write_text(text)
    library = folder / f"axis_{np.random.default_rng().integers(1 << 40)}.so"
    command = [
        "gcc",
        "-O2",
        "-std=c99",
        "-ffp-contract=off",
        "-shared",
        "-fPIC",
        "axis_x.c",
        "run.c",
        "-lm",
    ]
    subprocess.run([*command, "-o", str(library)], cwd=folder, check=True)
    return ctypes.CDLL(str(library))


class Law:
    """A control law in C, called once a sample with all that its structure of inputs asks for."""

    def __init__(self, folder: Path, dt: float) -> None:
        header = _text(folder, ".h")
        inputs = re.search(r"typedef struct \{([^}]*)\} axis_x_inputs;", header)[1]
        self.fields = re.findall(r"double (\w+)(?:\[(\d+)\])?;", inputs)
        text = (
            '#include "axis_x.h"\nstatic axis_x axis;\nvoid begin(void)\n{\n    axis_x_start(&axis);\n}\n'
            "double effort(const axis_x_inputs *in) { return axis_x_effort(&axis, in); }\n"
        )
        self._library, self._dt = _compiled(folder, text), dt
        self._library.effort.restype = ctypes.c_double

    def along(self, x: np.ndarray, count: int) -> Callable[[int, float], float]:
        """Return the law for a motion, which goes on for some samples behind `count`."""
        x = np.append(x, np.full(8, x[-1]))
        v = np.gradient(x, self._dt)
        told = {"position": x, "velocity": v, "acceleration": np.gradient(v, self._dt)}
        ahead = {"place_ahead": x, "acceleration_ahead": told["acceleration"]}
        self._library.begin()

        def law(k: int, read: float) -> float:
            values: list[float] = []
            for name, several in self.fields:
                if several:
                    values += ahead[name][k + 1 : k + 1 + int(several)].tolist()
                else:
                    values.append(read if name == "measured" else float(told[name][k]))
            return float(self._library.effort((ctypes.c_double * len(values))(*values)))

        return law


def of_wasm(folder: Path, machine: Machine) -> Drive:
    """Load the module into node."""
    del machine

    def drive(x: np.ndarray, dt: float) -> np.ndarray:
        (folder / "x.json").write_text(json.dumps([float(value) for value in x]))
        (folder / "run.mjs").write_text(
            'import { readFileSync } from "node:fs";\nimport { load } from "./axis_x.mjs";\n'
            'const axis = await load();\nconst x = JSON.parse(readFileSync("x.json"));\n'
            f"console.log(JSON.stringify(x.map((each) => axis.force(each, {dt!r}))));\n"
        )
        ran = subprocess.run(
            ["node", "run.mjs"], cwd=folder, capture_output=True, text=True, check=True
        )
        return np.array(json.loads(ran.stdout))

    return drive


TARGETS: dict[str, tuple[tuple[str, ...], Callable[[Path, Machine], Drive] | None]] = {
    "table": (("found", "--to", "table", "--axis", "axis.toml"), of_table),
    "levels": (("found", "--to", "table", "--points", "3", "--axis", "axis.toml"), of_levels),
    "tf5200": (("found", "--to", "tf5200", "--axis", "axis.toml"), of_tf5200),
    "ax8000": (("found", "--to", "ax8000", "--axis", "axis.toml"), of_ax8000),
    "c": (("found", "--to", "c", "--axis", "axis.toml"), of_c),
    "law": (
        ("--law", "found/experiment.toml", "--variant", "compensated", "--to", "c", "--tunable"),
        None,
    ),
    **(
        {"wasm": (("found", "--to", "wasm", "--axis", "axis.toml"), of_wasm)}
        if shutil.which("node")
        else {}
    ),
}
