"""What the rules of a check measure in a log, each once, and from where on they say something.

A line through a log knows inertia, levels and slopes by direction, a fall with speed, and the rate of the effort: a delay
or a filter of one of both channels is then no error of the inertia. No fit takes a number from it.
"""

from dataclasses import dataclass

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.lazy import cached_property
from bristle.core.least_squares import unbounded
from bristle.core.values import Thresholds, threshold
from bristle.logs.channel import LogData
from bristle.logs.lines import Line, Rows, piled_up, rows_of, work_share
from bristle.logs.problems import Cut, clipped
from bristle.logs.turns import graininess, turning_points

FALLS = (0.1, 0.02)  # of the largest speed, over which friction may fall
TELLS = 0.95  # of the scatter of the effort: a line that leaves more says nothing
SIDE = 0.02  # share of the rows in a direction from which it has columns of its own
BENT = 0.2  # of the largest effort: a channel that bends over
CLIPPED = 10  # samples in a row at an extreme from which an effort is clipped
SAME_SCALE, SAME_SIGNAL = 0.05, 0.8  # of a recorded velocity beside that of the position: relative deviation, correlation


@dataclass(frozen=True)
class CheckThresholds(Thresholds):
    """The thresholds of the checks before a fit; `CheckThresholds.described` tells what each of them is."""

    # A log by itself, before anything is fitted.
    reversed_work: float = threshold(
        0.1, "share of the work over closed motion, taken as put in, from which the sign of the effort is doubted", most=1.0
    )
    one_speed: float = threshold(1.3, "ratio of the 90 % to the 10 % quantile of the speed below which a log has one", least=1.0)
    mass_ratio: float = threshold(
        1.15, "ratio of the known mass or inertia to the one that the log shows from which they contradict", least=1.0
    )
    fastest: float = threshold(20.0, "speed of a linear axis above which the unit of the position is doubted", "m/s")
    fastest_turning: float = threshold(2500.0, "speed of a rotary axis above which the unit of the position is doubted", "rad/s")
    level_drift: float = threshold(0.1, "share of the level of friction by which it must change over time, or over the range, to be told")
    sure: float = threshold(5.0, "standard errors by which what a line through the log shows must differ from none", "σ")


DEFAULT = CheckThresholds()


