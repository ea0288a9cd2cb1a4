r"""Which one number of what is told of a loop explains that it followed otherwise than it does in simulation.

The loop is simulated again with one factor at a time, the one with which its following error comes closest to the
measured one:

============= ========================================================================================================
k_p           the position gain of its law
k_ff          the share of the reference velocity that the drive feeds forward
position      the scale of position, such as gear or lead: a length that the law is told becomes another one
effort        the scale of effort, such as a torque constant
delay         samples from a measurement to the effort computed from it
reference     the time by which the reference acts later than it was recorded
============= ========================================================================================================

Position and effort of the log stand in the identified model as well, so that a wrong scale shows nowhere but in the
numbers of the law: :math:`x \to f x` turns a gain in N·s/m into one of `f` times as many, :math:`u \to f u` into
one of :math:`1/f`. A law whose gains have one ratio of the two cannot tell them apart.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bristle.core.contracts import Model
from bristle.core.dimensions import exponents_of
from bristle.core.errors import InputError
from bristle.core.experiment import Experiment, Variant
from bristle.core.status import Status
from bristle.simulation import simulate, statistics_of
from bristle.simulation.result import Statistics

__all__ = ["Suspect", "apart", "explanations"]

POSITION_GAINS = ("k_p", "lambda_")
FACTORS = 2.0 ** np.arange(-4.0, 4.5, 0.5)
HALVINGS = 5  # of the step between two factors
DELAYS = range(1, 9)  # samples
ROUNDS = 3  # of Newton's method for a time
MOST = 30_000  # samples that are simulated for each factor
BETTER = 0.5  # of the difference of both errors is left at most, if a factor is to explain it
ALIKE = 1.1  # ratio of two differences that tell nothing apart


class Suspect(NamedTuple):
    """One number that would have to be another one."""

    name: str
    value: float
    difference: float


def apart(measured: Statistics, simulated: Statistics) -> float:
    """Return by how much two errors differ, peak to peak or root mean square, relative to the measured one."""
    pairs = ((measured.peak_to_peak, simulated.peak_to_peak), (measured.rms, simulated.rms))
    return max(abs(second - first) / first if first > 0.0 else np.inf for first, second in pairs)


def explanations(variant: Variant, error: np.ndarray, allowed: float) -> tuple[Suspect, ...]:
    """Return the numbers one of which would make a loop follow as measured, the best first; those tell it alike."""
    trial = _Trial.of(variant, error)
    before = trial.difference(trial.variant)
    better = [suspect for suspect in _suspects(trial) if suspect.difference <= BETTER * before]
    agreeing = sorted((suspect for suspect in better if trial.agrees(suspect, allowed)), key=_difference)
    return tuple(suspect for suspect in agreeing if suspect.difference <= ALIKE * agreeing[0].difference)


class _Trial(NamedTuple):
    """The beginning of a loop, to be run with other numbers."""

    variant: Variant
    error: np.ndarray
    judged: np.ndarray
    desired: np.ndarray

    @classmethod
    def of(cls, variant: Variant, error: np.ndarray) -> _Trial:
        """Return the first samples of a loop."""
        run, count = variant.run, min(error.size, MOST)
        time = run.sample_time * np.arange(count)
        desired = variant.reference.component.sample(time, variant.reference.parameters)[0]
        shorter = variant.first(count)
        return cls(shorter, error[:count], time >= run.settle, desired)

    def followed(self, variant: Variant) -> np.ndarray | None:
        """Return the following error of a loop against the recorded reference; None where it diverges."""
        outcome = simulate(Experiment("trial", variant.plant.kind, (variant,))).variants[variant.name]
        return None if outcome.status is Status.NOT_FINITE else self.desired - outcome.measured

    def difference(self, variant: Variant) -> float:
        """Return by how much a loop follows otherwise than measured [m or rad]."""
        followed = self.followed(variant)
        return np.inf if followed is None else statistics_of((followed - self.error)[self.judged]).rms

    def changed(self, suspect: Suspect) -> Variant:
        """Return the loop with one number as suspected."""
        return CHANGES[suspect.name](self.variant, suspect.value)

    def agrees(self, suspect: Suspect, allowed: float) -> bool:
        """Return whether the loop follows as measured, with one number as suspected."""
        followed = self.followed(self.changed(suspect))
        if followed is None:
            return False
        return apart(statistics_of(self.error[self.judged]), statistics_of(followed[self.judged])) <= allowed


def _suspects(trial: _Trial) -> list[Suspect]:
    law = trial.variant.controller
    scales = [name for name in ("k_p", "position", "effort") if CHANGES[name](trial.variant, 2.0).controller != law]
    late = [_at(trial, "delay", float(samples)) for samples in DELAYS]
    fed = [_fed(trial)] if "k_ff" in law.component.variables else []
    return [*(_best_factor(trial, name) for name in scales), *fed, min(late, key=_difference), _shifted(trial)]


def _at(trial: _Trial, name: str, value: float) -> Suspect:
    suspect = Suspect(name, value, np.inf)
    try:
        return suspect._replace(difference=trial.difference(trial.changed(suspect)))
    except InputError:  # a gain out of its range
        return suspect


def _difference(suspect: Suspect) -> float:
    return suspect.difference


def _best_factor(trial: _Trial, name: str) -> Suspect:
    """Return the factor with the least difference, found on a grid that gets finer around the best."""
    best, step = min((_at(trial, name, float(factor)) for factor in FACTORS), key=_difference), 2.0**0.5
    for _ in range(HALVINGS):
        step **= 0.5
        nearer = (_at(trial, name, best.value * factor) for factor in (1.0 / step, step))
        best = min((best, *nearer), key=_difference)
    return best


def _fed(trial: _Trial) -> Suspect:
    """Return the share of the reference velocity fed forward, on the line between none of it and all of it."""
    ends = [trial.followed(_velocity_fed(trial.variant, share)) for share in (0.0, 1.0)]
    if ends[0] is None or ends[1] is None:
        return Suspect("k_ff", 1.0, np.inf)
    along, left = (ends[1] - ends[0])[trial.judged], (trial.error - ends[0])[trial.judged]
    power = float(along @ along)
    return _at(trial, "k_ff", max(float(left @ along) / power, 0.0) if power > 0.0 else 0.0)


def _shifted(trial: _Trial) -> Suspect:
    """Return the time by which the reference acts later, from what of the difference goes with the velocity."""
    velocity = np.gradient(trial.desired, trial.variant.run.sample_time)[trial.judged]
    power, late = float(velocity @ velocity), 0.0
    for _ in range(ROUNDS):
        followed = trial.followed(_reference_later(trial.variant, late))
        if followed is None or power == 0.0:
            return Suspect("reference", late, np.inf)
        late += float((trial.error - followed)[trial.judged] @ velocity) / power
    return _at(trial, "reference", late)


def _position_gain(variant: Variant, factor: float) -> Variant:
    values = variant.controller.values
    gains = {name: factor * values[name] for name in POSITION_GAINS if name in values}
    return replace(variant, controller=variant.controller.with_values(**gains))


def _velocity_fed(variant: Variant, share: float) -> Variant:
    return replace(variant, controller=variant.controller.with_values(k_ff=share))


def _position_scaled(variant: Variant, factor: float) -> Variant:
    return replace(variant, controller=_told_in(variant.controller, "length", factor))


def _effort_scaled(variant: Variant, factor: float) -> Variant:
    return replace(variant, controller=_told_in(variant.controller, "force", factor))


def _told_in(law: Model, name: str, factor: float) -> Model:
    """Return a law in whose numbers what was taken for 1 of a quantity is so many times as much."""
    powers = {key: exponents_of(variable.quantity).get(name, 0.0) for key, variable in law.component.variables.items()}
    values = {key: law.values[key] * factor**-power for key, power in powers.items() if power}
    return law.with_values(**values)


def _delayed(variant: Variant, samples: float) -> Variant:
    return replace(variant, run=replace(variant.run, delay=variant.run.delay + int(samples)))


def _reference_later(variant: Variant, time: float) -> Variant:
    reference, dt = variant.reference, variant.run.sample_time
    position = np.asarray(reference.parameters.position)
    samples = np.arange(position.size)
    later = np.interp(samples - time / dt, samples, position)
    return replace(variant, reference=reference.with_values(position=later))


CHANGES: dict[str, Callable[[Variant, float], Variant]] = {
    "k_p": _position_gain,
    "k_ff": _velocity_fed,
    "position": _position_scaled,
    "effort": _effort_scaled,
    "delay": _delayed,
    "reference": _reference_later,
}
