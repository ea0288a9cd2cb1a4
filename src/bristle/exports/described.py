"""The request for an export, and descriptions of its model in files: parameters, source, licence, and a hash of the model."""

from __future__ import annotations

import hashlib
import json
import math
import re
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from functools import cache
from importlib import resources
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.core import Axis, Model, Variant
from bristle.core.typography import typed
from bristle.core.variable import Kind, Variable, unit_of
from bristle.engine.translation.scope import NotExportableError, ascii_name
from bristle.engine.translation.tree import Array, Function, Node, Scalar, Struct, Unit
from bristle.exports.printing import loops_of
from bristle.exports.subject import Subject, subject_of
from bristle.exports.tunable import TOLERANCE
from bristle.logs.log import Log
from bristle.models.controllers.feedforward import WHOLE, Rule
from bristle.models.friction.resting import rest_rule, with_rest

if TYPE_CHECKING:
    import jinja2

    from bristle.prediction.drive_units import CommandUnits


@dataclass(frozen=True)
class Source:
    """Origin of the values of a model."""

    provenance: Mapping[str, str] = field(default_factory=dict)
    uncertainty: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    model_hash: str = ""

    @property
    def lines(self) -> list[str]:
        """Remarks and provenance, one line each."""
        facts = [f"{key}: {plain(str(value))}" for key, value in self.provenance.items()]
        return [*(plain(remark) for remark in self.remarks), *facts]


@dataclass(frozen=True)
class Request:
    """A request for an export: the model and the options.

    Parameters
    ----------
    model : Model
        A friction model with parameters.
    name : str
        Name of files, types and functions.
    dt : float
        Time step [s].
    source : Source
        Origin of the values.
    tunable : bool
        Whether parameters can be changed at run time.
    single : bool
        Whether numbers are of single precision.
    derivatives : bool
        Whether the files also compute derivatives.
    axis : Axis or None
        The axis; its columns define the units of a table.
    speed : float
        Largest speed of a table [m/s or rad/s].
    points : int
        Maximum number of entries of a table. With 3, a ``table`` holds gravity and one level per direction.
    mass : float
        Moved mass of a scene [kg or kg*m^2].
    plant : Model or None
        The plant with the friction, if known.
    log : Log or None
        Log whose motion is used to compare a table with the model.
    info : mapping
        Further contents of the model file: ``provenance``, the log of the fit, and ``treatment``, its preprocessing.
    rest : {"held", "middle", ""}
        Force of a memoryless model at rest: the force of the last direction, or the mean of both directions. Empty
        for the rule of the target.
    loop : Variant or None
        The loop of the axis along the motion of its log. The effect of the files is simulated in this loop.
    mode : {"torque", "velocity"}
        The quantity that the amplifier of the axis follows.
    table : Model or None
        Friction of the table of a plant with a screw, in N and m.
    rule : Rule or None
        Share of the friction that a compensator feeds forward; None for all of it.
    undivided : Model or None
        The friction of the axis, if `model` contains a share of it.
    """

    model: Model
    name: str
    dt: float
    source: Source = field(default_factory=Source)
    tunable: bool = False
    single: bool = False
    axis: Axis | None = None
    speed: float = 0.0
    points: int = 20
    mass: float = 1.0
    plant: Model | None = None
    log: Log | None = None
    info: Mapping[str, Any] = field(default_factory=dict)
    rest: str = ""
    loop: Variant | None = None
    mode: str = "torque"
    table: Model | None = None
    derivatives: bool = False
    rule: Rule | None = None
    undivided: Model | None = None

    @property
    def draws(self) -> Mapping[str, np.ndarray]:
        """Draws of the parameters of the friction; empty if its uncertainty is unknown."""
        return (self.info.get("bands") or {}).get("draws", {})

    @property
    def share(self) -> Rule:
        """The share of the friction that a compensator feeds forward."""
        return self.rule or WHOLE

    @property
    def treatment(self) -> Mapping[str, Any]:
        """The preprocessing of the log of the identification; empty for a model that is not from a log."""
        return self.info.get("treatment", {})

    @property
    def friction(self) -> Model:
        """The friction of the axis."""
        return self.undivided or self.model

    @property
    def is_from_log(self) -> bool:
        """Whether the model was identified from a log."""
        return bool(self.treatment)

    @property
    def sampled(self) -> Model:
        """The model as evaluated along samples: a memoryless model gets a rule at rest."""
        if self.rest:
            return with_rest(self.model, self.rest)
        return self.model


def meaning_of(variable: Variable, kind: Kind) -> str:
    """Return the meaning of a variable with its unit, for a comment."""
    unit = variable.unit(kind)
    meaning = plain(variable.description)
    if unit != "1":
        meaning += f" [{plain(unit)}]"
    return meaning


