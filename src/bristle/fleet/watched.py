"""`watch`: the axes of fleets over time: which of them changed, since when, by how much, at a stated rate of errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.special import stdtrit

from bristle.core.errors import InputError
from bristle.core.least_squares import unbounded
from bristle.fleet.change import COURSES, LevelChange, course_of_change, largest_ratios
from bristle.fleet.false_alarms import FalseAlarms, false_alarms_from, threshold_for
from bristle.fleet.innovations import Innovations
from bristle.fleet.tracks import Rows, Track, rows_in, tracks_of

__all__ = ["Alarm", "Verdict", "Watched", "verdict_on", "watch"]

USUAL = "1 in 1000 days"
ALIKE = 3.0  # standard deviations, from which on neighbouring innovations are told to be alike
WIDER = 3.84  # twice the fall of the log-likelihood within which the onset lies at 95 %
BASELINE = 10  # observations before which no alarm is raised: what came first is only then a level


@dataclass(frozen=True)
class Alarm:
    """A change of a quantity, told."""

    at: float
    onset: float
    onset_interval: tuple[float, float]
    course: str
    change: float
    change_interval: tuple[float, float]
    before: float

    @property
    def change_percent(self) -> float:
        """The change in percent of the level before."""
        return 100.0 * self.change / abs(self.before)


@dataclass(frozen=True)
class Verdict:
    """A track with what is said of it.

    Parameters
    ----------
    track : Track
        The track.
    level : ndarray, shape (observation,)
        The values with the temperature taken off, as at its mean.
    fitted : ndarray, shape (observation,)
        The level that goes with it, with the change where there is one.
    ratio : ndarray, shape (observation,)
        Largest likelihood ratio of a change, as it stood at each observation [standard deviations].
    threshold : float
        From which on it is an alarm.
    alarm : Alarm or None
        The change; None where there is none.
    temperature_coefficient, temperature_interval : float, tuple of float or None
        By how much the value changes with temperature [unit/K], with its 95 % interval, fitted together with the
        change; None without temperatures.
    alike : float or None
        Correlation of neighbouring innovations, where it is told from zero: false alarms are then more frequent.
    """

    track: Track
    level: np.ndarray
    fitted: np.ndarray
    ratio: np.ndarray
    threshold: float
    alarm: Alarm | None
    temperature_coefficient: float | None
    temperature_interval: tuple[float, float] | None
    alike: float | None


@dataclass(frozen=True)
class Watched:
    """What the watch over fleets says."""

    rows: Rows
    verdicts: tuple[Verdict, ...]
    false_alarms: FalseAlarms

    @property
    def alarms(self) -> tuple[Verdict, ...]:
        """Those that changed, the earliest alarm first."""
        changed = [verdict for verdict in self.verdicts if verdict.alarm is not None]
        return tuple(sorted(changed, key=lambda verdict: verdict.alarm.at if verdict.alarm else 0.0))


def watch(
    folders: str | Path | Sequence[str | Path],
    *,
    axis_from: str | None = None,
    quantities: Sequence[str] = (),
    false_alarms: str = USUAL,
    since: float | None = None,
) -> Watched:
    """Watch the axes of fleets: which changed, since when and by how much.

    Parameters
    ----------
    folders : path-like or sequence of path-like
        Folders that `bristle.fleet.identify_each` wrote, or folders that hold such.
    axis_from : str, optional
        Regular expression with a group ``axis``, and ``date`` where a log has one, looked for in ``FOLDER/LOG``; the
        folder of a log is its axis where not given.
    quantities : sequence of str
        Columns to watch; levels and viscous parts of friction, and the scatter of the level, where none is named.
    false_alarms : str
        How often a healthy axis may alarm, over all of its quantities: ``"1 in 1000 days"``, ``"1 in 500 logs"``.
    since : float, optional
        Logs from before are left out [s since 1970].

    Returns
    -------
    Watched
        A verdict for each quantity of each axis.

    Raises
    ------
    InputError
        If a folder is none of a fleet, a rate in days is asked for and logs do not say when they were recorded, or no
        axis has enough logs.
    """
    rate = false_alarms_from(false_alarms)
    listed = [folders] if isinstance(folders, (str, Path)) else list(folders)
    rows = rows_in(listed, axis_from=axis_from)
    if rows.time is None and rate.unit == "days":
        raise InputError(
            "is in days, and not every log says when it was recorded",
            path="--false-alarms",
            value=false_alarms,
            allowed='"1 in 2000 logs"',
            mend="Name the date with --axis-from, or the rate in logs",
        )
    tracks = tracks_of(rows, quantities, since=since)
    if not tracks:
        raise InputError("no axis has enough logs that tell what is watched", path=str(listed[0]), mend="Five days, or logs, are the least")
    counts = {track.axis: sum(track.axis == own.axis for own in tracks) for track in tracks}
    return Watched(rows, tuple(verdict_on(track, rate, counts[track.axis]) for track in tracks), rate)


def verdict_on(track: Track, rate: FalseAlarms, quantities: int = 1) -> Verdict:
    """Return what a track says."""
    count = track.time.size
    days = float(track.time[-1] - track.time[0]) / (count - 1) if track.is_dated else None
    threshold = threshold_for(rate.per_observation(days, quantities))
    design, variances = _design(track), _variances(track)
    innovations = Innovations(design, variances)
    scores = innovations.scores(track.value)
    ratio = largest_ratios(innovations, track.time, scores)
    over = np.flatnonzero((ratio >= threshold) & (np.arange(count) >= BASELINE))
    at = int(over[0]) if over.size else None
    costs = {} if at is None else _costs(track, design, variances, at)
    fitted = _Fitted.of(track, design, variances, min(costs, key=costs.__getitem__, default=None))
    return Verdict(
        track,
        track.value - fitted.by_temperature,
        fitted.level,
        ratio,
        threshold,
        None if at is None else _alarm(track, at, costs, fitted),
        *fitted.temperature(track),
        _alike(scores if at is None else scores[:at]),
    )


def _design(track: Track) -> np.ndarray:
    constant = np.ones(track.time.size)
    if track.temperature is None:
        return constant[:, None]
    return np.column_stack([constant, (track.temperature - _reference(track)) / _spread(track)])


def _reference(track: Track) -> float:
    return 0.0 if track.temperature is None else float(np.mean(track.temperature))


def _spread(track: Track) -> float:
    return 1.0 if track.temperature is None else float(np.std(track.temperature))


def _variances(track: Track) -> np.ndarray:
    """Return relative variances: days with wider intervals than usual count less, none counts more."""
    return np.square(np.maximum(track.std / np.median(track.std), 1.0))


@dataclass(frozen=True)
class _Fitted:
    """Weighted least squares of a track: level, temperature, and a change where there is one, together."""

    coefficients: np.ndarray
    std: np.ndarray
    freedom: int
    cost: float
    by_temperature: np.ndarray
    level: np.ndarray

    @classmethod
    def of(cls, track: Track, design: np.ndarray, variances: np.ndarray, change: LevelChange | None) -> _Fitted:
        added = [] if change is None else [course_of_change(change, track.time)]
        matrix, weights = np.column_stack([design, *added]), 1.0 / np.sqrt(variances)
        rows, right = matrix * weights[:, None], track.value * weights
        coefficients = unbounded(rows, right)
        cost = float(np.sum(np.square(right - rows @ coefficients)))
        freedom = max(rows.shape[0] - rows.shape[1], 1)
        covariance = np.linalg.pinv(rows.T @ rows) * cost / freedom
        by_temperature = design[:, 1:] @ coefficients[1 : design.shape[1]]
        level = matrix @ coefficients - by_temperature
        return cls(coefficients, np.sqrt(np.diag(covariance)), freedom, cost, by_temperature, level)

    def interval(self, place: int) -> tuple[float, float]:
        """Return the 95 % interval of a coefficient, by Student."""
        half = float(stdtrit(self.freedom, 0.975) * self.std[place])
        return float(self.coefficients[place]) - half, float(self.coefficients[place]) + half

    def temperature(self, track: Track) -> tuple[float | None, tuple[float, float] | None]:
        """Return the temperature coefficient in the unit of the track over K, with its interval."""
        if track.temperature is None:
            return None, None
        low, high = self.interval(1)
        return float(self.coefficients[1]) / _spread(track), (low / _spread(track), high / _spread(track))


def _costs(track: Track, design: np.ndarray, variances: np.ndarray, at: int) -> dict[LevelChange, float]:
    """Return the sum of squares with each change that may have begun until the alarm."""
    changes = [LevelChange(onset, course) for course in COURSES for onset in range(1, at + 1)]
    return {change: _Fitted.of(track, design, variances, change).cost for change in changes}


def _alarm(track: Track, at: int, costs: Mapping[LevelChange, float], fitted: _Fitted) -> Alarm:
    change = min(costs, key=costs.__getitem__)
    most = fitted.cost * (1.0 + WIDER / fitted.freedom)
    onsets = [track.time[candidate.onset] for candidate, cost in costs.items() if cost <= most and candidate.course == change.course]
    grown = float(course_of_change(change, track.time)[-1])
    low, high = sorted(end * grown for end in fitted.interval(-1))
    size, before = float(fitted.coefficients[-1]) * grown, float(fitted.coefficients[0])
    if track.is_logarithmic:
        size, low, high, before = (*(np.exp(before) * np.expm1([size, low, high])).tolist(), float(np.exp(before)))
    return Alarm(
        float(track.time[at]),
        float(track.time[change.onset]),
        (float(min(onsets)), float(max(onsets))),
        change.course,
        size,
        (low, high),
        before,
    )


def _alike(scores: np.ndarray) -> float | None:
    """Return the correlation of neighbouring innovations where it is told from zero; None else."""
    scored = scores[np.flatnonzero(scores)[0] :] if np.any(scores) else scores
    if scored.size < BASELINE:
        return None
    correlation = float(np.sum(scored[1:] * scored[:-1]) / np.sum(np.square(scored)))
    return correlation if correlation * np.sqrt(scored.size) > ALIKE else None
