"""Figures of an experiment: following error over time, close up and as a distribution; effort; all signals of an open loop."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from bristle.core import Kind, Scale, Status
from bristle.report.figures import style
from bristle.report.figures.drawing import label, shortened_apart
from bristle.report.figures.report_figure import shown
from bristle.simulation import SimulationResult, worst_reversal

MICROMETRE = np.array([1e-6])  # the smallest usual unit of servo errors
SHARES = (0.01, 0.1, 1.0, 10.0, 100.0)  # percent


class _Loop(NamedTuple):
    """A variant after its settling time."""

    variant: str
    look: style.Look
    time: np.ndarray
    reference: np.ndarray
    error: np.ndarray
    effort: np.ndarray
    word: str
    is_measured: bool = False

    @property
    def name(self) -> str:
        """The name for the legend."""
        return label(self.variant)

    def between(self, begin: float, end: float) -> _Loop:
        """Return the loop between two times [s]."""
        inside = (self.time >= begin) & (self.time <= end)
        return self._replace(**{name: getattr(self, name)[inside] for name in self._fields[2:-2]})


@shown(
    "following",
    ("simulation", "focus"),
    "Following error and effort of each variant over time",
    lambda simulation, focus, following: (
        f"{_difference(simulation)}{', measured and simulated' if following is not None else ''}: over time, as a "
        "distribution, and close up at a reversal (shaded above). Spikes at reversals come from friction. "
        "An error that grows with the speed comes from lag of the position loop, or from viscous friction without feedforward. "
        "Below, the effort."
    ),
    draw=lambda draw, simulation, focus, following: draw(
        simulation, focus, None if following is None else following.error
    ),
    may_take=("following",),
    applies=lambda simulation, focus, following: has_completed(simulation),
)
def following_error(
    result: SimulationResult, focus: Sequence[str] = (), measured: np.ndarray | None = None
) -> Figure:
    """Return the following error of each variant, whole, close up and as a distribution, and the effort.

    Parameters
    ----------
    result : SimulationResult
        The simulated variants, at least one of them completed. A loop that diverged is left out, because it would flatten
        all others. So is the time before settling.
    focus : sequence of str, optional
        Names of the variants in the close-up, if others have errors so large that they would flatten them;
        all of them by default.
    measured : ndarray, shape (sample,), optional
        Following error of the axis along the same reference [m or rad], drawn under the simulated errors.
    """
    loops = loops_of(result, measured)
    simulated = [loop for loop in loops if not loop.is_measured]
    near = [loop for loop in simulated if loop.variant in focus]
    near = near if 0 < len(near) < len(simulated) else loops
    rows = 4 if len(near) == len(loops) else 5
    undivided = [row for row in range(rows) if row != rows - 3]
    figure, grid = style.panels(
        style.ROW * rows,
        rows=rows,
        columns=2,
        heights=(0.6, *(1.2,) * (rows - 2), 1.0),
        widths=(3.2, 1.0),
        undivided=undivided,
        between=0.2,
        names=[loop.name for loop in loops],
    )
    motion, *all_, full, close, effort = (row[0] for row in grid)
    spread = grid[-3][1]
    kind, reference = result.experiment.kind, simulated[0].reference
    curve = reference, {"color": style.INK, "linewidth": 1.0}, "_"
    style.over_time(
        motion,
        simulated[0].time,
        curve,
        scale=style.scale_for("length", kind, reference),
        word=style.position_word(kind),
    )
    motion.set_title("reference")
    force, word = style.effort_scale(kind, *(loop.effort for loop in simulated))
    for loop in simulated:
        style.over_time(
            effort, loop.time, (loop.effort, loop.look, f"_{loop.name}"), scale=force, word=word
        )
    for axes in all_:
        _draw_errors(axes, loops, kind)
    scale = _draw_errors(full, near, kind)
    times = at_worst_reversal(near[0])
    _draw_errors(
        close,
        [part for part in (loop.between(times[0], times[-1]) for loop in near) if part.time.size],
        kind,
    )
    style.mark_window(full, times * style.time_scale(near[0].time).factor)
    close.set_title("close up, at a reversal of the reference")
    # The share of samples in bins common to all.
    errors = np.concatenate([loop.error for loop in near]) * scale.factor
    low, high = float(errors.min()), float(errors.max())
    edges = np.linspace(low, high if high > low else low + 1.0, 80 + 1)
    for loop in near:
        spread.stairs(
            style.shares(loop.error * scale.factor, edges),
            edges,
            orientation="horizontal",
            label=f"_{loop.name}",
            **loop.look,
        )
    # A loop rests or slides most of the time: only a logarithmic scale shows its rare large errors too.
    spread.set(xscale="log", xlim=(SHARES[0], SHARES[-1]), xlabel="Share [%]", ylim=full.get_ylim())
    spread.set_xticks(SHARES, [f"{share:g}" for share in SHARES])
    spread.xaxis.set_minor_locator(NullLocator())
    spread.tick_params(labelleft=False)
    style.legend((all_ or [full])[0])
    if all_:
        style.title(full, " and ".join(loop.name for loop in near) + " only")
    return figure


def _difference(result: SimulationResult) -> str:
    at_load = any(variant.at_load for variant in result.variants.values())
    return (
        "Desired minus true position of the load" if at_load else "Reference minus encoder reading"
    )


def _draw_errors(axes: style.Axes, loops: list[_Loop], kind: Kind) -> Scale:
    scale = style.scale_for("length", kind, *(loop.error for loop in loops), MICROMETRE)
    for loop in loops:
        style.over_time(
            axes, loop.time, (loop.error, loop.look, loop.name), scale=scale, word=loop.word
        )
    return scale


def at_worst_reversal(loop: _Loop) -> np.ndarray:
    """Return the times around a reversal of the reference, that with the widest swing of the error."""
    # If the reference never reverses, around the largest error.
    at = worst_reversal(loop.reference, loop.error)
    # Without a reversal
    return loop.time[style.window(loop.time, loop.error, 0.05) if at is None else at]


def has_completed(result: SimulationResult) -> bool:
    """Return whether there is a variant to draw, completed and longer than its settling time."""
    return bool(loops_of(result, None))


def loops_of(result: SimulationResult, measured: np.ndarray | None) -> list[_Loop]:
    """Return the variants that did not diverge, after their settling time; before them the measured following error."""
    loops: list[_Loop] = []
    for number, variant in enumerate(result.experiment.variants, 0 if measured is None else 1):
        outcome, part = (
            result.variants[variant.name],
            slice(round(variant.run.settle / variant.run.sample_time), None),
        )
        if outcome.status is Status.NOT_FINITE or not outcome.time[part].size:
            continue
        look = style.LINES[number % len(style.LINES)]
        if measured is not None and not loops:
            own = (outcome.time[part], outcome.reference[part], measured[: outcome.time.size][part])
            loops.append(
                _Loop(
                    "measured",
                    style.MEASURED,
                    *own,
                    np.zeros_like(own[2]),
                    outcome.error_word,
                    is_measured=True,
                )
            )
        time, reference, error, effort = (
            signal[part]
            for signal in (outcome.time, outcome.reference, outcome.error, outcome.effort)
        )
        loops.append(_Loop(variant.name, look, time, reference, error, effort, outcome.error_word))
    return loops


QUANTITIES = {
    "position": "length",
    "velocity": "length/time",
    "friction": "force",
    "effort": "force",
}


@shown(
    "motion",
    "open_loop",
    "Position, velocity, friction and effort of each variant over time",
    "While the velocity is zero and friction balances the effort, the axis sticks.",
    applies=has_completed,
)
def open_loop(result: SimulationResult) -> Figure:
    """Return position, velocity, friction and effort of each variant over time, one panel each."""
    variants = [
        variant for variant in result.variants.values() if variant.status is not Status.NOT_FINITE
    ]
    kind = result.experiment.kind
    force = style.effort_word(kind)
    words = (
        style.position_word(kind),
        "Velocity",
        f"Friction {force.lower()}",
        f"{force} of the drive",
    )
    names = shortened_apart([label(variant.name) for variant in variants], 1.2)
    figure, rows = style.panels(
        4.4, rows=2, columns=2, across=1.7 * style.WIDTH, right=style.room_for(names), top=0.12
    )
    for axes, word, (name, quantity) in zip(chain(*rows), words, QUANTITIES.items(), strict=True):
        scale = style.scale_for(quantity, kind, *(getattr(variant, name) for variant in variants))
        for number, variant in enumerate(variants):
            signal = (getattr(variant, name), style.LINES[number % len(style.LINES)], names[number])
            style.over_time(axes, variant.time, signal, scale=scale, word=word)
    if len(variants) > 1:
        style.label_lines(rows[0][1])
    return figure
