r"""Friction along a motion with its derivatives: the force of each step, and its change in any number of directions.

.. math:: \dot F_k = \frac{\partial F}{\partial s}\,\dot s_{k-1} + \frac{\partial F}{\partial p}\,\dot p, \qquad
   \dot s_k = \frac{\partial s}{\partial s}\,\dot s_{k-1} + \frac{\partial s}{\partial p}\,\dot p

with the state :math:`s` including its memory, and the parameters :math:`p`: sensitivities are computed in the same pass as
the force, without changing any bit of it. They belong to the executed branches. At zero velocity, this is the branch of the
sign, or the branch of rest if the law has one, in which the contact does not move. At a boundary between two branches,
derivatives are one-sided. If a law has a special form for one value of an exponent, its derivative with respect to the
exponent is zero there. All derivatives are finite.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np

from bristle.core import Model, kernel
from bristle.core.dispatch import friction_commit, friction_trial
from bristle.core.edge import vector
from bristle.core.packing import (
    Structure,
    kernel_of,
    motion_reader,
    number_count,
    packer,
    unowned,
    unpacker,
)
from bristle.core.tangent import DIRECTIONS, keep_tangent, tangent_at
from bristle.engine.checks import check_run
from bristle.engine.compilation import compiled
from bristle.engine.instance import Instance, memory_of, warn_of_lost
from bristle.engine.motion import _surroundings
from bristle.engine.signature import Vector
from bristle.engine.translation.build import Builder
from bristle.engine.translation.derivative import (
    Activity,
    Derivatives,
    activity_of,
    is_active,
    nowhere,
)
from bristle.engine.translation.tree import INTEGER, REAL, Array, Struct, Type, struct_of

# A friction model along a motion, each vector followed by its tangents: (state, memory, v, x, consecutive surroundings, dt,
# parameters, force).
ForceWithTangents = Callable[[*(Vector,) * 10, float, *(Vector,) * 4], float]

UNMOVED: Mapping[str, np.ndarray] = {}


class Argument(NamedTuple):
    """An argument of a kernel: a packed structure, or a value of a type; whether it has tangents, or receives them."""

    name: str
    holds: Structure | Type
    moves: bool = False
    handed: bool = False

    @property
    def type(self) -> Type:
        """Its type in the tree."""
        return type_of_structure(self.holds) if isinstance(self.holds, tuple) else self.holds

    @property
    def activity(self) -> Activity:
        """Activity of its numbers: which have tangents."""
        return activity_of(self.type) if self.moves else nowhere(self.type)


def with_tangents(
    derivatives: Derivatives,
    function: Callable[..., Any],
    arguments: Sequence[Argument],
    kept: str = "",
) -> Callable[..., Any]:
    """Return the entry that runs a kernel with tangents, each after its argument; the result is a number, or is stored in `kept`."""
    activities = [argument.activity for argument in arguments]
    derived = derivatives.of(
        Builder().function(function, [argument.type for argument in arguments]), activities
    )
    parts: dict[str, Any] = {
        "with_tangents": derivatives.scope[derived.name],
        "tangent_at": tangent_at,
    }
    heads, values, tangents = list[str](), list[str](), list[str]()
    for (name, holds, moves, handed), activity in zip(arguments, activities, strict=True):
        heads += [name, *([f"d_{name}"] if moves or handed else [])]
        tangent = f"tangent_at(d_{name}, 0)" if holds == REAL else f"d_{name}"
        if isinstance(holds, tuple):
            parts |= {f"load_{name}": unpacker(holds), f"tangents_{name}": _tangent_reader(holds)}
            tangent = f"tangents_{name}({name}, d_{name})"
        values.append(f"load_{name}({name})" if isinstance(holds, tuple) else name)
        tangents += [tangent] * is_active(activity)
    call = f"with_tangents({', '.join(values + tangents)})"
    lines = [f"return float({call})"]
    if kept:
        structure = next(argument.holds for argument in arguments if argument.name == kept)
        assert isinstance(structure, tuple)
        parts |= {"store": packer(structure), "keep": _tangent_packer(structure)}
        moved = is_active(derived.result)
        lines = [
            f"end{', d_end' * moved} = {call}",
            f"store(end, {kept})",
            *[f"keep(d_end, d_{kept})"] * moved,
            "return 0.0",
        ]
    return kernel_of(f"entry({', '.join(heads)})", lines, parts, portable=False)


VECTOR, WRITTEN = Array(-1), Array(-1, writable=True)


@cache
def make_force_with_tangents(
    parameters: Structure, state: Structure, motion: Any, moves: bool, acts: bool
) -> Callable[..., Any]:
    """Return the entry of a friction model with tangents; `moves` adds those of the motion, `acts` those of the surroundings."""
    moved = motion_reader(motion)

    @kernel(portable=False)
    def along(s, memory, v, x, around, dt, p, force):
        for k in range(v.size):
            force[k], move = friction_trial(s, memory, moved(v, x, around, k), dt, p)
            s = friction_commit(s, memory, move, p)
        return s

    begun = Argument("s", state, True), Argument("memory", WRITTEN, True)
    signals = (
        Argument("v", VECTOR, moves, True),
        Argument("x", VECTOR, moves, True),
        Argument("around", VECTOR, acts, True),
    )
    arguments = [
        *begun,
        *signals,
        Argument("dt", REAL),
        Argument("p", parameters, True),
        Argument("force", WRITTEN, True),
    ]
    return with_tangents(Derivatives(), along, arguments, kept="s")


def type_of_structure(structure: Structure) -> Struct:
    """Return the type, in the tree, of a NamedTuple of this structure."""
    cls, parts = structure
    kinds: dict[str, Type] = {"number": REAL, "integer": INTEGER, "array": Array(-1)}
    return struct_of(
        cls, [type_of_structure(part) if isinstance(part, tuple) else kinds[part] for part in parts]
    )


def _tangent_reader(structure: Structure) -> Callable[..., Any]:
    """Return the kernel ``tangents(vector, all)`` for the real numbers of a NamedTuple that `unpacker` reads from the vector."""
    lines = ["at = 0"]

    def text_of(part: Any) -> str:
        if isinstance(part, tuple):
            inside = [text for text in map(text_of, part[1]) if text]
            return f"({', '.join(inside)},)" if inside else ""
        name = f"part_{len(lines)}"
        if part == "array":
            begin = (
                f"{name} = unowned(all[(at + 1) * {DIRECTIONS} : (at + 1 + size) * {DIRECTIONS}])"
            )
            lines.extend(["size = int(vector[at])", begin, "at += 1 + size"])
            return name
        lines.extend([*[f"{name} = tangent_at(all, at)"] * (part == "number"), "at += 1"])
        return name * (part == "number")

    text = text_of(structure)
    return kernel_of(
        "tangents(vector, all)",
        [*lines, f"return {text}"],
        {"tangent_at": tangent_at, "unowned": unowned},
        portable=False,
    )


def _tangent_packer(structure: Structure) -> Callable[..., Any]:
    """Return the kernel ``keep(tangent, all)`` that stores the tangents of a NamedTuple of scalars."""
    lines = list[str]()

    def write(part: Any, at: int, of: str) -> None:
        if part == "number":
            lines.append(f"keep_tangent(all, {at}, {of})")
        place = 0
        for inner in part[1] if isinstance(part, tuple) else ():
            before = len(lines)
            write(inner, at, f"{of}[{place}]")
            at, place = at + number_count(inner), place + (len(lines) > before)

    write(structure, 0, "tangent")
    return kernel_of(
        "keep(tangent, all)", lines or ["return"], {"keep_tangent": keep_tangent}, portable=False
    )


class TangentRun:
    """A friction model along a motion, block by block, with tangents of shape (number, direction), in at most `DIRECTIONS` directions."""

    def __init__(
        self,
        model: Model,
        tangents: np.ndarray,
        state: Any = None,
        state_tangents: np.ndarray | None = None,
        *,
        moves: bool = False,
        acts: bool = False,
    ) -> None:
        self.part, self.memory, self.moves, self.acts = (
            Instance(model),
            memory_of(model, None),
            moves,
            acts,
        )
        self.part.begin(state)
        self._tangents = (
            padded(tangents, self.part.parameters.size),
            padded(state_tangents, self.part.state.size),
        )
        self._d_memory, self._entry = (
            np.zeros(self.memory.size * DIRECTIONS),
            _entry(self.part, moves, acts),
        )

    def along(
        self,
        v: np.ndarray,
        dt: float,
        x: np.ndarray,
        around: Mapping[str, Any],
        out: np.ndarray,
        moved: Mapping[str, np.ndarray] = UNMOVED,
    ) -> np.ndarray:
        """Return the force of the next steps; `out` receives its tangents, shape (step, `DIRECTIONS`). `moved` are tangents of signals."""
        part, (dp, ds), signals = (
            self.part,
            self._tangents,
            _surroundings(self.part, v.size, around).ravel(),
        )
        d_v, d_x = (padded(moved.get(name), v.size * self.moves) for name in "vx")
        d_around = np.concatenate(
            [padded(moved.get(name), v.size * self.acts) for name in part.motion._field_defaults]
        )
        force = np.empty(v.size)
        begun, motion = (
            (part.state, ds, self.memory, self._d_memory),
            (v, d_v, x, d_x, signals, d_around),
        )
        self._entry(*begun, *motion, float(dt), part.parameters, dp, force, out.reshape(-1))
        return force


def force_with_derivatives(
    model: Model,
    tangents: np.ndarray,
    v: np.ndarray,
    dt: float,
    x: np.ndarray,
    *,
    state: Any = None,
    state_tangents: np.ndarray | None = None,
    motion_tangents: tuple[np.ndarray, np.ndarray] | None = None,
    around: Mapping[str, Any] | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the exact force of `force_along` and its derivatives; all tangents have shape (number, direction)."""
    v, x = vector(v, "v"), vector(x, "x")
    check_run(v.size, x=x)

    def run(first: int) -> tuple[np.ndarray, np.ndarray]:
        now, force_tangents = slice(first, first + DIRECTIONS), np.empty((v.size, DIRECTIONS))
        begun = None if state_tangents is None else state_tangents[:, now]
        part = TangentRun(model, tangents[:, now], state, begun, moves=motion_tangents is not None)
        moved = {
            name: columns[:, now]
            for name, columns in zip("vx", motion_tangents or (), strict=False)
        }
        force = part.along(v, dt, x, around or {}, force_tangents, moved)
        if first == 0:
            warn_of_lost(part.part)
        return force, force_tangents

    return in_blocks(run, tangents.shape[1])


def in_blocks(
    run: Callable[[int], tuple[np.ndarray, np.ndarray]], directions: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return a signal with its derivatives in all directions, from runs with a limited number of directions each."""
    signals, slopes = zip(
        *(run(first) for first in range(0, max(directions, 1), DIRECTIONS)), strict=True
    )
    return signals[0], np.hstack([part.reshape(-1, DIRECTIONS) for part in slopes])[:, :directions]


def padded(columns: np.ndarray | None, count: int) -> np.ndarray:
    """Return flat tangents of `count` numbers; 0 in directions without a column."""
    block = np.zeros((count, DIRECTIONS))
    if columns is not None:
        block[:, : columns.shape[1]] = columns
    return block.ravel()


def _entry(part: Instance, moves: bool, acts: bool) -> Any:
    name = f"force_with_tangents{'_moving' * moves}{'_acting' * acts}-{part.key}"
    make = partial(make_force_with_tangents, *part.structures, part.motion, moves, acts)
    return compiled(name, make, ForceWithTangents, part.functions)
