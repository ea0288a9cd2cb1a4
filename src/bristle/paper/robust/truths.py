"""The truths: frictions of different kinds that one pipeline is tried on, as files, and measured ones.

The simulated ones have the stiffness at a reversal, the break-away force, the asymmetry and the offset of the rig
(`bristle.paper.rig`) as far as their equations know them, and scatter by 5 % from reversal to reversal.

Conditions are what changes on the rig after its compensator was identified, which nobody tells it.
"""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

from bristle.core.axis import Axis
from bristle.core.content import Origin, content_of
from bristle.core.contracts import Model
from bristle.core.errors import InputError, did_you_mean
from bristle.files.arguments import read_log
from bristle.files.axis import read_axis
from bristle.files.model import read_model
from bristle.logs.assembly import within
from bristle.logs.log import Log
from bristle.paper.rig import SCATTER, STATIC, screw_ratio
from bristle.paper.robust.recorded import half_cycles_of, recorded_contact
from bristle.paper.robust.uneven import uneven
from bristle.paper.setting import EXPERIMENTS

FOLDER = Path(str(files("bristle.paper.robust") / "truths"))
SIMULATED: dict[str, Path] = {"thirty_sliders": EXPERIMENTS / "set_a_rig.toml"} | {
    name: FOLDER / f"{name}.toml" for name in ("gms", "reformed_dahl", "bouc_wen", "printed", "lugre")
}
MEASURED = "measured"
DATA = "BRISTLE_DATA"
RECORD = Path("tribometer") / "test_data_2.txt"
OF_FAMILY = {
    "thirty_sliders": ("maxwell_slip", "gms"),
    "gms": ("gms", "maxwell_slip"),
    "reformed_dahl": ("reformed_dahl",),
    "bouc_wen": ("bouc_wen", "dahl"),
    "printed": ("preisach_lugre", "printed"),
    "lugre": ("lugre", "dahl"),
}
"""Families that have the structure of a truth, or are what it becomes in slow motion or at the ends of its ranges."""
AMPLITUDE = 6.8e-6  # [m] of the motion of sets A and C
TRAVEL = 0.15  # of the amplitude, after which 1/e of a change of level is left
WITHIN_STROKE = 0.95  # share of a recorded stroke that the rig goes through


@dataclass(frozen=True)
class Truth:
    """A friction that the rig has."""

    name: str
    friction: Model
    origin: Origin
    families: tuple[str, ...] = ()
    amplitude: float = AMPLITUDE
    is_varied: bool = True
    record: Log | None = field(default=None, compare=False)
    axis: Axis | None = field(default=None, compare=False)


def truths_named(names: Sequence[str] = (), axis: Path | None = None, *, allow_code: bool = False) -> list[Truth]:
    """Return truths by their names, or by the files that hold them; all that there are where none is named."""
    present = [*SIMULATED, *([MEASURED] if _data() else [])]
    truths = [_truth(name, axis, present, allow_code) for name in dict.fromkeys(names or present)]
    if axis is not None and not any(truth.record is not None and truth.name != MEASURED for truth in truths):
        raise InputError("is there for a log, and none is among the truths", path="--axis", value=str(axis))
    if len({truth.name for truth in truths}) < len(truths):
        raise InputError(
            "two truths have one name", path="TRUTH", value=", ".join(truth.name for truth in truths), mend="Rename one of the files"
        )
    return truths


def _data() -> Path | None:
    """Return the record that the environment names; None where it names none."""
    file = Path(os.environ[DATA]) / RECORD if os.environ.get(DATA) else None
    return file if file is not None and file.is_file() else None


def _truth(name: str, axis: Path | None, present: Sequence[str], allow_code: bool) -> Truth:
    file = _data() if name == MEASURED else SIMULATED.get(name)
    if name == MEASURED:
        if file is None:
            raise InputError(
                f"needs the record {RECORD.as_posix()} in the folder that {DATA} names",
                path="TRUTH",
                value=name,
                mend="Name a log instead: --robust log.csv --axis axis.toml",
            )
        return _recorded(name, file, read_axis(FOLDER / "measured_axis.toml"))
    if file is not None:
        friction = read_model(file).friction
        scatter = 0.0 if "scatter" in friction.values else SCATTER  # the thirty elements have their own
        return Truth(name, uneven(friction, unevenness=scatter, travel=TRAVEL * AMPLITUDE), content_of(file).origin, OF_FAMILY[name])
    path = Path(name)
    if not path.is_file():
        raise InputError(
            "no such truth",
            path="TRUTH",
            value=name,
            allowed=", ".join([*present, "a model file", "a log"]),
            mend=did_you_mean(name, present),
        )
    if path.suffix == ".toml":
        friction = read_model(path, allow_code=allow_code).friction
        around = uneven(friction, unevenness=0.0, travel=TRAVEL * AMPLITUDE)
        return Truth(path.stem, around, content_of(path).origin, (friction.name.split("+")[0],))
    if axis is None:
        raise InputError("is a log, and nothing says what its columns are", path="TRUTH", value=name, mend="Add --axis axis.toml")
    return _recorded(path.stem, path, read_axis(axis))


def _recorded(name: str, file: Path, axis: Axis) -> Truth:
    """Return a contact of the second half of a record, as strong as the friction of the rig, and the first half."""
    log = read_log(file, axis)
    middle = 0.5 * float(log.time.values[0] + log.time.values[-1])
    first, second = within(log, (float(log.time.values[0]), middle)), within(log, (middle, float("inf")))
    record = half_cycles_of(second)
    assert first.effort is not None
    factor = STATIC * screw_ratio(5e-3) / record.height
    amplitude = WITHIN_STROKE * float(record.x[-1])
    friction = uneven(recorded_contact(record, factor), unevenness=0.0, travel=TRAVEL * amplitude)
    heard = replace(first, effort=replace(first.effort, values=factor * first.effort.values))
    return Truth(name, friction, content_of(file).origin, amplitude=amplitude, is_varied=False, record=heard, axis=axis)


NOMINAL = "nominal"


CONDITIONS: dict[str, Callable[[Truth], dict[str, Any]]] = {
    NOMINAL: lambda truth: {},
    "level_0.7": lambda truth: {"level": 0.7},
    "level_1.3": lambda truth: {"level": 1.3},
    "level_1.6": lambda truth: {"level": 1.6},
    "scatter_10": lambda truth: {"scatter" if "scatter" in truth.friction.values else "unevenness": 0.1},
    "position_wave": lambda truth: {"wave": 0.2, "wavelength": 0.75 * truth.amplitude},
    "creep": lambda truth: {"k_creep": 10.0 / truth.amplitude, "tau": 5.0},
}
"""Parameters of the layer around a truth, by condition; `MEANINGS` says them in words."""
MEANINGS = {
    NOMINAL: "as when the log for the compensator was made",
    "level_0.7": "friction 0.7 times as large",
    "level_1.3": "friction 1.3 times as large",
    "level_1.6": "friction 1.6 times as large",
    "scatter_10": "the level scatters by 10 % from reversal to reversal",
    "position_wave": "the level waves by 20 % over three quarters of the amplitude",
    "creep": "beside it a spring and a damper in series, 10 N over the amplitude, 5 s",
}


def under(condition: str, truth: Truth) -> Model:
    """Return the friction of a truth under a condition."""
    changes = CONDITIONS[condition](truth)
    return truth.friction.with_values(**changes) if changes else truth.friction
