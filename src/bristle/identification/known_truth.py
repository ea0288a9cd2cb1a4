"""Recovery test of a log: bristle simulates the identified axis along the recorded motion and identifies it again.

A simulated log has the motion, channel and encoder of the recorded log, with encoder steps of random phase. The friction
level scatters from half-cycle to half-cycle, and the effort is noisy. The simulated axis runs in a loop around the recorded
motion, so friction affects the motion. Friction that depends on a recorded channel, such as temperature, acts along the
recorded motion instead. The fit to a simulated log receives only the known data of the axis.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from bristle.core.axis import Axis
from bristle.core.edge import Progress
from bristle.core.errors import InputError
from bristle.core.values import numbers_of
from bristle.identification.dataset import Alignment, Dataset, effort_of
from bristle.identification.estimate import Estimate
from bristle.identification.half_cycles import Disturbance, disturbance_of
from bristle.identification.identify import identify
from bristle.identification.inverse_dynamics import InverseDynamics, RowReplicates
from bristle.identification.observed_fit import Channel, IdentifiedAxis
from bristle.identification.observer import Recorded, steps_of
from bristle.identification.parameters import ParameterSet, Role, name_of, names_of
from bristle.identification.preprocessing import aligned, treat
from bristle.identification.result import Fit, Identification
from bristle.logs.filters import through_filter
from bristle.logs.log import Log
from bristle.models.friction.level import TRANSMITTED
from bristle.models.friction.slots import OFFSET

SEED = 20_261_127
DETERMINED, ROUGH = 10.0, 50.0  # percent: limits of the errors
FEWEST = 0.5  # share of the simulated logs that must identify a determined parameter
FEWEST_DRAWS, MOST_DRAWS = 20, 100  # for the intervals of a fit to a simulated log
# Smallest share of intervals that contain the truth; fewest intervals for this verdict.
HOLD_LEAST, TELLING = (0.75, 5)


@dataclass(frozen=True)
class Determined:
    """Errors and intervals of one parameter, identified from simulated logs.

    Parameters
    ----------
    name : str
        Name of the parameter.
    unit : str
        SI unit for the kind of axis.
    description : str
        Meaning of the parameter.
    truth : float
        The value of the simulated axis in `unit`.
    relative_to : str
        The reference of relative errors: the parameter, or the friction level for a constant force.
    errors : ndarray, shape (fit,)
        Relative error of each fit that identified the parameter [%], not finite for a true value of zero.
    intervals : int
        Number of these fits with a 95 % interval.
    hold : int
        Number of these intervals that contain the true value.
    logs : int
        Number of simulated logs.
    """

    name: str
    unit: str
    description: str
    truth: float
    relative_to: str
    errors: np.ndarray
    intervals: int
    hold: int
    logs: int

    @property
    def identified(self) -> int:
        """Number of fits that identified the parameter."""
        return self.errors.size

    @property
    def median_error_percent(self) -> float | None:
        """Median of the errors, with its sign [%]."""
        return float(np.median(self.errors)) if np.isfinite(self.errors).any() else None

    @property
    def spread_percent(self) -> float | None:
        """Standard deviation of the errors [%]."""
        return float(np.std(self.errors, ddof=1)) if np.isfinite(self.errors).sum() > 1 else None

    @property
    def within_percent(self) -> float | None:
        """Median error and a 95 % prediction interval about it [%]: the bound of the error of a further log."""
        from scipy.special import stdtrit

        if self.median_error_percent is None or self.spread_percent is None:
            return None
        count = self.identified
        return (
            abs(self.median_error_percent)
            + float(stdtrit(count - 1, 0.975)) * self.spread_percent * (1.0 + 1.0 / count) ** 0.5
        )

    @property
    def verdict(self) -> str:
        """``determined``, ``rough`` or ``not determined``."""
        if self.within_percent is None or self.within_percent > ROUGH or self.is_rare:
            return "not determined"
        return "determined" if self.within_percent <= DETERMINED else "rough"

    @property
    def is_rare(self) -> bool:
        """Whether at most half of the fits identified the parameter."""
        return self.identified <= FEWEST * self.logs

    @property
    def too_narrow(self) -> bool:
        """Whether too few of the intervals contain the truth."""
        return self.intervals >= TELLING and self.hold < HOLD_LEAST * self.intervals

    @classmethod
    def by_simulated_logs(
        cls,
        logs: Sequence[Log],
        axes: Sequence[Axis | None],
        fit: Fit,
        treatment: Mapping[str, float],
        settings: Mapping[str, float],
        *,
        count: int = 10,
        progress: Progress | None = None,
    ) -> tuple[Determined, ...]:
        """Return the recovery of each parameter from simulated logs, with the models of `fit` and its treatment as the truth."""
        again = _same_fit(logs, axes, fit, treatment, settings)
        estimates, refused = list[Mapping[str, Estimate]](), list[InputError]()
        for number, seed in enumerate(np.random.SeedSequence(SEED).spawn(count)):
            rng = np.random.default_rng(seed)

            def report(share: float, _: str, number: int = number) -> None:
                if progress is not None:
                    progress(
                        (number + share) / count,
                        f"identifying simulated log {number + 1} of {count}",
                    )

            report(0.0, "")
            try:
                drawn = [
                    SimulatedLog(log, axis, fit, treatment).drawn(rng)
                    for log, axis in zip(logs, axes, strict=True)
                ]
                estimates.append(again(drawn, progress=report).best.parameters)
            except InputError as error:
                refused.append(error)
        if not estimates:
            raise refused[0]
        return tuple(
            _determined(fit, estimate, estimates, count)
            for estimate in fit.estimates
            if estimate.status != "held"
        )


def _same_fit(
    logs: Sequence[Log],
    axes: Sequence[Axis | None],
    fit: Fit,
    treatment: Mapping[str, float],
    settings: Mapping[str, float],
) -> Callable[..., Identification]:
    """Return `identify` with the arguments of a fit; reject a fit that cannot be simulated."""
    if fit.position_rmse is not None or fit.loop_rmse is not None:
        raise InputError(
            "were identified by a method for which bristle simulates no logs",
            path="results",
            value="output_error",
            allowed="inverse_dynamics or prediction_error",
            mend="Identify again with one of these methods",
        )
    if fit.resampling is None:
        raise InputError(
            "were identified without simulated logs, so the intervals and the scatter of the friction level are unknown",
            path="results",
            value="--draws 0",
            allowed="20 or more",
            mend="Identify again with --draws 100",
        )
    component = fit.friction.component
    shapes = [
        name
        for name, variable in component.variables.items()
        if name in component.defaults and not variable.excitation
    ]
    held = [
        estimate
        for estimate in fit.estimates
        if estimate.reason is not None and estimate.reason.code == "held_known"
    ]
    stated = {estimate.name: estimate.value for estimate in held}
    observed = any(diagnostic.code == "prediction_error" for diagnostic in fit.diagnostics)
    return partial(
        identify,
        model=component,
        axis=list(axes),  # type: ignore[arg-type]
        cutoff=treatment["cutoff"]
        if treatment["cutoff"] != treat(logs[0], axes[0]).cutoff
        else None,
        free=[
            estimate.name
            for estimate in fit.estimates
            if estimate.name in shapes and estimate.status != "held"
        ],
        mass=stated.get(name_of(Role.INERTIA, fit.plant.component.variables) or ""),
        offset=stated.get(name_of(OFFSET, component.variables) or ""),
        draws=min(max(fit.resampling.bands.count, FEWEST_DRAWS), MOST_DRAWS),
        method="prediction_error" if observed else "inverse_dynamics",
        settings=settings,
    )


class SimulatedLog(NamedTuple):
    """A simulated log of the identified axis along the motion of a recorded log."""

    log: Log
    axis: Axis | None
    fit: Fit
    treatment: Mapping[str, float]

    def drawn(self, rng: np.random.Generator) -> Log:
        """Return a simulated log."""
        log, component = self.log, self.fit.friction.component
        along = (
            any(part.is_recorded for part in component.surroundings)
            or TRANSMITTED in component.variables.values()
        )
        make = (
            self._along
            if along or getattr(self.fit.plant.component, "columns", ())
            else self._in_loop
        )
        assert log.effort is not None
        position, effort, segments, lag = (
            log.position.values.copy(),
            log.effort.values.copy(),
            list[slice](),
            self._channel.lag,
        )
        position_lag = self.treatment.get("position_smoothing", 0.0)
        for place, part in make(rng):
            effort[place] = (
                through_filter(part.effort, -lag, log.sample_time) if lag else part.effort
            )
            position[place] = (
                through_filter(part.position, position_lag, log.sample_time)
                if position_lag
                else part.position
            )
            segments.append(place)
        channels = {
            "position": replace(log.position, values=position),
            "effort": replace(log.effort, values=effort),
        }
        return replace(
            log, **channels, velocity=None, reference=None, injected=(), segments=tuple(segments)
        )

    @property
    def _channel(self) -> Channel:
        dt, held, treatment = (
            self.log.sample_time,
            self.axis.held if self.axis else None,
            self.treatment,
        )
        lag = -treatment.get("smoothing", 0.0)
        return Channel(
            treatment.get("delay", 0.0) - 0.5 * dt * bool(held),
            0.0 if held is False else -(dt**2) / 24.0,
            lag,
        )

    def _unseen(self, dataset: Dataset) -> Disturbance:
        assert self.fit.resampling is not None
        return disturbance_of(dataset, self.fit.resampling.bands.scatter)._replace(
            noise=self.fit.resampling.bands.noise
        )

    def _in_loop(self, rng: np.random.Generator) -> Iterator[tuple[slice, Recorded]]:
        """Yield the slice of each segment, and the record of the axis there in a loop around the recorded motion."""
        log, dt, channel = self.log, self.log.sample_time, self._channel
        dataset = treat(log, self.axis, self.treatment["cutoff"])
        axis = IdentifiedAxis(self.fit.plant, self.fit.friction, dataset, dt, steps_of(dt), channel)
        for segment in dataset.segments:
            place = self._place(segment.time)
            effort = effort_of(log)[place]
            acted = through_filter(effort, channel.lag, dt) if channel.lag else effort
            part = axis.replicate(
                Recorded(log.position.values[place], acted, ()), self._unseen(dataset), rng
            )
            if part is None:
                raise InputError(
                    "do not let the simulated axis follow the recorded motion",
                    path="plant and friction",
                    mend="Check their parameters in model.toml",
                )
            yield place, part

    def _along(self, rng: np.random.Generator) -> Iterator[tuple[slice, Recorded]]:
        """Yield the slice of each segment, and the effort of the axis along the recorded motion."""
        plant, friction, channel = self.fit.plant, self.fit.friction, self._channel
        lag = self.treatment.get("position_smoothing", 0.0)
        alignment = Alignment(
            self.treatment.get("delay", 0.0),
            smoothing=-(lag or channel.lag) or None,
            sought=False,
            of_position=lag > 0.0,
        )
        dataset = aligned(treat(self.log, self.axis, self.treatment["cutoff"]), alignment)
        values = numbers_of(plant.component, plant.parameters) | numbers_of(
            friction.component, friction.parameters
        )
        problem = InverseDynamics(
            dataset, ParameterSet(friction.component, (), {}, plant.component)
        )
        drawn = RowReplicates(problem, values).log(self._unseen(dataset), rng)
        for segment, part in zip(dataset.segments, drawn.segments, strict=True):
            recorded = Recorded(drawn.position.values[part], effort_of(drawn)[part], ())
            late = recorded.efforts(-channel.delay, 0.0, dataset.sample_time)[0, :-1]
            yield self._place(segment.time), replace(recorded, effort=late)

    def _place(self, time: np.ndarray) -> slice:
        """Return the slice of a segment in the log."""
        first = int(np.searchsorted(self.log.time.values, time[0]))
        return slice(first, first + time.size)


def _determined(
    fit: Fit, estimate: Estimate, fits: Sequence[Mapping[str, Estimate]], count: int
) -> Determined:
    """Return the recovery of one parameter in fits to simulated logs."""
    name, values, variables = (
        estimate.name,
        {**fit.plant.values, **fit.friction.values},
        fit.friction.component.variables,
    )
    # The stiffness of all elements is not a parameter of their model.
    truth = float(values.get(name, estimate.value))
    levels = names_of(Role.LEVEL, variables) if variables.get(name) == OFFSET else []
    scale = max(levels, key=lambda level: abs(values[level]), default=name)
    # The relative error of a constant force near zero refers to the friction level.
    of_fits = [parameters[name] for parameters in fits if name in parameters]
    identified = [again for again in of_fits if again.status == "identified" or scale != name]
    ends = [again.interval for again in identified if again.interval is not None]
    size = abs(values[scale]) if levels else abs(truth)
    errors = 100.0 * (np.array([again.value for again in identified]) - truth) / (size or np.nan)
    hold = sum(low <= truth <= high for low, high in ends)
    return Determined(
        name, estimate.unit, estimate.description, truth, scale, errors, len(ends), hold, count
    )
