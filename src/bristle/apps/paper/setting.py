"""Experiments on a contact or an operator: the moved part, its path or its torque, and the measurement.

The tables of such a file; all but the first line are optional. An experiment refuses to run without those it needs:

========================= ==============================================================================================
``lead``                  travel of the table for one turn of the screw: models are described at the table, in lengths
                          and forces; driving and plotted torques are those of the screw
``[contact.NAME]``        friction models by name, each as in the ``[friction]`` of an experiment file
``[operator.NAME]``       hysteresis operators by name, with ``model`` and its parameters
``[plant]``               the inertia that a torque drives
``[bench]``               the torque measurement: a motor of inertia ``J_m``, the torque sensor, and behind it the rest
                          of ``J``, screw and table, all at the screw; ``torque_filter`` of the sensor, and the
                          ``acceleration`` of a table that is moved along a path
``[path]``                turning points of the table (``turns``) and its speed (``speed``)
``[torque]``              a torque that breaks the contact away (``break_away``) and then alternates between
                          ``low`` and ``high``, with a ``period``, for a number of ``cycles``
``[measurement]``         loops of ``amplitudes`` at a ``speed``, ``repeats`` of the largest loop, read with a
                          ``resolution``, the torque with ``noise``; ``branches`` from a loop to ``extent``, and the
                          number of repetitions (``seeds``)
``[transition_branches]`` stiffness ``s`` and saturation ``f_p`` of the reformed Dahl model, the amplitude ``x_r`` of
                          its loop, and the number of its branches (``count``)
========================= ==============================================================================================
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bristle.core import InputError, Kind, Model, Origin, Variable, content_of, located
from bristle.files import (
    TOML_LIMIT,
    Sources,
    check_keys,
    check_schema,
    number_at,
    read_toml,
    results_folder,
    table_at,
)

KIND: Kind = "translational"


class Key(NamedTuple):
    """A key of a table: a number, or a list of numbers."""

    variable: Variable
    kind: Kind = KIND
    is_list: bool = False
    is_integer: bool = False


# In steps of nanometres, larger numbers would take hours.
FARTHEST = 0.01  # [m]
MOST = 10_000.0  # repetitions
LENGTHS = Key(Variable("length", "travels of the table", min=-FARTHEST, max=FARTHEST), is_list=True)
LENGTH = Key(Variable("length", "travel of the table", min=0.0, max=FARTHEST))
SPEED = Key(Variable("length/time", "speed of the table", min=1e-9))
TORQUE = Key(Variable("force", "torque of the screw"), "rotational")
COUNT = Key(Variable("1", "a number of times", min=1.0, max=MOST), is_integer=True)
COUNTS = Key(Variable("1", "numbers of branches", min=1.0, max=MOST), is_list=True, is_integer=True)
SECTIONS: dict[str, dict[str, Key]] = {
    "bench": {
        "J": Key(Variable("mass", "inertia of all moving parts", min=1e-12), "rotational"),
        "J_m": Key(
            Variable("mass", "inertia of the motor, before the torque sensor", min=0.0),
            "rotational",
        ),
        "acceleration": Key(
            Variable(
                "length/time^2", "acceleration of the table at starts, turns and stops", min=1e-9
            )
        ),
        "torque_filter": Key(Variable("frequency", "cut-off of the torque sensor", min=1e-3)),
    },
    "path": {"turns": LENGTHS, "speed": SPEED},
    "torque": dict.fromkeys(("break_away", "low", "high"), TORQUE)
    | {"period": Key(Variable("time", "of one cycle", min=1e-6)), "cycles": COUNT},
    "measurement": {
        "amplitudes": LENGTHS,
        "speed": SPEED,
        "resolution": LENGTH,
        "extent": LENGTH,
        "branches": COUNTS,
    }
    | {
        "noise": Key(
            Variable("force", "standard deviation of the torque read", min=0.0), "rotational"
        ),
        "repeats": COUNT,
        "seeds": COUNT,
    },
    "transition_branches": {
        "s": Key(Variable("force/length", "stiffness at a reversal", min=1e-9)),
        "f_p": Key(Variable("force", "force at saturation", min=1e-12)),
        "x_r": LENGTH,
        "count": Key(Variable("1", "number of branches", min=2.0, max=MOST), is_integer=True),
    },
}
KEYS = ("schema", "name", "lead", "contact", "operator", "plant", *SECTIONS)


@dataclass(frozen=True)
class Setting:
    """An experiment on a contact or an operator."""

    source: Path
    origin: Origin
    arm: float
    contacts: Mapping[str, Model]
    operators: Mapping[str, Model]
    plant: Model | None
    numbers: Mapping[str, Mapping[str, Any]]

    def __getitem__(self, path: tuple[str, str]) -> Any:
        """Return a number or a list of numbers, by table and key."""
        section, key = path
        if key not in self.numbers.get(section, {}):
            raise self._missing(f"{section}.{key}")
        return self.numbers[section][key]

    def contact(self, name: str) -> Model:
        """Return a friction model by name."""
        if name not in self.contacts:
            raise self._missing(f"contact.{name}", f"Write [contact.{name}] with a friction model")
        return self.contacts[name]

    @property
    def operator(self) -> Model:
        """The first hysteresis operator."""
        if not self.operators:
            raise self._missing(
                "operator", 'Write [operator.f_h] and, below it, model = "preisach"'
            )
        return next(iter(self.operators.values()))

    @property
    def mass(self) -> Model:
        """The mass driven by a torque."""
        if self.plant is None:
            raise self._missing("plant")
        return self.plant

    def _missing(self, key: str, mend: str = "") -> InputError:
        return InputError(
            "is missing, but this experiment needs it", path=f"{self.source}: {key}", mend=mend
        )


def read_setting(path: Path, *, allow_code: bool = False) -> Setting:
    """Return the experiment on a contact or an operator in a file."""
    content = content_of(path, limit=TOML_LIMIT)
    data, source, _ = read_toml(content)
    sources = Sources(source.parent, allow_code)
    with located(path):
        check_keys(data, KEYS, "")
        check_schema(data)
        lead = number_at(
            data.get("lead", 2.0 * math.pi),
            Variable("length", "lead", min=1e-9),
            "translational",
            "lead",
        )
        contacts, operators = (
            table_at(data.get(section, {}), section).items() for section in ("contact", "operator")
        )
        return Setting(
            source=content.source,
            origin=content.origin,
            arm=lead / (2.0 * math.pi),
            contacts={
                name: sources.friction(table, KIND, f"contact.{name}")[1]
                for name, table in contacts
            },
            operators={
                name: sources.listed("hysteresis", table, KIND, f"operator.{name}")
                for name, table in operators
            },
            plant=sources.listed("plant", data["plant"], KIND, "plant")
            if "plant" in data
            else None,
            numbers={
                section: _numbers(data[section], section) for section in SECTIONS if section in data
            },
        )


def _numbers(value: Any, section: str) -> dict[str, Any]:
    table = table_at(value, section)
    keys = SECTIONS[section]
    check_keys(table, keys, section)
    numbers: dict[str, Any] = {}
    for name, entry in table.items():
        key = keys[name]
        path = f"{section}.{name}"
        if not key.is_list:
            numbers[name] = _number(entry, key, path)
        elif isinstance(entry, list) and entry:
            numbers[name] = np.array(
                [_number(number, key, f"{path}[{i}]") for i, number in enumerate(entry)]
            )
        else:
            raise InputError("must be a list", path=path, value=entry)
    return numbers


def _number(entry: Any, key: Key, path: str) -> float:
    value = number_at(entry, key.variable, key.kind, path)
    if key.is_integer and not value.is_integer():
        raise InputError(
            "must be a whole number", path=path, value=entry, allowed=key.variable.allowed(key.kind)
        )
    return value


EXPERIMENTS = Path(str(files("bristle.apps.paper") / "experiments"))


def write_experiments(folder: Path, *, force: bool = False) -> list[Path]:
    """Copy the experiments of the paper into a new folder, for reading, changes and runs; return the files written.

    Its parent must exist. `force` replaces an earlier copy without changes.
    """
    sources = sorted(source for source in EXPERIMENTS.iterdir() if source.suffix == ".toml")
    with results_folder(folder, force=force) as written:
        for source in sources:
            written.write(source.name, source.read_bytes())
    return [folder / source.name for source in sources]
