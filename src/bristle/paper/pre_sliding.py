"""Figures 1, 8, 9 and 10: the contact led along a path before break-away."""

from __future__ import annotations

import math

import numpy as np

from bristle import hysteresis
from bristle.certificates import holding_of
from bristle.core.errors import InputError
from bristle.core.typography import number
from bristle.paper.reproduced import Reproduced, in_micrometres, percent
from bristle.paper.setting import Setting
from bristle.paper.walk import Walk, follow, walk

__all__ = ["figure_1", "figure_8", "figure_9", "figure_10"]

CLOSED = 0.005  # of the largest torque: what a torque sensor would not tell from nothing
REPEATS = 0.1  # of the largest torque: what a contact that scatters by some per cent may miss
NEARLY = 0.95  # of the break-away torque: where an eye sees it
SAID = 7e-6  # where the paper sees it [m]
LUGRE, RIG = "LuGre", "virtual rig"


def _led(setting: Setting, *needed: str) -> dict[str, Walk]:
    """Return the walks of all contacts along the path; those that are `needed` must be among them."""
    for name in needed:
        setting.contact(name)
    turns, speed = setting["path", "turns"], setting["path", "speed"]
    return {name: walk(model, turns, speed, setting.arm) for name, model in setting.contacts.items()}


def _traces(walks: dict[str, Walk]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    return {name: (one.x, one.torque) for name, one in walks.items()}


def _missing(one: Walk, returns: tuple[int, int]) -> float:
    """Return the torque missing at a return to a turning point, over the largest torque on the path."""
    left, back = (one.at_turns[index] for index in returns)
    return float(back - left) / float(np.max(np.abs(one.torque)))


def _told(share: float) -> str:
    return f"{percent(share)} at the return" if abs(share) >= CLOSED else "closes"


def _comes_back(share: float, letter: str) -> str:
    if abs(share) < CLOSED:
        return f"closes at {letter}"
    word = "missing" if share < 0.0 else "too much"
    return f"back at {letter}, {percent(abs(share))} of the largest torque is {word}"


def _must_return(setting: Setting, pairs: tuple[tuple[int, int], ...]) -> None:
    """Refuse a path that does not come back to where it turned."""
    turns = setting["path", "turns"]
    for first, second in pairs:
        if turns.size <= max(first, second) or turns[first] != turns[second]:
            raise InputError(
                f"must come back: its entries {first + 1} and {second + 1} must be the same",
                path=f"{setting.source}: path.turns", value=turns.tolist(),
            )  # fmt: skip


def figure_1(setting: Setting) -> Reproduced:
    """Return figure 1: from A over B, C and B again to D, LuGre beside a contact that closes its loops."""
    from bristle.figures import marked_path

    _must_return(setting, ((0, 2),))
    walks = _led(setting, LUGRE, RIG)
    missing = {name: _missing(one, (0, 2)) for name, one in walks.items()}
    found = [f"{name}: {_comes_back(share, 'B')}." for name, share in missing.items()]
    return Reproduced(
        number=1,
        verdict="holds" if abs(missing[LUGRE]) > 5.0 * abs(missing[RIG]) else "does not hold",
        found=found,
        draw=lambda: marked_path(
            _traces(walks), {name: [0, *one.turns] for name, one in walks.items()}, "ABCBD",
            {name: f"{name}: {_told(missing[name])}" for name in walks}, "translational", "rotational",
        ),
        origin=setting.origin,
        numbers={"missing_at_return": missing},
    )  # fmt: skip


def figure_8(setting: Setting) -> Reproduced:
    """Return figure 8: where friction breaks away when the table is moved one way."""
    from bristle.figures import break_away

    if np.any(setting["path", "turns"] <= 0.0):
        raise InputError("must lead forward", path=f"{setting.source}: path.turns", allowed="> 0 m")
    walks = _led(setting, RIG)
    # A limit that scatters may lie above the one that it starts with.
    held = {
        name: max(setting.arm * holding_of(model).forward, float(np.max(walks[name].torque)))
        for name, model in setting.contacts.items()
    }
    reached = {name: _reached(one, NEARLY * held[name]) for name, one in walks.items()}
    at = reached[RIG]
    found = [_breaks_away(name, walks[name], held[name], reached[name]) for name in walks]
    return Reproduced(
        number=8,
        verdict="holds" if abs(at - SAID) < 0.15 * SAID else "does not hold",
        found=found,
        draw=lambda: break_away(_traces(walks), reached, SAID, "translational", "rotational"),
        origin=setting.origin,
        numbers={"position_at_95_percent": reached, "break_away": held},
    )  # fmt: skip


def _reached(one: Walk, torque: float) -> float:
    """Return where a torque is first reached [m]; NaN where it is not."""
    beyond = np.flatnonzero(one.torque >= torque)
    return float(one.x[beyond[0]]) if beyond.size else math.nan


def _breaks_away(name: str, one: Walk, held: float, at: float) -> str:
    told = f"{number(1e3 * held, digits=3)} mN·m"
    if math.isnan(at):
        last = percent(float(one.torque[-1]) / held, 1.0)
        return f"{name} breaks away at {told}, of which it has {last} after {in_micrometres(float(one.x[-1]))}."
    return f"{name} breaks away at {told}, and has {percent(NEARLY, 1.0)} of it after {in_micrometres(at)}."


def figure_9(setting: Setting) -> Reproduced:
    """Return figure 9: wiping-out on the virtual rig."""
    walks = _led(setting, RIG)
    missing = _missing_of_nest(setting, walks)
    worst = max(abs(share) for pair in missing.values() for share in pair.values())
    return Reproduced(
        number=9,
        verdict="holds" if worst < REPEATS else "does not hold",
        found=_nest_sentences(missing),
        draw=lambda: _nest(walks, missing),
        origin=setting.origin,
        numbers={"missing_at_return": missing},
    )


def figure_10(setting: Setting) -> Reproduced:
    """Return figure 10: the same path through the paper's construction, its equations, and what mends them."""
    branches = hysteresis.transition_branches(
        setting["transition_branches", "s"], setting["transition_branches", "f_p"],
        setting["transition_branches", "x_r"], count=round(setting["transition_branches", "count"]),
    )  # fmt: skip
    name = f"{branches.inputs.size - 1} branches, over z"
    walks = {name: follow(branches.operator(), setting["path", "turns"], setting.arm)} | _led(setting)
    missing = _missing_of_nest(setting, walks)
    open_ = [one for one, pair in missing.items() if max(map(abs, pair.values())) > CLOSED]
    return Reproduced(
        number=10,
        verdict="holds in part" if open_ and name not in open_ else "holds" if not open_ else "does not hold",
        found=[*_nest_sentences(missing),
               f"As branches that leave one loop the {branches.inputs.size - 1} are not those of an operator: at the "
               f"end of the descending ones {percent(branches.corner_error)} of the tip is missing, and the two "
               f"directions differ by {percent(branches.symmetry_error)} of the largest Everett value."],
        draw=lambda: _nest(walks, missing),
        origin=setting.origin,
        numbers={"missing_at_return": missing, "corner_error": branches.corner_error,
                 "symmetry_error": branches.symmetry_error},
    )  # fmt: skip


def _missing_of_nest(setting: Setting, walks: dict[str, Walk]) -> dict[str, dict[str, float]]:
    """Return what is missing where the inner loop closes (D) and where the outer one does (B)."""
    _must_return(setting, ((2, 4), (0, 5)))
    return {name: {"D": _missing(one, (2, 4)), "B": _missing(one, (0, 5))} for name, one in walks.items()}


def _nest_sentences(missing: dict[str, dict[str, float]]) -> list[str]:
    return [
        f"{name}: {_comes_back(pair['D'], 'D')}, and {_comes_back(pair['B'], 'B')}." for name, pair in missing.items()
    ]


def _nest(walks: dict[str, Walk], missing: dict[str, dict[str, float]]):
    from bristle.figures import marked_path

    titles = {name: f"{name}: {_told(max(pair.values(), key=abs))}" for name, pair in missing.items()}
    turns = {name: [0, *one.turns] for name, one in walks.items()}
    return marked_path(_traces(walks), turns, "ABCDEDBF", titles, "translational", "rotational")
