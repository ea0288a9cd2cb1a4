"""`export`: a model as files for other languages, tools and drives."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bristle.core import Axis, InputError, Model, Variable
from bristle.core.edge import Amount, among, amount, guarded, model, optional, whole
from bristle.core.experiment import RESTS, Variant
from bristle.engine.checks import PERIOD
from bristle.exports.described import Request, Source
from bristle.exports.effect import Effect
from bristle.exports.moves import moved_by
from bristle.exports.targets import NAME, Product, Target
from bristle.exports.writing import files_for, law_for, load_target_file, name_for, target_named
from bristle.files import log_and_axis, results_folder

STEP = 5e-4  # [s]
POINTS = 20  # of a table


@dataclass(frozen=True)
class Exported:
    """Result of `export`.

    Parameters
    ----------
    folder : Path
        Folder of the files.
    files : tuple of str
        Names of the files.
    notes : tuple of str
        The effect on the axis, and losses and differences of the target, one sentence each.
    effect : Effect or None
        The following error without and with the files, if `axis` has a controller and `plant` an inertia.
    """

    folder: Path
    files: tuple[str, ...]
    notes: tuple[str, ...]
    effect: Effect | None = None


@guarded(
    model=lambda value, path, kind: (
        value if isinstance(value, Variant) else model("friction", "hysteresis")(value, path, kind)
    ),
    step=amount(Variable("time", "time step", min=0.0, max=1e3), exclusive=True),
    points=whole(2, 1000),
    speed=amount(Variable("length/time", "largest speed", min=0.0)),
    mass=optional(amount(Variable("mass", "moving mass or inertia", min=0.0), exclusive=True)),
    plant=optional(model("plant")),
    table=optional(model("friction")),
    rest=optional(among(*RESTS)),
)
def export(
    model: Model | Variant,
    to: str | os.PathLike[str] | Target,
    out: str | os.PathLike[str],
    *,
    name: str = NAME,
    step: Amount = STEP,
    tunable: bool = False,
    float32: bool = False,
    derivatives: bool = False,
    axis: Axis | None = None,
    speed: Amount = 0.0,
    points: int = POINTS,
    mass: Amount | None = None,
    plant: Model | None = None,
    table: Model | None = None,
    source: Source | None = None,
    log: Any = None,
    info: Mapping[str, Any] | None = None,
    rest: str | None = None,
    accept_harm: bool = False,
    force: bool = False,
) -> Exported:
    """Write a model as files for another language, tool or drive, with identical numbers if the target allows it.

    Parameters
    ----------
    model : Model or Variant
        A friction model; for some targets also an operator, or a variant for its control law.
    to : str, Target or path-like
        The target: a name of `bristle.exports.TARGETS`, such as ``"c"`` or ``"table"``; your own `Target`; or the file
        that defines it, such as ``"my_drive.py"``, which bristle executes.
    out : path-like
        The new folder; its parent must exist.
    name : str
        Name of files, types and functions.
    step : float or str
        Time step [s] of the self-test and of the example; internal step of an FMU.
    tunable : bool
        Whether parameters can be changed at run time.
    float32 : bool
        Whether numbers are of single precision. They then differ from those of bristle by rounding.
    derivatives : bool
        Whether the files also compute the derivatives of the force.
    axis : Axis, optional
        The axis, which defines the units of a table; SI without it.
    speed : float or str
        Largest speed of a table [m/s or rad/s].
    points : int
        Maximum number of entries of a table. With 3, a ``"table"`` holds gravity and one level per direction.
    mass : float or str, optional
        Moved mass of the scene [kg or kg*m^2]: by default that of the plant, and 1 without a plant.
    plant : Model, optional
        The plant with the friction. A second FMU then contains both.
    table : Model, optional
        Friction of the table of a `ball_screw`, in N and m, in this second FMU.
    source : Source, optional
        Origin of the values, for the comments.
    log : Log or path-like, optional
        Log whose motion is used to compare a table with the model.
    info : mapping, optional
        The third result of `read_model`, with the log of the identification and its preprocessing.
    rest : {"held", "middle"}, optional
        Force of a memoryless model at rest (`bristle.response`). Default: the rule of the target.
    accept_harm : bool
        Whether to write files that make the simulated following error larger.
    force : bool
        Whether to replace an earlier export in this folder.

    Returns
    -------
    Exported
        Folder, files, and losses of the target.

    Raises
    ------
    InputError
        If the target is unknown or does not support the model, or a kernel of your own is not exportable.

    Examples
    --------
    >>> import bristle as br
    >>> model = br.friction.lugre(F_C="34 mN*m", F_S="40 mN*m", v_S="0.5 rad/s", sigma_0="100 N*m/rad")
    >>> folder = getfixture("tmp_path") / "axis_c"
    >>> br.export(model, "c", folder).files
    ('axis_x.h', 'axis_x.c', 'axis_x_selftest.c', 'CMakeLists.txt', 'example_main.c', 'README.md')
    """
    options = {
        "mass": mass,
        "table": table,
        "points": points != POINTS,
        "step": step != STEP,
        "speed": speed,
    }
    of_model = {
        "plant": plant,
        "axis": axis,
        "log": log,
        "rest": rest,
        "info": info,
        "derivatives": derivatives,
    }
    label = name_for(name)
    origin = source or Source()
    if isinstance(to, os.PathLike) or (isinstance(to, str) and to.endswith(".py")):
        to = load_target_file(to)
    target = target_named(to)
    with results_folder(out, force=force) as folder:
        if isinstance(model, Variant):
            _refuse_given("applies to a model only", options | of_model)
            product = law_for(
                target,
                model,
                label,
                origin,
                tunable=tunable,
                single=float32,
                accept_harm=accept_harm,
            )
        else:
            if axis is not None and axis.kind != model.kind:
                raise InputError(
                    "is of another kind than the model",
                    path="axis.kind",
                    value=axis.kind,
                    allowed=model.kind,
                    mend="Set the kind",
                )
            recorded = None
            if log is not None:
                recorded = log_and_axis(log, axis)[0]
            others = {
                "axis": axis,
                "speed": float(speed),
                "points": points,
                "log": recorded,
                "info": info or {},
                "rest": rest or "",
            }
            _refuse_given(
                f"has no effect on {target.name}", {key: options[key] for key in target.useless}
            )
            others |= {"derivatives": derivatives, "mass": float(mass or moved_by(plant) or 1.0)}
            if table is not None and (plant is None or plant.component.screw is None):
                raise InputError(
                    "applies to a plant with a screw",
                    path="table",
                    value=table.name,
                    mend="Give plant=plants.ball_screw(...)",
                )
            request = Request(
                model,
                label,
                float(step),
                origin,
                tunable,
                float32,
                plant=plant,
                table=table,
                **others,
            )
            product = files_for(target, request, accept_harm=accept_harm)
        for file, content in product.files.items():
            folder.write(file, content)
    return Exported(Path(out), tuple(product.files), product.notes, product.effect)


def _refuse_given(reason: str, options: Mapping[str, Any]) -> None:
    """Refuse options that would have no effect."""
    name = next((name for name, value in options.items() if value), "")
    if name:
        raise InputError(reason, path=name, mend=f"Omit {name}")


def files_from_text(
    target: Target,
    model: Model,
    source: Source,
    *,
    name: str | None = None,
    step: str | float | None = None,
    rest: str | None = None,
    accept_harm: bool = False,
    **options: Any,
) -> Product:
    """Return the files of a model for a target, with options of a `Request`; name, step and rule at rest are unchecked text."""
    label = name_for(name or NAME)
    if step is None:
        step = STEP
    dt = PERIOD(step, "--step", None)
    rule = ""
    if rest is not None:
        rule = among(*RESTS)(rest, "--rest", None)
    return files_for(
        target, Request(model, label, dt, source, rest=rule, **options), accept_harm=accept_harm
    )
