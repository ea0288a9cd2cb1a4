"""Write the pages under docs/reference that derive from the code: ``python docs/generate.py``.

A test compares the pages with the texts of this file.
"""

from __future__ import annotations

import ast
import dataclasses
import importlib
import inspect
import json
import math
import re
import sys
import tomllib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from runpy import run_path
from typing import Any

import typer

import bristle
from bristle.cli.application import application
from bristle.cli.options import Listing
from bristle.core.contracts import Component
from bristle.core.documented import Documented
from bristle.core.formula import REFERENCE, as_markdown
from bristle.core.slot import Slot
from bristle.core.variable import KINDS, unit_of
from bristle.exports.described import text_of
from bristle.files.components import key_of
from bristle.models.friction import CHANNEL_SLOTS
from bristle.models.friction.slots import OFFSET, PARAMETERS_OF_SLOTS, WHAT_SLOTS_DO

FOLDER = Path(__file__).parent / "reference"
PACKAGE = Path(bristle.__file__).parent
NOTE = "<!-- Written by docs/generate.py: change the code, then run it again. -->"


def main() -> None:
    """Write every page."""
    for name, page in PAGES.items():
        (FOLDER / name).write_text(page(), encoding="utf-8")


def families() -> dict[str, Mapping[str, Component]]:
    """Return every component, by family and name."""
    from bristle import controllers, friction, hysteresis, plants, references, sensors

    return {
        "Friction": friction.MODELS,
        "Hysteresis operators": hysteresis.OPERATORS,
        "Plants": plants.PLANTS,
        "Controllers": controllers.CONTROLLERS,
        "Sensors": sensors.SENSORS,
        "References": references.REFERENCES,
    }


