"""Figures 9 and 10: loops inside loops, as the torque sensor of the rig reads them and as models draw them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from bristle import hysteresis
from bristle.core.contracts import Model
from bristle.core.typography import number
from bristle.hysteresis.transition_branches import TransitionBranches
from bristle.paper.economy import repeated
from bristle.paper.reproduced import Reproduced, percent, spread
from bristle.paper.returns import CLOSED, closure_text, comes_back, missing_at, must_return, traces, walks_of
from bristle.paper.setting import Setting
from bristle.paper.torque_bench import Reading, bench_of, led, sensor_numbers, sensor_says
from bristle.paper.walk import Walk, follow
from bristle.report.table import Table

__all__ = ["figure_9", "figure_10"]

RIG, LETTERS = "virtual rig", "ABCDEDBF"
RETURNS = {"D": (2, 4), "B": (0, 5)}  # where the inner loop closes, and where the outer one does
REPEATS = 0.1  # of the largest torque: what a contact that scatters by some per cent may miss
RAISED = (
    "Friction torque over position along nested loops: models, each raised by one offset, over the virtual rig",
    "The models of figure 10 again, each raised by the one offset with which it comes nearest to the curve that the "
    "torque sensor read in figure 9, wide and light.",
)

Missing = dict[str, float]


def figure_9(setting: Setting) -> Reproduced:
    """Return figure 9: wiping-out on the rig, as its torque sensor reads it."""
    must_return(setting, tuple(RETURNS.values()))
    setting.contact(RIG)
    bench = bench_of(setting)
    runs = {name: [_led(setting, contact) for contact in repeated(setting, model)] for name, model in setting.contacts.items()}
    missing = {name: _missing_of(run.sensor) for name, (run, *_) in runs.items()}
    by_run = {name: [_missing_of(run.sensor) for run in repetitions] for name, repetitions in runs.items()}
    worst = max(abs(share) for shares in by_run.values() for pair in shares for share in pair.values())
    sensor = sensor_numbers([run.sensed for repetitions in runs.values() for run in repetitions])
    return Reproduced(
        number=9,
        verdict="built in" if worst < REPEATS else "refuted",
        found=[*_sentences(missing), sensor_says(bench, sensor, "At this speed")],
        draw=lambda: _draw(
            {name: run.sensor for name, (run, *_) in runs.items()},
            missing,
            {name: run.friction for name, (run, *_) in runs.items()},
            ("friction", "torque sensor"),
        ),
        origin=setting.origin,
        numbers={
            "missing_at_return": missing,
            "missing_of_friction": {name: _missing_of(run.friction) for name, (run, *_) in runs.items()},
            "missing_of_runs": by_run,
            "torque_sensor": sensor,
        },
        tables=(_table(by_run),),
    )


def figure_10(setting: Setting) -> Reproduced:
    """Return figure 10: the same path through the paper's construction, its equations, and what mends them."""
    must_return(setting, tuple(RETURNS.values()))
    rig = _led(setting, setting.contact(RIG)).sensor
    branches = hysteresis.transition_branches(
        setting["transition_branches", "s"],
        setting["transition_branches", "f_p"],
        setting["transition_branches", "x_r"],
        count=round(setting["transition_branches", "count"]),
    )
    name = f"{branches.inputs.size - 1} branches, over z"
    walks = {name: follow(branches.operator(), setting["path", "turns"], setting.arm)} | walks_of(setting)
    del walks[RIG]
    missing = {name: _missing_of(path) for name, path in walks.items()}
    open_ = [name for name, pair in missing.items() if max(map(abs, pair.values())) > CLOSED]
    apart = {name: _apart(path, rig) for name, path in walks.items()}
    names = (f"{RIG}, torque sensor", "model")
    return Reproduced(
        number=10,
        verdict="found in part" if open_ and name not in open_ else "found" if not open_ else "refuted",
        found=[*_sentences(missing), _no_operator(branches), _beside(apart, name)],
        draw=lambda: _draw(walks, missing, dict.fromkeys(walks, rig), names),
        origin=setting.origin,
        numbers={
            "missing_at_return": missing,
            "corner_error": branches.corner_error,
            "symmetry_error": branches.symmetry_error,
            "apart_from_rig": apart,
        },
        tables=(_table_beside(missing, apart),),
        extras={"raised": (lambda: _draw_raised(walks, apart, rig, names), *RAISED)},
    )


