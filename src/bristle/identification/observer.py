r"""Prediction errors: the parameters with which a loose observer best predicts the recorded position.

.. math:: \hat\theta = \arg\min_\theta \sum_k \bigl[q_k - \hat q_{k|k-1}(\theta)\bigr]^2

The recorded effort moves the simulated axis, and an observer corrects it by the recorded position
(`bristle.engine.observer`). Encoder rounding is then output noise, and the position is never differentiated: the
simulated motion moves the contact, also at rest. The effort is corrected for a delay :math:`\tau` and for a smoothing
by :math:`e^{-c\,\omega^2}`. A filter of time constant `T` has :math:`c = T^2 / 2`, a hold has
:math:`-\Delta t^2 / 24`.

The bandwidth of the observer is lowered step by step until it drifts [1]_. Each step starts from the result of the last.
`bristle.identification.ladder` is the mean of these rungs.

References
----------
.. [1] L. Ljung, "System Identification: Theory for the User", 2nd ed., Prentice Hall, 1999.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, cast

import numpy as np

from bristle.core.lazy import cached_property
from bristle.core.normal import NORMAL_95
from bristle.core.packing import pack
from bristle.core.variable import Variable
from bristle.engine.loop_derivatives import Sensitive
from bristle.engine.observer import prediction_errors
from bristle.identification.dataset import PIECES, Alignment, effort_of, spread
from bristle.identification.estimation import Context
from bristle.identification.fixed_shape import ShapedModel
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.least_squares import Report, silent
from bristle.identification.level_scatter import LevelScatter, starts_of
from bristle.identification.observed_elements import SpreadModel, spread_out, spreads
from bristle.identification.parameter_space import Solution
from bristle.identification.parameters import Fixed, ParameterSet, Role, Scales, name_of, names_of
from bristle.identification.sensitivities import Perturbed
from bristle.logs.filters import through_filter
from bristle.logs.log import Log
from bristle.models.friction.level import TRANSMITTED

DELAY, BEND = "delay", "bend"
RATE = 4e3  # steps of the integration in a second, at least
# Bandwidth of the stiffest observer [Hz], ratio of consecutive bandwidths, number of rungs.
FIRST, LOOSER, RUNGS = (100.0, 0.6, 7)
HIGHEST = 0.1  # of the sampling frequency: the stiffest observer
DRIFTS = 6.0  # times the smallest prediction error: end of a ladder
FEW = 6  # evaluations of a further start
STARTS = ((1.0, 0.01, 0.15), (0.5, 0.02, 0.5), (1.0, 0.03, 0.5))
"""Further starts: factor of the stiffness, share of the largest speed, share of the square root of stiffness and mass."""
SETTLES = 0.3  # s, after which the start of an observer has decayed
SHARPEST = 0.7  # largest exponent of the sharpening of an effort
BESIDE = 256  # samples by which an effort is extended beyond its ends
# Weight of a weak prior in rows, and of a level from inverse dynamics.
WEIGHT, LEVELS_WEIGHT = (30.0, 10.0)
BEND_STD = 5e-7  # s^2: prior of the bend
# priors: Stribeck velocity over the largest speed; logarithm of break-away over the level
FALLS, EXCESS = (0.02, 0.3)
SLOWEST = 1e-4  # of the largest speed: the smallest Stribeck velocity
SHORTEST, MOST = 1.0, 150_000  # s: shortest segment; total samples, of which pieces are used beyond
EVALUATIONS, ENDED = 15, 1e-4  # of a descent; relative change of its cost that ends it
ROUNDED = 0.25  # of an encoder step: prediction errors are no smaller


@dataclass(frozen=True)
class Recorded:
    """A segment of a log: position [m or rad], effort [N or N*m], and known columns, shape (sample,) each."""

    position: np.ndarray
    effort: np.ndarray
    columns: tuple[np.ndarray, ...]

    @cached_property
    def _swing(self) -> tuple[np.ndarray, np.ndarray, int]:
        """The line between the ends of the effort, the spectrum of the deviation from it, and its number of samples."""
        from scipy.fft import next_fast_len, rfft

        count = self.effort.size
        ramp, beside = np.linspace(self.effort[0], self.effort[-1], count), min(count - 1, BESIDE)
        swing, fades = (
            self.effort - ramp,
            0.5 + 0.5 * np.cos(np.pi * np.arange(1, beside + 1) / beside),
        )
        around = np.zeros(cast(int, next_fast_len(count + 2 * beside, real=True)))
        # The swing is 0 at both ends: rotated about them it continues without a jump.
        around[:count], around[count : count + beside] = (
            swing,
            -fades * swing[-2 : -2 - beside : -1],
        )
        around[around.size - beside :] = -fades[::-1] * swing[beside:0:-1]
        return ramp, np.asarray(rfft(around)), around.size

    def efforts(self, delay: float, bend: float, dt: float) -> np.ndarray:
        """Return the corrected effort, and its derivatives by delay and bend, at the samples and once beyond, shape (3, sample + 1)."""
        from scipy.fft import irfft

        ramp, spectrum, around = self._swing
        count, slope = ramp.size, (ramp[-1] - ramp[0]) / (max(ramp.size - 1, 1) * dt)
        omega = 2.0 * np.pi * np.fft.rfftfreq(around, dt)
        sharper = bend * omega**2
        moved = spectrum * np.exp(1j * omega * delay + np.minimum(sharper, SHARPEST))
        parts = np.asarray(
            irfft(
                [moved, 1j * omega * moved, np.where(sharper < SHARPEST, omega**2, 0.0) * moved],
                around,
            )
        )[:, :count]
        parts[0] += ramp + slope * delay
        parts[1] += slope
        return np.hstack([parts, parts[:, -1:]])


@dataclass(frozen=True)
class PredictionErrors:
    """The prediction errors of an observer of a `bandwidth` [Hz]; each prior in `expected` is an additional row."""

    inverse: InverseDynamics  # the same model as inverse dynamics
    parts: tuple[Recorded, ...]
    bandwidth: float
    expected: tuple[Expected, ...] = ()
    unit: float = 1.0
    lag: float = 0.0
    scatter: LevelScatter | None = None

    @property
    def parameters(self) -> ParameterSet:
        """The free and fixed parameters."""
        return self.inverse.parameters

    @property
    def dt(self) -> float:
        """Sample time [s]."""
        return self.inverse.dataset.sample_time

    @cached_property
    def measured(self) -> np.ndarray:
        """The recorded position of all segments [m or rad], shape (sample,)."""
        return np.concatenate([part.position for part in self.parts])

    def excerpt(self) -> None:
        """Return None: the ladder starts from the result of inverse dynamics."""

    def residual(self, free: Mapping[str, float]) -> np.ndarray:
        """Return the prediction error of each sample [m or rad], and the priors as further rows."""
        return self.linearised(free)[0]

    def linearised(self, free: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray]:
        """Return the residual, and the derivative of the predicted position by each free parameter, shape (row, free)."""
        values, names = self.parameters.complete(free), self.parameters.free
        plant, friction = (
            Perturbed(self.inverse.plant, values, names),
            Perturbed(self.inverse.model, values, names),
        )
        virgin = friction.slopes(lambda near: pack(near.component.initial_state(near.parameters)))
        body, contact = (
            Sensitive(plant.model, plant.parameters()),
            Sensitive(friction.model, friction.parameters(), state_tangents=virgin),
        )
        settled, rows = round(SETTLES / self.dt), list[np.ndarray]()
        weights, tangents = self._weights(values, names)
        for part in self.parts:
            efforts = np.vstack(
                [
                    part.efforts(values[DELAY], values[BEND], self.dt),
                    *(-np.append(column, column[-1:]) for column in part.columns),
                ]
            )
            omega = 2.0 * np.pi * self.bandwidth
            errors = prediction_errors(
                body, contact, part.position, efforts, weights, tangents, omega, self.dt, self.steps
            )
            rows.append(np.column_stack(errors)[settled:])
        predicted = np.vstack(rows)
        stacked = np.vstack(
            [self.scatter.whitened(predicted) if self.scatter else predicted, self.beforehand(free)]
        )
        return stacked[:, 0], -stacked[:, 1:]

    def beforehand(self, free: Mapping[str, float]) -> np.ndarray:
        """Return the deviations of the parameters from their priors, and the derivatives, shape (expectation, 1 + free)."""
        values, names = self.parameters.complete(free), self.parameters.free
        rows = [expectation.row(values, names, self.unit) for expectation in self.expected]
        return np.reshape(rows, (len(rows), 1 + len(names)))

    def size_at(self, values: Mapping[str, float]) -> float:
        """Return the root mean square of the prediction errors at these parameters [m or rad]."""
        return float(
            np.sqrt(
                np.mean(
                    self.residual({name: values[name] for name in self.parameters.free})[
                        : self.settled_rows
                    ]
                    ** 2
                )
            )
        )

    def scattering(self, values: Mapping[str, float], scatter: float) -> PredictionErrors:
        """Return the same problem with this relative `scatter` of the friction level between half-cycles."""
        variables, free = self.parameters.component.variables, self.parameters.free
        levels = [
            name
            for role in (Role.LEVEL, Role.BREAK_AWAY)
            for name in names_of(role, variables)
            if name in free
        ]
        if not scatter or not levels:
            return self
        plain = replace(self, scatter=None)
        derivatives = plain.linearised({name: values[name] for name in free})[1][
            : self.settled_rows
        ]
        column = np.sum(
            derivatives[:, [free.index(name) for name in levels]]
            * [values[name] for name in levels],
            axis=1,
        )
        starts = starts_of(
            [part.position for part in self.parts], round(SETTLES / self.dt), self.dt
        )
        # A reversal shows the mean of the levels before and after it.
        return replace(
            self, scatter=LevelScatter.of(starts, column, scatter / math.sqrt(2.0), self.unit)
        )

    def of_size(self, size: float) -> PredictionErrors:
        """Return the same problem with this typical prediction error [m or rad]."""
        return replace(self, unit=max(size, ROUNDED * self.inverse.dataset.resolution))

    def _weights(
        self, values: Mapping[str, float], names: Sequence[str]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the weights of efforts and known columns, and their derivatives, shapes (column,) and (column, parameter)."""
        plant = self.parameters.plant
        columns = [f"known_{name}" for name in getattr(plant, "columns", ())]
        weights = np.array([1.0, 0.0, 0.0, *map(values.__getitem__, columns)])
        moving = ["", DELAY, BEND, *columns]
        return weights, np.array([[float(name == column) for name in names] for column in moving])

    @property
    def steps(self) -> int:
        """Steps of the integration in a sample."""
        return steps_of(self.dt)

    @property
    def settled_rows(self) -> int:
        """Number of rows with prediction errors."""
        return sum(max(part.position.size - round(SETTLES / self.dt), 0) for part in self.parts)