def table(heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a table in Markdown."""
    lines = [list(heads)]
    lines += [["---"] * len(lines[0]), *(list(row) for row in rows)]
    return "\n".join(
        "| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines
    )


def page(title: str, *parts: str) -> str:
    """Return a page in Markdown."""
    return "\n\n".join((f"# {title}", NOTE, *(part for part in parts if part))) + "\n"


# --- models -----------------------------------------------------------------------------------------------------


def models() -> str:
    """Return the page of all models: the texts of `bristle models`."""
    parts = [
        "`bristle models NAME` and, in Python, `help(bristle.models.friction.lugre)` print these texts. Every "
        "friction model also takes an `offset`, and [slots](#slots) "
        "after its name. With `+asymmetry` the parameters marked *by direction* have one value forward (`_pos`) and "
        "one backward (`_neg`). The other slots let friction [vary](../theory/models.md#what-varies). Plants take "
        "[terms](../theory/models.md#terms-of-the-plant): `+gravity`, `+cogging`, `+known`. To choose a model: "
        "[how to choose](../how-to/choose-a-model.md)."
    ]
    for family, members in families().items():
        parts.append(f"## {family}")
        parts.append(
            table(
                ("Name", "Description"),
                [(f"[`{one.name}`](#{one.name})", one.description) for one in members.values()],
            )
        )
        parts += [part for one in members.values() for part in _member(one)]
    return page("Models and their parameters", *parts, *slots(), *cost())


def cost() -> tuple[str, ...]:
    """Return the instructions of a step of each friction model in C."""
    double, single = json.loads(text_of("shared/instructions.json")).values()
    rows = [
        (f"`{name}`", *(str(number) for number in (*double[name], *single[name])))
        for name in double
    ]
    said = (
        "Instructions of a step in C, in the median and at most, counted under QEMU (gcc 12, `-O2`). The motion consists of hard cases: "
        "steps from a thousandth of break-away to thousands of it, more reversals than a memory has room for, and long steps that leave "
        "all of them. No step takes more than ten times the median. Count again with `python -m tests.exports.instructions`."
    )
    return (
        "## Cost of a step",
        said,
        table(("Model", "Cortex-M7, double", "worst", "Cortex-M4F, `--float32`", "worst"), rows),
    )


def slots() -> tuple[str, ...]:
    """Return the slots of friction models."""
    rows = [
        (
            f"[`+{name}`](#{name})" if name in CHANNEL_SLOTS else f"`+{name}`",
            ", ".join(f"`{one}`" for one in PARAMETERS_OF_SLOTS[name]),
            what,
        )
        for name, what in WHAT_SLOTS_DO.items()
    ]
    own = "Add [a slot of your own](../how-to/your-own-model.md#a-slot-of-your-own) by its file, `+my_slot.py`."
    described = [
        part for slot in CHANNEL_SLOTS.values() for part in (*_member(slot), _channel(slot))
    ]
    return "## Slots", table(("Name", "Parameters", "Effect"), rows), own, *described


def _channel(slot: Slot) -> str:
    channel = slot.channel
    return (
        f"The slot uses the channel `{channel.name}` of the log: {channel.variable.description}, in "
        f"{_units(channel.variable.quantity)}. Without this channel the slot uses the value {channel.usual:g}."
    )


def _member(one: Documented) -> list[str]:
    """Return the section of a model."""
    return [
        f"### {one.name}",
        f"{one.description[0].upper()}{one.description[1:]}.",
        *(as_markdown(part) for part in one.explanation[1:] if part.kind != REFERENCE),
        _parameters(one),
        *(
            f"{'Recommended' if relation.advisory else 'Condition'}: `{relation.condition}`."
            for relation in one.relations
        ),
        f"Source: {_linked(one.reference)}" if one.reference else "",
    ]


def _parameters(one: Documented) -> str:
    rows = []
    for name, variable in one.variables.items():
        low, high = (
            ("−∞" if math.isinf(variable.min) else f"{variable.min:g}"),
            ("∞" if math.isinf(variable.max) else f"{variable.max:g}"),
        )
        allowed = ", ".join(f"`{one}`" for one in variable.choices) or f"{low} … {high}"
        default = one.defaults.get(name)
        rows.append(
            (
                f"`{key_of(name)}`",
                variable.description + (" (a list)" if one.is_array(name) else ""),
                _units(variable.quantity),
                allowed,
                _default(default),
                "by direction" if variable.directional else "",
            )
        )
    return table(("Parameter", "Meaning", "Unit", "Range", "Default", "With `+asymmetry`"), rows)


def _default(default: Any) -> str:
    if default is None or isinstance(default, str):
        return default or ""
    return "∞" if math.isinf(default) else f"{default:g}"


def _units(quantity: str) -> str:
    both = [unit_of(quantity, kind) for kind in KINDS]
    return both[0] if both[0] == both[1] else f"{both[0]} or {both[1]}"


def _linked(reference: str) -> str:
    doi = reference.removeprefix("doi:")
    return f"[doi:{doi}](https://doi.org/{doi})" if doi != reference else reference


# --- symbols ----------------------------------------------------------------------------------------------------


def symbols() -> str:
    """Return the page of all symbols: each with its meaning, its unit and where it is used."""
    found: dict[tuple[str, str, str], list[str]] = {}
    for members in (*families().values(), CHANNEL_SLOTS):
        for one in members.values():
            for name, variable in one.variables.items():
                entry = (key_of(name), variable.description, _units(variable.quantity))
                found.setdefault(entry, []).append(one.name)
    offset = ("offset", OFFSET.description, _units(OFFSET.quantity))
    found[offset] = list(families()["Friction"])
    rows = [
        (f"`{symbol}`", meaning, unit, ", ".join(f"[{name}](models.md#{name})" for name in names))
        for (symbol, meaning, unit), names in sorted(
            found.items(), key=lambda one: (one[0][0].lower(), one[0])
        )
    ]
    return page(
        "Symbols",
        "The symbols follow the literature. A symbol has one meaning in a model. If models use a symbol for different "
        "quantities, the table has a row for each. The unit of a translational axis is first, that of a rotational axis second.",
        table(("Symbol", "Meaning", "Unit", "Used in"), rows),
        "## In formulas",
        table(
            ("Symbol", "Meaning", "Unit"),
            (
                ("x, v", "position and velocity of the axis", "m, m/s or rad, rad/s"),
                ("F", "friction force, positive when it opposes v > 0", "N or N*m"),
                ("u", "effort: force or torque of the drive on the axis", "N or N*m"),
                ("r", "reference, the desired position", "m or rad"),
                ("q", "position measured by the encoder", "m or rad"),
                ("e", "following error, r − q; the true error is r − x", "m or rad"),
                ("z", "deflection of the bristles", "m or rad"),
                ("G(v)", "Stribeck curve: the level of friction in sliding, a force", "N or N*m"),
                ("ζ", "deflection over its value in sliding, −1 to 1", "1"),
                ("h, dt", "length of an integration step", "s"),
                ("T_s", "sample time of the controller", "s"),
                ("r", "in models with Φ: the ratio f sgn v / G(v), 1 in steady sliding", "1"),
                (
                    "Φ",
                    "share of the travel by which the bristles slip, a function of the ratio r",
                    "1",
                ),
                (
                    "ρ",
                    "ratio r up to which the gate of the elastoplastic transition prevents slip",
                    "1",
                ),
                ("ς", "sliding surface of a control law, ė + λ e", "m/s or rad/s"),
                ("ξ", "position along the axis, −1 to 1 over its range", "1"),
                ("φ", "angle of a screw, 2π x/pitch", "rad"),
                (
                    "α, β",
                    "inputs at which a relay of the Preisach plane goes up and down, α ≥ β",
                    "m or rad",
                ),
                ("μ", "measure of the Preisach plane over α and β", "N/m^2 or N*m/rad^2"),
                (
                    "E, F(α, β)",
                    "Everett function, integral of μ over a triangle; the source paper writes F",
                    "N or N*m",
                ),
                ("τ", "effort transmitted to the load", "N or N*m"),
            ),
        ),
        "## Letters with several meanings",
        "The meaning of these letters depends on the subject:",
        table(
            ("Letter", "Meaning", "Other meanings"),
            (
                (
                    "r",
                    "reference, in control",
                    "ratio f sgn v / G(v), in friction; threshold of a stop or play; 1 − F sgn v/F_C in the Dahl model",
                ),
                (
                    "s",
                    "stiffness after a reversal",
                    "the sliding surface in the source paper, here ς; Laplace variable",
                ),
                (
                    "F",
                    "friction force",
                    "integral of the measure over a triangle, in (13) to (15) of the source paper",
                ),
                ("G", "Stribeck curve, a force", "g(v) in other texts, with σ₀ g(v) = G(v)"),
                ("φ", "angle of a screw", "`phi`: boundary layer of a control law"),
                (
                    "α, β",
                    "thresholds of a relay",
                    "`alpha`, `beta`: shape of Bouc-Wen; β: limit superior of |ς|, in the bound for sampled control",
                ),
                (
                    "τ",
                    "effort transmitted to the load",
                    "largest age of the position reading, in the bound for sampled control",
                ),
                (
                    "n",
                    "exponent of the transition `leuven`",
                    "exponent of Bouc-Wen (`exponent`); exponent of a hardening spring",
                ),
            ),
        ),
    )


# --- command line -----------------------------------------------------------------------------------------------


def command_line() -> str:
    """Return the page of all commands, from the same declarations that `--help` is made from."""
    group: Any = typer.main.get_command(application())
    rows = [
        (f"[`{name}`](#bristle-{name})", _paragraphs(command.help)[0])
        for name, command in group.commands.items()
    ]
    parts = [*_paragraphs(group.help), table(("Command", "Purpose"), rows)]
    for name, command in group.commands.items():
        parts += [f"## bristle {name}", *_paragraphs(command.help), _options(command)]
        parts += (
            [table(command.heads, [(f"`{name}`", text) for name, text in command.rows()])]
            if isinstance(command, Listing)
            else []
        )
        parts += [
            "```sh\n"
            + inspect.cleandoc(command.epilog.replace("\b", "").replace("Example:", ""))
            + "\n```"
        ]
    return page("Command line", *parts)


def _paragraphs(text: str) -> list[str]:
    return [" ".join(one.split()) for one in re.split(r"\n\s*\n", inspect.cleandoc(text))]


def _options(command: Any) -> str:
    rows = []
    for one in command.params:
        argument = one.param_type_name == "argument"
        words = one.metavar or one.name.upper()
        # A flag takes no value.
        spelt = (
            words
            if argument
            else one.opts[0] + ("" if getattr(one, "is_flag", False) else f" {words}")
        )
        default = (
            ""
            if one.default is None or isinstance(one.default, bool)
            else f" Default: `{one.default}`."
        )
        need = " Required." if one.required else ""
        rows.append((f"`{spelt}`", f"{one.help}{need}{default}"))
    return table(("Argument or option", "Meaning"), rows)


# --- Python -----------------------------------------------------------------------------------------------------


def python() -> str:
    """Return the page of the public names and of the classes of results."""
    functions, modules = [], []
    for name in sorted(bristle.__all__):
        value = getattr(bristle, name)
        if inspect.ismodule(value):
            modules.append((f"`bristle.{name}`", _first_line(value), _names(value)))
        elif inspect.isroutine(value):
            functions += [
                f"### {name}",
                f"```text\nbristle.{name}{_signature(value)}\n```",
                _first_line(value),
            ]
            functions += [
                f"Returns {_linked_classes(_returned(value))}." if _returned(value) else ""
            ]
    return page(
        "Python",
        "`import bristle as br` is quick: bristle imports heavy libraries at their first use. Quantities are "
        'numbers in SI units of the axis (m, N, kg or rad, N*m, kg*m^2) or text with a unit (`"40 mN*m"`). '
        "`help(br.identify)` prints parameters, units, shapes and errors, and `help(br.friction.lugre)` the "
        "equations of a model.",
        "## Functions",
        *functions,
        "## Results and data",
        "These are the classes of arguments and results. All of them can be pickled. Classes with signals convert to tables: "
        "`to_dataframe()` (pandas), `to_xarray()` with units, `to_dict()` with plain "
        "data. `np.asarray(log.position)` is an array.",
        *(part for one in _classes() for part in _class(one)),
        "## Modules",
        table(("Module", "Content", "Public names"), modules),
        "## What applications use",
        "The command line, reports and apps use the rooms below. They import only these names from their packages, for example `from "
        "bristle.files import read_axis`. A test compares these lists with the imports.",
        *(
            part
            for room, names in sorted(border().items())
            for part in (f"### bristle.{room}", _offered(room, names))
        ),
    )


def border() -> dict[str, set[str]]:
    """Return the names that applications import from each package of the library."""
    project = tomllib.loads((FOLDER.parents[1] / "pyproject.toml").read_text(encoding="utf-8"))
    (contract,) = (
        contract
        for contract in project["tool"]["importlinter"]["contracts"]
        if contract["name"].startswith("Rooms:")
    )
    rooms = [name for layer in contract["layers"] for name in layer.split(" | ")]
    above = rooms.index("bristle.report") + 1
    found: dict[str, set[str]] = {}
    for room in rooms[:above]:
        for file in (PACKAGE / room.removeprefix("bristle.")).rglob("*.py"):
            if PACKAGE / "apps" / "targets" not in file.parents:  # it continues the exports
                for module, name in _imported(file, rooms[above:]):
                    found.setdefault(module.removeprefix("bristle."), set()).add(name)
    return found


def _imported(file: Path, rooms: Collection[str]) -> Iterator[tuple[str, str]]:
    """Yield module and name of what a file imports from some rooms, but for what every package uses: lazy loading, colours, families."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.ImportFrom) or node.module in (
            "bristle.core.loading",
            "bristle.core.palette",
            "bristle.core.former",
            "bristle.models",
        ):
            continue
        if ".".join(str(node.module).split(".")[:2]) in rooms:
            yield from ((str(node.module), alias.name) for alias in node.names)


