"""The simulated axis: its components, and its logs in the form of a real drive."""

import io
from importlib.resources import files
from pathlib import Path

import numpy as np

from bristle.cli.demonstration import truth
from bristle.core import Axis, Model, Status
from bristle.engine import run_closed_loop
from bristle.files import read_axis, write_whole
from bristle.models.plants import inertia
from bristle.models.sensors import encoder

AXIS_FILE = Path(str(files("bristle.cli.demonstration") / "axis.toml"))
SAMPLE_TIME = 1e-3


def axis() -> Axis:
    """Return the axis of the axis file."""
    return read_axis(AXIS_FILE)


def plant() -> Model:
    """Return the moving mass of the simulated axis."""
    return inertia(M=28.0)


def friction() -> Model:
    """Return the friction of the simulated axis: thirty elements that slip in sequence."""
    return truth.MODEL(**truth.MODEL.example)


def motion(seed: int, duration: float = 24.0) -> np.ndarray:
    """Return a production-like motion: moves of random length and speed, with pauses, position [m] at each sample."""
    generator = np.random.default_rng(seed)
    pieces = [np.zeros(200)]
    position = 0.0
    while sum(piece.size for piece in pieces) < duration / SAMPLE_TIME:
        target = float(
            np.clip(
                position + generator.choice((-1, 1)) * 10 ** generator.uniform(-3.0, -0.8),
                -0.15,
                0.15,
            )
        )
        speed = 10 ** generator.uniform(-2.3, -0.6)
        pieces += [
            _move(position, target, speed, acceleration=2.0),
            np.full(int(generator.integers(20, 120)), target),
        ]
        position = target
    return np.concatenate(pieces)[: round(duration / SAMPLE_TIME)]


def _move(start: float, end: float, speed: float, acceleration: float) -> np.ndarray:
    """Return a move of trapezoidal velocity whose corners are rounded over 20 ms."""
    distance = abs(end - start)
    speed = min(speed, np.sqrt(distance * acceleration))
    ramp = speed / acceleration
    duration = 0.0
    if speed > 0.0:
        duration = distance / speed + ramp
    t = SAMPLE_TIME * np.arange(round(duration / SAMPLE_TIME) + 41)
    if ramp > 0.0:
        velocity = np.clip(np.minimum(t / ramp, (duration - t) / ramp), 0.0, 1.0)
    else:
        velocity = np.zeros_like(t)
    smooth = np.convolve(velocity, np.full(20, 0.05))[: t.size]
    travelled = np.cumsum(smooth)
    if travelled[-1] > 0.0:
        share = travelled / travelled[-1]
    else:
        share = np.zeros_like(t)
    return start + (end - start) * share


def write_log(path: Path, seed: int) -> None:
    """Run the axis along a motion and write the log of its drive, as CSV."""
    described = axis()
    reference = motion(seed)
    velocity = np.gradient(reference, SAMPLE_TIME)
    desired = np.stack(
        (reference, velocity, np.gradient(velocity, SAMPLE_TIME), np.zeros_like(reference))
    )
    trace = run_closed_loop(
        plant(),
        friction(),
        described.controller,
        encoder(resolution=described.resolution or 0.0),
        desired,
        SAMPLE_TIME,
        steps=8,
        limit=described.effort_limit or np.inf,
    )
    if trace.status != Status.OK:
        raise RuntimeError(f"the simulation of the axis failed: {trace.status.sentence}")
    constant = 61.2
    generator = np.random.default_rng(seed + 1000)
    # With noise of 10 mA
    current = trace.command / constant + 0.01 * generator.standard_normal(trace.command.size)
    table = np.column_stack((trace.time, 1e3 * trace.measured, 1e3 * reference, current))
    header = "# simulated axis, not a measurement\ntime [s],position [mm],reference [mm],motor_current [A]"
    out = io.StringIO()
    np.savetxt(
        out, table, fmt=("%.3f", "%.4f", "%.6f", "%.5f"), delimiter=",", header=header, comments=""
    )
    write_whole(path, out.getvalue())
