"""Write the experiment file of an identification, and the loop of the log as a table."""

import io
import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np

from bristle.core import Axis, Content, InputError, Model
from bristle.core.experiment import (
    FEEDFORWARD as FEEDFORWARD_FIELDS,
    LOOP_VARIANTS,
    OF_A_SAMPLE,
    START,
    Variant,
)
from bristle.core.variable import KINDS, Kind, unit_of
from bristle.files.components import FILL_IN
from bristle.files.toml import quoted
from bristle.logs.log import Log
from bristle.models.controllers.feedforward import WHOLE, Rule, feedforward_of

COLUMNS = 3
INJECTED = ",injected"


class LoopRecord(NamedTuple):
    """By sample: the desired motion of a log [m or rad], the unexplained force and the known inputs [N or N*m]."""

    kind: Kind
    sample_time: float
    reference: np.ndarray
    unexplained: np.ndarray
    injected: np.ndarray | None = None

    @property
    def text(self) -> str:
        """The table as text."""
        columns, header = (
            [self.sample_time * np.arange(self.reference.size), self.reference, self.unexplained],
            _header(self.kind),
        )
        if self.injected is not None:
            columns, header = (
                [*columns, self.injected],
                f"{header}{INJECTED} [{unit_of('force', self.kind)}]",
            )
        row = ",".join(["%.12g"] * len(columns)) + "\n"
        # One format for all rows takes a third of the time of one for each row.
        return f"{header}\n{row * self.reference.size % tuple(np.column_stack(columns).ravel().tolist())}"


def read_loop(content: Content) -> LoopRecord:
    """Return the table in a file."""
    kind, name = kind_of_loop(content), content.source.name
    if kind is None:
        raise InputError(
            "is not a table of the loop of a log",
            path=name,
            allowed=f"columns: {_header('translational')}",
            mend="Give the file loop.csv that bristle identify wrote",
        )
    try:
        rows = np.loadtxt(io.BytesIO(content.data), delimiter=",", skiprows=1, ndmin=2)
    except ValueError as error:
        raise InputError(f"cannot be read ({str(error).rstrip('.')})", path=name) from None
    columns = COLUMNS + (INJECTED.encode() in content.data.partition(b"\n")[0])
    if rows.shape[0] < COLUMNS or rows.shape[1] != columns or not np.all(np.isfinite(rows)):
        raise InputError("needs a finite number in each column and at least three rows", path=name)
    steps = np.diff(rows[:, 0])
    dt = float(np.mean(steps))
    if not dt > 0.0 or np.max(np.abs(steps - dt)) > OF_A_SAMPLE * dt + 1e-11 * abs(rows[-1, 0]):
        raise InputError("has unevenly spaced samples", path=name)
    return LoopRecord(
        kind, dt, rows[:, 1], rows[:, 2], rows[:, COLUMNS] if columns > COLUMNS else None
    )


def kind_of_loop(content: Content) -> Kind | None:
    """Return the kind of axis of such a table; None for any other file."""
    return next((kind for kind in KINDS if content.data.startswith(_header(kind).encode())), None)


def _header(kind: Kind) -> str:
    return f"time [s],reference [{unit_of('length', kind)}],unexplained [{unit_of('force', kind)}]"


LOOP = "loop.csv"  # file with the signals of the loop of a log, beside its experiment file
AS_RECORDED, FEEDFORWARD, COMPENSATED = LOOP_VARIANTS
# Default gains for an unknown controller: their bandwidth is limited by the sampling and by the dynamics of most axes.
# [rad/s], of 1/sample time, of the velocity loop
FASTEST, OF_SAMPLING, FOR_POSITION = (2.0 * math.pi * 20.0, 0.1, 0.25)
HEAD = """\
# The identified axis in its loop: as recorded, with feedforward of inertia and gravity, and with friction too.
# Simulate it: bristle run {name}; its margins: bristle design {name}
"""


@dataclass(frozen=True)
class NextExperiment:
    """An experiment file, and the keys to fill in before it runs."""

    text: str
    missing: tuple[str, ...]
    loop: LoopRecord | None = None
    """Signals for ``loop.csv`` if the file names it."""

    @classmethod
    def beside_model(
        cls,
        plant: Model,
        axis: Axis,
        log: Log,
        folder: Path,
        *,
        has_axis_file: bool,
        loop: Variant | None = None,
        rule: Rule = WHOLE,
    ) -> Self:
        """Return the experiment file for the model file of an axis, in the same folder, with the share of a rule."""
        share = "".join(
            f", {name} = {_entry_text(name, value, plant.kind)}"
            for name, value in feedforward_of(rule).items()
        )
        has_law, gains = (
            axis.controller is not None,
            {} if axis.controller is None else axis.controller.values,
        )
        title = f"schema = 1\nname = {quoted((axis.name or 'the axis') + ', without and with compensation')}\n"
        # Without an axis file the kind comes before all tables. Variants: as recorded, with inertia fed forward, and with friction.
        mass = (
            ""
            if "J" in gains
            else f'mass = "{plant.values["M"]:.12g} {unit_of("mass", plant.kind)}", '
        )
        follows, fed = (
            "k_ff = 1.0\n" if not has_law or "k_ff" in gains else "",
            f'{mass}plant = "own"',
        )
        parts = [
            HEAD.format(name="experiment.toml"),
            title if has_axis_file else f'{title}kind = "{plant.kind}"\n',
            '[axis]\nfile = "axis.toml"\n' if has_axis_file else "",
            '[friction]\nfile = "model.toml"           # with the plant\n',
            "" if has_law else _open_loop(plant, log),
            *(_motion(log, folder) if loop is None else _motion_of(loop)),
            f"[compare.{AS_RECORDED}]\n",
            f"[compare.{FEEDFORWARD}.controller]\n{follows}feedforward = {{ {fed} }}\n",
            f'[compare.{COMPENSATED}.controller]\n{follows}feedforward = {{ {fed}, friction = {{ file = "model.toml" }}{share} }}\n',
        ]
        record = None
        if loop is not None:
            position = np.asarray(loop.reference.values["position"])
            left = np.zeros(position.size) if loop.disturbance is None else loop.disturbance
            record = LoopRecord(
                loop.plant.kind, loop.run.sample_time, position, left, loop.injected
            )
        missing = () if has_law else ("controller.k_p", "controller.k_v")
        return cls("\n".join(part for part in parts if part), missing, record)


