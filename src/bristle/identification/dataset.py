"""The rows of a regression, and the filters from a signal along the segments of a log to these rows."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from operator import attrgetter

import numpy as np

from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.core.lazy import cached_property
from bristle.core.variable import Kind
from bristle.engine.contact import place_of, state_at
from bristle.engine.filtered_rows import Block, filtered_rows
from bristle.engine.motion import along
from bristle.logs.break_away import BreakAway, Recording, break_aways
from bristle.logs.filters import butterworth, low_passed
from bristle.logs.log import Log
from bristle.logs.turns import reversals
from bristle.models.friction.level import rises_with_effort
from bristle.models.plants.terms import effort_of_columns, effort_of_place, terms_of

REACH = 10  # rows on either side that enter the decimating filter
REACH_PERIODS = 2  # of the cut-off, over which the zero-phase filter mixes samples

# Deviation of a change from a whole number of encoder steps; share of such changes.
OFF_GRID, OFTEN = (0.1, 0.2)

# Samples at least, share of the log, and pieces of a segment, of an excerpt.
EXCERPT, EXCERPT_SHARE, PIECES = (60_000, 0.1, 4)


def effort_of(log: Log) -> np.ndarray:
    """Return the effort of a log that has one [N or N*m], shape (sample,)."""
    assert log.effort is not None
    return log.effort.values


def spread(size: int, length: int) -> list[slice]:
    """Return `PIECES` slices of `length` samples, evenly spaced over `size` samples."""
    return [
        slice(first, first + length)
        for first in np.linspace(0, size - length, PIECES).astype(int).tolist()
    ]


@cache
def _taps(decimation: int) -> np.ndarray:
    from scipy.signal import firwin

    return np.asarray(firwin(2 * REACH * decimation + 1, 1.0 / decimation, window="hamming"))


def mechanical(plant: Model, motion: Segment) -> np.ndarray:
    """Return the effort [N or N*m] of a plant along a segment without friction, shape (sample,)."""
    effort, beside = inverse_of(plant, motion), effort_of_columns(plant, motion.regressors)
    return effort if beside is None else effort + beside


def inverse_of(plant: Model, motion: Segment | Dataset) -> np.ndarray:
    """Return the effort of a plant along a segment or in rows, without friction and known columns."""
    inverse = plant.component.inverse
    if inverse is None:
        raise InputError(
            "has no inverse dynamics in bristle",
            path="plant",
            value=plant.name,
            allowed="inertia, oscillator",
        )
    return inverse(motion.position, motion.velocity, motion.acceleration, plant.parameters)


def transmitted_by(friction: Model, plant: Model | None, segment: Segment) -> np.ndarray | None:
    """Return the effort transmitted to the load along a segment [N or N*m]; None if friction does not depend on it."""
    if plant is None or not rises_with_effort(friction):
        return None
    return mechanical(plant, segment)


@dataclass(frozen=True)
class Segment:
    """A segment of the log without gaps, at the rate of the log; position and effort have passed the same filter."""

    # [s]; each array has shape (sample,), edges included, over which a model with memory settles
    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray  # +0.0 or -0.0 means rest after a forward or backward motion
    acceleration: np.ndarray
    effort: np.ndarray
    recorded: np.ndarray  # position [m or rad], not filtered
    log: int = 0  # number of the log
    # Recorded quantities, by name [SI]
    surroundings: Mapping[str, np.ndarray] = field(default_factory=dict)
    first_cycle: int = 0  # number of samples that are run before the segment of a periodic motion
    regressors: tuple[np.ndarray, ...] = ()  # filtered; a coefficient converts them to effort

    def part(
        self, samples: slice, dt: float, transmitted: np.ndarray | None = None
    ) -> dict[str, np.ndarray]:
        """Return the input signals of friction along some samples."""
        v, x = self.velocity[samples], self.position[samples]
        # The velocity at a sample is the mean over the step around it, which ends half a step later.
        signals = {"v": v, "x": x + 0.5 * dt * v} | {
            name: values[samples] for name, values in self.surroundings.items()
        }
        return signals if transmitted is None else signals | {"transmitted": transmitted[samples]}

    def cut(self, samples: slice) -> Segment:
        """Return some of the samples as a segment."""
        arrays = {
            name: getattr(self, name)[samples]
            for name in ("time", "position", "velocity", "acceleration", "effort", "recorded")
        }
        around = {name: values[samples] for name, values in self.surroundings.items()}
        return replace(
            self,
            **arrays,
            surroundings=around,
            regressors=tuple(column[samples] for column in self.regressors),
        )

    def signals(self, dt: float, transmitted: np.ndarray | None = None) -> dict[str, np.ndarray]:
        """Return the input signals of friction along the segment, after its first cycle if it has one."""
        signals = self.part(slice(None), dt, transmitted)
        if not self.first_cycle:
            return signals
        return {
            name: np.concatenate([values[: self.first_cycle], values])
            for name, values in signals.items()
        }

    def friction(
        self,
        model: Model,
        dt: float,
        contact: float | None = None,
        transmitted: np.ndarray | None = None,
    ) -> np.ndarray:
        """Return the force of a friction model along the segment [N or N*m], from the initial state `contact`, -1 to 1."""
        state = None if contact is None else state_at(model, contact)
        return along(model, dt=dt, state=state, **self.signals(dt, transmitted))[self.first_cycle :]


@dataclass(frozen=True)
class Dataset:
    """The segments of a log, and how a signal along them becomes rows of a regression."""

    segments: tuple[Segment, ...]
    kind: Kind
    sample_time: float
    resolution: float
    noise: float
    cutoff: float
    decimation: int
    dropped: int
    held: bool | None = None
    keeps_rests: bool = False
    delay: float = 0.0
    row_mask: np.ndarray | None = None
    effort_noise: float = 0.0
    alignment: Alignment | None = None
    creeping: bool = False
    units: Mapping[str, str] = field(default_factory=dict)
    calmed_from: float = 0.0

    def excerpt(self) -> Dataset | None:
        """Return pieces of a long log for the start of a search; None if they are half of the log, or mostly rest."""
        total = sum(segment.time.size for segment in self.segments)
        share = max(EXCERPT / total, EXCERPT_SHARE)
        if (
            share > 0.5
            or self.row_mask is not None
            or any(segment.first_cycle for segment in self.segments)
        ):
            return None
        pieces = list[Segment]()
        for segment in self.segments:
            size = segment.time.size
            length = max(round(share * size / PIECES), 10 * self.dropped)
            if PIECES * length > 0.5 * size:
                pieces.append(segment)
                continue
            pieces += map(segment.cut, spread(size, length))
        part = replace(self, segments=tuple(pieces))
        share = sum(piece.time.size for piece in pieces) / total
        is_like_all = np.count_nonzero(part.in_motion) > 0.5 * share * np.count_nonzero(
            self.in_motion
        )
        return part if share <= 0.5 and is_like_all else None

    def explained(
        self, plant: Model, friction: Model, contacts: Sequence[float | None] | None = None
    ) -> list[np.ndarray]:
        """Return the effort of plant and friction along each segment [N or N*m]; `contacts` as below."""
        pairs = zip(self.segments, self.friction_along(friction, plant, contacts), strict=True)
        return [self.mechanical_along(plant, segment) + force for segment, force in pairs]

    def mechanical_along(self, plant: Model, segment: Segment) -> np.ndarray:
        """Return the effort of a plant along a segment [N or N*m]; terms nonlinear in the position are filtered."""
        terms = terms_of(plant)
        if terms is None:
            return mechanical(plant, segment)
        bent = effort_of_place(segment.position, terms)
        return mechanical(plant, segment) - bent + self.filtered(bent)

    def mechanical_rows(self, plant: Model) -> np.ndarray:
        """Return the effort of a plant in each row, without friction [N or N*m]."""
        if terms_of(plant) is None:
            return inverse_of(plant, self)
        return self.rows_of([self.mechanical_along(plant, segment) for segment in self.segments])

    def friction_along(
        self,
        friction: Model,
        plant: Model | None = None,
        contacts: Sequence[float | None] | None = None,
    ) -> list[np.ndarray]:
        """Return the friction force along each segment [N or N*m], filtered; by default the `contacts` that fit the effort best."""
        contacts = self.contacts(friction, plant) if contacts is None else contacts
        return [
            self.filtered(
                segment.friction(
                    friction, self.sample_time, contact, transmitted_by(friction, plant, segment)
                )
            )
            for segment, contact in zip(self.segments, contacts, strict=True)
        ]

    def contacts(self, friction: Model, plant: Model | None) -> tuple[float | None, ...]:
        """Return the state of the contact before each segment, from -1 to 1; None for a model without this state."""
        if plant is None or friction.component.start is None:
            return (None,) * len(self.segments)
        places = []
        for segment in self.segments:
            signals = segment.signals(self.sample_time, transmitted_by(friction, plant, segment))
            ahead = {name: values[segment.first_cycle :] for name, values in signals.items()}
            places.append(
                place_of(
                    friction, ahead, self.sample_time, segment.effort - mechanical(plant, segment)
                )
            )
        return tuple(places)

    def break_aways(self, plant: Model, offset: float) -> tuple[BreakAway, ...]:
        """Return the break-aways of the log, from the effort minus `plant` and a constant force [N or N*m]."""
        recordings = [
            Recording(
                segment.time, segment.position, segment.effort - mechanical(plant, segment) - offset
            )
            for segment in self.segments
        ]
        return break_aways(
            recordings,
            cutoff=self.cutoff,
            sample_time=self.sample_time,
            resolution=self.resolution,
            noise=self.noise,
        )

    def filtered(self, part: np.ndarray) -> np.ndarray:
        """Return a signal along a segment after the filter of effort and position."""
        return low_passed(part, self.cutoff, self.sample_time)

    def without_edges(self, part: np.ndarray) -> np.ndarray:
        """Return a signal along a segment without the transients of the filter at its edges."""
        return part[self.dropped : part.size - self.dropped]

    def rows_of(self, parts: Iterable[np.ndarray]) -> np.ndarray:
        """Return the rows of a signal given along each whole segment, shape (row,)."""
        return self._thinned(parts)[self.in_motion]

    def rows_of_tangents(self, blocks: Iterable[Block], count: int) -> np.ndarray:
        """Return all rows of `count` samples of a segment, shape (row, direction), filtered, from tangents block by block."""
        taps = _taps(self.decimation) if self.decimation > 1 else np.ones(1)
        return filtered_rows(
            blocks,
            count,
            *butterworth(self.cutoff, self.sample_time),
            self.dropped,
            self.decimation,
            taps,
        )

    def sampled(self, parts: Iterable[np.ndarray]) -> np.ndarray:
        """Return the samples of a signal at the rows, without the decimating filter."""
        return np.concatenate([self.without_edges(part)[:: self.decimation] for part in parts])[
            self.in_motion
        ]

    def _thinned(self, signals: Iterable[np.ndarray]) -> np.ndarray:
        from scipy.signal import resample_poly

        parts, step = list[np.ndarray](), self.decimation
        for signal in signals:
            part = self.without_edges(signal)
            parts.append(
                part
                if step == 1
                else np.asarray(resample_poly(part, 1, step, window=_taps(step), padtype="edge"))
            )
        return np.concatenate(parts)

    @cached_property
    def in_motion(self) -> np.ndarray:
        """Mask of the decimated samples that are rows, shape (sample,) of bool."""
        if self.row_mask is not None:
            return self.row_mask
        if self.keeps_rests:
            return np.ones(self._thinned(self._signals("time")).size, dtype=bool)
        # Weights of the motion, not of the rests: a filter of a signal that stays at zero computes with denormal numbers, 20 times slower.
        moving = [
            self.filtered((segment.velocity != 0.0).astype(float)) for segment in self.segments
        ]
        # Weight of samples at rest that a row may contain.
        return np.abs(1.0 - self._thinned(moving)) < 0.01

    @property
    def response(self) -> np.ndarray:
        """Weights of the samples around a row in this row, shape (2 n + 1,); their sum is 1."""
        # By then, the response has decayed.
        beside = REACH_PERIODS * 2 * math.ceil(1.0 / (self.cutoff * self.sample_time))
        impulse = np.zeros(2 * beside + 1)
        impulse[beside] = 1.0
        passed = self.filtered(impulse)
        return np.convolve(passed, _taps(self.decimation)) if self.decimation > 1 else passed

    @property
    def reach(self) -> int:
        """Reach of the filters to either side, in rows."""
        return math.ceil(REACH_PERIODS / (self.cutoff * self.sample_time * self.decimation)) + (
            REACH if self.decimation > 1 else 0
        )

    def _signals(self, name: str) -> Iterator[np.ndarray]:
        """Return a signal of all segments."""
        return map(attrgetter(name), self.segments)

    @cached_property
    def time(self) -> np.ndarray:
        """Time of each row [s]."""
        return self.sampled(self._signals("time"))

    @cached_property
    def position(self) -> np.ndarray:
        """Position of each row [m or rad]."""
        return self.rows_of(self._signals("position"))

    @cached_property
    def velocity(self) -> np.ndarray:
        """Velocity of each row [m/s or rad/s]."""
        return self.rows_of(self._signals("velocity"))

    @cached_property
    def acceleration(self) -> np.ndarray:
        """Acceleration of each row [m/s^2 or rad/s^2]."""
        return self.rows_of(self._signals("acceleration"))

    @cached_property
    def effort(self) -> np.ndarray:
        """Effort of each row [N or N*m]."""
        return self.rows_of(self._signals("effort"))

    @cached_property
    def log_of_row(self) -> np.ndarray:
        """Number of the log of each row."""
        return self.sampled([np.full(segment.time.size, segment.log) for segment in self.segments])

    @cached_property
    def segment_of_row(self) -> np.ndarray:
        """Number of the segment of each row."""
        return self.sampled(
            [np.full(segment.time.size, number) for number, segment in enumerate(self.segments)]
        )

    @property
    def off_grid(self) -> bool:
        """Whether the recorded position changes by fractions of the stated encoder step, as a filtered position does."""
        if self.resolution <= 0.0:
            return False
        steps = (
            np.concatenate([np.diff(segment.recorded) for segment in self.segments])
            / self.resolution
        )
        # 1 where the step is that of the log itself
        smallest = np.min(np.abs(steps[steps != 0.0]), initial=1.0)
        return bool(
            smallest < 1.0 - OFF_GRID
            and np.mean(np.abs(steps - np.round(steps)) > OFF_GRID) > OFTEN
        )

    @property
    def bandwidth(self) -> float:
        """Highest frequency that the rows contain [Hz]."""
        return min(self.cutoff, 0.5 / (self.sample_time * self.decimation))

    @property
    def acceleration_noise_share(self) -> float:
        r"""Share of noise in the mean square of the acceleration; it biases the inertia towards zero.

        White noise of the position, differentiated twice up to the bandwidth `f`, has the mean square
        :math:`\tfrac{2}{5} \Delta t \sigma^2 (2\pi)^4 f^5`. Noise that is not white is estimated from its effect on
        the inertia.
        """
        square = 0.4 * self.sample_time * self.noise**2 * (2.0 * np.pi) ** 4 * self.bandwidth**5
        total = float(np.mean(self.acceleration**2))
        share = min(square / total, 1.0) if total > 0.0 else 1.0
        return max(share, self.alignment.too_small) if self.alignment else share

    @property
    def all_velocities(self) -> np.ndarray:
        """Velocity of every sample [m/s or rad/s], without edges."""
        parts = list(map(self.without_edges, self._signals("velocity")))
        return parts[0] if len(parts) == 1 else np.concatenate(parts)

    @property
    def rest_share(self) -> float:
        """Share of the samples at rest."""
        return float(np.mean(self.all_velocities == 0.0))

    @cached_property
    def reversals(self) -> tuple[tuple[int, ...], ...]:
        """First sample after each change of direction in each segment, without edges."""
        edge, inside = self.dropped, list[tuple[int, ...]]()
        for velocity in self._signals("velocity"):
            first = reversals(velocity, sided=True)
            inside.append(tuple(first[(edge < first) & (first < velocity.size - edge)].tolist()))
        return tuple(inside)

    @cached_property
    def samples_from_reversal(self) -> np.ndarray:
        """Samples between each row and the nearest reversal of its segment; infinite without a reversal."""
        return self._samples_from(self.reversals)

    @cached_property
    def samples_from_rest(self) -> np.ndarray:
        """The same to the nearest reversal or sample at rest."""
        rests = [np.flatnonzero(segment.velocity == 0.0).tolist() for segment in self.segments]
        return self._samples_from(
            [sorted({*at, *turns}) for at, turns in zip(rests, self.reversals, strict=True)]
        )

    def _samples_from(self, places: Sequence[Sequence[int]]) -> np.ndarray:
        distances = []
        for segment, marked in zip(self.segments, places, strict=True):
            ends, sample = np.array([-math.inf, *marked, math.inf]), np.arange(segment.time.size)
            after = np.searchsorted(ends, sample)
            distances.append(np.minimum(sample - ends[after - 1], ends[after] - sample))
        return self.sampled(distances)


@dataclass(frozen=True)
class Alignment:
    """The delay and filter between effort and position of a log, and the inertia estimated with them."""

    delay: float | None = None
    delay_half_width: float | None = None
    smoothing: float | None = None
    smoothing_half_width: float | None = None
    mass: float | None = None
    mass_half_width: float | None = None
    slow: float = 0.0
    sought: bool = True
    of_position: bool = False
    filter_open: bool = False
    too_small: float = (
        0.0  # relative bias of the least-squares inertia by position noise; 0 if not significant
    )

    def as_data(self) -> dict[str, float]:
        """Return the known values, as in the treatment of a log."""
        smoothing = "position_smoothing" if self.of_position else "smoothing"
        data = {
            "delay": self.delay,
            "delay_half_width": self.delay_half_width,
            smoothing: abs(self.smoothing or 0.0) if self.of_position else self.smoothing,
            f"{smoothing}_half_width": self.smoothing_half_width,
            "mass": self.mass,
            "mass_half_width": self.mass_half_width,
            "slow": self.slow,
        }
        return {name: value for name, value in data.items() if value}
