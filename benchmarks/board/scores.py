"""Scores of the answers of a competitor, with 95 % intervals by a bootstrap over blocks of the record."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from benchmarks.board.child import NOT_FINITE, Fault
from benchmarks.board.loop import following_error
from benchmarks.board.record import Data, Record, smoothed
from bristle.core import Model

BLOCKS, DRAWS = 20, 1000  # blocks of a record, draws of a bootstrap
AROUND = 0.1  # [s] before and after a reversal
SLOW = 0.02  # of the largest speed: slower samples have no direction
OK = "ok"


class Score(NamedTuple):
    """A score with its interval, or the reason of a missing score."""

    value: float = np.nan
    lower: float = np.nan
    upper: float = np.nan
    status: str = OK
    reason: str = ""


ANSWER_OF = {
    "force": "predict",
    "reversals": "predict",
    "loop": "loop",
    "parameters": "parameters",
    "compensation": "feedforward",
}


def scored(
    scores: Sequence[str], answers: Mapping[str, Any], data: Data, seed: int
) -> dict[str, Score]:
    """Return the scores of the answers of a competitor."""
    results = {}
    for name in scores:
        answer = answers[ANSWER_OF[name]]
        if isinstance(answer, Fault):
            results[name] = Score(status=answer.status, reason=answer.reason)
        else:
            score = SCORING[name](answer, data, np.random.default_rng(seed))
            results[name] = (
                score
                if np.isfinite(score.value)
                else Score(status=NOT_FINITE, reason="the loop diverges")
            )
    return results


def _force(answer: Sequence[np.ndarray], data: Data, rng: np.random.Generator) -> Score:
    """Score predicted efforts, both filtered alike; an arm by the mean of its joints."""
    pairs = [_pair(record, effort) for record, effort in zip(data.test, answer, strict=True)]
    return _ratio([sums for record, error, effort in pairs for sums in _blocks(error, effort)], rng)


def _reversals(answer: Sequence[np.ndarray], data: Data, rng: np.random.Generator) -> Score:
    """Score predicted efforts near reversals, against the rms effort of the whole records."""
    windows, power = [], []
    for record, predicted in zip(data.test, answer, strict=True):
        _, error, effort = _pair(record, predicted)
        power.append(np.mean(effort**2))
        half = max(round(AROUND / record.sample_time), 1)
        for sample in reversals_of(record) - record.edge:
            part = error[max(sample - half, 0) : max(sample + half + 1, 0)]
            if part.size:
                windows.append(
                    (np.sum(part**2, axis=0), np.full(part.shape[1:], float(part.shape[0])))
                )
    return _ratio([(error, count * np.mean(power)) for error, count in windows], rng)


def reversals_of(record: Record) -> np.ndarray:
    """Return the samples at which a motion begins to move in the other direction."""
    moving = np.flatnonzero(np.abs(record.velocity) > SLOW * np.max(np.abs(record.velocity)))
    directions = np.sign(record.velocity[moving])
    return moving[1:][np.diff(directions) != 0.0]


def _loop(answer: np.ndarray, data: Data, rng: np.random.Generator) -> Score:
    """Score a predicted following error against the part that a mass without friction does not show."""
    reference = data.reference
    assert reference is not None
    assert data.followed is not None
    inner = slice(reference.edge, -reference.edge)
    free = following_error(
        lambda motion: data.loop_mass * motion.acceleration, reference, data.loop_mass
    )
    return _ratio(_blocks((answer - data.followed)[inner], (free - data.followed)[inner]), rng)


def _parameters(answer: Mapping[str, float], data: Data, rng: np.random.Generator) -> Score:
    errors = [
        min(abs(answer.get(name, np.inf) / value - 1.0), 1.0) for name, value in data.truth.items()
    ]
    return Score(100.0 * float(np.mean([error if np.isfinite(error) else 1.0 for error in errors])))


def _compensation(
    answer: tuple[Model | None, np.ndarray | None], data: Data, rng: np.random.Generator
) -> Score:
    assert data.left is not None
    return Score(100.0 * data.left(*answer))


SCORING: dict[str, Callable[[Any, Data, np.random.Generator], Score]] = {
    "force": _force,
    "reversals": _reversals,
    "loop": _loop,
    "parameters": _parameters,
    "compensation": _compensation,
}


def _pair(record: Record, predicted: np.ndarray) -> tuple[Record, np.ndarray, np.ndarray]:
    """Return the error and the measured effort of a record, filtered, without its ends."""
    assert record.effort is not None
    measured, error = (
        smoothed(signal, record.sample_time, record.axis)
        for signal in (record.effort, predicted - record.effort)
    )
    inner = slice(record.edge, -record.edge)
    return record, error[inner], measured[inner]


def _blocks(error: np.ndarray, signal: np.ndarray) -> list[tuple[Any, Any]]:
    """Return the sums of squares of an error and its signal by block."""
    parts = (np.array_split(values**2, BLOCKS) for values in (error, signal))
    return [
        (np.sum(left, axis=0), np.sum(right, axis=0)) for left, right in zip(*parts, strict=True)
    ]


def _ratio(sums: Sequence[tuple[Any, Any]], rng: np.random.Generator) -> Score:
    """Return the relative error over blocks [%] with its interval; of an arm the mean over joints."""
    if not sums:
        return Score()
    error, signal = (
        np.array(side, dtype=float).reshape(len(sums), -1) for side in zip(*sums, strict=True)
    )
    drawn = rng.integers(len(sums), size=(DRAWS, len(sums)))
    draws = 100.0 * np.mean(np.sqrt(error[drawn].sum(axis=1) / signal[drawn].sum(axis=1)), axis=1)
    value = 100.0 * float(np.mean(np.sqrt(error.sum(axis=0) / signal.sum(axis=0))))
    return Score(value, *_ends(draws))


def over_cases(values: Sequence[float], seed: int) -> Score:
    """Return the mean of a score over axes, with the interval of a bootstrap over these axes."""
    numbers = np.array(values, dtype=float)
    drawn = np.random.default_rng(seed).integers(numbers.size, size=(DRAWS, numbers.size))
    return Score(float(np.mean(numbers)), *_ends(np.mean(numbers[drawn], axis=1)))


def _ends(draws: np.ndarray) -> tuple[float, float]:
    lower, upper = np.percentile(draws, [2.5, 97.5])
    return float(lower), float(upper)