def _offered(room: str, names: Iterable[str]) -> str:
    """Return the names of a package with the first sentence of each."""
    package = importlib.import_module(f"bristle.{room}")
    rows = []
    for name in sorted(names, key=lambda name: (name.lower(), name)):
        value = getattr(package, name)
        documented = _is_ours(value) or (
            inspect.isclass(value) and value.__module__.startswith("bristle")
        )
        told = (
            value.description
            if isinstance(value, Component)
            else _first_line(value)
            if documented and inspect.getdoc(value)
            else _remark(f"bristle.{room}", name)
        )
        rows.append((f"`{name}`", _markdown(re.split(r"\.(?: |$)", told)[0])))
    return table(("Name", "Description"), rows)


def _remark(module: str, name: str) -> str:
    """Return the text below an assignment, or the comment at its end."""
    file = Path(str(importlib.import_module(module).__file__))
    lines, tree = (
        file.read_text(encoding="utf-8").splitlines(),
        ast.parse(file.read_text(encoding="utf-8")),
    )
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and name in {
            alias.asname or alias.name for alias in node.names
        }:
            (own,) = (alias.name for alias in node.names if name == (alias.asname or alias.name))
            return _remark(str(node.module), own)
    for node, after in zip(tree.body, [*tree.body[1:], None], strict=True):
        if isinstance(node, ast.FunctionDef) and node.name == name:
            return _paragraphs(ast.get_docstring(node) or "")[0]
        targets = (
            node.targets
            if isinstance(node, ast.Assign)
            else [node.target]
            if isinstance(node, ast.AnnAssign)
            else []
        )
        if name in {
            part.id for target in targets for part in ast.walk(target) if isinstance(part, ast.Name)
        }:
            if (
                isinstance(after, ast.Expr)
                and isinstance(after.value, ast.Constant)
                and isinstance(after.value.value, str)
            ):
                return _paragraphs(after.value.value)[0]
            beside = lines[node.end_lineno - 1].partition("  # ")[2]
            above = lines[node.lineno - 2].partition("# ")[2]
            told = beside or ("" if above.startswith("type:") else above)
            return told[:1].upper() + told[1:]
    return ""


