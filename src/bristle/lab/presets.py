"""Figures of the source paper that the page can show: its models on their paths, as what a link to the page holds."""

from __future__ import annotations

import tomllib
from importlib import resources
from typing import Any
from urllib.parse import urlencode

import numpy as np

from bristle.core.contracts import Model
from bristle.core.units import quantity
from bristle.core.variable import Variable
from bristle.friction import find
from bristle.lab.loop import loop_described, paper_experiment

__all__ = ["presets"]

LENGTH, SPEED = Variable("length", "turn"), Variable("length/time", "speed")
LUGRE, PRINTED, GATE = "LuGre", "equations (5)–(7)", "with a gate"
ON_PATHS = (
    ("Figure 1: nonlocal memory, LuGre", "fig_01", LUGRE),
    ("Figure 1: nonlocal memory, with a gate", "fig_01", GATE),
    ("Figure 8: break-away, equations as printed", "fig_08", PRINTED),
    ("Figure 9: wiping-out, with a gate", "fig_09", GATE),
)
AT_REST = (("Figure 2: drift, LuGre", "fig_02", LUGRE), ("Figure 2: drift, equations as printed", "fig_02", PRINTED))
CONTACTS = "fig_01"  # what a figure has no contact of its own of


def presets() -> list[dict[str, str]]:
    """Return the name of each figure, and the state of the page that shows it."""
    rows = []
    for word, file, contact in ON_PATHS:
        setting = _setting(file)
        turns = np.array([0.0, *(quantity(turn, LENGTH, "translational") for turn in setting["path"]["turns"])])
        speed = quantity(setting["path"]["speed"], SPEED, "translational")
        amplitude = float(np.max(np.abs(turns)))
        path = {
            "path": "drawn",
            "turns": " ".join(f"{turn:.4g}" for turn in turns / amplitude),
            "amplitude": amplitude,
            "period": 4.0 * amplitude / speed,
        }
        rows.append({"word": word, "state": _state(_contact(setting, contact), path)})
    for word, file, contact in AT_REST:
        rows.append({"word": word, "state": _state(_contact(_setting(file), contact), {"path": "presliding"})})
    rows += [{"word": f"Figure 11: tracking, {word}", "state": state} for word, state in _tracking()]
    return sorted(rows, key=lambda row: int(row["word"].split(":")[0].split()[1]))


def _tracking() -> list[tuple[str, str]]:
    variants = {variant.name: variant for variant in paper_experiment().variants}
    numbers = loop_described()["paper"]
    named = {"M": "M", "gain": "gain", "K_2": "K_2", "g": "g", "resolution": "resolution", "amplitude": "A", "frequency": "f"}
    loop = {"loop_body": 1} | {f"loop_{name}": numbers[key] for key, name in named.items()}
    fed = (("equations as printed", "printed"), ("LuGre", "lugre"))
    models = [(word, variants[name].feedforward) for word, name in fed]
    return [(word, _state(fed.friction, loop, offset=fed.offset)) for word, fed in models if fed.friction is not None]


def _setting(name: str) -> dict[str, Any]:
    file = resources.files("bristle").joinpath("paper", "experiments", f"{name}.toml")
    return tomllib.loads(file.read_text(encoding="utf-8"))


def _contact(setting: dict[str, Any], name: str) -> Model:
    table = dict(setting["contact"].get(name) or _setting(CONTACTS)["contact"][name])
    return find(table.pop("model"))(**table)


def _state(model: Model, rest: dict[str, Any], **changes: float) -> str:
    """Return what the link to a page holds: the model with its values, and the rest."""
    numbers = {}
    for name, value in (dict(model.values) | changes).items():
        variable = model.component.variables.get(name)
        if variable is None or not variable.choices:
            numbers[name] = " ".join(repr(float(number)) for number in np.atleast_1d(value))
        else:
            numbers[name] = str(variable.choices.index(str(value)))
    return urlencode({"model": model.name, **numbers, **rest})
