"""Measure quantities of a log once for all checks, with the thresholds of the checks.

The regression line of a log has terms for the inertia and, for each direction, a friction level, its slope and its fall
with speed. A term for the rate of the effort keeps a delay or filter of one channel from biasing the inertia. Fits do not
use these numbers.
"""

from dataclasses import dataclass

import numpy as np

from bristle.core import Axis, Model, cached_property, unbounded
from bristle.core.values import Thresholds, threshold
from bristle.logs.channel import LogData
from bristle.logs.lines import Line, Rows, piled_up, rows_of, work_share
from bristle.logs.problems import Cut, clipped
from bristle.logs.turns import graininess, turning_points

FALLS = (0.1, 0.02)  # of the largest speed, over which friction can fall
TELLS = 0.95  # of the scatter of the effort: above, the line is not used
SIDE = 0.02  # share of the rows in a direction above which it has separate columns
BENT = 0.2  # of the largest effort: threshold of gradual saturation
CLIPPED = 10  # consecutive samples at an extreme of a clipped effort
# Of a recorded velocity against that of the position: relative deviation, correlation.
SAME_SCALE, SAME_SIGNAL = (0.05, 0.8)


@dataclass(frozen=True)
class CheckThresholds(Thresholds):
    """Thresholds of the checks before a fit; `CheckThresholds.described` explains each."""

    # Checks of a log alone.
    reversed_work: float = threshold(
        0.1,
        "work that the effort takes out of the axis over closed motion, as a share of its friction work, above which its sign is doubtful",
        most=1.0,
    )
    one_speed: float = threshold(
        1.3,
        "ratio of the 90 % to the 10 % quantile of the speed, below which a log has a single speed",
        least=1.0,
    )
    mass_ratio: float = threshold(
        1.15,
        "ratio of the known mass or inertia to the value in the log, above which they contradict",
        least=1.0,
    )
    fastest: float = threshold(
        20.0, "speed of a linear axis above which the unit of the position is doubtful", "m/s"
    )
    fastest_turning: float = threshold(
        2500.0, "speed of a rotary axis above which the unit of the position is doubtful", "rad/s"
    )
    level_drift: float = threshold(
        0.1,
        "change of the friction level over time or over the range, as a share of the level, above which bristle reports it",
    )
    sure: float = threshold(
        5.0,
        "distance from zero, in standard errors, at which an effect in a regression line through the log is significant",
        "σ",
    )


DEFAULT = CheckThresholds()


