r"""Terms of a plant besides friction: gravity of a link, cogging, a spring or cable, and effects of known columns of the log.

.. math::
    u = u_\text{plant} + g_s \sin x + g_c \cos x + \sum_{T} \sum_n \left(c_{T,n} \cos \frac{2\pi n x}{T}
        + s_{T,n} \sin \frac{2\pi n x}{T}\right) + \sum_{i=1}^3 c_i x^i + \sum_j k_j w_j(t) + F

Gravity of a link depends on its angle, with two coefficients for any mounting position. Cogging pulls a motor from tooth
to tooth, or a screw from ball to ball: :math:`n` times per turn :math:`T` of motor or screw. A linear spring has the
stiffness :math:`c_1`, and its rest position acts as a constant offset. The cubic polynomial describes the pull of a
cable or hose within the range of the log. All these forces depend on the position only and are equal in both directions,
but friction changes its sign. A motion in both directions therefore separates them. A known column :math:`w_j` of the log
acts only on simulations along that log.

A step uses the position-dependent force at :math:`x + \tfrac12 h v`, half a step ahead at the initial velocity. The
port stays affine in the friction force, and a motion without friction keeps its energy (Verlet's scheme).
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from bristle.core import InputError, Model, Plant, kernel
from bristle.core.dispatch import plant_port, plant_rate, plant_rest, plant_step
from bristle.core.documented import Enclosing
from bristle.core.edge import TEXT, among, component, guarded, many, mapping, optional, whole
from bristle.core.lazy import once
from bristle.core.mathematics import cos, sin
from bristle.core.variable import Kind, Variable

TWO_PI = 2.0 * math.pi
GRAVITY, COGGING, SPRING, COLUMNS = "gravity", "cogging", "spring", "known"
# Suffixes of the name of a plant, as in `inertia+gravity`
TERMS = (GRAVITY, COGGING, SPRING, COLUMNS)
TURNS = {"motor": "motor_turn", "screw": "screw_turn"}
"""Causes of cogging, and the parameter with the movement for a turn of each."""
TURN = {
    turner: Variable("length", f"movement for one turn of the {turner}", min=1e-12)
    for turner in TURNS
}
_GRAVITY = {
    name: Variable("force", f"effort of gravity, {part} of the angle", excitation="place")
    for name, part in (("g_sin", "sine"), ("g_cos", "cosine"))
}
SPRINGS = {"linear": 1, "cubic": 3}
"""Degree of the polynomial of each spring."""
DEGREES = {degree: name for name, degree in SPRINGS.items()}
_SPRING = {
    "spring_1": Variable(
        "force/length", "stiffness of a spring over the position", excitation="place"
    ),
    "spring_2": Variable(
        "force/length^2", "force of a cable over the position, square part", excitation="place"
    ),
    "spring_3": Variable(
        "force/length^3", "force of a cable over the position, cubic part", excitation="place"
    ),
}
_WAVE = re.compile(r"(motor|screw)_([1-9][0-9]*)_(cos|sin)")


class Terms(NamedTuple):
    """Values for the kernels: gravity [N or N*m], movement for a turn, wave numbers [1/m or 1/rad], coefficients."""

    g_sin: Annotated[float, _GRAVITY["g_sin"]]
    g_cos: Annotated[float, _GRAVITY["g_cos"]]
    motor_turn: Annotated[float, TURN["motor"]]
    screw_turn: Annotated[float, TURN["screw"]]
    waves: Annotated[np.ndarray, Variable("1/length", "angle of each wave over the position")]
    cosines: Annotated[np.ndarray, Variable("force", "cosine part of each wave")]
    sines: Annotated[np.ndarray, Variable("force", "sine part of each wave")]
    per_column: Annotated[np.ndarray, Variable("force", "effort for one unit of each known column")]
    spring_1: Annotated[float, _SPRING["spring_1"]] = 0.0
    spring_2: Annotated[float, _SPRING["spring_2"]] = 0.0
    spring_3: Annotated[float, _SPRING["spring_3"]] = 0.0


class Place(NamedTuple):
    """The position-dependent part of `Terms`."""

    g_sin: float
    g_cos: float
    waves: np.ndarray
    cosines: np.ndarray
    sines: np.ndarray
    spring_1: float = 0.0
    spring_2: float = 0.0
    spring_3: float = 0.0

    @property
    def is_link(self) -> bool:
        """Whether no effort besides gravity depends on the position."""
        return not (self.waves.size or self.spring_1 or self.spring_2 or self.spring_3)


NOWHERE = Place(0.0, 0.0, np.zeros(0), np.zeros(0), np.zeros(0))  # For a plant without terms


class Termed(NamedTuple):
    """Parameters of a plant with terms."""

    inner: Any
    terms: Terms


@kernel
def gravity_at(x, q):
    """Return the effort [N or N*m] against gravity of a link at an angle [rad]."""
    return q.g_sin * sin(x) + q.g_cos * cos(x) if q.g_sin != 0.0 or q.g_cos != 0.0 else 0.0


@kernel
def effort_at(x, q):
    """Return the effort [N or N*m] against gravity, cogging and a spring at a position [m or rad]."""
    total = gravity_at(x, q) + x * (q.spring_1 + x * (q.spring_2 + x * q.spring_3))
    for i in range(q.waves.size):
        phase = q.waves[i] * x
        total += q.cosines[i] * cos(phase) + q.sines[i] * sin(phase)
    return total


@kernel
def left_of(state, effort, dt, p):
    """Return an effort [N or N*m] minus that of the terms, over a step of `dt` [s]."""
    return effort - effort_at(state.x + 0.5 * dt * state.v, p.terms)


@kernel
def port(state, effort, dt, p):
    """Return `a` and `b` of the plant for the effort minus that of the terms."""
    return plant_port(state, left_of(state, effort, dt, p), dt, p.inner)


@kernel
def step(state, effort, force, dt, p):
    """Return position and state of the plant after a step, for the effort minus that of the terms."""
    return plant_step(state, left_of(state, effort, dt, p), force, dt, p.inner)


@kernel
def rest(state, effort, dt, p):
    """Return the state of the plant after a time with its port at rest."""
    return plant_rest(state, effort, dt, p.inner)


@kernel
def rate(state, effort, force, p):
    """Return the time derivative of the state of the plant, for the effort minus that of the terms."""
    return plant_rate(state, effort - effort_at(state.x, p.terms), force, p.inner)


@dataclass(frozen=True, kw_only=True)
class TermedPlant(Enclosing, Plant):
    """A plant with terms: gravity, orders of cogging per turn of motor and screw, degree of a spring, known columns by name."""

    inner: Plant
    gravity: bool
    orders: tuple[tuple[str, int], ...]
    columns: tuple[str, ...]
    degree: int

    def _made_by(self) -> tuple[Any, tuple[Any, ...]]:
        return _termed, (self.inner, self.gravity, self.orders, self.columns, self.degree)

    @property
    def turners(self) -> tuple[str, ...]:
        """Causes of cogging."""
        return tuple(
            turner for turner in TURNS if any(turner == counted for counted, _ in self.orders)
        )

    @property
    def beside(self) -> Mapping[str, Variable]:
        """The parameters of its terms."""
        return _variables(self.gravity, self.turners, self.orders, self.columns, self.degree)

    @property
    def defaults(self) -> dict[str, Any]:
        """Default values of the parameters; a turn has none."""
        return self.inner.defaults | dict.fromkeys(
            _variables(self.gravity, (), self.orders, self.columns, self.degree), 0.0
        )

    def assemble(self, values: Mapping[str, Any]) -> Termed:
        """Return the parameters of the kernels from the values of the user."""
        turns = {turner: float(values.get(name, 1.0)) for turner, name in TURNS.items()}
        cosines, sines = (
            np.array([values[_wave(*wave, part)] for wave in self.orders], dtype=float)
            for part in ("cos", "sin")
        )
        terms = Terms(
            float(values.get("g_sin", 0.0)),
            float(values.get("g_cos", 0.0)),
            turns["motor"],
            turns["screw"],
            np.array(
                [TWO_PI * order / turns[turner] for turner, order in self.orders], dtype=float
            ),
            cosines,
            sines,
            np.array([values[f"known_{name}"] for name in self.columns], dtype=float),
            *(float(values.get(name, 0.0)) for name in _SPRING),
        )
        return Termed(self.inside(values), terms)

    def values(self, parameters: Termed) -> dict[str, Any]:
        """Return the values of the user from the parameters of the kernels."""
        terms = parameters.terms
        values = self.inner.values(parameters.inner)
        values |= {"g_sin": terms.g_sin, "g_cos": terms.g_cos} if self.gravity else {}
        values |= {TURNS[turner]: getattr(terms, TURNS[turner]) for turner in self.turners}
        for wave, cosine, sine in zip(
            self.orders, terms.cosines.tolist(), terms.sines.tolist(), strict=True
        ):
            values |= {_wave(*wave, "cos"): cosine, _wave(*wave, "sin"): sine}
        values |= {name: getattr(terms, name) for name in tuple(_SPRING)[: self.degree]}
        return values | {
            f"known_{name}": k
            for name, k in zip(self.columns, terms.per_column.tolist(), strict=True)
        }


def _orders(value: Any, path: str, kind: Kind | None) -> dict[str, Any]:
    """Return orders of cogging for each cause."""
    for turner, orders in mapping(lambda orders, *_: tuple(orders))(value, path, kind).items():
        many(whole(1))(orders, f"{path}.{among(*TURNS)(turner, path, kind)}", kind)
    return dict(value)


def _named(value: Any, path: str, kind: Kind | None) -> str:
    name = TEXT(value, path, kind)
    if not name:
        raise InputError("is empty", path=path, mend="Give each column a name")
    return name


@guarded(
    plant=component("plant"),
    cogging=optional(_orders),
    columns=many(_named),
    spring=optional(among(*SPRINGS)),
)
def with_terms(
    plant: Plant,
    *,
    gravity: bool = False,
    cogging: Mapping[str, Iterable[int]] | None = None,
    columns: Iterable[str] = (),
    spring: str | None = None,
) -> Plant:
    """Return a plant with terms; the plant itself without terms.

    Parameters
    ----------
    plant : Plant
        The plant.
    gravity : bool
        Whether the plant has gravity of a link.
    cogging : mapping of str to iterable of int
        Orders of cogging per turn of the ``"motor"`` and of the ``"screw"``.
    columns : iterable of str
        Names of known columns, each with a coefficient.
    spring : {"linear", "cubic"}, optional
        Polynomial of a spring or cable over the position.
    """
    orders = cogging or {}
    pairs = tuple(
        (turner, int(order)) for turner in TURNS for order in sorted(set(orders.get(turner, ())))
    )
    named, degree = tuple(columns), SPRINGS[spring] if spring else 0
    if gravity or pairs or named or degree:
        return _termed(plant, gravity, pairs, named, degree)
    return plant


def terms_in(names: Iterable[str]) -> dict[str, Any]:
    """Return the arguments of `with_terms` for some names of parameters."""
    parameters = list(names)
    waves = [match for name in parameters if (match := _WAVE.fullmatch(name))]
    return {
        "gravity": "g_sin" in parameters or "g_cos" in parameters,
        "cogging": {
            turner: {int(match[2]) for match in waves if match[1] == turner} for turner in TURNS
        },
        "columns": list(
            dict.fromkeys(
                match[1] for name in parameters if (match := re.fullmatch(r"known_(\w+)", name))
            )
        ),
        "spring": "cubic"
        if {"spring_2", "spring_3"} & set(parameters)
        else "linear"
        if "spring_1" in parameters
        else None,
    }


def effort_of_place(x: np.ndarray, terms: Terms) -> np.ndarray:
    """Return the effort [N or N*m] of the position-dependent terms at some positions [m or rad], of the same shape."""
    spring = x * (terms.spring_1 + x * (terms.spring_2 + x * terms.spring_3))
    phase = np.multiply.outer(np.asarray(x, dtype=float), terms.waves)
    return (
        terms.g_sin * np.sin(x)
        + terms.g_cos * np.cos(x)
        + (np.cos(phase) @ terms.cosines + np.sin(phase) @ terms.sines)
        + spring
    )


def terms_of(plant: Model) -> Terms | None:
    """Return the terms of a plant with their values; None for a plant without terms."""
    if isinstance(plant.parameters, Termed):
        return plant.parameters.terms
    return None


def place_of(plant: Model | None) -> Place:
    """Return the position-dependent terms of a plant; `NOWHERE` for a plant without terms."""
    terms = None if plant is None else terms_of(plant)
    if terms is None:
        return NOWHERE
    return Place(*(getattr(terms, name) for name in Place._fields))


def effort_of_columns(plant: Model, columns: Sequence[np.ndarray]) -> np.ndarray | None:
    """Return the effort [N or N*m] of known columns, from their samples; None for a plant without known columns."""
    terms = terms_of(plant)
    if terms is None or not terms.per_column.size:
        return None
    columns = [np.asarray(column, dtype=float) for column in columns]
    if len(columns) != terms.per_column.size:
        raise InputError(
            "has too few or too many known columns for the plant",
            path="log",
            value=f"{len(columns)} columns",
            allowed=", ".join(plant.component.columns),
            mend="Name these columns under [[known]] of the axis file",
        )
    return np.asarray(terms.per_column @ np.stack(columns))


def _wave(turner: str, order: int, part: str) -> str:
    return f"{turner}_{order}_{part}"


def _variables(
    gravity: bool,
    turners: Iterable[str],
    orders: Iterable[tuple[str, int]],
    columns: Iterable[str],
    degree: int,
) -> dict[str, Variable]:
    variables = dict(_GRAVITY) if gravity else {}
    variables |= {TURNS[turner]: TURN[turner] for turner in turners}
    for turner, order in orders:
        often = "once" if order == 1 else f"{order} times"
        for part, word in (("cos", "cosine"), ("sin", "sine")):
            variables[_wave(turner, order, part)] = Variable(
                "force", f"cogging {often} a turn of the {turner}, {word}", excitation="place"
            )
    variables |= {name: _SPRING[name] for name in tuple(_SPRING)[:degree]}
    for name in columns:
        variables[f"known_{name}"] = Variable(
            "force", f"effort for a 1 in the known column {name}", excitation="place"
        )
    return variables


@once
def _termed(
    plant: Plant,
    gravity: bool,
    orders: tuple[tuple[str, int], ...],
    columns: tuple[str, ...],
    degree: int,
) -> TermedPlant:
    own = plant.inverse

    def inverse(x: np.ndarray, v: np.ndarray, a: np.ndarray, p: Termed) -> np.ndarray:
        """Return the effort [N or N*m] of the motion, without known columns."""
        assert own is not None
        return own(x, v, a, p.inner) + effort_of_place(x, p.terms)

    named = (
        [GRAVITY] * gravity
        + [COGGING] * bool(orders)
        + [SPRING] * bool(degree)
        + [COLUMNS] * bool(columns)
    )
    return TermedPlant(
        name="+".join((plant.name, *named)),
        description=f"{plant.description}, with {' and '.join(_WORDS[name] for name in named)}",
        Parameters=Termed,
        State=plant.State,
        port=port,
        step=step,
        rest=rest,
        rate=rate if plant.rate else None,
        inverse=inverse if own else None,
        reference=plant.reference,
        module=plant.module,
        inner=plant,
        gravity=gravity,
        orders=orders,
        columns=columns,
        degree=degree,
    )


_WORDS = {
    GRAVITY: "gravity of a link",
    COGGING: "cogging",
    SPRING: "a spring",
    COLUMNS: "known columns of a log",
}