def _first_line(value: Any) -> str:
    return _paragraphs(inspect.getdoc(value) or "")[0]


def _returned(function: Any) -> list[type]:
    """Return the classes of ours that a function returns."""
    inner = inspect.unwrap(function)
    return _ours(inner.__annotations__.get("return", ""), inner.__module__)


def _ours(annotation: Any, module: str) -> list[type]:
    """Return the data classes of ours that an annotation names, as text has it."""
    words = re.findall(r"[A-Za-z_]\w*", str(annotation))
    found = [vars(sys.modules[module]).get(word) or _elsewhere(word) for word in words]
    return [
        one
        for one in found
        if inspect.isclass(one) and one.__module__.startswith("bristle") and _fields(one)
    ]


@cache
def _homes() -> dict[str, set[str]]:
    """Return the modules of ours that define each class, from their text: an import may need a library that is not here."""
    found: dict[str, set[str]] = {}
    for file in PACKAGE.rglob("*.py"):
        for one in ast.parse(file.read_text(encoding="utf-8")).body:
            if isinstance(one, ast.ClassDef):
                found.setdefault(one.name, set()).add(
                    ".".join(file.relative_to(PACKAGE.parent).with_suffix("").parts)
                )
    return found


@cache
def _elsewhere(name: str) -> type | None:
    """Return the class of this name that any module of ours defines, where there is but one."""
    homes = _homes().get(name, set())
    return getattr(importlib.import_module(*homes), name) if len(homes) == 1 else None