def meaning_within(variable: Variable, kind: Kind) -> str:
    """Return the meaning of a variable with its unit and, if it has one, its allowed range."""
    return ", ".join(filter(None, (meaning_of(variable, kind), plain(variable.allowed(kind)))))


def parameter_table(model: Model, source: Source) -> str:
    """Return value, unit, allowed range, 95 % interval and meaning of each parameter as a table of plain text."""
    rows = [("", "value", "unit", "allowed", "95 % interval", "")]
    for name, variable in model.component.variables.items():
        value = model.values[name]
        low = variable.min
        high = variable.max
        facts = source.uncertainty.get(name, {})
        cell = ""
        if isinstance(value, float):
            cell = f"{value:.9g}"
        elif isinstance(value, str):
            cell = value
        elif isinstance(value, np.ndarray):
            cell = ", ".join(f"{number:.9g}" for number in value[:8])
            if value.size > 8:
                cell += f", ... ({value.size} in all)"
        if variable.choices:
            allowed = "fixed"
        elif math.isfinite(low) and math.isfinite(high):
            allowed = f"{low:g} to {high:g}"
        elif math.isfinite(low):
            allowed = f">= {low:g}"
        elif math.isfinite(high):
            allowed = f"<= {high:g}"
        else:
            allowed = ""
        unit = variable.unit(model.kind)
        if unit == "1":
            unit = ""
        interval = facts.get("interval")
        if interval:
            sure = f"{interval[0]:.6g} to {interval[1]:.6g}"
        else:
            sure = facts.get("status", "")
        rows.append(
            (
                ascii_name(name),
                cell or typed(value),
                unit,
                allowed,
                plain(sure),
                plain(variable.description),
            )
        )
    if not any(row[4] for row in rows[1:]):
        rows = [(*row[:4], *row[5:]) for row in rows]  # type: ignore[misc]
    widths = [max(len(row[place]) for row in rows) for place in range(len(rows[0]) - 1)]
    lines = [
        "   "
        + "  ".join(
            f"{cell:<{width}}" for cell, width in zip(row, [*widths, 0], strict=True)
        ).rstrip()
        for row in rows
    ]
    return "\n".join(lines)


def model_facts(
    subject: Subject, name: str, source: Source, dt: float, *, single: bool, tunable: bool
) -> dict[str, Any]:
    """Return the facts of a friction model or an operator for the templates of all languages."""
    model = subject.model
    operator = subject.is_operator
    component = subject.model.component
    entering = "length"
    leaving = "force"
    title = "Friction of an axis"
    if operator:
        entering = component.input
        leaving = component.output
        title = "Hysteresis operator"
    return (
        {
            "name": name,
            "model": model.name,
            "version": version(),
            "title": plain(f"{title}: {model.name}"),
        }
        | {
            "description": f"{plain(component.description)}.",
            "operator": operator,
            "rest": rest_rule(model),
            "facts": source.lines,
        }
        | {
            "table": parameter_table(model, source).rstrip(),
            "loops": loops_of(subject.unit, subject.memory_size),
        }
        | {
            "unit_x": unit_of(entering, model.kind),
            "unit_force": unit_of(leaving, model.kind),
            "dt": repr(dt),
            "rate": f"{1.0 / dt:g}",
        }
        | {
            "single": single,
            "tunable": tunable,
            "allowed": f"{TOLERANCE:g}",
            "several_places": False,
        }
    )


def command_facts(units: CommandUnits | None, kind: Kind) -> dict[str, Any] | None:
    """Return facts on the units of a drive; None if they are unknown."""
    if units is None:
        return None
    efforts = []
    for unit in (units.effort, *units.others):
        # The unit as a name in C: ``% of rated`` becomes ``PERCENT_OF_RATED``.
        words = re.findall(
            r"[A-Za-z0-9]+",
            plain(unit.name.replace("%", "percent").replace("*", "").replace("/", " per ")),
        )
        efforts.append(
            {"unit": plain(unit.name), "si": repr(unit.si), "macro": "_".join(words).upper()}
        )
    position = {"unit": plain(units.position.name), "si": repr(units.position.si)}
    force, length = (plain(unit_of(quantity, kind)) for quantity in ("force", "length"))
    return {"position": position, "efforts": efforts, "unit_force": force, "unit_x": length}


def plain(text: str) -> str:
    """Return text in ASCII that cannot end a comment."""
    for mark, instead in (
        ("µ", "u"),
        ("·", "*"),
        ("–", "-"),
        ("−", "-"),
        ("²", "^2"),
        ("*/", "* /"),
        ("/*", "/ *"),
    ):
        text = text.replace(mark, instead)
    return " ".join(text.encode("ascii", "replace").decode().split())


def rendered(template: str, facts: dict[str, Any]) -> str:
    """Return the text of a template, filled with facts."""
    return _environment().get_template(template).render(facts)