def steps_of(dt: float) -> int:
    """Return the steps of the integration in a sample [s]."""
    return max(math.ceil(RATE * dt), 2)


class Expected(NamedTuple):
    """Prior of a product of powers of parameters, or of its logarithm: `mean`, `std`, and a weight in rows."""

    powers: Mapping[str, float]
    logarithmic: bool
    mean: float
    std: float
    weight: float = WEIGHT

    def row(self, values: Mapping[str, float], names: Sequence[str], unit: float) -> np.ndarray:
        """Return the deviation from the prior, and its derivatives, as a row of a residual of this unit."""
        product = math.prod(values[name] ** power for name, power in self.powers.items())
        slopes = [
            self.powers.get(name, 0.0) * (product / values[name] if values[name] else 1.0)
            for name in names
        ]
        far, slopes = (
            (math.log(product), np.array(slopes) / product)
            if self.logarithmic
            else (product, np.array(slopes))
        )
        return unit * math.sqrt(self.weight) / self.std * np.array([far - self.mean, *slopes])


class Rung(NamedTuple):
    """One step of the ladder: its problem, its solution, and the root mean square of its prediction errors [m or rad]."""

    problem: PredictionErrors
    solution: Solution
    error: float


def observable(inverse: InverseDynamics, free: Mapping[str, float]) -> bool:
    """Return whether an observer supports a model: a mass, a contact stiffness, and no recorded surroundings."""
    component, values = inverse.parameters.component, inverse.parameters.complete(free)
    # The effort of a sensor next to the contact does not move a mass.
    if (isinstance(component, ShapedModel) and not spreads(component)) or (
        inverse.dataset.keeps_rests and not inverse.dataset.creeping
    ):
        return False
    recorded = (
        any(surrounding.is_recorded for surrounding in component.surroundings)
        or TRANSMITTED in component.variables.values()
    )
    moves = all(
        values[name] > 0.0 for name in names_of(Role.INERTIA, inverse.parameters.plant.variables)
    )
    return moves and bool(names_of(Role.STIFFNESS, component.variables)) and not recorded


