"""Lives of axes that wear, made by a stranger: when each log is recorded, how warm it is, and what friction does.

Nothing here is of the form that `bristle watch` takes for granted: friction falls exponentially with temperature, not
linearly; temperature has a season, weather and a day; the scatter of a day is shared by its logs, has heavy tails and
leans to one side; single logs are far off, some fail, some days have none; wear begins slowly and is not straight.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bristle.fleet.tracks import DAY, Rows

__all__ = ["Errors", "Life", "lived", "rows_of"]

START = 1_767_225_600.0  # [s]: the first of January 2026
HOURS = (6.5, 14.5)  # when the logs are recorded
SEASON, WEATHER, DAILY = 4.5, 1.5, 2.0  # [K]: together about +-8
LEVEL_PER_KELVIN, VISCOUS_PER_KELVIN = 0.004, 0.018
OF_DAY, OF_LOG = 0.008, 0.004  # scatter, as a share
FAR, FAR_OFF = 0.01, 0.06  # share of the logs that are far off, and how far
FAILS, SKIPPED = 0.03, 0.02  # share of logs and of days
FREEDOM = 5.0  # of the tails


@dataclass(frozen=True)
class Life:
    """What an axis goes through, log by log; arrays of shape (log,).

    Parameters
    ----------
    time : ndarray
        When each log is recorded [s since 1970].
    temperature : ndarray
        Mean temperature of each [K].
    level, viscous : ndarray
        Coulomb and viscous friction, over what they are at first.
    wear : ndarray
        By how much the level has changed for good, as a share.
    fails : ndarray of bool
        Whether a log is of no use.
    """

    time: np.ndarray
    temperature: np.ndarray
    level: np.ndarray
    viscous: np.ndarray
    wear: np.ndarray
    fails: np.ndarray


def lived(seed: int, days: int, *, onset: float | None = None, wear: float = 0.1, over: float = 200.0) -> Life:
    """Return a life.

    Parameters
    ----------
    seed
        Decides everything else.
    days
        How long it lasts.
    onset
        Day on which wear begins; None for an axis that stays healthy.
    wear
        Change of the level [1] after `over` days, up for an even seed and down for an odd one.
    over
        In how many days.
    """
    rng = np.random.default_rng((seed, 2026))
    used = [day for day in range(days) if rng.random() >= SKIPPED]
    day = np.repeat(used, len(HOURS)).astype(float)
    hour = np.tile(HOURS, len(used)) + rng.normal(0.0, 0.3, day.size)
    weather = np.zeros(days)
    for later in range(1, days):
        weather[later] = 0.8 * weather[later - 1] + 0.6 * rng.standard_normal()
    season = np.cos(2.0 * np.pi * (day / 365.0 + rng.random()))
    warmth = SEASON * season + WEATHER * weather[day.astype(int)] + DAILY * np.sin(2.0 * np.pi * (hour - 9.0) / 24.0)
    age = np.clip((day + hour / 24.0 - onset) / over, 0.0, None) if onset is not None else np.zeros(day.size)
    lasting = wear * (1.0 if seed % 2 == 0 else -1.0) * age**1.1
    shared = np.repeat(_strange(rng, len(used)), len(HOURS))
    single = rng.standard_normal(day.size)
    far = np.where(rng.random(day.size) < FAR, FAR_OFF * rng.choice((-1.0, 1.0), day.size), 0.0)
    level = np.exp(-LEVEL_PER_KELVIN * warmth) * (1.0 + lasting) * (1.0 + OF_DAY * shared + OF_LOG * single + far)
    viscous = np.exp(-VISCOUS_PER_KELVIN * warmth) * (1.0 + 2.0 * OF_DAY * np.roll(shared, 2) + 2.0 * OF_LOG * single)
    return Life(START + DAY * day + 3600.0 * hour, 293.15 + warmth, level, viscous, lasting, rng.random(day.size) < FAILS)


def _strange(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return numbers of mean zero and variance one with heavy tails that lean to one side."""
    tails = rng.standard_t(FREEDOM, count) * np.sqrt((FREEDOM - 2.0) / FREEDOM)
    leaning = (rng.gamma(4.0, 1.0, count) - 4.0) / 2.0
    return np.sqrt(0.5) * (tails + leaning)


@dataclass(frozen=True)
class Errors:
    """What identifications of logs were off by and what they said of it; arrays of shape (log,), by column.

    `error` is value over truth less one, `half` the half-width of the 95 % interval over the truth; of the scatter,
    `value` is what was found, as its truth is not one number.
    """

    error: dict[str, np.ndarray]
    half: dict[str, np.ndarray]
    scatter: np.ndarray
    scatter_ends: np.ndarray

    @property
    def count(self) -> int:
        """From how many logs they come."""
        return self.scatter.size


def rows_of(lives: dict[str, Life], errors: Errors, seed: int) -> Rows:
    """Return the rows that a fleet would hold of these lives, each log with the errors of an identification drawn."""
    rng = np.random.default_rng((seed, 7))
    parts = {name: _columns(name, life, errors, rng) for name, life in lives.items()}
    columns = {key: np.concatenate([part[key] for part in parts.values()]) for key in next(iter(parts.values()))}
    order = np.argsort(columns["time"], kind="stable")
    columns = {key: values[order] for key, values in columns.items()}
    described = {
        name: {"role": "parameter", "unit": unit, "stands_for": stands}
        for name, unit, stands in (("friction.F_C", "N", "level"), ("friction.F_v", "N*s/m", "viscous"), ("scatter", "", "scatter"))
    }
    axis = tuple(columns.pop("axis").tolist())
    return Rows(axis, tuple(map(str, range(len(axis)))), columns.pop("time"), columns, described)


def _columns(name: str, life: Life, errors: Errors, rng: np.random.Generator) -> dict[str, np.ndarray]:
    drawn = rng.integers(errors.count, size=life.time.size)
    columns = {
        "axis": np.full(life.time.size, name),
        "time": life.time,
        "temperature": life.temperature,
        "status": np.where(life.fails, "refused", "ok"),
        "reason": np.where(life.fails, "is truncated", ""),
    }
    for column, truth, size in (("friction.F_C", life.level, 10.0), ("friction.F_v", life.viscous, 60.0)):
        value, half = size * truth * (1.0 + errors.error[column][drawn]), size * truth * errors.half[column][drawn]
        for key, values in (("", value), (".lower", value - half), (".upper", value + half)):
            columns[column + key] = np.where(life.fails, np.nan, values)
        columns[f"{column}.status"] = np.where(life.fails, "", "identified")
    for key, values in (("", errors.scatter), (".lower", errors.scatter_ends[:, 0]), (".upper", errors.scatter_ends[:, 1])):
        columns[f"scatter{key}"] = np.where(life.fails, np.nan, values[drawn])
    return columns