def _fields(cls: type) -> dict[str, Any]:
    """Return the fields of a data class or a named tuple, with their annotations, without descriptors."""
    if dataclasses.is_dataclass(cls) and not issubclass(cls, Component):
        return {one.name: one.type for one in dataclasses.fields(cls)}
    return {name: cls.__annotations__[name] for name in getattr(cls, "_fields", ())}


def _classes() -> list[type]:
    """Return the classes of results of the public functions, in order."""
    from bristle import engine

    functions = [
        value for name in bristle.__all__ if inspect.isroutine(value := getattr(bristle, name))
    ]
    functions += [
        value for name in engine.__all__ if inspect.isroutine(value := getattr(engine, name))
    ]
    waiting = [one for function in functions for one in _returned(function)]
    found: list[type] = []
    while waiting:
        one = waiting.pop(0)
        if one not in found:
            found.append(one)
            waiting += [
                inner
                for annotation in _fields(one).values()
                for inner in _ours(annotation, one.__module__)
            ]
    return sorted(found, key=lambda one: one.__name__)


def _is_ours(value: Any) -> bool:
    return inspect.isroutine(value) and str(getattr(value, "__module__", "")).startswith("bristle")


def _class(cls: type) -> list[str]:
    """Return the section of a class: description, attributes, methods."""
    described = _described(cls)
    rows = [
        (f"`{name}`", *described.get(name, (_typed(kind), "")))
        for name, kind in _fields(cls).items()
    ]
    for name, value in inspect.getmembers(cls):
        if not name.startswith("_") and (isinstance(value, property) or hasattr(value, "attrname")):
            rows.append((f"`{name}`", "", _markdown(_first_line(value))))
    heads = ("Attribute", "Type", "Meaning")
    methods = [
        (f"`{name}{_signature(value, bound=True)}`", _markdown(_first_line(value)))
        for name, value in inspect.getmembers(cls, callable)
        if not name.startswith("_") and _is_ours(value)
    ]
    prose = [
        _markdown(one)
        for one in _paragraphs(re.split(r"\n[A-Z]\w+\n---", inspect.getdoc(cls) or "")[0])
    ]
    told = table(
        heads if any(row[2] for row in rows) else heads[:2],
        [row if any(r[2] for r in rows) else row[:2] for row in rows],
    )
    return [
        f"### {cls.__name__}",
        *prose,
        told,
        table(("Method", "Purpose"), methods) if methods else "",
    ]


def _described(cls: type) -> dict[str, tuple[str, str]]:
    """Return type and meaning of each attribute in the docstring of a class and its bases."""
    found: dict[str, tuple[str, str]] = {}
    for one in cls.__mro__:
        section = re.search(
            r"\nParameters\n-+\n(.*?)(?=\n\S[^\n]*\n---|\Z)",
            inspect.cleandoc(one.__doc__ or ""),
            re.DOTALL,
        )
        for entry in re.split(r"\n(?=\S)", section[1]) if section else ():
            head, _, meaning = entry.partition("\n")
            names, _, kind = head.partition(" : ")
            for name in names.split(", "):
                found.setdefault(name, (_markdown(kind), _markdown(" ".join(meaning.split()))))
    return found


def _typed(annotation: Any) -> str:
    text = getattr(annotation, "__forward_arg__", annotation)
    text = text if isinstance(text, str) else inspect.formatannotation(text)
    return "`" + re.sub(r"\b[a-z_]\w*\.(?=\w)", "", text) + "`"  # without the modules


