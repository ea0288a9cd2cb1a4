"""Figures of a notebook: the channels of a log, the loop of a model, and the following error at the worst reversal."""

from itertools import pairwise

import numpy as np
from matplotlib.figure import Figure

from bristle.core import Model
from bristle.engine import response
from bristle.figures import style
from bristle.figures.following_error import draw_worst_reversal
from bristle.figures.small_multiples import minor_loops
from bristle.logs import Log
from bristle.simulation import SimulationResult

WINDOW = 5e-3  # [s] of the position from which a velocity is derived
TURNS = (0.0, 1.0, -1.0, 0.3, -0.6, 1.0)  # of a path of nested loops
SLIDES, STEPS = (0.0, 1.0, -1.0, 1.0), 400  # of a path of long slides; steps between two turns


@style.styled
def log_over_time(log: Log) -> Figure:
    """Return position, velocity and effort of a log over time, a panel each; a velocity that was not recorded is derived."""
    kind, time = log.kind, log.time.values
    velocity = _velocity(log) if log.velocity is None else log.velocity.values
    signals = [(log.position.values, "length", style.position_word(kind)), (velocity, "length/time", "Velocity")]
    signals += [] if log.effort is None else [(log.effort.values, "force", style.effort_word(kind))]
    figure, rows = style.panels(0.3 + style.ROW * len(signals), rows=len(signals))
    for (axes,), (values, quantity, word) in zip(rows, signals, strict=True):
        scale = style.scale_for(quantity, kind, values)
        style.over_time(axes, time, (values, style.PREDICTED, "_"), scale=scale, word=word)
    if log.velocity is None:
        rows[1][0].set_title("derived from the position")
    return figure


def _velocity(log: Log) -> np.ndarray:
    """Return the velocity as the slope of the position over a window, within each segment."""
    velocity, reach = np.full(len(log), np.nan), max(round(0.5 * WINDOW / log.sample_time), 1)
    for segment in log.segments:
        position = log.position.values[segment]
        ends = [np.clip(np.arange(position.size) + side * reach, 0, position.size - 1) for side in (-1, 1)]
        span = log.sample_time * np.maximum(ends[1] - ends[0], 1)
        velocity[segment] = (position[ends[1]] - position[ends[0]]) / span
    return velocity


def loop(friction: Model, distance: float) -> Figure:
    """Return force over position along nested reversals within the pre-sliding `distance` [m or rad], and along long slides."""
    speed = next((value for name, value in friction.values.items() if name.startswith("v_S")), None)
    paths = {"pre-sliding": (TURNS, distance, distance)} if distance > 0.0 else {}
    if speed is not None or not paths:
        fastest = 3.0 * (speed or 1.0 / 30.0)  # [m/s or rad/s]
        paths["sliding"] = (SLIDES, 50.0 * distance or 0.01, fastest)
    traces = {}
    for name, (turns, amplitude, fastest) in paths.items():
        part = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, STEPS + 1))
        x = amplitude * np.concatenate([start + (end - start) * part[:-1] for start, end in pairwise(turns)])
        traces[name] = x, response(friction, x, dt=float(np.max(np.abs(np.diff(x)))) / fastest)
    return minor_loops(traces, friction.kind)


@style.styled
def worst_reversal(simulation: SimulationResult, measured: np.ndarray | None) -> Figure:
    """Return the following error around its worst reversal: measured, of the first loop, and of the last loop."""
    figure, ((axes,),) = style.panels(2.7)
    draw_worst_reversal(axes, simulation, measured)
    style.legend(axes)
    return figure