def climb(
    inverse: InverseDynamics,
    start: Mapping[str, float],
    logs: Sequence[Log],
    context: Context,
    held: Mapping[str, Fixed],  # fixed parameters
    # Priors of the friction levels, with standard errors.
    levels: Mapping[str, tuple[float, float]],
    scatter: float = 0.0,  # of the level between half-cycles
    report: Report = silent,
) -> tuple[Rung, ...]:
    """Return the rungs of a ladder from these free parameters [SI]; empty without a long segment, or if every observer loses the motion."""
    if isinstance(inverse.parameters.component, ShapedModel):
        inverse, start = spread_out(inverse, start)
    dataset, dt, parameters = inverse.dataset, inverse.dataset.sample_time, inverse.parameters
    alignment = dataset.alignment or Alignment()
    bend = 0.0 if dataset.held is False else -(dt**2) / 24.0
    values = {
        **parameters.complete(start),
        DELAY: (alignment.delay or 0.0) - 0.5 * dt * bool(dataset.held),
        BEND: bend,
    }
    # Filtered rows may hide a fall of friction that a contact shows.
    speed = float(np.max(np.abs(dataset.velocity)))
    falls = [
        name
        for name in names_of(Role.FALL, parameters.component.variables)
        if parameters.is_redundant(name)
    ]
    values |= dict.fromkeys(falls, FALLS * speed)
    fixed = {
        name: entry for name, entry in ({**parameters.fixed, **held}).items() if name not in falls
    }
    free = [name for name in parameters.variables if name not in fixed]
    parameters = replace(parameters, free=(*free, DELAY, BEND), fixed=fixed, loop=_channel(dt))
    problem = replace(inverse, parameters=parameters)
    parts, expected = tuple(_parts(logs, alignment, dt)), _expected(problem, values, speed, levels)
    if not parts:
        return ()
    stiffest, least, rungs, begun = min(FIRST, HIGHEST / dt), math.inf, list[Rung](), values
    errors = PredictionErrors(problem, parts, stiffest, expected, lag=effort_lag(alignment))
    errors = errors.of_size(errors.size_at(values))
    for number in range(RUNGS):
        # The first rung has five climbs, and mostly three rungs follow.
        report(min((number + 4.0 * (number > 0)) / 8.0, 1.0))
        errors = replace(errors, bandwidth=stiffest * LOOSER**number).scattering(values, scatter)
        rung = climbed(errors, values, context)
        if number == 0:
            ends = [
                rung,
                *(
                    climbed(errors, further, context, FEW)
                    for further in _starts(values, problem, speed)
                ),
            ]
            best = min(ends, key=_error_of)
            rung = (
                rung
                if best is rung
                else climbed(errors, {**values, **best.solution.values}, context)
            )
        elif isinstance(parameters.component, SpreadModel):
            # From elements without force the search does not find each minimum.
            rung = min(rung, climbed(errors, begun, context), key=_error_of)
        if not (math.isfinite(rung.error) and rung.error <= DRIFTS * least):
            break
        rungs.append(rung)
        values, least = {**values, **rung.solution.values}, min(least, rung.error)
        errors = errors.of_size(rung.error)
    return tuple(rungs)