def version() -> str:
    """Return the version of bristle."""
    from bristle import __version__

    return __version__


PACKAGES = ("bristle.exports", "bristle.apps.targets")  # with templates
FOLD = 120  # characters of a line of a comment


@cache
def _environment() -> jinja2.Environment:
    import jinja2

    loader = jinja2.ChoiceLoader([jinja2.PackageLoader(package) for package in PACKAGES])
    environment = jinja2.Environment(
        loader=loader,
        autoescape=False,
        undefined=jinja2.StrictUndefined,
        keep_trailing_newline=True,
    )
    environment.filters["folded"] = folded
    environment.globals["instructions"] = json.loads(text_of("shared/instructions.json"))
    return environment


def folded(text: str, margin: str) -> str:
    """Return a text of a comment in lines of at most `FOLD` characters, with a margin before all but the first."""
    return f"\n{margin}".join(
        textwrap.wrap(text, FOLD, break_long_words=False, break_on_hyphens=False)
    )


LICENCE = "BSD-3-Clause"  # Of the text that bristle writes, as an SPDX identifier
COMMENTS = {".st": ("(* ", " *)")} | dict.fromkeys((".txt", ".hal", ".py", ".yaml"), ("# ", ""))
COMMENTS |= dict.fromkeys((".mjs", ".comp"), ("// ", ""))
COMMENTS |= dict.fromkeys((".c", ".h", ".cu", ".cpp"), ("/* ", " */")) | dict.fromkeys(
    (".xml", ".md"), ("<!-- ", " -->")
)
DIGITS = 12  # of a hash in a version


def hash_of_model(model: Model) -> str:
    """Return the SHA-256 of a friction model or an operator; empty if its kernels cannot become a tree."""
    try:
        subject = subject_of(model)
    except NotExportableError:
        return ""
    start = [subject.virgin, float(subject.memory_size)]
    return digest_over(model.name, model.kind, subject.unit.functions, start, model.parameters)


def hash_on_plant(friction: str, plant: Model, unit: Unit) -> str:
    """Return the SHA-256 of a plant with its friction, from the hash of the friction and the functions of both."""
    return digest_over(friction, plant.name, plant.kind, unit.functions, plant.parameters)


def model_version(source: Source) -> str:
    """Return the version of an exported model: the version of bristle and the first digits of the hash."""
    if source.model_hash:
        return f"{version()}+{source.model_hash[:DIGITS]}"
    return version()


@cache
def text_of(path: str, package: str = PACKAGES[0]) -> str:
    """Return a file that lies among the templates, such as the licence of the text that bristle writes."""
    return (resources.files(package) / "templates" / path).read_text(encoding="utf-8")


def copyright_line() -> str:
    """Return the copyright line of the text that bristle writes."""
    return next(
        line for line in text_of("shared/LICENSE.txt").splitlines() if line.startswith("Copyright")
    )


def with_rights(files: Mapping[str, str], source: Source) -> dict[str, str]:
    """Return texts by file name, each with a head of licence and hash of the model."""
    lines = [
        f"SPDX-License-Identifier: {LICENCE}",
        f"{copyright_line()}: the text that bristle {version()} wrote.",
        "The model and its numbers are yours.",
    ]
    if source.model_hash:
        lines.append(f"Hash of the model: sha256 {source.model_hash}")
    headed = {}
    for name, text in files.items():
        opening, closing = COMMENTS[PurePosixPath(name).suffix]
        head = [f"{opening}{line}{closing}" for line in lines]
        if text.startswith("<?xml"):
            first, _, rest = text.partition("\n")
            headed[name] = "\n".join([first, *head, rest])
        else:
            headed[name] = "\n".join([*head, text])
    return headed


def digest_over(*parts: Any) -> str:
    """Return the SHA-256 of names, numbers and functions."""
    digest = hashlib.sha256()
    for word in _words(parts):
        digest.update(word.encode() + b"\0")
    return digest.hexdigest()


def _words(part: Any) -> Iterator[str]:
    """Yield words that identify a part of a model: different models have different words."""
    if isinstance(part, Function):
        yield from _words([part.name, part.parameters, part.result, part.body])
    elif isinstance(part, Node):
        yield type(part).__name__
        for field in fields(part):
            value = getattr(part, field.name)
            if isinstance(value, Function):
                value = value.name
            yield from _words(value)
    elif isinstance(part, Struct):
        yield from _words([part.cls.__name__, part.fields])
    elif isinstance(part, (Array, Scalar, str)):
        yield repr(part)
    elif isinstance(part, np.ndarray):
        yield from _words(part.tolist())
    elif isinstance(part, Iterable):
        yield "("
        for inner in part:
            yield from _words(inner)
        yield ")"
    elif isinstance(part, float):
        yield part.hex()
    else:
        yield repr(part)