def _markdown(text: str) -> str:
    return text.replace("``", "`")


def _linked_classes(classes: Iterable[type]) -> str:
    return " and ".join(
        f"[`{one.__name__}`](#{one.__name__.lower()})" for one in dict.fromkeys(classes)
    )


def _signature(function: Callable[..., Any], bound: bool = False) -> str:
    def plain(one: inspect.Parameter) -> str:
        star = "**" if one.kind is one.VAR_KEYWORD else ""
        return star + one.name + ("" if one.default is one.empty else f"={one.default!r}")

    parts, keyword_only = [], False
    for one in inspect.signature(function).parameters.values():
        if bound and one.name == "self":
            continue
        if one.kind is one.KEYWORD_ONLY and not keyword_only:
            parts.append("*")
            keyword_only = True
        parts.append(plain(one))
    return f"({', '.join(parts)})"


def _names(module: Any) -> str:
    components = {
        name
        for name, value in vars(module).items()
        if isinstance(value, Component) and not name.startswith("_")
    }
    return ", ".join(
        f"`{one}`" for one in sorted({*module.__all__, *components}) if not one.isupper()
    )


# --- errata -----------------------------------------------------------------------------------------------------


def errata() -> str:
    """Return the page of the errata of the source paper."""
    from bristle.apps.paper.errata import KINDS, errata_of

    parts = []
    for kind, what in KINDS.items():
        found = [
            (one.location, one.printed, one.correct, f"`{one.test}`") for one in errata_of(kind)
        ]
        parts += [
            f"## {kind.capitalize()}s",
            what,
            table(("Place", "As printed", "Correct", "Test"), found),
        ]
    return page(
        "Errata of the source paper",
        "The tables list errors and ambiguities of *Pre-sliding friction control using the sliding mode controller with "
        "hysteresis friction compensator*: the passage as printed, the correct form, and the test in `tests/` that shows the "
        "error. The page on [the source paper](../theory/the-source-paper.md) describes the consequences. The report of "
        "`bristle paper` also contains these tables. All equations: [equations](equations.md).",
        *parts,
    )


# --- equations --------------------------------------------------------------------------------------------------


def equations() -> str:
    """Return the page of the source paper's equations: printed, here, computed, tested, run."""
    from bristle.apps.paper.equations import EQUATIONS, SETUP

    rows = []
    for one in EQUATIONS:
        run = f"`{one.run}`" + (f" gives `{one.gives}`" if one.gives else "")
        rows.append(
            (
                f"({one.number})",
                one.title,
                f"${one.printed}$",
                one.stands + (f": ${one.formula}$" if one.formula else ""),
                f"[{one.file}](../../src/bristle/{one.file})",
                f"[`{one.test}`](../../tests/{one.test.partition('::')[0]})",
                run,
            )
        )
    return page(
        "Equations of the source paper",
        "The table lists equations (1) to (23) of *Pre-sliding friction control using the sliding mode controller with "
        "hysteresis friction compensator*: the printed form, the form in bristle, the file that computes it, its test, and a "
        "line to run. *Corrected*: the printed form is wrong. *Completed*: the printed form lacks a term or a condition. "
        "Reasons: [errata](errata.md). Along a sampled position, `br.response` returns the mean force of each step, not the "
        "force at its end. `contact_equations` returns the force and the rates of (position, deflection) at one instant. Before "
        "you run a line of Python from the table, run",
        "```python\n" + "\n".join(f">>> {line}" for line in SETUP) + "\n```",
        table(
            ("Equation", "Subject", "As printed", "In bristle", "Computed by", "Tested by", "Run"),
            rows,
        ),
        "Below (17), the paper defines $f_r = (f_s/2)\\left[\\sqrt{(1+k)^2 + 4k} - (1+k)\\right]$ and $k = S x_r/f_s$. bristle "
        "uses $f_s = f_p$ and $S = s$, in [hysteresis/everett.py](../../src/bristle/models/hysteresis/everett.py).",
    )


# --- diagnostics ------------------------------------------------------------------------------------------------


