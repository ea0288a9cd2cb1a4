"""Varied values of a study: a value of the experiment by its dotted key, drawn alone or jointly from an identification."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core import (
    Experiment,
    InputError,
    Kind,
    Model,
    Origin,
    Variable,
    Variant,
    content_of,
    did_you_mean,
    located,
)
from bristle.files import (
    check_keys,
    key_of,
    number_at,
    read_arrays,
    read_model,
    variables_of_section,
)

WHOLE_NUMBERS = ("delay", "substeps", "trials")
EXAMPLES = {
    "normal": 'normal = ["34 mN*m", "2 mN*m"], mean and standard deviation',
    "uniform": 'uniform = ["0.8e-4 kg*m^2", "1.2e-4 kg*m^2"], lowest and highest',
    "log_uniform": 'log_uniform = ["1e4 N/m", "1e6 N/m"], lowest and highest',
    "choice": 'choice = ["1 mm", "5 mm"], values that are drawn equally often',
}
DISTRIBUTIONS = tuple(EXAMPLES)
OF_FIT = ("from", "draws")
SECTIONS = ("plant", "friction")
FED = ("controller.feedforward.friction", "controller.feedforward.table_friction")


@dataclass(frozen=True)
class Target:
    """A value of the experiment that a study sets: its dotted key, variable, kind of axis, and whether it is an integer."""

    path: str
    variable: Variable
    kind: Kind
    is_whole: bool = False

    @property
    def unit(self) -> str:
        """Its unit in SI, empty for names and pure numbers."""
        if self.variable.choices or self.variable.quantity == "1":
            return ""
        return self.variable.unit(self.kind)

    def number(self, raw: Any, path: str) -> Any:
        """Return a value of the file in SI, or a name; refuse a wrong unit and values out of range."""
        if self.variable.choices:
            self.variable.code(raw, path)
            return raw
        value = number_at(raw, self.variable, self.kind, path)
        if self.is_whole and not value.is_integer():
            raise InputError("must be a whole number", path=path, value=raw)
        return value

    def numbers(self, raw: list[Any], path: str) -> tuple[Any, ...]:
        """Return several values of the file, converted by `number`."""
        return tuple(self.number(value, f"{path}[{place}]") for place, value in enumerate(raw))


def sections_of(variant: Variant) -> dict[str, Model]:
    """Return the models of a variant by their section in the file."""
    models = {"plant": variant.plant, "friction": variant.friction, "sensor": variant.sensor}
    if variant.table is not None:
        models["table_friction"] = variant.table
    if variant.effort is None:
        models |= {"controller": variant.controller, "reference": variant.reference}
    return models


def target_at(path: str, experiment: Experiment, data: Mapping[str, Any], place: str) -> Target:
    """Return the target under a dotted key of an experiment."""
    keys = path.split(".")
    variant = experiment.variants[0]
    variants = {variant.name: variant for variant in experiment.variants}
    if keys[0] == "compare":
        if len(keys) < 4 or keys[1] not in variants:
            allowed = ", ".join(f"compare.{name}.…" for name in variants)
            raise InputError("is not a variant of the experiment", path=place, allowed=allowed)
        variant = variants[keys[1]]
        keys = keys[2:]
    section = ".".join(keys[:-1])
    fed = {"friction": variant.feedforward.friction, "table_friction": variant.feedforward.table}
    if section in FED:
        model = fed[section.rpartition(".")[2]]
    else:
        model = sections_of(variant).get(section)
    if model is None:
        registry = _variables(section, variant, data, place)
    else:
        registry = model.component.variables
    names = {key_of(name): name for name in registry}
    if keys[-1] == "seed" or keys == ["run", "seeds"]:
        raise InputError(
            "is a seed, which [vary] cannot contain",
            path=place,
            mend="Remove this key: bristle adds a separate seed for each run to those of sensor and friction",
        )
    if keys[-1] not in names:
        raise InputError(
            "is not a value of this experiment",
            path=place,
            allowed=", ".join(".".join((*keys[:-1], name)) for name in names if name != "seed"),
            mend=did_you_mean(keys[-1], names),
        )
    name = names[keys[-1]]
    if model is not None and model.component.is_array(name):
        raise InputError(
            "is a list, which cannot be varied as one number",
            path=place,
            mend='Use joint draws of an identification (from = "results"), or vary another value',
        )
    is_whole = name in WHOLE_NUMBERS or (model is not None and model.component.is_integer(name))
    kind = experiment.kind
    if "table_friction" in keys:
        kind = "translational"
    return Target(path, registry[name], kind, is_whole and not registry[name].choices)


def _variables(
    section: str, variant: Variant, data: Mapping[str, Any], place: str
) -> Mapping[str, Variable]:
    """Return the values of a section without a model."""
    variables = variables_of_section(section, variant, data)
    if variables is not None:
        return variables
    sections = [*sections_of(variant), "run"]
    raise InputError(
        "is not a value of this experiment",
        path=place,
        allowed=f"a key below {', '.join(sections)}",
        mend=did_you_mean(section, sections),
    )


@dataclass(frozen=True)
class Drawn:
    """A quantity drawn independently, from a distribution with these numbers."""

    target: Target
    distribution: str
    numbers: tuple[Any, ...]

    @property
    def name(self) -> str:
        """Name of the cause."""
        return self.target.path

    @property
    def units(self) -> dict[str, str]:
        """Unit of each value by dotted key."""
        return {self.target.path: self.target.unit}

    def values(self, unit_numbers: np.ndarray) -> dict[str, np.ndarray]:
        """Return the values by dotted key for numbers between 0 and 1, shape (draw,), by the inverse distribution function."""
        first = self.numbers[0]
        second = self.numbers[-1]
        if self.distribution == "choice":
            places = np.minimum(
                (unit_numbers * len(self.numbers)).astype(int), len(self.numbers) - 1
            )
            values = np.array(self.numbers)[places]
        elif self.distribution == "normal":
            from scipy.special import ndtri

            values = first + second * ndtri(unit_numbers)
        elif self.distribution == "uniform":
            values = first + (second - first) * unit_numbers
        else:
            values = np.exp(math.log(first) + (math.log(second) - math.log(first)) * unit_numbers)
        return {self.target.path: values}


@dataclass(frozen=True)
class Joint:
    """Quantities drawn jointly: rows of a table, all equally often."""

    name: str
    columns: Mapping[str, np.ndarray]
    units: Mapping[str, str]

    def values(self, unit_numbers: np.ndarray) -> dict[str, np.ndarray]:
        """Return the values by dotted key for numbers between 0 and 1, shape (draw,) or (draw, element)."""
        count = len(next(iter(self.columns.values())))
        rows = np.minimum((unit_numbers * count).astype(int), count - 1)
        return {path: values[rows] for path, values in self.columns.items()}


Cause = Drawn | Joint


def drawn_from(table: Mapping[str, Any], target: Target, path: str) -> Drawn:
    """Return the drawn quantity described by a table of ``[vary]``."""
    allowed = f"{', '.join(DISTRIBUTIONS)}, or from and draws"
    for key, value in table.items():
        if key not in DISTRIBUTIONS:
            raise InputError(
                "is not a distribution",
                path=f"{path}.{key}",
                value=value,
                allowed=allowed,
                mend=did_you_mean(key, DISTRIBUTIONS),
            )
    if len(table) != 1:
        fault = "has no distribution"
        if table:
            fault = "has two distributions"
        raise InputError(fault, path=path, allowed=allowed, mend=f"Write {EXAMPLES['normal']}")
    name = next(iter(table))
    values = table[name]
    place = f"{path}.{name}"
    count = "two values"
    if name == "choice":
        count = "at least one value"
    if not isinstance(values, list) or not values or (name != "choice" and len(values) != 2):
        raise InputError(
            "does not fit", path=place, value=values, allowed=count, mend=f"Write {EXAMPLES[name]}"
        )
    if name == "choice":
        return Drawn(target, name, target.numbers(values, place))
    if target.is_whole or target.variable.choices:
        raise InputError(
            f"needs a continuous quantity, but {target.path} is a whole number or a name",
            path=place,
            value=values,
            mend="Write choice = [...] instead",
        )
    first = target.number(values[0], f"{place}[0]")
    if name == "normal":
        width = number_at(
            values[1], replace(target.variable, min=0.0, max=math.inf), target.kind, f"{place}[1]"
        )
        if not width > 0.0:
            raise InputError(
                "must be positive",
                path=f"{place}[1]",
                value=values[1],
                allowed="> 0",
                mend="The second value is the standard deviation",
            )
        return Drawn(target, name, (first, width))
    second = target.number(values[1], f"{place}[1]")
    if not first < second:
        raise InputError(
            "must be above the lowest value",
            path=f"{place}[1]",
            value=values[1],
            allowed=f"> {first:g}",
            mend=f"Write {EXAMPLES[name]}",
        )
    if name == "log_uniform" and not first > 0.0:
        raise InputError(
            "must be positive, because log_uniform takes its logarithm",
            path=f"{place}[0]",
            value=values[0],
            allowed="> 0",
        )
    return Drawn(target, name, (first, second))


@dataclass(frozen=True)
class Fitted:
    """Draws of an identification."""

    folder: str
    plant: Model | None
    friction: Model
    draws: Mapping[str, np.ndarray] = field(repr=False)
    origin: Origin


def fitted_at(
    table: Mapping[str, Any], folder: Path, path: str, *, allow_code: bool = False
) -> Fitted:
    """Return the draws named by a table such as ``{ from = "results", draws = "bootstrap" }``."""
    check_keys(table, OF_FIT, path)
    for key in OF_FIT:
        if key not in table:
            raise InputError(
                f"needs the key {key}",
                path=path,
                mend='Write { from = "results", draws = "bootstrap" }',
            )
    if table["draws"] != "bootstrap":
        raise InputError(
            "are not draws of an identification",
            path=f"{path}.draws",
            value=table["draws"],
            allowed="bootstrap",
        )
    named = table["from"]
    if not isinstance(named, str) or not named:
        raise InputError(
            "must be the name of a folder of results", path=f"{path}.from", value=named
        )
    results = folder / named
    file = results / "model.toml"
    with located(f"{path}.from"):
        plant, friction, info = read_model(file, allow_code=allow_code)
        draws = read_arrays(results, "draws")
    if draws:
        file = next(
            file for file in (results / "draws.parquet", results / "draws.npz") if file.is_file()
        )
    else:
        draws = (info["bands"] or {}).get("draws", {})
    if not draws:
        raise InputError(
            "names results without draws and intervals",
            path=f"{path}.from",
            value=named,
            mend="Identify again with --draws 1000",
        )
    return Fitted(named, plant, friction, draws, content_of(file).origin)


def columns_of(
    fitted: Fitted, section: str, experiment: Experiment, path: str
) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Return the draws of one section of an experiment by dotted key, in SI, and their units."""
    if section not in SECTIONS:
        raise InputError(
            "cannot use draws of an identification", path=path, allowed=" or ".join(SECTIONS)
        )
    own = sections_of(experiment.variants[0])[section]
    drawn = fitted.plant
    if section == "friction":
        drawn = fitted.friction
    if drawn is None or (own.name, own.kind) != (drawn.name, drawn.kind):
        identified = "no plant"
        if drawn is not None:
            identified = f"{drawn.name} ({drawn.kind})"
        raise InputError(
            f"the identification has {identified}, but the experiment has {own.name} ({own.kind})",
            path=path,
            value=fitted.folder,
            mend=f'Write file = "{fitted.folder}/model.toml" under [friction] of the experiment',
        )
    variables = {
        name: own.component.variables[name]
        for name in fitted.draws
        if name in own.component.variables
    }
    if not variables:
        raise InputError(
            f"the draws contain no parameter of {own.name}, only {', '.join(fitted.draws)}",
            path=path,
            value=fitted.folder,
        )
    count = min(len(values) for values in fitted.draws.values())
    columns = {f"{section}.{key_of(name)}": fitted.draws[name][:count] for name in variables}
    units = {
        f"{section}.{key_of(name)}": ""
        if variable.quantity == "1"
        else variable.unit(experiment.kind)
        for name, variable in variables.items()
    }
    return columns, units