def _entry_text(name: str, value: float | str, kind: Kind) -> str:
    """Return an entry of a feedforward as text of TOML."""
    if isinstance(value, str):
        return quoted(value)
    unit = FEEDFORWARD_FIELDS[name].unit(kind)
    return f"{value:.6g}" if unit == "1" else f'"{value:.6g} {unit}"'


def _motion_of(loop: Variant) -> tuple[str, ...]:
    """Return the tables of the reference, the disturbances and the start of the loop, as identified."""
    kind, run, start = loop.plant.kind, loop.run, loop.start
    reference = (
        '[reference]\nmodel = "recorded"            '
        f'# the reference of the log, its longest stretch without a gap\nfile = "{LOOP}"\n'
    )
    unexplained = f'[disturbance]                 # replayed force that the model does not explain\nfile = "{LOOP}"\n'
    if loop.injected is not None:
        before = (
            "[injected]                    # known input of the log, before the limit of the drive"
        )
        unexplained += f'\n{before}\nfile = "{LOOP}"\n'
    lag = (
        f"delay = {run.delay}                     # samples from a measurement to its effort\n"
        if run.delay
        else ""
    )
    lag += f'current_lag = "{run.current_lag:.9g} s"\n' if run.current_lag else ""
    judged = f'[run]\nsettle = "{run.settle:.9g} s"           # excluded from the statistics, at the start\n{lag}'
    if start is None:
        return reference, unexplained, judged
    values = {
        "position": start.position,
        "velocity": start.velocity,
        "acceleration": start.acceleration,
    }
    lines = [
        f'{name} = "{value:.12g} {START[name].unit(kind)}"\n' for name, value in values.items()
    ]
    lines += (
        []
        if start.effort is None
        else [f'effort = "{start.effort:.12g} {unit_of("force", kind)}"\n']
    )
    begun = f"[start]                       # motion and effort at the start of the log\n{''.join(lines)}"
    return reference, unexplained, begun, judged


def _open_loop(plant: Model, log: Log) -> str:
    """Return the controller of an axis with unknown gains, with suggested gains that suit its inertia and sampling."""
    fast = min(FASTEST, OF_SAMPLING / log.sample_time)
    k_p, k_v = FOR_POSITION * fast, plant.values["M"] * fast
    unit = unit_of("force*time/length", plant.kind)
    return (
        "# The axis file has no [controller]. Write the gains here; or write them there and remove this table.\n"
        '[controller]\nmodel = "cascade"\n'
        f'k_p = "{FILL_IN}"                     # gain of the position loop, such as "{k_p:.3g} 1/s"\n'
        f'k_v = "{FILL_IN}"                     # gain of the velocity loop, such as "{k_v:.3g} {unit}"\n'
        '# T_n = "10 ms"                # integral time of the velocity loop, if the drive has it\n'
        "# k_ff = 1.0                   # share of the reference velocity that the drive feeds forward\n"
    )


def _motion(log: Log, folder: Path) -> tuple[str, str]:
    """Return the tables of the reference and the run: the reference of the log, or a sine like its motion."""
    try:
        file = (
            Path(os.path.relpath(log.source.resolve(), folder.resolve())).as_posix()
            if log.source.is_file()
            else ""
        )
    except (OSError, ValueError):  # on Windows, another drive
        file = ""
    if file and log.reference is not None and len(log.segments) == 1:
        # Of the duration, and in seconds.
        settle = min(0.05 * log.sample_time * log.reference.values.size, 0.5)
        head = '[reference]\nmodel = "recorded"            # the reference of the log\n'
        judged = f'[run]\nsettle = "{settle:.3g} s"           # excluded from the statistics, at the start\n'
        return f"{head}file = {quoted(file)}\n", judged
    position, unit = log.position.values, unit_of("length", log.kind)
    low, high = float(position.min()), float(position.max())
    speed = float(np.quantile(np.abs(np.gradient(position, log.sample_time)), 0.95))
    amplitude = 0.5 * (high - low)
    # Of the range: slower is no motion.
    frequency = max(speed, 1e-9 * amplitude) / (2.0 * math.pi * amplitude)
    reference = (
        "# A sine with the range and speed of the log: replace it by the motion of the machine.\n"
        f'[reference]\nmodel = "sine"\namplitude = "{amplitude:.4g} {unit}"\n'
        f'offset = "{0.5 * (low + high):.4g} {unit}"\n'
        f'frequency = "{frequency:.3g} Hz"\n'
    )
    duration, settle = 4 / frequency, 1.0 / frequency
    run = f'[run]\nduration = "{duration:.4g} s"\nsample_time = "{log.sample_time:.9g} s"\nsettle = "{settle:.3g} s"\n'
    return reference, run
