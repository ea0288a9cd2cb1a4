"""What a study may vary: a value of the experiment, named by the dotted key under which it stands in the file."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from bristle.core.contracts import Model
from bristle.core.errors import InputError, did_you_mean
from bristle.core.experiment import FEEDFORWARD, LEARNING, RUN, Experiment, Variant
from bristle.core.variable import Kind, Variable
from bristle.files.components import key_of, number_at
from bristle.files.run import effort_variables

__all__ = ["Target", "sections_of", "target_at"]

WHOLE_NUMBERS = ("delay", "substeps", "trials")
OF_RUNS = "each run has a seed of its own, which is added to those of sensor and friction"


@dataclass(frozen=True)
class Target:
    """A value of the experiment that a study sets.

    Parameters
    ----------
    path : str
        Its dotted key, as ``"friction.F_C"``.
    variable : Variable
        What it is: unit and range.
    kind : {"translational", "rotational"}
        Kind of axis that its unit follows.
    is_whole : bool
        Whether it is a whole number.
    """

    path: str
    variable: Variable
    kind: Kind
    is_whole: bool = False

    @property
    def is_discrete(self) -> bool:
        """Whether it takes steps: a whole number, or one of several names."""
        return self.is_whole or bool(self.variable.choices)

    @property
    def unit(self) -> str:
        """Its unit in SI, empty for names and pure numbers."""
        return "" if self.variable.choices or self.variable.quantity == "1" else self.variable.unit(self.kind)

    @property
    def spread(self) -> Variable:
        """What its standard deviation is: of the same unit, without its range."""
        return replace(self.variable, min=0.0, max=math.inf)

    def number(self, raw: Any, path: str) -> Any:
        """Return a value of the file in SI, or the name that it is.

        Raises
        ------
        InputError
            If it has another unit, or is out of range.
        """
        if self.variable.choices:
            self.variable.code(raw, path)
            return raw
        value = number_at(raw, self.variable, self.kind, path)
        if self.is_whole and not value.is_integer():
            raise InputError("must be a whole number", path=path, value=raw)
        return value

    def numbers(self, raw: list[Any], path: str) -> tuple[Any, ...]:
        """Return several values of the file, each as `number` does."""
        return tuple(self.number(value, f"{path}[{place}]") for place, value in enumerate(raw))


def sections_of(variant: Variant) -> dict[str, Model]:
    """Return the models of a variant by the section of the file that describes them."""
    models = {"plant": variant.plant, "friction": variant.friction, "sensor": variant.sensor}
    if variant.table is not None:
        models["table_friction"] = variant.table
    if variant.effort is None:
        models |= {"controller": variant.controller, "reference": variant.reference}
    return models


def target_at(path: str, experiment: Experiment, data: Mapping[str, Any], place: str) -> Target:
    """Return what stands under a dotted key of an experiment."""
    keys = path.split(".")
    variant, keys = _variant_of(keys, experiment, place)
    registry = _variables(keys[:-1], variant, data, place)
    names = {key_of(name): name for name in registry}
    if keys[-1] == "seed" or keys == ["run", "seeds"]:
        raise InputError("is not varied", path=place, mend=f"Leave it out: {OF_RUNS}")
    if keys[-1] not in names:
        raise InputError(
            "is no value of this experiment",
            path=place,
            allowed=", ".join(".".join((*keys[:-1], name)) for name in names if name != "seed"),
            mend=did_you_mean(keys[-1], names),
        )
    model = _model_at(keys[:-1], variant)
    name = names[keys[-1]]
    if model is not None and model.component.is_array(name):
        raise InputError(
            "is a list, which is not varied as one number",
            path=place,
            mend='Take joint draws of a fit, from = "results", or vary another value',
        )
    is_whole = name in WHOLE_NUMBERS or (model is not None and model.component.is_integer(name))
    kind = "translational" if keys[0] == "table_friction" else experiment.kind
    return Target(path, registry[name], kind, is_whole and not registry[name].choices)


def _variant_of(keys: list[str], experiment: Experiment, place: str) -> tuple[Variant, list[str]]:
    variants = {variant.name: variant for variant in experiment.variants}
    if keys[0] != "compare":
        return experiment.variants[0], keys
    if len(keys) < 4 or keys[1] not in variants:
        raise InputError("names no variant of the experiment", path=place, allowed=", ".join(f"compare.{name}.…" for name in variants))
    return variants[keys[1]], keys[2:]


def _model_at(keys: list[str], variant: Variant) -> Model | None:
    if keys == ["controller", "feedforward", "friction"]:
        return variant.feedforward.friction
    return sections_of(variant).get(keys[0]) if len(keys) == 1 else None


def _variables(keys: list[str], variant: Variant, data: Mapping[str, Any], place: str) -> Mapping[str, Variable]:
    model = _model_at(keys, variant)
    if model is not None:
        return model.component.variables
    section = ".".join(keys)
    if section == "effort" and variant.effort is not None:
        return effort_variables(data.get("effort", {}).get("model"))
    if section == "run":
        return RUN
    if section == "controller.feedforward" and variant.effort is None:
        return FEEDFORWARD
    if section == "controller.learning" and variant.learning is not None:
        return LEARNING
    sections = [*sections_of(variant), "run"]
    raise InputError(
        "is no value of this experiment", path=place, allowed=f"a key below {', '.join(sections)}", mend=did_you_mean(section, sections)
    )
