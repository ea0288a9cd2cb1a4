"""Open loop of a log: the motion of a plant with friction under its effort."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bristle.core import Axis, Diagnostic, InputError, Model, Status, unbounded
from bristle.engine import run_open_loop
from bristle.engine.loop import held
from bristle.engine.loop_derivatives import Sensitive, open_loop_with_derivatives
from bristle.logs.log import Log

FINE = 20  # steps for one sample of a band-limited effort
SETTLED = 1e-6  # of the range of the position: tolerance between periods
LEADS = (1, 2, 4, 8, 16)  # periods before the judged one
ORDER = 24  # samples of a linear prediction


@dataclass(frozen=True)
class OpenLoop:
    """A log that begins at rest or is periodic, ready to run with any model."""

    effort: np.ndarray
    steps: int
    sample_time: float
    count: int
    periodic: bool
    hold: str = "linear"

    @property
    def diagnostic(self) -> Diagnostic:
        """Initial condition of the motion, as a diagnostic."""
        if not self.periodic:
            return Diagnostic("start_of_contact", severity="note")
        return Diagnostic(
            "start_of_contact",
            severity="note",
            numbers={"periods": self.count * self.steps / self.effort.size},
        )

    def position(
        self, plant: Model, friction: Model, unseen: np.ndarray | None = None
    ) -> tuple[np.ndarray, Status]:
        """Return the position at each sample of the record [m or rad], NaN after divergence."""
        effort = self.effort
        ended = list[Status]()
        if unseen is not None:
            effort = effort - np.repeat(unseen, self.steps)[: effort.size]

        def run(effort: np.ndarray) -> np.ndarray:
            trace = run_open_loop(
                plant, friction, effort, self.sample_time / self.steps, hold=self.hold
            )
            ended.append(trace.status)
            return np.concatenate(
                [trace.position, np.full(effort.size - trace.position.size, np.nan)]
            )[:: self.steps, None]

        return self._settled(run, effort)[:, 0], ended[-1]

    def with_derivatives(
        self, plant: Sensitive, friction: Sensitive
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the position and its derivatives, shape (sample, direction)."""

        def run(effort: np.ndarray) -> np.ndarray:
            step = self.sample_time / self.steps
            return np.column_stack(
                open_loop_with_derivatives(
                    plant, friction, effort, held(effort, self.hold), step, self.steps
                )
            )

        rows = self._settled(run, self.effort)
        return rows[:, 0], rows[:, 1:]

    def _settled(self, run: Callable[[np.ndarray], np.ndarray], effort: np.ndarray) -> np.ndarray:
        """Return the rows of a run, one for each sample of the record, the position first; run periodic records to a steady state."""
        if not self.periodic:
            return run(effort)
        size = effort.size // self.steps
        period = np.empty(0)
        for lead in LEADS:
            # One more sample, for the position at the end of the period.
            rows = run(np.concatenate([np.tile(effort, lead + 1), effort[:1]]))[lead * size :]
            if not np.isfinite(rows[size, 0]):
                if not period.size:
                    period = np.full_like(rows[:size], np.nan)
                break
            period = rows[:size]
            if abs(rows[size, 0] - rows[0, 0]) <= SETTLED * np.ptp(period[:, 0]):
                break
        return np.tile(period, (-(-self.count // size), 1))[: self.count]


def open_loop_of(log: Log, axis: Axis, part: slice, steps: int = FINE) -> OpenLoop:
    """Return the open loop of a stretch of a log that begins at rest or is periodic."""
    if log.effort is None:
        raise InputError(
            "has no effort to apply",
            path="log",
            mend="Name the column of the effort in the axis file",
        )
    effort = log.effort.values[part]
    position = log.position.values[part]
    period = None if axis.periodic is False else period_of(effort)
    if period is None and (
        axis.periodic or (axis.periodic is None and closes(effort) and closes(position))
    ):
        period = effort.size
    period_of_effort = effort
    if period is not None:
        period_of_effort = effort[:period]
    if axis.hold == "band_limited":
        hold = "linear"
        fine = finer(period_of_effort, steps, periodic=period is not None)
    elif axis.hold == "linear":
        hold = "linear"
        after = effort[0] if period is not None else period_of_effort[-1]
        at = np.arange(period_of_effort.size * steps) / steps
        fine = np.interp(
            at, np.arange(period_of_effort.size + 1), np.append(period_of_effort, after)
        )
    else:
        hold = "zero"
        fine = np.repeat(period_of_effort, steps)
    return OpenLoop(fine, steps, log.sample_time, effort.size, period is not None, hold)


def finer(effort: np.ndarray, steps: int, *, periodic: bool) -> np.ndarray:
    """Return a band-limited effort on a finer grid that contains the samples.

    The samples determine a signal without content above half the sampling frequency (Whittaker, Shannon). Other interpolations
    falsify a structure that is excited at a tenth of the sampling frequency. The result is exact for a periodic record.
    """
    from scipy.signal import resample

    if periodic:
        return np.asarray(resample(effort, effort.size * steps))
    # Samples of extrapolation at the ends before the interpolation.
    beyond = min(effort.size - 1, 4096)
    before = 2.0 * effort[0] - effort[beyond:0:-1]
    after = 2.0 * effort[-1] - effort[-2 : -2 - beyond : -1]
    fade = 0.5 * (1.0 - np.cos(np.pi * np.arange(1, beyond + 1) / (beyond + 1)))
    faded = np.concatenate([fade * before, effort, fade[::-1] * after])
    return np.asarray(resample(faded, faded.size * steps))[
        beyond * steps : (beyond + effort.size) * steps
    ]


def period_of(effort: np.ndarray) -> int | None:
    """Return the period in samples of a record with two equal periods or more; None for other records."""
    size = effort.size
    if size < 4 or not np.any(effort != effort[0]):
        return None
    tolerance = 1e-9 * float(np.max(np.abs(effort)))  # between two equal periods
    swing = effort - effort.mean()
    spectrum = np.fft.rfft(swing, 2 * size)
    overlap = np.arange(size, 0, -1)
    alike = np.fft.irfft(np.abs(spectrum) ** 2)[:size] / overlap
    # Shifted by a period, a record equals itself.
    for period in np.flatnonzero(alike[: size // 2 + 1] > (1.0 - 1e-6) * alike[0]).tolist():
        if period >= 2 and np.all(np.abs(effort[period:] - effort[:-period]) <= tolerance):
            return period
    return None


def closes(signal: np.ndarray) -> bool:
    """Return whether a record is a whole period: it continues from its end to its beginning as smoothly as inside.

    Inside, a linear prediction gives each sample from its predecessors. The prediction is equally good across the seam of whole
    periods, and fails across any other seam.
    """
    if signal.size < 8 * ORDER or not np.any(signal != signal[0]):
        return False
    rows = np.lib.stride_tricks.sliding_window_view(signal - signal.mean(), ORDER + 1)
    learnt = rows[:: max(rows.shape[0] // 5000, 1)]
    weights = unbounded(learnt[:, :-1], learnt[:, -1], rcond=1e-12)
    seam = np.concatenate([signal[-ORDER:], signal[:ORDER]]) - signal.mean()
    across = np.lib.stride_tricks.sliding_window_view(seam, ORDER + 1)
    inside, across_seam = (
        float(np.max(np.abs(windows[:, -1] - windows[:, :-1] @ weights)))
        for windows in (rows, across)
    )
    return across_seam <= 2.0 * inside
