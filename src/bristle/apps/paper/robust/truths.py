"""The truths: different kinds of friction for one pipeline, as files.

They have the stiffness at a reversal, the break-away force, the asymmetry and the offset of the rig
(`bristle.apps.paper.rig`) as far as their equations allow, and scatter by 5 % from reversal to reversal.

Conditions are changes of the rig after the identification of its compensator, which does not know them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple

from bristle.apps.paper.rig import SCATTER
from bristle.apps.paper.setting import EXPERIMENTS
from bristle.core import InputError, Model, Origin, content_of, did_you_mean
from bristle.files import read_model
from bristle.models.friction import uneven

FOLDER = Path(str(files("bristle.apps.paper.robust") / "truths"))
SIMULATED: dict[str, Path] = {"thirty_sliders": EXPERIMENTS / "set_a_rig.toml"} | {
    name: FOLDER / f"{name}.toml"
    for name in ("gms", "reformed_dahl", "bouc_wen", "printed", "lugre")
}
OF_FAMILY = {
    "thirty_sliders": ("maxwell_slip", "gms"),
    "gms": ("gms", "maxwell_slip"),
    "reformed_dahl": ("reformed_dahl",),
    "bouc_wen": ("bouc_wen", "dahl"),
    "printed": ("preisach_lugre", "printed"),
    "lugre": ("lugre", "dahl"),
}
"""Families with the structure of a truth, or of its limit in slow motion or at the ends of its ranges."""
AMPLITUDE = 6.8e-6  # [m] of the motion of sets A and C
TRAVEL = 0.15  # of the amplitude, travel over which a change of level decays to 1/e


@dataclass(frozen=True)
class Truth:
    """A friction of the rig."""

    name: str
    friction: Model
    origin: Origin
    families: tuple[str, ...]


def truths_named(names: Sequence[str] = (), *, allow_code: bool = False) -> list[Truth]:
    """Return truths by name or model file; by default all."""
    truths = [_truth(name, allow_code) for name in dict.fromkeys(names or SIMULATED)]
    if len({truth.name for truth in truths}) < len(truths):
        raise InputError(
            "two frictions have the same name",
            path="FRICTION",
            value=", ".join(truth.name for truth in truths),
            mend="Rename one of the files",
        )
    return truths


def _truth(name: str, allow_code: bool) -> Truth:
    file = SIMULATED.get(name, Path(name))
    if not file.is_file() or file.suffix != ".toml":
        allowed = ", ".join([*SIMULATED, "a model file"])
        mend = did_you_mean(name, SIMULATED)
        if file.is_file():
            mend = "bristle identify writes a model file of a log"
        raise InputError(
            "is not a known friction", path="FRICTION", value=name, allowed=allowed, mend=mend
        )
    friction = read_model(file, allow_code=allow_code).friction
    # The thirty elements have their own scatter; a user's model stays unchanged.
    scatter = 0.0
    if name in SIMULATED and "scatter" not in friction.values:
        scatter = SCATTER
    families = OF_FAMILY.get(name, (friction.name.split("+")[0],))
    around = uneven(friction, unevenness=scatter, travel=TRAVEL * AMPLITUDE)
    return Truth(
        name if name in SIMULATED else file.stem, around, content_of(file).origin, families
    )


class Condition(NamedTuple):
    """A description, and the parameters of the layer around a truth."""

    words: str
    changes: dict[str, float]


NOMINAL = "nominal"
CONDITIONS = {
    NOMINAL: Condition("unchanged since the log that identified the compensator", {}),
    "level_0.7": Condition("friction 0.7 times as large", {"level": 0.7}),
    "level_1.3": Condition("friction 1.3 times as large", {"level": 1.3}),
    "level_1.6": Condition("friction 1.6 times as large", {"level": 1.6}),
    "scatter_10": Condition(
        "the level scatters by 10 % from reversal to reversal", {"unevenness": 0.1}
    ),
    "position_wave": Condition(
        "the level varies by 20 % with the position, with a period of 0.75 amplitudes",
        {"wave": 0.2, "wavelength": 0.75 * AMPLITUDE},
    ),
    "creep": Condition(
        "a spring (10 N per amplitude) and a damper in series (5 s) act in parallel to the friction",
        {"k_creep": 10.0 / AMPLITUDE, "tau": 5.0},
    ),
}


def under(condition: str, truth: Truth) -> Model:
    """Return the friction of a truth under a condition."""
    changes = CONDITIONS[condition].changes
    # A model with its own scatter uses that.
    if "scatter" in truth.friction.values and "unevenness" in changes:
        changes = {"scatter": changes["unevenness"]}
    return truth.friction.with_values(**changes)
