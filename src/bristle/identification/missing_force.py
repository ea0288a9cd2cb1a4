r"""Forces that a model has no place for, found in what its fit leaves over.

Each cause has a few columns: what friction would do with it, to first order. A cause is there where its columns,
fitted to most half-cycles, tell the residual of the others (cross-validation [1]_). Two things would hide it, and are
weighed first. Rows around reversals err by their sampling: what does not act there alone is looked for farther away,
and each band of distance from a reversal counts by what it leaves over. And friction has another level on each
half-cycle: with the share :math:`1 - \sqrt{v_k / (\tau^2 + v_k)}` of that level taken out, of a scatter :math:`\tau`
and an error :math:`v_k`, rows are as good as independent of it [2]_.

What the parameters of the model can take is no missing force, nor is what a wrong inertia, a delay or a filter of
a channel makes: their derivatives are fitted with each cause.

References
----------
.. [1] M. Stone, "Cross-validatory choice and assessment of statistical predictions", Journal of the Royal Statistical
   Society B 36(2), 1974. doi:10.1111/j.2517-6161.1974.tb00994.x
.. [2] W. A. Fuller, G. E. Battese, "Transformations for estimation of linear models with nested-error structure",
   Journal of the American Statistical Association 68(343), 1973. doi:10.1080/01621459.1973.10481414
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from bristle.core.least_squares import unbounded
from bristle.core.variable import KINDS
from bristle.friction.next_model import CHANNELS
from bristle.identification.half_cycles import Groups
from bristle.identification.missing_rows import FEWEST_ROWS, SMALLEST, Rows, Weighed
from bristle.identification.settings import Settings
from bristle.logs.waves import frequency_in, refined, waves

AS_GOOD = 1.05  # times what another cause leaves: gravity is what turns with an angle, before a parabola or a ripple
EVEN = 0.9  # of what a ripple tells, where it is alike in both directions, or not
OVERTONES = range(2, 7)  # of a ripple
FALLS = (0.01, 0.03, 0.1, 0.3, 1.0)  # of the largest speed, over which friction may fall
WAYS = tuple(np.geomspace(1e-4, 0.03, 6).tolist())  # of the range, over which a force may build up after a reversal
LAGS = (0.01, 0.04)  # [s]
LAG_FALLS = (0.003, 0.01, 0.03, 0.1)  # of the largest speed
ANYWHERE = ("speed", "direction", "position", "ripple", "gravity", *CHANNELS, "transmitted")
AROUND = ("lag", "play")  # Causes that act everywhere, and those that act around reversals
MOST_CAUSES, MOST_SEARCHES = 3, 5
TINY = 1e-9


class Missing(NamedTuple):
    """A force that the model lacks."""

    cause: str
    share: float
    force: float
    period: float = 0.0
    amplitude: float = 0.0
    alike: bool | None = None
    overtones: tuple[int, ...] = ()
    ratio: float = 0.0


def missing_forces(rows: Rows, settings: Settings) -> tuple[tuple[Missing, ...], float]:
    """Return the forces that a model lacks, the one that tells most first, and what is left without them [N or N*m].

    A cause counts from the shares of the weighted squares, of friction and of the effort that the settings name.
    """
    if not rows.enough:
        return (), 0.0
    missing, left = list[Missing](), 0.0
    if np.count_nonzero(rows.far) >= FEWEST_ROWS and (away := rows.at(rows.far)).enough:
        missing, left = _search(away, away.explained, ANYWHERE, settings.missing_share, settings)
    explained, causes = rows.explained, columns_by_cause(rows)
    for force in missing:
        columns = waves(rows.position, rows.side, 1.0 / force.period) if force.period else causes[force.cause]
        explained = np.column_stack([explained, columns])
    around, of_all = _search(rows, explained, AROUND, settings.missing_share_around, settings)
    return (*missing, *around), left if missing else of_all


def _search(rows: Rows, explained: np.ndarray, names: Sequence[str], least_share: float, settings: Settings) -> tuple[list[Missing], float]:
    """Return the causes of these names that tell something of rows, besides what is explained, and what is left."""
    friction, effort = float(np.sqrt(np.mean(rows.friction**2))), float(np.sqrt(np.mean(rows.effort**2)))
    least = max(settings.missing_force * friction, settings.missing_effort * effort)
    weighed, missing = Weighed.of(rows), list[Missing]()
    causes = {name: columns for name, columns in columns_by_cause(rows).items() if name in names}
    left = weighed.left(explained)
    for _ in range(MOST_SEARCHES):
        ripple, period = ripple_in(rows, weighed, explained, rows.cutoff) if "ripple" in names else (None, 0.0)
        tried = causes | ({} if ripple is None or any(force.period for force in missing) else {"ripple": ripple})
        forces = dict[str, Missing]()
        for name, columns in tried.items():
            force = force_of(weighed, name, columns, explained=explained, left=left)
            if force.share >= least_share and force.force >= least:
                forces[name] = force
        if not forces:
            break
        best, gravity = max(forces.values(), key=lambda force: force.share), forces.get("gravity")
        if gravity is not None and best.cause in ("position", "ripple"):
            # Gravity comes before a place or a ripple that, alike in both directions as its first columns are, tells no more.
            alike = force_of(weighed, best.cause, tried[best.cause][:, :2], explained=explained, left=left)
            best = gravity if 1.0 - gravity.share <= AS_GOOD * (1.0 - alike.share) else best
        if best.cause == "ripple":
            error = _encoder_error(rows, period)
            if force_of(weighed, "ripple", error, explained=explained, left=left).share > best.share:
                explained = np.column_stack([explained, tried["ripple"], error])
                left = weighed.left(explained)
                continue
            best = _in_detail(best._replace(period=period), rows, weighed, explained, left, least)
        missing.append(best)
        explained = np.column_stack([explained, tried[best.cause]])
        causes.pop(best.cause, None)
        left = weighed.left(explained)
        if len(missing) == MOST_CAUSES:
            break
    return missing, float(np.sqrt(np.mean(left**2)))


def ripple_in(rows: Rows, weighed: Weighed, explained: np.ndarray, fastest: float) -> tuple[np.ndarray | None, float]:
    """Return the waves over the position that take most of what is left, added to friction and in proportion to it.

    At the usual speed no faster ones than `fastest` [Hz] are looked for.
    """
    x, side = rows.position, rows.side
    most = float(np.ptp(x)) * fastest / float(np.median(np.abs(rows.velocity)))
    residual = weighed.without(explained)
    frequency = frequency_in(x, side, residual, most)
    frequency = None if frequency is None else refined(x, side, residual, frequency)
    return (None, 0.0) if frequency is None else (waves(x, side, frequency), 1.0 / frequency)


def _encoder_error(rows: Rows, period: float) -> np.ndarray:
    """Return what an error of the position of such a period does to the acceleration: it grows with the square of the speed."""
    return waves(rows.position, None, 1.0 / period) * (rows.velocity**2 / np.mean(rows.velocity**2))[:, None]


def force_of(weighed: Weighed, cause: str, columns: np.ndarray, *, explained: np.ndarray, left: np.ndarray) -> Missing:
    """Return the force that a model lacks by a cause, fitted beside what is explained.

    `left` is what that leaves of each part, fitted to the others.
    """
    after, force, coefficients = weighed.with_columns(explained, columns)
    share = 1.0 - float(after @ after) / max(float(left @ left), SMALLEST)
    amplitude = float(np.hypot(*coefficients)) if cause == "gravity" else 0.0
    return Missing(cause, share, float(np.sqrt(np.mean(force**2))), amplitude=amplitude)


def _in_detail(ripple: Missing, rows: Rows, weighed: Weighed, explained: np.ndarray, left: np.ndarray, least: float) -> Missing:
    """Return a ripple with whether it is alike in both directions, and how often in its period it comes back."""
    columns = waves(rows.position, rows.side, 1.0 / ripple.period)
    even, odd = (
        force_of(weighed, "ripple", part, explained=explained, left=left).share >= EVEN * ripple.share
        for part in (columns[:, :2], columns[:, 2:])
    )
    if not even or odd:
        return ripple._replace(alike=False if odd and not even else None)
    overtones, explained = [1], np.column_stack([explained, columns])
    for times in OVERTONES:
        pair = waves(rows.position, rows.side, times / ripple.period)[:, :2]
        force = force_of(weighed, "ripple", pair, explained=explained, left=weighed.left(explained))
        if force.share >= 0.1 and force.force >= least:  # of the residual without the ripple, that one tells
            overtones.append(times)
            explained = np.column_stack([explained, pair])
    return ripple._replace(alike=True, overtones=tuple(overtones))


def columns_by_cause(rows: Rows) -> Mapping[str, np.ndarray]:
    """Return what friction does by each cause but a ripple, to first order, shape (row, column) each."""
    x, side, speed = rows.position, rows.side[:, None], np.abs(rows.velocity)
    speed = speed / float(np.quantile(speed, 0.99))
    falls = np.exp(-speed[:, None] / np.array(FALLS))
    middle, reach = 0.5 * (x.max() + x.min()), 0.5 * float(np.ptp(x))
    place = ((x - middle) / reach)[:, None]
    turns = rows.kind == KINDS[1] and 2.0 * reach > 1.0  # [rad], over which the sine of an angle is more than a straight line
    behind, before = (way[:, None] / (2.0 * reach * np.array(WAYS)) for way in rows.from_ends(x))
    return {
        "speed": side * np.column_stack([falls, np.sqrt(speed), speed**2]),
        "direction": np.column_stack([np.ones_like(speed), speed, falls]),
        "lag": rows.acceleration[:, None] * falls,
        "play": side * np.exp(-np.column_stack([behind, before])),
        "position": np.column_stack([place, place**2, side * place, side * place**2]),
        "transmitted": side * np.abs(rows.predicted - rows.friction)[:, None],
        **({"gravity": np.column_stack([np.sin(x), np.cos(x)])} if turns else {}),
        **{name: (rows.friction * (signal - np.mean(signal)))[:, None] for name, signal in rows.surroundings.items()},
    }


def lagging_columns(rows: Rows) -> np.ndarray:
    """Return what friction that falls with the speed does where it lags behind it, shape (row, column).

    Rows that are left out are at rest: the speed that friction sees has died away over them.
    """
    speed, time = np.abs(rows.velocity), rows.time
    top, step = float(np.quantile(speed, 0.99)), np.diff(time, prepend=time[0])
    usual, falls = float(np.median(step)), np.array(LAG_FALLS)
    columns = []
    for lag in LAGS:
        keep, gain = np.exp(-step / lag), 1.0 - np.exp(-np.minimum(step, usual) / lag)
        lagged, late = np.empty_like(speed), float(speed[0])
        for row, (share, gained) in enumerate(zip(keep.tolist(), (gain * speed).tolist(), strict=True)):
            late = share * late + gained
            lagged[row] = late
        columns.append(np.exp(-lagged[:, None] / (falls * top)) - np.exp(-speed[:, None] / (falls * top)))
    return rows.side[:, None] * np.hstack(columns)


HALF_POWER = np.log(2.0) ** 0.5 / (2.0 * np.pi)  # of a Gaussian: its width times its cut-off
FEWEST_UNITS = 24  # half-cycles, or parts of them, that have a sign of their own
SMALL = 1e-3


def slow_forces(rows: Rows, settings: Settings) -> tuple[tuple[Missing, ...], float]:
    """Return the force that a model lacks, none or one, and what is left without it [N or N*m].

    It is looked for away from reversals; around them, a lag alone.
    """
    if not rows.enough:
        return (), 0.0
    friction, lag = float(np.sqrt(np.mean(rows.friction**2))), lagging_columns(rows)
    missing, left = (), 0.0
    if np.count_nonzero(rows.far) >= FEWEST_ROWS and (away := rows.at(rows.far)).enough:
        causes = {name: columns for name, columns in columns_by_cause(rows).items() if name in ANYWHERE} | {"lag": lag}
        causes = {name: columns[rows.far] for name, columns in causes.items()}
        forces = settings.missing_slow_force * friction, settings.missing_sought_force * friction
        least = _Least(settings.missing_slow_share, settings.missing_level, *forces)
        missing, left = _largest(away, rows.explained[rows.far], causes, least)
    if missing:
        return missing, left
    force = settings.missing_slow_force_around * friction
    return _largest(rows, rows.explained, {"lag": lag}, _Least(settings.missing_slow_share_around, settings.missing_level, force))


class _Least(NamedTuple):
    """From which share of what is left, level by chance and force [N or N*m] on a cause counts."""

    # A ripple, whose period is looked for, counts from a `ripple` of its own on; none is looked for without.

    share: float
    level: float
    force: float
    ripple: float = math.inf


def _largest(rows: Rows, explained: np.ndarray, causes: Mapping[str, np.ndarray], least: _Least) -> tuple[tuple[Missing, ...], float]:
    """Return the cause that tells most behind the filter, none or one, and what is left beside all causes."""
    if rows.cycles.count < 10:  # fewer do not tell a scatter of friction from a cause
        return (), 0.0
    passed = _LowPass.of(rows)
    explained = passed(explained / np.maximum(np.linalg.norm(explained, axis=0), SMALLEST))
    residual = passed(rows.residual)
    residual = residual - explained @ unbounded(explained, residual, rcond=TINY)
    weighed = Weighed.of(replace(rows, residual=residual, slope=passed(rows.slope)))
    ripple, period = (None, 0.0) if math.isinf(least.ripple) else ripple_in(rows, weighed, explained, rows.narrow)
    left, forces = weighed.left(explained), list[Missing]()
    for name, columns in ({**causes} | ({} if ripple is None else {"ripple": ripple})).items():
        slow = passed(columns)
        force = force_of(weighed, name, slow, explained=explained, left=left)
        large = force.force >= (least.ripple if name == "ripple" else least.force)
        if large and force.share >= least.share and _no_chance(weighed, explained, slow, least.level):
            forces.append(force._replace(period=period) if name == "ripple" else force)
    if not forces:
        return (), 0.0
    return (max(forces, key=lambda force: force.share),), float(np.sqrt(np.mean(left**2)))


@dataclass(frozen=True)
class _LowPass:
    """A Gaussian over stretches of rows, of a width in rows."""

    starts: np.ndarray
    ends: np.ndarray
    width: float

    @classmethod
    def of(cls, rows: Rows) -> _LowPass:
        """Return the filter whose cut-off is where the acceleration of rows begins to be noise."""
        starts = np.flatnonzero(np.diff(rows.stretch, prepend=-1))
        width = HALF_POWER / (rows.narrow * float(np.median(np.diff(rows.time))))
        return cls(starts, np.append(starts[1:], rows.time.size), width)

    def __call__(self, signals: np.ndarray) -> np.ndarray:
        """Return signals, shape (row, ...), behind the filter, which takes no more than there is at an end."""
        from scipy.ndimage import gaussian_filter1d

        behind = np.empty_like(signals, dtype=float)
        for start, end in zip(self.starts, self.ends, strict=True):
            weight = gaussian_filter1d(np.ones(end - start), self.width, mode="constant")
            behind[start:end] = (gaussian_filter1d(signals[start:end], self.width, axis=0, mode="constant").T / weight).T
        return behind


def _no_chance(weighed: Weighed, explained: np.ndarray, columns: np.ndarray, level: float) -> bool:
    """Return whether columns take more of what is left than with signs by chance, but for so many of them."""
    certain, free = weighed.of_columns(explained), weighed.of_columns(columns)
    free = free - certain @ unbounded(certain, free, rcond=TINY)
    free = free / np.maximum(np.linalg.norm(free, axis=0), SMALLEST)
    cycle, count = weighed.rows.cycles.index, weighed.rows.cycles.count
    part = np.arange(cycle.size) * FEWEST_UNITS // cycle.size
    units = Groups(cycle if count >= FEWEST_UNITS else cycle * FEWEST_UNITS + part)
    pulls = units.summed(free * weighed.without(explained)[:, None])
    signs = np.random.default_rng(units.count).choice([-1.0, 1.0], (499, units.count))  # drawn for each
    drawn = np.vstack([np.ones(units.count), signs]) @ pulls
    squares = np.sum(drawn * np.linalg.solve(free.T @ free + SMALL * np.eye(free.shape[1]), drawn.T).T, axis=1)
    return bool(squares[0] > np.quantile(squares[1:], level))
