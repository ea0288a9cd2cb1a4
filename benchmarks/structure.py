"""Is a wrong structure told, and a right one left alone? On logs of axes that another hand simulated.

The axes, their friction, loops and motions are those of `benchmarks.strangers`. Their channels are clean of filters,
lost rows and jitter, their motors of ripple and cogging, and both directions are alike: what is wrong is the structure
alone. Wrong are friction that lags 20 ms behind the speed, 10 % of ripple over the position, friction that rises with
the root of the speed or falls with another exponent, and play of some tenths of a millimetre at the screw.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from typing import NamedTuple

import numpy as np

import bristle as br
from benchmarks.coverage import Share
from benchmarks.strange_logs import MODELS, STROKES, table_of
from benchmarks.strangers import Run, Truth, draw, record_of, simulate
from benchmarks.strangers.recording import low_pass
from bristle.core.cores import core_count
from bristle.core.errors import InputError

__all__ = ["Tried", "lacking", "structures", "tried", "truth_of"]

FIRST, RIGHT, WRONG = 2000, {"lugre": 70, "coulomb": 30}, 12
KINDS = ("lag", "ripple", "root_viscous", "stribeck_half", "play")
TOLD = ("structure", "unexplained")
"""Codes that report a model that is not that of the axis."""
LAG = 0.02  # [s]
PLAY = 10.0  # times the play that is drawn
SHOWS = 0.01  # of friction: a missing force that matters
SMOOTH = 0.01  # [s]
# Of the largest speed, over which a law of the right structure may fall.
FALLS = np.geomspace(2e-3, 1.0, 24)


class Tried(NamedTuple):
    """What is said of the structure of one log, the share of friction that the law of a fit lacks; or why it failed."""

    told: tuple[str, ...]
    lacking: float
    refused: str = ""


def truth_of(kind: str, seed: int) -> Truth:
    """Return an axis of a kind, with nothing wrong but its structure."""
    truth = draw(seed, "backlash" if kind == "play" else kind, STROKES[seed % len(STROKES)])
    friction, axis, recording = truth.friction, truth.axis, truth.recording
    alike = {name: (float(np.mean(getattr(friction, name))),) * 2 for name in ("F_C", "F_S", "F_v")}
    friction = replace(friction, **alike, lag=LAG if kind == "lag" else 0.0)
    axis = replace(axis, cogging=0.0, half_play=PLAY * axis.half_play)
    recording = replace(
        recording, every=1, lost=(), jitter=0.0, effort_filter=0.0, position_filter=0.0
    )
    motor = replace(truth.motor, ripple=0.0)
    return replace(truth, friction=friction, axis=axis, recording=recording, motor=motor)


def lacking(truth: Truth, run: Run) -> float:
    """Return the force that a law of the right structure lacks along a motion, as a share of friction (rms)."""
    f, v, dt = truth.friction, run.v, truth.recording.trace_period
    side, speed = np.where(v < 0.0, -1.0, 1.0), np.abs(v)
    lagged = low_pass(speed, f.lag, dt)
    dry = f.F_C[0] + (f.F_S[0] - f.F_C[0]) * np.exp(-((lagged / f.v_S) ** f.shape))
    force = (
        side
        * dry
        * (1.0 + f.ripple * np.sin(2.0 * np.pi * run.q / f.ripple_period + f.ripple_phase))
    )
    force += f.F_v[0] * v + f.F_root * v / np.sqrt(speed + f.root_floor)
    if truth.axis.half_play > 0.0:
        turns = np.flatnonzero(np.diff(side, prepend=side[0]))
        first = np.concatenate([[0], turns])
        way = np.abs(
            run.q - run.q[first[np.searchsorted(first, np.arange(v.size), side="right") - 1]]
        )
        force = np.where(
            way < 2.0 * truth.axis.half_play, (1.0 - truth.axis.load_share) * force, force
        )
    every = max(round(SMOOTH / dt), 1)
    rows = v.size // every * every

    def smooth(signal: np.ndarray) -> np.ndarray:
        return signal[:rows].reshape(rows // every, every).mean(axis=1)

    force, law = smooth(force), [smooth(signal) for signal in (side, v, np.ones_like(v))]
    left = []
    for fall in FALLS:
        columns = np.column_stack(
            [*law, smooth(side * np.exp(-((speed / (fall * speed.max())) ** 2)))]
        )
        left.append(force - columns @ np.linalg.lstsq(columns, force, rcond=None)[0])
    return float(np.sqrt(min(np.mean(one**2) for one in left) / np.mean(force**2)))


def tried(kind: str, seed: int) -> Tried:
    """Fit the model that a person would take to one log, and return what is said of its structure."""
    truth = truth_of(kind, seed)
    run = simulate(truth)
    axis = br.Axis(kind="translational" if truth.axis.linear else "rotational")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            table = table_of(truth, record_of(truth, run))
            found = br.identify(table, MODELS.get(kind, "lugre"), axis=axis, blocks=0, draws=0)
        except InputError as error:
            return Tried((), 0.0, str(error))
    codes = [one.code.replace("-", "_") for one in found.best.diagnostics]
    causes = [code for code in codes if code in TOLD or code.startswith("missing_")]
    return Tried(tuple(causes), lacking(truth, run))


def structures(first: int = FIRST) -> Iterator[Share]:
    """Yield how often a wrong structure is told, and how often a right one is."""
    kinds = dict.fromkeys(KINDS, WRONG) | RIGHT
    asked = [(kind, first + number) for kind, count in kinds.items() for number in range(count)]
    with ProcessPoolExecutor(core_count()) as pool:
        trials = dict(zip(asked, pool.map(tried, *zip(*asked, strict=True)), strict=True))
    for (kind, seed), one in trials.items():
        print(
            kind,
            seed,
            f"{100.0 * one.lacking:.2f} %",
            one.refused or ", ".join(one.told),
            file=sys.stderr,
        )
    read = {
        kind: [one for (of, _), one in trials.items() if of == kind and not one.refused]
        for kind in kinds
    }
    for kind in KINDS:
        yield _share(f"{kind}, reported", read[kind])
    wrong, right = ([one for kind in of for one in read[kind]] for of in (KINDS, RIGHT))
    yield _share("wrong structure, reported", wrong)
    yield _share(
        "wrong structure above 1 %, reported",
        [one for one in wrong if one.lacking > SHOWS],
        least=90.0,
    )
    yield _share("right structure, reported as wrong", right, most=5.0)


def _share(name: str, tried: list[Tried], least: float = 0.0, most: float = 100.0) -> Share:
    return Share(
        name, 100.0 * float(np.mean([bool(one.told) for one in tried])), least, most, len(tried)
    )