def diagnostics() -> str:
    """Return the page of the codes of all diagnostics, and of the thresholds that decide on them."""
    from bristle.identification.settings import Settings
    from bristle.report.messages import fields_of
    from bristle.report.sentences import SENTENCES

    codes = [
        (
            f"`{code}`",
            one.means,
            ", ".join(
                _number_of(name, spec)
                for name, spec in fields_of(code).items()
                if name != "std_percent"
            )
            or "–",
            one.advice,
        )
        for code, one in SENTENCES.items()
    ]
    settings = [
        (
            f"`{one.name}`",
            f"{one.default:g}",
            one.unit if one.unit != "1" else "–",
            _range(one.least, one.most),
            one.meaning + (f" ({one.source})" if one.source else ""),
        )
        for one in Settings.described()
    ]
    return page(
        "Diagnostics",
        "A diagnostic has a code with a fixed meaning, the parameter that it concerns, a severity, and numbers in SI. "
        "`bristle explain CODE` prints the meaning and the advice. The sentences in `warnings[]`, `assumptions[]`, `notes[]` and "
        "`note` of the [JSON](json.md) come from diagnostics. In Python, diagnostics are in `fit.diagnostics`, `estimate.reason` "
        "and `prediction.diagnostics`. `bristle.report.messages.message` returns the sentence of a diagnostic.",
        "| Severity | Meaning |\n| --- | --- |\n| `error` | bristle has no reliable result |\n"
        "| `warning` | the result may "
        "mislead |"
        "\n| `note` | an assumption or treatment behind the result |",
        "## Codes",
        "A code with a parameter and the severity `warning` states why the log does not determine this parameter. With the "
        "severity `note` it states why bristle held the parameter constant. Numbers without a unit are counts, shares in percent or "
        "names. A cut-off is in Hz. The `value` of a parameter comes with its `unit`. `std_percent` is its standard error, if known.",
        table(("Code", "Meaning", "Numbers", "Advice"), codes),
        "## Thresholds",
        "Thresholds decide when bristle gives a diagnostic. They do not change the value of a parameter, but the thresholds "
        "of validation may change the choice of the model. Set a threshold with "
        "`NAME = VALUE` under `[identification.settings]` of the axis file, or with "
        '`settings={"NAME": VALUE}` in Python. The JSON contains all thresholds.',
        table(("Name", "Default", "Unit", "Allowed", "Meaning"), settings),
    )


def _number_of(name: str, spec: str) -> str:
    from bristle.core.dimensions import KINDS, NAMES, unit_of

    if re.split(r"[*/]", spec)[0] not in NAMES:
        return f"`{name}`"
    return f"`{name}` [{' or '.join(dict.fromkeys(unit_of(spec, kind) for kind in KINDS))}]"


def _range(least: float, most: float) -> str:
    return f"{least:g} … {'∞' if math.isinf(most) else f'{most:g}'}"


# --- robustness -------------------------------------------------------------------------------------------------

RUN = Path(__file__).parent / "theory" / "robust.json"


def robustness() -> str:
    """Return the page of the compensation on other frictions, from the run of ``bristle paper --robust``."""
    from bristle.apps.paper.robust.findings import LOOPS, SET_NAMES
    from bristle.apps.paper.robust.truths import CONDITIONS

    told = json.loads(RUN.read_text(encoding="utf-8"))
    tables = {"Set A": told["robust"], "Set C": told["robust_set_c"]}
    seeds = next(iter(told["robust"].values()))["nominal"]["none"]["seeds"]
    parts = [
        f"The numbers come from one run of `{told['provenance']['command']}`, stored in [robust.json](../theory/robust.json). "
        f"The tables give the following error peak to peak in µm: its mean over {seeds} runs with different noise and scatter, "
        "and the 95 % interval of the mean. A *truth* is a simulated friction of the rig. *Both* is model feedforward and "
        "observer together. Method and limits: [compensation](../theory/compensation.md#on-other-frictions).",
        "\n".join(f"- {sentence}" for sentence in told["sentences"]),
    ]
    for name, by_truth in tables.items():
        rows = [
            (truth, condition, *(_interval(loops.get(loop)) for loop in LOOPS))
            for truth, conditions in by_truth.items()
            for condition, loops in conditions.items()
        ]
        parts += [f"## {name}", table(("Friction of the rig", "Condition", *LOOPS.values()), rows)]
    margins = [
        (SET_NAMES[place], LOOPS[loop], f"{one['phase_deg']:.1f}", f"{one['gain']:.2f}")
        for place, loops in told["margins"].items()
        for loop, one in loops.items()
    ]
    return page(
        "Compensation on other frictions",
        *parts,
        "## Conditions",
        table(
            ("Condition", "The rig"),
            [(name, condition.words) for name, condition in CONDITIONS.items()],
        ),
        "## Margins",
        table(("Set", "Friction compensation", "Phase margin [°]", "Gain margin"), margins),
        "## Families",
        "A model of each family is identified from one log and fed forward alone. The tables give the remaining error in "
        "percent of the error without compensation. **Bold**: the family has the structure of the true friction, or of a limiting "
        "case of it. The last row names the family with the smallest error.",
        *_families_of(told),
    )