def _led(setting: Setting, friction: Model) -> Reading:
    return led(setting, friction, setting["path", "turns"], setting["path", "speed"])


def _missing_of(path: Walk) -> Missing:
    return {letter: missing_at(path, pair) for letter, pair in RETURNS.items()}


def _sentences(missing: Mapping[str, Missing]) -> list[str]:
    return [f"{name}: {comes_back(pair['D'], 'D')}, and {comes_back(pair['B'], 'B')}." for name, pair in missing.items()]


def _table(by_run: Mapping[str, Sequence[Missing]]) -> Table:
    """Return what is missing at each return, over all runs."""
    rows = [
        (name, str(len(runs)), *(spread([100.0 * run[letter] for run in runs], 0.1) for letter in RETURNS)) for name, runs in by_run.items()
    ]
    return Table(
        "Torque back at D and B, less that at the turn [%], of the largest; mean and standard deviation over the runs",
        ("Contact", "Runs", *RETURNS),
        rows,
    )


def _no_operator(branches: TransitionBranches) -> str:
    return (
        f"As branches that leave one loop the {branches.inputs.size - 1} are not those of an operator: at the end of "
        f"the descending ones "
        f"{percent(branches.corner_error)} of the tip is missing, and the two directions differ by "
        f"{percent(branches.symmetry_error)} of the largest Everett value."
    )


def _apart(model: Walk, rig: Walk) -> dict[str, float]:
    """Return how far a model is from the rig along its path: root mean square [N*m], and with one `offset` [N*m] added.

    Both are over the position, leg by leg, as an eye compares them.
    """
    left = []
    for leg in range(rig.turns.size):
        x, torque = rig.leg(leg)
        at, modelled = model.leg(leg)
        side = 1 if at[-1] > at[0] else -1
        left.append(torque - np.interp(side * x, side * at, modelled))
    difference = np.concatenate(left)
    offset = float(np.mean(difference))
    largest = float(np.max(np.abs(rig.torque)))
    return {
        "as_it_is": float(np.sqrt(np.mean(difference**2))) / largest,
        "offset": offset,
        "with_offset": float(np.std(difference)) / largest,
    }


def _beside(apart: Mapping[str, dict[str, float]], name: str) -> str:
    difference = apart[name]
    return (
        f"Laid over what the torque sensor of the rig reads (figure 9), {name}: {percent(difference['as_it_is'])} of "
        f"the largest torque apart, root mean square; raised by {number(1e3 * difference['offset'], digits=2)} mN·m, "
        f"{percent(difference['with_offset'])}."
    )


def _table_beside(missing: Mapping[str, Missing], apart: Mapping[str, dict[str, float]]) -> Table:
    """Return what each model misses at the returns, and how far it is from the rig."""
    rows = [
        (
            name,
            *(number(100.0 * missing[name][letter], resolution=1.0) for letter in RETURNS),
            number(100.0 * difference["as_it_is"], resolution=1.0),
            number(1e3 * difference["offset"], resolution=1.0),
            number(100.0 * difference["with_offset"], resolution=1.0),
        )
        for name, difference in apart.items()
    ]
    heads = ("Model", "At D [%]", "At B [%]", "From the rig [%]", "Offset [mN·m]", "With it [%]")
    return Table("Models at the returns, and beside the rig (root mean square), of the largest torque", heads, rows)


def _draw(walks: Mapping[str, Walk], missing: Mapping[str, Missing], beneath: Mapping[str, Walk], names: tuple[str, str]):
    titles = {name: f"{name}: {closure_text(max(pair.values(), key=abs))}" for name, pair in missing.items()}
    return _drawn(walks, titles, beneath, names)


def _draw_raised(walks: Mapping[str, Walk], apart: Mapping[str, dict[str, float]], rig: Walk, names: tuple[str, str]):
    raised = {name: path._replace(torque=path.torque + apart[name]["offset"]) for name, path in walks.items()}
    titles = {name: f"{name}: {percent(difference['with_offset'])} apart" for name, difference in apart.items()}
    return _drawn(raised, titles, dict.fromkeys(walks, rig), names)


def _drawn(walks: Mapping[str, Walk], titles: Mapping[str, str], beneath: Mapping[str, Walk], names: tuple[str, str]):
    from bristle.figures import marked_path

    turns = {name: [0, *path.turns] for name, path in walks.items()}
    return marked_path(traces(walks), turns, LETTERS, titles, "translational", "rotational", traces(beneath), names)