@dataclass(frozen=True)
class Look:
    """A log with measured quantities that several checks share."""

    log: LogData
    axis: Axis
    settings: CheckThresholds
    resolution: float
    lost: np.ndarray

    @cached_property
    def share(self) -> float:
        """Work over closed motion that the axis absorbs, as a share of the work of friction."""
        return work_share(self.log)

    @cached_property
    def is_reversed(self) -> bool:
        """Whether the effort takes work out of the axis, and its power against friction is clear, too."""
        if self.share >= -self.settings.reversed_work:
            return False
        # In a short log no motion is closed well enough: what is left of the inertia looks like work of friction.
        rows = self.rows.sliding
        v, side = rows.velocity, np.sign(rows.velocity)
        # With a second column that takes no power, the coefficient of the side is the power of both over that of the side.
        shape = v - side * float(v @ v) / (float(v @ side) or 1.0)
        line = Line.through(
            np.column_stack([rows.acceleration, np.ones_like(v), shape, side]), rows.effort
        )
        return line is not None and line.last[0] < -self.settings.sure * line.last[1]

    @cached_property
    def rows(self) -> Rows:
        """The log in rows after one filter."""
        return rows_of(self.log, self.resolution)

    @cached_property
    def cut(self) -> Cut | None:
        """Clipping of the effort: at a limit, or below its noise."""
        log = self.log
        if log.effort is None:
            return None
        limit = (
            self.axis.controller.values.get("limit")
            if isinstance(self.axis.controller, Model)
            else None
        )
        # The controller limits its own output; known inputs are added after its limit.
        own = (
            clipped(log.effort.values - log.injected_effort, limit, CLIPPED)
            if log.injected
            else None
        )
        cut = own or clipped(log.effort.values, self.axis.effort_limit or limit, CLIPPED)
        return cut or piled_up(log, self.rows, self.resolution, CLIPPED, self.settings.sure)

    @cached_property
    def is_unsigned(self) -> bool:
        """Whether an effort repeatedly touches zero without crossing it, like a magnitude."""
        values = np.zeros(1) if self.log.effort is None else self.log.effort.values
        size = np.abs(values)
        if values.min() < 0.0 < values.max() or not size.any():
            return False
        # A magnitude touches zero often; an effort of zero for a fifth of the log belongs to a drive that is off.
        near = size < 0.02 * float(np.quantile(size, 0.95))
        return int(np.sum(np.diff(near.astype(np.int8)) == 1)) >= 8 and float(np.mean(near)) < 0.2

    @cached_property
    def velocity(self) -> tuple[float, float, float] | None:
        """Scale, correlation and delay of a recorded velocity relative to the derivative of the position; None if they agree."""
        moved = self.rows.sliding
        # Range of at least 100.0 encoder steps, so that the position shows a velocity.
        moves = float(np.ptp(self.log.position.values)) > 100.0 * self.resolution
        # Rows to compare velocities.
        if not self.rows.recorded.size or not moves or moved.velocity.size < 50:
            return None
        v, recorded = moved.velocity, moved.recorded
        likeness = likeness_of(v, recorded)
        # A delayed velocity lacks the acceleration times the delay.
        scale, late = unbounded(np.column_stack([v, -moved.acceleration]), recorded).tolist()
        of_size = likeness >= SAME_SIGNAL and abs(scale - 1.0) <= SAME_SCALE
        delay = late / scale if of_size else 0.0
        # s, smallest reported delay
        return None if of_size and abs(delay) <= 0.005 else (scale, likeness, delay)

    @cached_property
    def sliding(self) -> tuple[Rows, np.ndarray]:
        """Sliding rows, with the columns of a regression line through them."""
        slid = self.rows.sliding
        v = slid.velocity
        top = float(np.abs(v).max(initial=0.0)) or 1.0
        columns = [slid.acceleration, -slid.rate]
        for side in ((v > 0.0).astype(float), (v < 0.0).astype(float)):
            if v.size and side.mean() > SIDE:
                columns += [
                    side,
                    side * v,
                    *(side * np.exp(-np.abs(v) / (fall * top)) for fall in FALLS),
                ]
        return slid, np.column_stack(columns)

    def line(self, *further: np.ndarray) -> Line | None:
        """Return a regression line with further columns; None if the fit is poor or the effort has a wrong sign."""
        if self.log.effort is None or self.is_reversed:
            return None
        rows, columns = self.sliding
        line = Line.through(np.column_stack([columns, *further]), rows.effort)
        return line if line is not None and line.explained > TELLS else None

    @cached_property
    def plain(self) -> Line | None:
        """Regression line through the log."""
        return self.line()

    @cached_property
    def predicted(self) -> np.ndarray:
        """Effort predicted by the regression line, shape (row,)."""
        assert self.plain is not None
        return self.sliding[1] @ self.plain.coefficients

    @cached_property
    def bend(self) -> float | None:
        """Share by which the largest recorded effort is too low (negative: too high); None without evidence."""
        if self.plain is None or self.cut or self.is_unsigned:
            return None
        effort, predicted = self.sliding[0].effort, self.predicted
        # The deficit against a command follows the acting force: noise of the command would look the same.
        # It must dominate the residual of the line: an error of the motion follows its extremes, too.
        for force, sign, left in ((effort, 1.0, 1.0), (predicted, -1.0, 0.5)):
            top = float(np.abs(force).max())
            line = self.line(-((force / top) ** 3) * top)
            if line is None or 1.0 - line.explained > left * (1.0 - self.plain.explained):
                continue
            share, deviation = line.last
            if sign * share > max(BENT, self.settings.sure * deviation):
                return share
        return None

    @cached_property
    def step(self) -> tuple[float, float] | None:
        """Time [s] at which the effort changes its scale for inertia and friction together, and the change; None without a change."""
        if self.plain is None or self.cut or self.is_unsigned:
            return None
        rows, columns = self.sliding
        inertia = columns[:, :2] @ self.plain.coefficients[:2]
        steps = list[tuple[float, Line]]()
        for time in np.quantile(rows.time, np.linspace(0.1, 0.9, 33)).tolist():
            late = (rows.time > time).astype(float)
            line = self.line(late * inertia, late * (self.predicted - inertia))
            steps += [(time, line)] if line is not None else []
        if not steps:
            return None
        time, line = max(steps, key=lambda tried: tried[1].explained)
        shares, deviations = line.coefficients[-2:], line.deviations[-2:]
        alike = abs(shares[0] - shares[1]) < 3.0 * float(np.hypot(*deviations))  # standard errors
        return (
            (time, float(np.mean(shares)))
            if alike and np.all(np.abs(shares) > self.settings.sure * deviations)
            else None
        )

    @cached_property
    def high_pass(self) -> float | None:
        """Frequency [Hz] below which the effort is cut off, as by an AC-coupled channel; None if it is not cut off."""
        log = self.log
        if log.effort is None or len(log.segments) != 1 or self.cut or self.is_unsigned:
            return None
        rows, columns = self.sliding
        # A first-order high-pass subtracts its angular cut-off frequency times the integral of its output.
        integral = np.interp(
            rows.time,
            log.time.values,
            log.sample_time * np.cumsum(log.effort.values - np.mean(log.effort.values)),
        )
        # It can reverse the sign of the work: fit without the sign check of the effort.
        line = Line.through(np.column_stack([columns, -integral]), rows.effort)
        if line is None or line.explained < TELLS:
            return None
        cutoff, deviation = line.last
        much = cutoff * float(np.std(integral)) > self.settings.level_drift * float(
            np.std(columns[:, 2:] @ line.coefficients[2:-1])
        )
        return cutoff / (2.0 * np.pi) if much and cutoff > self.settings.sure * deviation else None

    @cached_property
    def mass(self) -> tuple[float, float] | None:
        """Mass according to the log, and ratio of the known mass to it; None if the two masses agree."""
        axis, line, settings = self.axis, self.plain, self.settings
        if (
            line is None
            or self.cut
            or self.is_unsigned
            or self.bend is not None
            or not axis.mass
            or axis.plant != "inertia"
        ):
            return None
        mass, deviation = float(line.coefficients[0]), float(line.deviations[0])
        share = (
            abs(mass)
            * float(np.std(self.sliding[0].acceleration))
            / float(np.std(self.sliding[0].effort))
        )
        # An inertia is clear above 0.05 of the mass and 0.06 of the scatter of the effort.
        if not (axis.mass > 0.0 < mass and deviation < 0.05 * mass and share > 0.06):
            return None
        ratio = axis.mass / mass
        contradicts = max(ratio, 1.0 / ratio) >= settings.mass_ratio * (
            1.0 + settings.sure * deviation / mass
        )
        return (mass, ratio) if contradicts else None

    @cached_property
    def changes(self) -> tuple[float, dict[int, float]]:
        """Level of friction, and its relative changes over time (-2) and over the position (-1), if significant."""
        line = self.plain
        rows = self.sliding[0] if line is not None else self.rows
        side = np.sign(rows.velocity)
        if line is None or min(np.mean(side > 0.0), np.mean(side < 0.0)) <= SIDE:
            return 0.0, {}
        ends = (
            (values, float(values.min()), float(values.max()))
            for values in (rows.time, rows.position)
        )
        time, position = (
            (values - 0.5 * (low + high)) / ((high - low) or 1.0) for values, low, high in ends
        )
        changing = self.line(time, position, side * time, side * position)
        if changing is None:
            return 0.0, {}
        rest = (
            rows.effort
            - line.coefficients[0] * rows.acceleration
            + line.coefficients[1] * rows.rate
        )
        level = float(np.mean(np.abs(rest - np.median(rest))))
        shares = {
            k: (float(changing.coefficients[k] / level), float(changing.deviations[k] / level))
            for k in (-2, -1)
        }
        least, sure = self.settings.level_drift, self.settings.sure
        return level, {
            k: share
            for k, (share, deviation) in shares.items()
            if abs(share) > max(least, sure * deviation)
        }

    @cached_property
    def ways(self) -> list[np.ndarray]:
        """Strokes of each segment [m or rad], shape (way,): to the first reversal, between reversals, to the end."""
        return [np.diff(x[self.turns(x)]) for x in self.segments]

    @cached_property
    def way(self) -> float:
        """Usual stroke between two reversals [m or rad]."""
        between = np.abs(np.concatenate([part[1:-1] for part in self.ways]))
        return (
            float(np.median(between)) if between.size else float(np.ptp(self.log.position.values))
        )

    @property
    def segments(self) -> list[np.ndarray]:
        """Positions of each segment."""
        return [self.log.position.values[segment] for segment in self.log.segments]

    def turns(self, position: np.ndarray) -> np.ndarray:
        """Return the first sample, the samples of the reversals, and the last sample, shape (turn,)."""
        # Of the range: smaller reversals do not count.
        least = max(graininess(position, self.resolution), 1e-3 * float(np.ptp(position)))
        return np.array([0, *turning_points(position, least), position.size - 1])


def likeness_of(first: np.ndarray, second: np.ndarray) -> float:
    """Return the similarity of two signals regardless of their amplitudes."""
    size = float(np.linalg.norm(first) * np.linalg.norm(second))
    return float(first @ second) / size if size > 0.0 else 0.0