def _interval(one: Mapping[str, Any] | None) -> str:
    if one is None or one["peak_to_peak"] is None:
        return "–" if one is None else "diverged"
    mean, low, high = (
        None if one[key] is None else f"{1e6 * one[key]:.2f}"
        for key in ("peak_to_peak", "low", "high")
    )
    return f"{mean}" if low is None else f"{mean} ({low} to {high})"


def _families_of(told: Mapping[str, Any]) -> list[str]:
    truths, parts = list(told["families"]), []
    for place, name in (("set_a", "Set A"), ("set_c", "Set C")):
        rows = [
            (f"`{family}`", *(_left(told["families"][truth][family], place) for truth in truths))
            for family in next(iter(told["families"].values()))
        ]
        best = [told["best_family"][truth][place]["family"] for truth in truths]
        parts.append(table((name, *truths), [*rows, ("best", *(f"`{family}`" for family in best))]))
    return parts


def _left(family: Mapping[str, Any], place: str) -> str:
    share = family[place]["share_left"] if place in family else None
    text = "–" if share is None else f"{100.0 * share:.0f}"
    return f"**{text}**" if family["own_structure"] else text


# --- what rests -------------------------------------------------------------------------------------------------

RESTS = Path(__file__).parent / "theory" / "sticking.json"


def sticking() -> str:
    """Return the page on rest and creep, from ``python -m benchmarks.sticking``."""
    heads = {
        "simulator": "Simulator",
        "setting": "Setting or model",
        "slope": "Block on a slope, creep [m/s]",
        "axis": "Axis under load, creep [m/s]",
        "stop": "Error of the stopping position [m]",
        "still": "Remaining speed after the stop [m/s]",
        "pulled": "Pulled by a spring, position error [m]",
        "step": "Time per step [s]",
    }
    rows = [
        [
            value
            if isinstance(value, str)
            else "–"
            if math.isnan(value)
            else f"{value:.1e}"
            if value
            else "0"
            for value in (row[key] for key in heads)
        ]
        for row in json.loads(RESTS.read_text(encoding="utf-8"))
    ]
    parts = [
        "The table compares simulators in four cases with known solutions, with steps of 1 ms. `python -m "
        "benchmarks.sticking` prints it, after `pip install mujoco drake pybullet`. In the first case, a block lies on a slope, "
        "and its weight pulls with 0.8 of the break-away force. The other cases use an axis of 1 kg with 1 N of friction. In "
        "the second case, a force of 0.8 N pushes the axis at rest. In the third, the axis starts at 1 m/s and stops after 0.5 m. "
        "In the fourth, a spring of 100 N/m, whose end moves at 10 mm/s, pulls the axis until it breaks away. Creep is the mean "
        "velocity over nine seconds, after a first second.",
        table(heads.values(), rows),
        "With Coulomb friction, the velocity at rest in bristle is exactly 0. Bristles deflect before they hold the axis. For "
        "`lugre` they absorb the momentum σ_1 z = 10 N·s/m · 10 µm, so that the axis stops 0.1 mm early. Under load, "
        "the axis with `lugre` oscillates and drifts by 1.3 µm ([reason](../theory/which-model-fails-which-certificate.md)). "
        "`preisach_lugre` does not drift and moves by a few nanometres. MuJoCo regularises friction. Its `noslip_iterations` "
        "remove the creep of a joint. A tendon with `springyield` does not drift, but its spring oscillates without damping. "
        "For a contact, elliptic cones reduce creep more. Drake used point contacts with default "
        "settings. The benchmark does not test joints of Drake and Bullet. MuJoCo, Drake and Bullet simulate bodies "
        "and contacts; bristle does not.",
    ]
    return page("Rest and creep", *parts)


def json_schema() -> str:
    """Return the schema of the JSON of all commands."""
    return run_path(str(Path(__file__).with_name("json_schema.py")))["json_schema"]()


def score_board() -> str:
    """Return the page of the score board, from the numbers of `python -m benchmarks board`."""
    sys.path.append(str(Path(__file__).parents[1]))
    from benchmarks.board.board import DATA, page as board_page

    return board_page(json.loads((FOLDER / DATA).read_text(encoding="utf-8")))


PAGES: dict[str, Callable[[], str]] = {
    "models.md": models,
    "symbols.md": symbols,
    "diagnostics.md": diagnostics,
    "command-line.md": command_line,
    "python.md": python,
    "errata.md": errata,
    "equations.md": equations,
    "robustness.md": robustness,
    "sticking.md": sticking,
    "score-board.md": score_board,
    "schema.json": json_schema,
}

if __name__ == "__main__":
    main()