@dataclass(frozen=True)
class Look:
    """A log with what several rules measure of it, each once."""

    log: LogData
    axis: Axis
    settings: CheckThresholds
    resolution: float
    lost: np.ndarray

    @cached_property
    def share(self) -> float:
        """Work over closed motion that stays in the axis, as a share of what friction would keep."""
        return work_share(self.log)

    @cached_property
    def rows(self) -> Rows:
        """The log in rows behind one filter."""
        return rows_of(self.log, self.resolution)

    @cached_property
    def cut(self) -> Cut | None:
        """Where the effort is cut off: at a limit, or below its noise."""
        log = self.log
        if log.effort is None:
            return None
        limit = self.axis.controller.values.get("limit") if isinstance(self.axis.controller, Model) else None
        # The controller bounds its own part: known inputs are added behind its limit.
        own = clipped(log.effort.values - log.injected_effort, limit, CLIPPED) if log.injected else None
        cut = own or clipped(log.effort.values, self.axis.effort_limit or limit, CLIPPED)
        return cut or piled_up(log, self.rows, self.resolution, CLIPPED, self.settings.sure)

    @cached_property
    def is_unsigned(self) -> bool:
        """Whether an effort turns back at zero again and again, as a magnitude does, and never crosses it."""
        values = np.zeros(1) if self.log.effort is None else self.log.effort.values
        size = np.abs(values)
        if values.min() < 0.0 < values.max() or not size.any():
            return False
        # A magnitude visits zero often; an effort that stays there for a fifth of the log is that of a drive that is off.
        near = size < 0.02 * float(np.quantile(size, 0.95))
        return int(np.sum(np.diff(near.astype(np.int8)) == 1)) >= 8 and float(np.mean(near)) < 0.2

    @cached_property
    def velocity(self) -> tuple[float, float, float] | None:
        """Scale, likeness and delay of a recorded velocity against that of the position; None where it is that one."""
        moved = self.rows.sliding
        # 100.0 encoder steps of the range from which the position tells a velocity
        moves = float(np.ptp(self.log.position.values)) > 100.0 * self.resolution
        if not self.rows.recorded.size or not moves or moved.velocity.size < 50:  # rows to compare velocities
            return None
        v, recorded = moved.velocity, moved.recorded
        likeness = likeness_of(v, recorded)
        # A velocity that is late by a time is less by that time of the acceleration.
        scale, late = unbounded(np.column_stack([v, -moved.acceleration]), recorded).tolist()
        of_size = likeness >= SAME_SIGNAL and abs(scale - 1.0) <= SAME_SCALE
        delay = late / scale if of_size else 0.0
        return None if of_size and abs(delay) <= 0.005 else (scale, likeness, delay)  # s between both from which it is told

    @cached_property
    def sliding(self) -> tuple[Rows, np.ndarray]:
        """The rows that slide, with the columns of a line through them."""
        slid = self.rows.sliding
        v = slid.velocity
        top = float(np.abs(v).max(initial=0.0)) or 1.0
        columns = [slid.acceleration, -slid.rate]
        for side in ((v > 0.0).astype(float), (v < 0.0).astype(float)):
            if v.size and side.mean() > SIDE:
                columns += [side, side * v, *(side * np.exp(-np.abs(v) / (fall * top)) for fall in FALLS)]
        return slid, np.column_stack(columns)

    def line(self, *further: np.ndarray) -> Line | None:
        """Return a line through the log with further columns; None where it says nothing, or the effort has a wrong sign."""
        if self.log.effort is None or self.share < -self.settings.reversed_work:
            return None
        rows, columns = self.sliding
        line = Line.through(np.column_stack([columns, *further]), rows.effort)
        return line if line is not None and line.explained > TELLS else None

    @cached_property
    def plain(self) -> Line | None:
        """The line through the log."""
        return self.line()

    @cached_property
    def predicted(self) -> np.ndarray:
        """The effort that the line through the log tells, shape (row,)."""
        assert self.plain is not None
        return self.sliding[1] @ self.plain.coefficients

    @cached_property
    def bend(self) -> float | None:
        """By how much of itself the largest effort reads too little, or too much (below 0); None where that does not show."""
        if self.plain is None or self.cut or self.is_unsigned:
            return None
        effort, predicted = self.sliding[0].effort, self.predicted
        # What a drive lacks of its command goes with the force that acts: noise of the command itself would look like it.
        # And it is most of what the line leaves over: an error of the motion goes with its extremes, too.
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
        """When the effort begins to read another share of inertia and friction alike [s], and by how much more; None where it does not."""
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
        return (time, float(np.mean(shares))) if alike and np.all(np.abs(shares) > self.settings.sure * deviations) else None

    @cached_property
    def high_pass(self) -> float | None:
        """The frequency [Hz] below which the effort is cut off, as by an AC-coupled channel; None where it is not."""
        log = self.log
        if log.effort is None or len(log.segments) != 1 or self.cut or self.is_unsigned:
            return None
        rows, columns = self.sliding
        # A first-order high-pass leaves out of an effort its cut-off, as an angular frequency, times the integral of what it shows.
        integral = np.interp(rows.time, log.time.values, log.sample_time * np.cumsum(log.effort.values - np.mean(log.effort.values)))
        # That may turn the sign of the work: no line of the effort with its sign.
        line = Line.through(np.column_stack([columns, -integral]), rows.effort)
        if line is None or line.explained < TELLS:
            return None
        cutoff, deviation = line.last
        much = cutoff * float(np.std(integral)) > self.settings.level_drift * float(np.std(columns[:, 2:] @ line.coefficients[2:-1]))
        return cutoff / (2.0 * np.pi) if much and cutoff > self.settings.sure * deviation else None

    @cached_property
    def mass(self) -> tuple[float, float] | None:
        """The mass that the log shows, and what the known one is of it, where they contradict each other."""
        axis, line, settings = self.axis, self.plain, self.settings
        if line is None or self.cut or self.is_unsigned or self.bend is not None or not axis.mass or axis.plant != "inertia":
            return None
        mass, deviation = float(line.coefficients[0]), float(line.deviations[0])
        share = abs(mass) * float(np.std(self.sliding[0].acceleration)) / float(np.std(self.sliding[0].effort))
        # 0.05 of the mass, and 0.06 of the scatter of the effort: an inertia that the log shows well enough
        if not (axis.mass > 0.0 < mass and deviation < 0.05 * mass and share > 0.06):
            return None
        ratio = axis.mass / mass
        contradicts = max(ratio, 1.0 / ratio) >= settings.mass_ratio * (1.0 + settings.sure * deviation / mass)
        return (mass, ratio) if contradicts else None

    @cached_property
    def changes(self) -> tuple[float, dict[int, float]]:
        """The level of friction, and by how much of it it changes over time (-2) and over the position (-1), where it does."""
        line = self.plain
        rows = self.sliding[0] if line is not None else self.rows
        side = np.sign(rows.velocity)
        if line is None or min(np.mean(side > 0.0), np.mean(side < 0.0)) <= SIDE:
            return 0.0, {}
        ends = ((values, float(values.min()), float(values.max())) for values in (rows.time, rows.position))
        time, position = ((values - 0.5 * (low + high)) / ((high - low) or 1.0) for values, low, high in ends)
        changing = self.line(time, position, side * time, side * position)
        if changing is None:
            return 0.0, {}
        rest = rows.effort - line.coefficients[0] * rows.acceleration + line.coefficients[1] * rows.rate
        level = float(np.mean(np.abs(rest - np.median(rest))))
        shares = {k: (float(changing.coefficients[k] / level), float(changing.deviations[k] / level)) for k in (-2, -1)}
        least, sure = self.settings.level_drift, self.settings.sure
        return level, {k: share for k, (share, deviation) in shares.items() if abs(share) > max(least, sure * deviation)}

    @cached_property
    def ways(self) -> list[np.ndarray]:
        """How far the axis goes in each segment [m or rad], shape (way,): to its first turn, from turn to turn, to the end."""
        return [np.diff(x[self.turns(x)]) for x in self.segments]

    @cached_property
    def way(self) -> float:
        """The usual way between two turns [m or rad]."""
        between = np.abs(np.concatenate([part[1:-1] for part in self.ways]))
        return float(np.median(between)) if between.size else float(np.ptp(self.log.position.values))

    @property
    def segments(self) -> list[np.ndarray]:
        """The positions of each segment."""
        return [self.log.position.values[segment] for segment in self.log.segments]

    def turns(self, position: np.ndarray) -> np.ndarray:
        """Return the first sample, those at which the motion turns, and the last, shape (turn,)."""
        least = max(graininess(position, self.resolution), 1e-3 * float(np.ptp(position)))  # of the range: a turn by less is none
        return np.array([0, *turning_points(position, least), position.size - 1])


def likeness_of(first: np.ndarray, second: np.ndarray) -> float:
    """Return by how much two signals are one, but for their size."""
    size = float(np.linalg.norm(first) * np.linalg.norm(second))
    return float(first @ second) / size if size > 0.0 else 0.0
