"""What a log can tell: its identified axis, simulated along the recorded motion, is identified again, and the truth is known.

A simulated log has the motion, the channel and the encoder of the recorded one, in steps of unknown phase; the level of
friction scatters from half-cycle to half-cycle, the effort is noisy. In a loop around the recorded motion the effort
moves the axis, so that friction decides how it moves; friction over a channel that was recorded beside the motion acts
along the recorded motion instead. The fit to a simulated log knows what the person said of the axis, and no more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bristle.core.axis import Axis
from bristle.core.edge import Progress
from bristle.core.errors import InputError
from bristle.core.values import numbers_of
from bristle.friction.level import TRANSMITTED
from bristle.friction.slots import OFFSET
from bristle.identification.dataset import Alignment, Dataset
from bristle.identification.half_cycles import disturbance_of
from bristle.identification.identify import identify
from bristle.identification.inverse_dynamics import InverseDynamics, RowReplicates
from bristle.identification.observed_fit import Channel, IdentifiedAxis, Unseen
from bristle.identification.observer import Recorded, steps_of
from bristle.identification.parameters import ParameterSet, Role, names_of
from bristle.identification.preprocessing import aligned, treat
from bristle.identification.result import Estimate, Fit
from bristle.logs.filters import through_filter
from bristle.logs.log import Log

SEED = 20_261_127
DETERMINED, ROUGH = 10.0, 50.0  # percent: what errors stay within
FEWEST = 0.5  # share of the simulated logs: a parameter that fewer identify is not determined
FEWEST_DRAWS, MOST_DRAWS = 20, 100  # behind the intervals of a fit to a simulated log
HOLD_LEAST, TELLING = 0.75, 5  # share of the intervals: where fewer hold, of so many at least, they are too narrow


@dataclass(frozen=True)
class Determined:
    """How well simulated logs determine one parameter.

    Parameters
    ----------
    name, unit, description : str
        Name, SI unit of the kind of axis, meaning.
    truth : float
        The value of the simulated axis in `unit`.
    scale : float
        What errors are a share of: the truth, or of a constant force the level of friction, `scale_name`.
    scale_name : str
        Name of that level; empty where errors are a share of the truth.
    values : tuple of float
        The value of each fit that identified the parameter, in `unit`.
    intervals, hold : int
        How many of these fits have a 95 % interval, and how many intervals hold the truth.
    logs : int
        How many logs were simulated.
    """

    name: str
    unit: str
    description: str
    truth: float
    scale: float
    scale_name: str
    values: tuple[float, ...]
    intervals: int
    hold: int
    logs: int

    @property
    def errors(self) -> np.ndarray:
        """Relative error of each fit [%]; none where the scale is zero."""
        return 100.0 * (np.array(self.values) - self.truth) / self.scale if self.scale else np.zeros(0)

    @property
    def median_error(self) -> float | None:
        """Median of the errors, with its sign [%]."""
        return float(np.median(self.errors)) if self.errors.size else None

    @property
    def spread(self) -> float | None:
        """Standard deviation of the errors [%]."""
        return float(np.std(self.errors, ddof=1)) if self.errors.size > 1 else None

    @property
    def within(self) -> float | None:
        """Median error and a 95 % prediction interval about it [%]: what the error of a further log stays within."""
        from scipy.special import stdtrit

        if self.median_error is None or self.spread is None:
            return None
        count = self.errors.size
        return abs(self.median_error) + float(stdtrit(count - 1, 0.975)) * self.spread * (1.0 + 1.0 / count) ** 0.5

    @property
    def verdict(self) -> str:
        """``determined``, ``rough`` or ``not determined``."""
        if self.within is None or self.within > ROUGH or self.is_rare:
            return "not determined"
        return "determined" if self.within <= DETERMINED else "rough"

    @property
    def is_rare(self) -> bool:
        """Whether no more than half of the fits identified the parameter."""
        return len(self.values) <= FEWEST * self.logs

    @property
    def too_narrow(self) -> bool:
        """Whether too few of the intervals hold the truth, of as many as tell."""
        return self.intervals >= TELLING and self.hold < HOLD_LEAST * self.intervals


def simulated_again(
    logs: Sequence[Log],
    axes: Sequence[Axis | None],
    fit: Fit,
    treatment: Mapping[str, float],
    settings: Mapping[str, float],
    *,
    count: int = 10,
    progress: Progress | None = None,
) -> tuple[Determined, ...]:
    """Return how well each parameter of a fit comes out of simulated logs, of which `fit` has the truth in its models.

    `treatment` and `settings` are those of the fit. One without intervals, or to a simulated signal, is refused.
    """
    options = _options(logs, axes, fit, treatment)
    estimates, refused = list[Mapping[str, Estimate]](), list[InputError]()
    for number, seed in enumerate(np.random.SeedSequence(SEED).spawn(count)):
        rng = np.random.default_rng(seed)

        def told(share: float, _: str, number: int = number) -> None:
            if progress is not None:
                progress((number + share) / count, f"identifying simulated log {number + 1} of {count}")

        told(0.0, "")
        try:
            drawn = [simulated(log, axis, fit, treatment, rng) for log, axis in zip(logs, axes, strict=True)]
            estimates.append(
                identify(drawn, fit.friction.component, settings=settings, progress=told, **options).best.parameters
            )
        except InputError as error:
            refused.append(error)
    if not estimates:
        raise refused[0]
    return tuple(_determined(fit, estimate, estimates, count) for estimate in fit.estimates if estimate.status != "held")


def _options(logs: Sequence[Log], axes: Sequence[Axis | None], fit: Fit, treatment: Mapping[str, float]) -> dict[str, Any]:
    """Return what a person asked of the fit, beside what the axes say; a fit that cannot be simulated is refused."""
    if fit.position_rmse is not None or fit.loop_rmse is not None:
        allowed = "inverse_dynamics or prediction_error"
        message = "were identified by a method whose logs are not simulated"
        raise InputError(message, path="results", value="output_error", allowed=allowed, mend="Identify again with one of these methods")
    if fit.resampling is None:
        message = "were identified without simulated logs: neither intervals nor the scatter of the friction level are known"
        raise InputError(message, path="results", value="--draws 0", allowed="20 or more", mend="Identify again with --draws 100")
    variables, shapes = fit.friction.component.variables, fit.friction.component.defaults
    free = [
        estimate.name
        for estimate in fit.estimates
        if estimate.name in shapes and estimate.status != "held" and not variables[estimate.name].excitation
    ]
    known = {one.name: one.value for one in fit.estimates if one.reason is not None and one.reason.code == "held_known"}
    (mass, *_), offset = (*names_of(Role.INERTIA, fit.plant.component.variables), ""), names_of(OFFSET, variables)
    usual = treat(logs[0], axes[0]).cutoff
    return {
        "axis": list(axes),
        "cutoff": treatment["cutoff"] if treatment["cutoff"] != usual else None,
        "free": [name for name in free if variables[name] != OFFSET],
        "mass": known.get(mass),
        "offset": next((known[name] for name in offset if name in known), None),
        "draws": min(max(fit.resampling.bands.count, FEWEST_DRAWS), MOST_DRAWS),
        "method": "prediction_error" if any(one.code == "prediction_error" for one in fit.diagnostics) else "inverse_dynamics",
    }


def simulated(log: Log, axis: Axis | None, fit: Fit, treatment: Mapping[str, float], rng: np.random.Generator) -> Log:
    """Return a log that the identified axis makes along the motion of a recorded one."""
    assert fit.resampling is not None
    dataset, bands, component = treat(log, axis, treatment["cutoff"]), fit.resampling.bands, fit.friction.component
    lag = treatment.get("position_smoothing", 0.0) - treatment.get("smoothing", 0.0)
    bend = 0.0 if dataset.held is False else -(log.sample_time**2) / 24.0
    channel = Channel(treatment.get("delay", 0.0) - 0.5 * log.sample_time * bool(dataset.held), bend, lag)
    needs_record = any(surrounding.is_recorded for surrounding in component.surroundings) or TRANSMITTED in component.variables.values()
    make = _along if needs_record or getattr(fit.plant.component, "columns", ()) else _in_loop
    assert log.effort is not None
    position, effort, segments = log.position.values.copy(), log.effort.values.copy(), list[slice]()
    for place, part in make(log, dataset, fit, channel, Unseen(bands.scatter, bands.noise), rng):
        position[place], effort[place] = part.position, through_filter(part.effort, -lag, log.sample_time) if lag else part.effort
        segments.append(place)
    channels = {"position": replace(log.position, values=position), "effort": replace(log.effort, values=effort)}
    return replace(log, **channels, velocity=None, reference=None, injected=(), segments=tuple(segments))


def _in_loop(
    log: Log, dataset: Dataset, fit: Fit, channel: Channel, unseen: Unseen, rng: np.random.Generator
) -> list[tuple[slice, Recorded]]:
    """Return the segments that the axis records in a loop around the recorded motion, and where they stand."""
    dt, made = log.sample_time, list[tuple[slice, Recorded]]()
    axis = IdentifiedAxis(fit.plant, fit.friction, dataset, dt, steps_of(dt), channel)
    assert log.effort is not None
    for segment in dataset.segments:
        place = _place(log, segment.time)
        effort = log.effort.values[place]
        recorded = Recorded(log.position.values[place], through_filter(effort, channel.lag, dt) if channel.lag else effort, ())
        part = axis.replicate(recorded, unseen, rng)
        if part is None:
            mend = "Check the parameters in model.toml"
            raise InputError("the identified axis does not follow the recorded motion in simulation", path="model", mend=mend)
        made.append((place, part))
    return made


def _along(
    log: Log, dataset: Dataset, fit: Fit, channel: Channel, unseen: Unseen, rng: np.random.Generator
) -> list[tuple[slice, Recorded]]:
    """Return the segments with the effort that the axis takes along the recorded motion, and where they stand."""
    delay = channel.delay + 0.5 * log.sample_time * bool(dataset.held)
    dataset = aligned(dataset, Alignment(delay, smoothing=-channel.lag or None, sought=False))
    values = numbers_of(fit.plant.component, fit.plant.parameters) | numbers_of(fit.friction.component, fit.friction.parameters)
    problem = InverseDynamics(dataset, ParameterSet(fit.friction.component, (), {}, fit.plant.component))
    drawn = RowReplicates(problem, values).log(disturbance_of(dataset, unseen.scatter)._replace(noise=unseen.noise), rng)
    made = list[tuple[slice, Recorded]]()
    for segment, part in zip(dataset.segments, drawn.segments, strict=True):
        assert drawn.effort is not None
        recorded = Recorded(drawn.position.values[part], drawn.effort.values[part], ())
        late = recorded.efforts(-channel.delay, 0.0, log.sample_time)[0, :-1]
        made.append((_place(log, segment.time), recorded._replace(effort=late)))
    return made


def _place(log: Log, time: np.ndarray) -> slice:
    """Return where the samples of a segment stand in a log."""
    first = int(np.searchsorted(log.time.values, time[0]))
    return slice(first, first + time.size)


def _determined(fit: Fit, estimate: Estimate, fits: Sequence[Mapping[str, Estimate]], count: int) -> Determined:
    """Return what fits to simulated logs say of one parameter of a fit."""
    name, values, variables = estimate.name, {**fit.plant.values, **fit.friction.values}, fit.friction.component.variables
    # The stiffness of all elements is none of the parameters of their model.
    truth = float(values.get(name, estimate.value))
    levels = [level for level in names_of(Role.LEVEL, variables) if variables.get(name) == OFFSET]
    scale_name = max(levels, key=lambda level: abs(values[level]), default="")
    # A constant force near zero is no share of itself, and known all the same.
    found = [one[name] for one in fits if name in one and (one[name].status == "identified" or scale_name)]
    ends = [one.interval for one in found if one.interval is not None]
    return Determined(
        name,
        estimate.unit,
        estimate.description,
        truth,
        abs(values[scale_name]) if scale_name else abs(truth),
        scale_name,
        tuple(one.value for one in found),
        len(ends),
        sum(low <= truth <= high for low, high in ends),
        count,
    )
