"""The following error of a log, compared with that of the simulated loop."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from operator import attrgetter
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from bristle.core import Axis, Diagnostic, InputError, Model, Status
from bristle.core.dimensions import exponents_of
from bristle.core.experiment import Experiment, Start, Variant
from bristle.identification.settings import DEFAULT, Settings
from bristle.logs.log import Log
from bristle.models.friction import with_presliding
from bristle.models.plants.terms import effort_of_columns
from bristle.prediction.claims import compensation_of, in_samples, lateness_of
from bristle.prediction.predict import TREATED, unexplained_force
from bristle.simulation import SimulationResult, Statistics, simulate, statistics_of
from bristle.simulation.compensation import (
    AS_RECORDED,
    COMPENSATED,
    compensation_experiment,
    settling,
)
from bristle.simulation.recorded.closed_loop import closed_loop_of

FACTORS = 2.0 ** np.arange(-4.0, 4.5, 0.5)
ALIKE = 1.1  # ratio below which two differences count as equal


@dataclass(frozen=True, eq=False)
class Following:
    """Following error of an axis, recorded and simulated."""

    time: np.ndarray
    error: np.ndarray
    measured: Statistics
    simulated: Statistics | None = None
    compensated: Statistics | None = None
    contradiction: Diagnostic | None = None

    def as_data(self) -> dict[str, Any]:
        """Return it for JSON; an implausible gain is null."""
        sides = {
            "measured": self.measured,
            "simulated": self.simulated,
            "compensated": self.compensated,
        }
        if self.contradiction is not None:
            sides["compensated"] = None
        return {
            name: None if error is None else {"peak_to_peak": error.peak_to_peak, "rms": error.rms}
            for name, error in sides.items()
        }


def following_of(
    log: Log, simulation: SimulationResult | None = None, settings: Settings = DEFAULT
) -> Following | None:
    """Return the following error of an axis in a log."""
    if log.reference is None:
        return None
    everywhere = log.reference.values - log.position.values
    part = longest_of(log)
    error = everywhere[part]
    time = log.sample_time * np.arange(error.size)
    simulable = statistics_of(error[_settled(error.size, log.sample_time)])
    first = log.segments[0]
    judged = np.ones(everywhere.size, dtype=bool)
    judged[first] = _settled(first.stop - first.start, log.sample_time)
    measured = statistics_of(everywhere[judged])
    if simulation is None:
        return Following(time, error, measured)
    ended = {name: simulation.variants[name] for name in (AS_RECORDED, COMPENSATED)}
    simulated, compensated = (
        None if run.status is Status.NOT_FINITE else run.following_error for run in ended.values()
    )
    differs = simulated is None or apart(simulable, simulated) > settings.loop_differs
    recorded = next(
        variant for variant in simulation.experiment.variants if variant.name == AS_RECORDED
    )
    if not differs:
        return Following(time, error, measured, simulated, compensated)
    # The difference between the loop and the log, and its possible explanations.
    suspects = explanations(recorded, error, settings.loop_differs)
    sides = {"measured": simulable}
    if simulated is not None:
        sides["simulated"] = simulated
    errors = {name: side.peak_to_peak for name, side in sides.items()}
    errors |= {f"{name}_rms": side.rms for name, side in sides.items()}
    directions = {True: "reference_later", False: "reference_earlier"}
    names = tuple(
        directions[cause.value > 0.0] if cause.name == "reference" else cause.name
        for cause in suspects
    )
    causes = {"suspects": names, "factors": tuple(abs(cause.value) for cause in suspects)}
    contradiction = Diagnostic(
        "loop_contradicts", numbers=errors | causes, kind=recorded.plant.kind
    )
    return Following(time, error, measured, simulated, compensated, contradiction)


def _settled(count: int, dt: float) -> np.ndarray:
    """Return the samples of a stretch after the settling time of its loop."""
    return dt * np.arange(count) >= settling(dt * count) - 0.5 * dt


def loop_of(
    plant: Model,
    friction: Model,
    log: Log,
    axis: Axis,
    treatment: Mapping[str, float] = MappingProxyType({}),
) -> Experiment | None:
    """Return the loop of an axis without and with compensation, on the reference of a log.

    The residual of the model on the log, with the `treatment` of its identification, is replayed as a disturbance, so that
    the compensator is not tested on its own model. The loops begin like the log, with its first effort. They have the
    identified lateness, and the compensator feeds the share of `bristle.prediction.claims`.
    """
    if axis.controller is None or log.reference is None or log.effort is None:
        return None
    longest = longest_of(log)
    loop = closed_loop_of(log, axis, longest)
    left = unexplained_force(
        plant, friction, log, axis, **{name: treatment.get(name) for name in TREATED}
    )
    beside = effort_of_columns(plant, [column.values for column in log.regressors])
    if beside is not None:
        left = left + beside
    late = in_samples(lateness_of(axis, treatment), treatment.get("lag", loop.lag), log.sample_time)
    return compensation_experiment(
        plant,
        with_presliding(friction, axis.presliding or 0.0),
        friction,
        axis.controller,
        log.reference.values[longest],
        log.sample_time,
        resolution=loop.resolution,
        effort_limit=loop.limit,
        lag=late.lag,
        delay=late.delay,
        rule=compensation_of(friction, axis, treatment).rule,
        disturbance=left[longest],
        injected=loop.injected if np.any(log.injected_effort) else None,
        start=Start(
            loop.beginning.x, loop.beginning.v, loop.beginning.acceleration, loop.resumed_effort
        ),
        name=axis.name,
    )


def longest_of(log: Log) -> slice:
    """Return the longest stretch of a log without a gap."""
    return max(log.segments, key=lambda part: part.stop - part.start)


class Suspect(NamedTuple):
    """A number that may be wrong, with a better value."""

    name: str
    value: float
    difference: float


def apart(measured: Statistics, simulated: Statistics) -> float:
    """Return the difference of two errors, peak to peak or root mean square, relative to the measured error."""
    pairs = ((measured.peak_to_peak, simulated.peak_to_peak), (measured.rms, simulated.rms))
    return max(abs(second - first) / first if first > 0.0 else np.inf for first, second in pairs)


def explanations(variant: Variant, error: np.ndarray, allowed: float) -> tuple[Suspect, ...]:
    """Return the numbers that alone would make a loop follow as measured, the best first, with equivalent ones."""
    # Position and effort of the log are in the identified model as well, so a wrong scale affects the numbers of the law
    # only. If all gains of a law contain the same ratio of the two, the scales are confounded.
    trial = _Trial.of(variant, error)
    before = trial.difference(trial.variant)
    law = trial.variant.controller
    scales = [
        name
        for name in ("k_p", "position", "effort")
        if CHANGES[name](trial.variant, 2.0).controller != law
    ]
    late = [_at(trial, "delay", float(samples)) for samples in range(1, 9)]
    suspects = [_best_factor(trial, name) for name in scales]
    if "k_ff" in law.component.variables:
        suspects.append(_fed(trial))
    suspects += [min(late, key=BY_DIFFERENCE), _shifted(trial)]
    better = [suspect for suspect in suspects if suspect.difference <= 0.5 * before]
    agreeing = sorted(
        (suspect for suspect in better if trial.agrees(suspect, allowed)), key=BY_DIFFERENCE
    )
    return tuple(
        suspect for suspect in agreeing if suspect.difference <= ALIKE * agreeing[0].difference
    )


BY_DIFFERENCE = attrgetter("difference")


class _Trial(NamedTuple):
    """The first samples of a loop, for simulations with other numbers."""

    variant: Variant
    error: np.ndarray
    judged: np.ndarray
    desired: np.ndarray

    @classmethod
    def of(cls, variant: Variant, error: np.ndarray) -> _Trial:
        """Return the first samples of a loop."""
        run = variant.run
        count = min(error.size, 30_000)  # samples of each simulation
        time = run.sample_time * np.arange(count)
        desired = variant.reference.component.sample(time, variant.reference.parameters)[0]
        return cls(variant.first(count), error[:count], time >= run.settle, desired)

    def followed(self, variant: Variant) -> np.ndarray | None:
        """Return the following error of a loop against the recorded reference; None if it diverges."""
        outcome = simulate(Experiment("trial", variant.plant.kind, (variant,))).variants[
            variant.name
        ]
        if outcome.status is Status.NOT_FINITE:
            return None
        return self.desired - outcome.measured

    def difference(self, variant: Variant) -> float:
        """Return the difference between the simulated and the measured following error of a loop [m or rad]."""
        followed = self.followed(variant)
        if followed is None:
            return np.inf
        return statistics_of((followed - self.error)[self.judged]).rms

    def agrees(self, suspect: Suspect, allowed: float) -> bool:
        """Return whether the loop follows as measured with the suspected number."""
        followed = self.followed(CHANGES[suspect.name](self.variant, suspect.value))
        if followed is None:
            return False
        return (
            apart(statistics_of(self.error[self.judged]), statistics_of(followed[self.judged]))
            <= allowed
        )


def _at(trial: _Trial, name: str, value: float) -> Suspect:
    suspect = Suspect(name, value, np.inf)
    try:
        return suspect._replace(difference=trial.difference(CHANGES[name](trial.variant, value)))
    except InputError:  # gain out of range
        return suspect


def _best_factor(trial: _Trial, name: str) -> Suspect:
    """Return the factor with the least difference, from a grid that is refined around the best."""
    best = min((_at(trial, name, float(factor)) for factor in FACTORS), key=BY_DIFFERENCE)
    step = 2.0**0.5
    for _ in range(5):
        step **= 0.5
        best = min(
            (best, *(_at(trial, name, best.value * factor) for factor in (1.0 / step, step))),
            key=BY_DIFFERENCE,
        )
    return best


def _fed(trial: _Trial) -> Suspect:
    """Return the share of the reference velocity in the feedforward, on the line from 0 to 1."""
    ends = [trial.followed(_with_law(trial.variant, k_ff=share)) for share in (0.0, 1.0)]
    if ends[0] is None or ends[1] is None:
        return Suspect("k_ff", 1.0, np.inf)
    along = (ends[1] - ends[0])[trial.judged]
    left = (trial.error - ends[0])[trial.judged]
    power = float(along @ along)
    if power > 0.0:
        return _at(trial, "k_ff", max(float(left @ along) / power, 0.0))
    return _at(trial, "k_ff", 0.0)


def _shifted(trial: _Trial) -> Suspect:
    """Return the time by which the reference acts later, from the part of the difference proportional to velocity."""
    velocity = np.gradient(trial.desired, trial.variant.run.sample_time)[trial.judged]
    power = float(velocity @ velocity)
    late = 0.0
    for _ in range(3):  # of Newton's method
        followed = trial.followed(_reference_later(trial.variant, late))
        if followed is None or power == 0.0:
            return Suspect("reference", late, np.inf)
        late += float((trial.error - followed)[trial.judged] @ velocity) / power
    return _at(trial, "reference", late)


def _with_law(variant: Variant, **values: float) -> Variant:
    return replace(variant, controller=variant.controller.with_values(**values))


def _scaled(variant: Variant, factor: float, quantity: str) -> Variant:
    """Return a loop whose law has a scaled quantity."""
    law = variant.controller
    powers = {
        key: exponents_of(variable.quantity).get(quantity, 0.0)
        for key, variable in law.component.variables.items()
    }
    return _with_law(
        variant, **{key: law.values[key] * factor**-power for key, power in powers.items() if power}
    )


def _reference_later(variant: Variant, time: float) -> Variant:
    reference = variant.reference
    dt = variant.run.sample_time
    position = np.asarray(reference.parameters.position)
    samples = np.arange(position.size)
    return replace(
        variant,
        reference=reference.with_values(position=np.interp(samples - time / dt, samples, position)),
    )


CHANGES: dict[str, Callable[[Variant, float], Variant]] = {
    "k_p": lambda variant, factor: _with_law(
        variant,
        **{
            name: factor * value
            for name, value in variant.controller.values.items()
            if name in ("k_p", "lambda_")
        },
    ),
    "k_ff": lambda variant, share: _with_law(variant, k_ff=share),
    "position": partial(_scaled, quantity="length"),
    "effort": partial(_scaled, quantity="force"),
    "delay": lambda variant, samples: replace(
        variant, run=replace(variant.run, delay=variant.run.delay + int(samples))
    ),
    "reference": _reference_later,
}