def _error_of(rung: Rung) -> float:
    return rung.error if math.isfinite(rung.error) else math.inf


def effort_lag(alignment: Alignment) -> float:
    """Return the time constant of the filter applied to the effort of a log [s]; negative for its inverse."""
    return 0.0 if alignment.of_position else -(alignment.smoothing or 0.0)


def _starts(
    values: Mapping[str, float], inverse: InverseDynamics, speed: float
) -> Iterator[dict[str, float]]:
    """Yield further starts: other stiffness, Stribeck velocity and contact damping."""
    component = inverse.parameters.component
    if isinstance(component, SpreadModel):
        yield from component.starts(values)
        return
    variables, free = component.variables, inverse.parameters.free
    mass = name_of(Role.INERTIA, inverse.parameters.plant.variables)
    roles = (Role.STIFFNESS, Role.FALL, Role.MICRO_DAMPING)
    stiff, falls, damped = (
        [name for name in names_of(role, variables) if name in free] for role in roles
    )
    pairs = list(
        zip(names_of(Role.BREAK_AWAY, variables), names_of(Role.LEVEL, variables), strict=False)
    )
    for softer, fall, damping in STARTS:
        start = dict(values)
        start.update((name, softer * values[name]) for name in stiff)
        start.update((name, fall * speed) for name in falls)
        start.update(
            (name, math.exp(EXCESS) * values[level]) for name, level in pairs if name in free
        )
        if stiff and mass:
            start.update(
                (name, damping * (start[stiff[0]] * values[mass]) ** 0.5) for name in damped
            )
        yield start


