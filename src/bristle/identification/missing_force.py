r"""Forces missing from a model, found in the residual of its fit.

Each cause has a few columns: the first-order change of friction by this cause. A cause is present if its columns,
fitted to most half-cycles, predict the residual of the others (cross-validation [1]_). Weights remove two
disturbances first. Sampling errors dominate rows around reversals: forces that also act elsewhere are sought farther
away, and the weight of each band of distance from a reversal follows from its residual. And friction has another
level in each half-cycle: with the share :math:`1 - \sqrt{v_k / (\tau^2 + v_k)}` of that level removed, for a scatter
:math:`\tau` and an error :math:`v_k`, rows are nearly independent of it [2]_.

Changes of the parameters, of the inertia, of the delay or of a filter are not missing forces: their derivatives are
fitted with each cause.

Errors of the treatment also repeat in each half-cycle. A cause must therefore exceed a threshold: its force, times the
share of the residual that it explains, must be a share of friction. It must also exceed the result of random signs for
each half-cycle [3]_.

References
----------
.. [1] M. Stone, "Cross-validatory choice and assessment of statistical predictions", Journal of the Royal Statistical
   Society B 36(2), 1974. doi:10.1111/j.2517-6161.1974.tb00994.x
.. [2] W. A. Fuller, G. E. Battese, "Transformations for estimation of linear models with nested-error structure",
   Journal of the American Statistical Association 68(343), 1973. doi:10.1080/01621459.1973.10481414
.. [3] P. Kline, A. Santos, "A score based approach to wild bootstrap inference", Journal of Econometric Methods 1(1),
   2012. doi:10.1515/2156-6674.1006
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from bristle.core.least_squares import unbounded
from bristle.core.variable import KINDS
from bristle.identification.half_cycles import Groups
from bristle.identification.missing_rows import FEWEST_ROWS, SMALL, SMALLEST, TINY, Rows, Weighed
from bristle.identification.settings import Settings
from bristle.logs.waves import frequency_in, refined, waves

AS_GOOD = 1.05  # times the residual of another cause: gravity is preferred to a parabola or a ripple over the angle
EVEN = 0.9  # of the share of a ripple, for a ripple equal in both directions, or opposite
OVERTONES = range(2, 7)  # of a ripple
FALLS = (0.01, 0.03, 0.1, 0.3, 1.0)  # of the largest speed, over which friction may fall
# Of the range: build-up length of a force after a reversal.
WAYS = tuple(np.geomspace(1e-4, 0.03, 6).tolist())
LAGS = (0.01, 0.04)  # [s]
LAG_FALLS = (0.003, 0.01, 0.03, 0.1)  # of the largest speed
LEAST_OF_A_RIPPLE = 0.3  # of the residual: its period is searched, so random signs are no test
FEWEST_WAVES = 1.5  # over the range: fewer waves are a change along the axis
MOST_CAUSES, MOST_SEARCHES = 3, 5
FEWEST_UNITS = 24  # half-cycles, or parts of them, with separate signs
DRAWS = 1999  # of signs
HALF_POWER = np.log(2.0) ** 0.5 / (2.0 * np.pi)  # of a Gaussian: its width times its cut-off


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

    @property
    def evidence(self) -> float:
        """The force [N or N*m] times the explained share of the residual, both small for errors of the treatment."""
        return self.share * self.force


def missing_forces(
    rows: Rows, settings: Settings, *, static: bool = False
) -> tuple[tuple[Missing, ...], float]:
    """Return the forces that a model lacks away from reversals, strongest evidence first, and the remaining residual [N or N*m]."""
    # Noise dominates the acceleration at high frequencies: only a ripple is also sought there. A `static` model lacks the force
    # that builds up after reversals.
    if not rows.enough:
        return (), 0.0
    columns_of, missing, left = columns_by_cause(rows), list[Missing](), 0.0
    behind = columns_of.pop("presliding")
    if np.count_nonzero(rows.far) >= FEWEST_ROWS and (away := rows.at(rows.far)).enough:
        explained, causes = (
            rows.explained[rows.far],
            {name: columns[rows.far] for name, columns in columns_of.items()},
        )
        # A ripple may be too fast for the filter: find it with its period in unfiltered rows.
        fast, left = _Search.of(away, explained, slow=False).causes_in(causes, settings)
        fast = [force for force in fast if force.cause == "ripple"]
        explained = np.column_stack([explained, *(_columns(force, away, causes) for force in fast)])
        slow, of_all = _Search.of(away, explained, slow=True).causes_in(
            causes, settings, ripple=not fast
        )
        missing, left = [*fast, *slow], left if fast else of_all
    if static:
        # A force that builds up over a way also lags: omit a lag from the explained columns.
        explained = np.column_stack(
            [
                rows.explained,
                *(_columns(force, rows, columns_of) for force in missing if force.cause != "lag"),
            ]
        )
        around, of_all = _Search.of(rows, explained, slow=True).causes_in(
            {"presliding": behind}, settings, ripple=False
        )
        missing, left = [*missing, *around], left if missing else of_all
    return tuple(sorted(missing, key=attrgetter("evidence"), reverse=True)[:MOST_CAUSES]), left


def _columns(force: Missing, rows: Rows, causes: Mapping[str, np.ndarray]) -> np.ndarray:
    return (
        waves(rows.position, rows.side, 1.0 / force.period) if force.period else causes[force.cause]
    )


@dataclass
class _Search:
    """A search for causes in rows, filtered or not; each found cause is added to the explained columns."""

    rows: Rows
    passed: Callable[[np.ndarray], np.ndarray]
    fastest: float
    weighed: Weighed
    explained: np.ndarray

    @classmethod
    def of(cls, rows: Rows, explained: np.ndarray, *, slow: bool) -> _Search:
        """Return a search in all frequencies of the rows, or only in the `slow` part."""
        passed, fastest = (_LowPass.of(rows), rows.narrow) if slow else (np.asarray, rows.cutoff)
        explained = passed(explained / np.maximum(np.linalg.norm(explained, axis=0), SMALLEST))
        residual = passed(rows.residual)
        residual = residual - explained @ unbounded(explained, residual, rcond=TINY)
        return cls(
            rows,
            passed,
            fastest,
            Weighed.of(replace(rows, residual=residual, slope=passed(rows.slope))),
            explained,
        )

    def causes_in(
        self, candidates: Mapping[str, np.ndarray], settings: Settings, *, ripple: bool = True
    ) -> tuple[list[Missing], float]:
        """Return the significant causes, including a `ripple` if requested, and the remaining residual."""
        least = settings.missing_evidence * float(np.sqrt(np.mean(self.rows.friction**2)))
        causes, missing = (
            {name: self.passed(columns) for name, columns in candidates.items()},
            list[Missing](),
        )
        left = self.weighed.left(self.explained)
        for _ in range(MOST_SEARCHES):
            waved, period = (
                ripple_in(self.rows, self.weighed, self.explained, self.fastest)
                if ripple
                else (None, 0.0)
            )
            tried = causes | ({} if waved is None else {"ripple": self.passed(waved)})
            level = 1.0 - (1.0 - settings.missing_level) / max(len(tried), 1)
            forces = {name: self._force(name, columns, left) for name, columns in tried.items()}
            forces = {
                name: force
                for name, force in forces.items()
                if force.evidence >= least
                and (
                    force.share >= LEAST_OF_A_RIPPLE
                    if name == "ripple"
                    else _no_chance(self.weighed, self.explained, tried[name], level)
                )
            }
            if not forces:
                break
            best = forces[max(forces, key=lambda name: forces[name].share)]
            if "gravity" in forces and best.cause in ("position", "ripple"):
                # Prefer gravity to a force over the position or a ripple that, with its symmetric columns, explains no more.
                alike = self._force(best.cause, tried[best.cause][:, :2], left)
                best = (
                    forces["gravity"]
                    if 1.0 - forces["gravity"].share <= AS_GOOD * (1.0 - alike.share)
                    else best
                )
            columns = tried[best.cause]
            if best.cause == "ripple":
                error = self.passed(_encoder_error(self.rows, period))
                if self._force("ripple", error, left).share > best.share:
                    # The error of a scale has overtones: other waves over the position are also its error.
                    self.explained, ripple = (
                        np.column_stack([self.explained, columns, error]),
                        False,
                    )
                    left = self.weighed.left(self.explained)
                    continue
                best, ripple = self._in_detail(best._replace(period=period), least), False
            if best.cause == "position":
                best = best._replace(
                    alike=self._force("position", columns[:, :2], left).share >= EVEN * best.share
                )
            missing.append(best)
            causes.pop(best.cause, None)
            self.explained = np.column_stack([self.explained, columns])
            left = self.weighed.left(self.explained)
            if len(missing) == MOST_CAUSES:
                break
        return missing, float(np.sqrt(np.mean(left**2)))

    def _force(self, cause: str, columns: np.ndarray, left: np.ndarray) -> Missing:
        """Return the force of a cause, fitted with the explained columns; `left` is the residual of these alone."""
        after, force, coefficients = self.weighed.with_columns(self.explained, columns)
        share = 1.0 - float(after @ after) / max(float(left @ left), SMALLEST)
        amplitude = float(np.hypot(*coefficients)) if cause == "gravity" else 0.0
        return Missing(
            cause, max(share, 0.0), float(np.sqrt(np.mean(force**2))), amplitude=amplitude
        )

    def _in_detail(self, ripple: Missing, least: float) -> Missing:
        """Return a ripple with its symmetry between directions, and its overtones."""
        x, side, left = self.rows.position, self.rows.side, self.weighed.left(self.explained)
        columns = self.passed(waves(x, side, 1.0 / ripple.period))
        even, odd = (
            self._force("ripple", part, left).share >= EVEN * ripple.share
            for part in (columns[:, :2], columns[:, 2:])
        )
        if not even or odd:
            return ripple._replace(alike=False if odd and not even else None)
        overtones, beside = [1], replace(self, explained=np.column_stack([self.explained, columns]))
        for times in OVERTONES:
            pair = self.passed(waves(x, side, times / ripple.period)[:, :2])
            force = beside._force("ripple", pair, self.weighed.left(beside.explained))
            if force.evidence >= least:
                overtones.append(times)
                beside.explained = np.column_stack([beside.explained, pair])
        return ripple._replace(alike=True, overtones=tuple(overtones))


def ripple_in(
    rows: Rows, weighed: Weighed, explained: np.ndarray, fastest: float
) -> tuple[np.ndarray | None, float]:
    """Return the waves over the position, up to the frequency `fastest` [Hz] at the usual speed, that explain most of the residual."""
    x, side = rows.position, rows.side
    most = float(np.ptp(x)) * fastest / float(np.median(np.abs(rows.velocity)))
    residual = weighed.without(explained)
    frequency = frequency_in(x, side, residual, most)
    frequency = None if frequency is None else refined(x, side, residual, frequency)
    return (
        (None, 0.0)
        if frequency is None or frequency * float(np.ptp(x)) < FEWEST_WAVES
        else (waves(x, side, frequency), 1.0 / frequency)
    )


def _encoder_error(rows: Rows, period: float) -> np.ndarray:
    """Return the acceleration error by a position error of this period: it grows with the square of the speed."""
    return (
        waves(rows.position, None, 1.0 / period)
        * (rows.velocity**2 / np.mean(rows.velocity**2))[:, None]
    )


def columns_by_cause(rows: Rows) -> dict[str, np.ndarray]:
    """Return the first-order changes of friction by each cause except a ripple, shape (row, column) each."""
    x, side, speed = rows.position, rows.side[:, None], np.abs(rows.velocity)
    speed = speed / float(np.quantile(speed, 0.99))
    falls = np.exp(-speed[:, None] / np.array(FALLS))
    middle, reach = 0.5 * (x.max() + x.min()), 0.5 * float(np.ptp(x))
    place = ((x - middle) / reach)[:, None]
    # [rad], over which the sine of an angle is more than a straight line
    turns = rows.kind == KINDS[1] and 2.0 * reach > 1.0
    behind = rows.from_ends(x)[0][:, None] / (2.0 * reach * np.array(WAYS))
    return {
        "speed": side * np.column_stack([falls, np.sqrt(speed), speed**2]),
        "direction": np.column_stack([np.ones_like(speed), speed, falls]),
        "lag": lagging_columns(rows),
        "presliding": side * np.exp(-behind),
        "position": np.column_stack([place, place**2, side * place, side * place**2]),
        "transmitted": side * np.abs(rows.predicted - rows.friction)[:, None],
        **({"gravity": np.column_stack([np.sin(x), np.cos(x)])} if turns else {}),
        **{
            name: (rows.friction * (signal - np.mean(signal)))[:, None]
            for name, signal in rows.surroundings.items()
        },
    }


def lagging_columns(rows: Rows) -> np.ndarray:
    """Return the change of falling friction by a lag behind the speed, shape (row, column); omitted rows are at rest."""
    speed, time = np.abs(rows.velocity), rows.time
    top, step = float(np.quantile(speed, 0.99)), np.diff(time, prepend=time[0])
    usual, falls = float(np.median(step)), np.array(LAG_FALLS)
    columns = []
    for lag in LAGS:
        keep, gain = np.exp(-step / lag), 1.0 - np.exp(-np.minimum(step, usual) / lag)
        lagged, late = np.empty_like(speed), float(speed[0])
        for row, (share, gained) in enumerate(
            zip(keep.tolist(), (gain * speed).tolist(), strict=True)
        ):
            late = share * late + gained
            lagged[row] = late
        columns.append(
            np.exp(-lagged[:, None] / (falls * top)) - np.exp(-speed[:, None] / (falls * top))
        )
    return rows.side[:, None] * np.hstack(columns)


@dataclass(frozen=True)
class _LowPass:
    """A Gaussian filter over stretches of rows, with its width in rows."""

    starts: np.ndarray
    ends: np.ndarray
    width: float

    @classmethod
    def of(cls, rows: Rows) -> _LowPass:
        """Return the filter whose cut-off separates the acceleration of the rows from its noise."""
        starts = np.flatnonzero(np.diff(rows.stretch, prepend=-1))
        width = HALF_POWER / (rows.narrow * float(np.median(np.diff(rows.time))))
        return cls(starts, np.append(starts[1:], rows.time.size), width)

    def __call__(self, signals: np.ndarray) -> np.ndarray:
        """Return filtered signals, shape (row, ...); at the ends the weights are renormalised."""
        from scipy.ndimage import gaussian_filter1d

        behind = np.empty_like(signals, dtype=float)
        for start, end in zip(self.starts, self.ends, strict=True):
            weight = gaussian_filter1d(np.ones(end - start), self.width, mode="constant")
            behind[start:end] = (
                gaussian_filter1d(signals[start:end], self.width, axis=0, mode="constant").T
                / weight
            ).T
        return behind


def _no_chance(weighed: Weighed, explained: np.ndarray, columns: np.ndarray, level: float) -> bool:
    """Return whether columns explain more of the residual than with random signs, at this level."""
    certain, free = weighed.of_columns(explained), weighed.of_columns(columns)
    free = free - certain @ unbounded(certain, free, rcond=TINY)
    free = free / np.maximum(np.linalg.norm(free, axis=0), SMALLEST)
    cycle, count = weighed.rows.cycles.index, weighed.rows.cycles.count
    part = np.arange(cycle.size) * FEWEST_UNITS // cycle.size
    units = Groups(cycle if count >= FEWEST_UNITS else cycle * FEWEST_UNITS + part)
    pulls = units.summed(free * weighed.without(explained)[:, None])
    # Drawn for each
    signs = np.random.default_rng(units.count).choice([-1.0, 1.0], (DRAWS, units.count))
    drawn = np.vstack([np.ones(units.count), signs]) @ pulls
    squares = np.sum(
        drawn * np.linalg.solve(free.T @ free + SMALL * np.eye(free.shape[1]), drawn.T).T, axis=1
    )
    return bool(squares[0] > np.quantile(squares[1:], level))