def climbed(
    errors: PredictionErrors, start: Mapping[str, float], context: Context, limit: int = EVALUATIONS
) -> Rung:
    """Return the rung that starts from these parameters."""
    search = replace(
        context, scales=_finer(context.scales, errors.inverse.dataset.resolution)
    ).search(errors, errors.unit)
    begun = {name: start[name] for name in errors.parameters.free}
    solution = search.descend(
        search.space.theta(errors.parameters.complete(begun)), limit=limit, tolerance=ENDED
    )
    beforehand = errors.beforehand(solution.values)[:, 0]
    squares = 2.0 * solution.cost * errors.unit**2 - float(beforehand @ beforehand)
    # An observer that lost the motion has no prediction error left over the priors.
    return Rung(
        errors, solution, math.sqrt(squares / errors.settled_rows) if squares > 0.0 else math.inf
    )


def _finer(scales: Scales, step: float) -> Scales:
    """Return scales that include motion between samples, down to an encoder step: an observer moves more finely than the log."""
    return scales._replace(
        shortest=min(scales.shortest, step or scales.shortest),
        slowest=min(scales.slowest, SLOWEST * scales.speed),
    )


def _parts(logs: Sequence[Log], alignment: Alignment, dt: float) -> Iterator[Recorded]:
    """Yield the long segments of logs, or pieces of them, with the effort before a known filter."""
    lag, share = effort_lag(alignment), min(MOST / sum(map(len, logs)), 1.0)
    position_lag = 0.0 if lag else alignment.smoothing or 0.0
    for log in logs:
        for part in log.segments or (slice(None),):
            position, effort = log.position.values[part], effort_of(log)[part]
            if position.size * dt <= SHORTEST:
                continue
            effort = through_filter(effort, lag, dt) if lag else effort
            position = (
                through_filter(position - position[0], position_lag, dt) + position[0]
                if position_lag
                else position
            )
            length = max(int(share * position.size / PIECES), math.ceil(SHORTEST / dt))
            for piece in (
                spread(position.size, length) if PIECES * length < position.size else [slice(None)]
            ):
                yield Recorded(
                    position[piece].copy(),
                    effort[piece],
                    tuple(column.values[part][piece] for column in log.regressors),
                )


def _channel(dt: float) -> dict[str, Variable]:
    """Return the unknown parameters of the channel of the effort."""
    return {
        DELAY: Variable(
            "time",
            "delay of the effort",
            min=-20.0 * dt,
            max=20.0 * dt,
            nominal=dt,
            excitation="drive",
        ),
        BEND: Variable("time^2", "smoothing of the effort", nominal=dt**2, excitation="drive"),
    }


def _expected(
    inverse: InverseDynamics,
    start: Mapping[str, float],
    speed: float,
    beside: Mapping[str, tuple[float, float]],
) -> tuple[Expected, ...]:
    """Return the priors of the channel, and of parameters that a log may not show."""
    variables, parameters = inverse.parameters.component.variables, inverse.parameters
    expected, alignment = (
        [Expected({BEND: 1.0}, False, start[BEND], BEND_STD)],
        inverse.dataset.alignment,
    )
    if alignment is not None and alignment.delay_half_width is not None:
        expected.append(
            Expected({DELAY: 1.0}, False, start[DELAY], alignment.delay_half_width / NORMAL_95)
        )
    free, levels = set(parameters.free), names_of(Role.LEVEL, variables)
    stiffness, mass = (
        name_of(Role.STIFFNESS, variables),
        name_of(Role.INERTIA, parameters.plant.variables),
    )
    falls = [name for name in names_of(Role.FALL, variables) if name in free]
    firsts = [
        pair
        for pair in zip(names_of(Role.BREAK_AWAY, variables), levels, strict=False)
        if pair[0] in free
    ]
    damped = [
        name
        for name in names_of(Role.MICRO_DAMPING, variables)
        if name in free and stiffness and mass
    ]
    expected += [
        Expected({name: 1.0}, False, mean, std, LEVELS_WEIGHT)
        for name, (mean, std) in beside.items()
        if name in free
    ]
    if isinstance(parameters.component, SpreadModel):
        expected += [
            Expected({name: 1.0}, False, level, level)
            for name, level in parameters.component.equal(start).items()
        ]
    expected += [Expected({name: 1.0}, True, math.log(FALLS * speed), 1.5) for name in falls]
    expected += [Expected({name: 1.0, level: -1.0}, True, EXCESS, EXCESS) for name, level in firsts]
    expected += [
        Expected({name: 1.0, str(stiffness): -0.5, str(mass): -0.5}, False, 0.5, 0.6)
        for name in damped
    ]
    return tuple(expected)
