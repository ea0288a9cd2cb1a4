"""The gain of compensation, and the best variant of a loop: every wording of how much less a loop errs than another."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from bristle.core.status import Status
from bristle.core.typography import number, scale_of, with_unit
from bristle.core.variable import Kind, unit_of
from bristle.report.messages import message
from bristle.report.table import fixed, length_text, short_text

if TYPE_CHECKING:
    from bristle.core.experiment import Experiment, Variant
    from bristle.prediction.following import Following
    from bristle.simulation.result import SimulationResult, Statistics, VariantResult

__all__ = [
    "NAMES_MAX",
    "NO_CHANGE",
    "Gain",
    "Standing",
    "about_loop",
    "closing_sentences",
    "gain_lines",
    "gain_of",
    "is_alike",
    "pair_in",
    "pair_of",
    "several",
    "standing",
    "variant_of",
]

BASE = "base"
NO_CHANGE = 0.05  # relative change below which nothing is claimed
MOSTLY_LAG = 0.5  # share of the mean square of the following error that is in proportion to velocity
NAMES_MAX = 4  # names of variants that are listed
MANY = 10.0  # times less: told as a factor
NOT_SIMULATED = "not simulated: that takes a log with a reference, and a controller in the axis file"


class Errors(NamedTuple):
    """The following error of one variant after its settling time, and what of it is lag."""

    name: str
    peak_to_peak: float
    beyond_lag: float
    lag: float
    lag_share: float


class Gain(NamedTuple):
    """The loop step by step: as it is where that differs, without friction fed forward, and with it."""

    steps: tuple[Errors, ...]
    kind: Kind
    caveat: str
    alone: bool = True
    velocity_fed: bool = False

    def sentences(self) -> list[str]:
        """Return what compensation does to the following error, in words."""
        if not self.steps:
            return ["A simulated loop left the finite numbers, so nothing can be said of the compensation."]
        return [self._about_friction(), *self._about_all(), *self._about_lag(), self.caveat]

    def _about_friction(self) -> str:
        before, after = (step.peak_to_peak for step in self.steps[-2:])
        old, new = (f"{self._words(step.peak_to_peak)} ({step.name})" for step in self.steps[-2:])
        change = f"the following error from {old} to {new} peak to peak"
        if not self.alone:
            return (
                f"In simulation, the following error goes from {old} to {new} peak to peak. The two differ in more than the friction "
                "fed forward: add a variant that differs in that alone to see what it gains."
            )
        if after > (1.0 + NO_CHANGE) * before:
            return f"In simulation, feeding the friction forward raises {change}: do not use this compensation as it is."
        if after > (1.0 - NO_CHANGE) * before:
            return f"In simulation, feeding the friction forward hardly changes the following error: {old}, then {new}."
        return f"In simulation, feeding the friction forward lowers {change}{_times(before, after)}."

    def _about_all(self) -> list[str]:
        first, last = self.steps[0].peak_to_peak, self.steps[-1].peak_to_peak
        text = (
            f"The first loop, {self.steps[0].name}, has {self._words(first)}: with all that is fed forward "
            f"it becomes {self._words(last)}{_times(first, last)}."
        )
        return [text] if len(self.steps) > 2 else []

    def _about_lag(self) -> list[str]:
        before, compensated = self.steps[-2:]
        if compensated.lag_share < MOSTLY_LAG:
            return []
        scale = scale_of(unit_of("length", self.kind), before.beyond_lag)
        old, new = (short_text(error.beyond_lag * scale.factor) for error in (before, compensated))
        # Which of the two it is cannot be told from the error: either rises with the velocity.
        cause = (
            "viscous friction that is not fed forward, or the rest of the lag of the position loop. Velocity is fed "
            "forward already: look at the viscous friction of the compensator, F_v"
            if self.velocity_fed
            else "the lag of the position loop, which velocity fed forward removes, or viscous friction that is not fed forward"
        )
        return [
            f"{100.0 * compensated.lag_share:.3g} % of the mean square of what is left is in proportion to the velocity, a lag of "
            f"{with_unit(compensated.lag, 's')}: {cause}. Beyond this lag the error goes from {old} to {new} {scale.unit} peak to peak."
        ]

    def _words(self, length: float) -> str:
        return with_unit(length, unit_of("length", self.kind))


class Standing(NamedTuple):
    """The loop as it stands, and the variant that errs least."""

    base: VariantResult
    best: VariantResult
    alike: bool

    @property
    def instead(self) -> str:
        """The error of the best variant instead of that of the loop as it stands, and how much less that is."""
        new, old = (f"{length_text(_peak(loop), loop.kind)} ({loop.name})" for loop in (self.best, self.base))
        return f"following error {new} instead of {old} peak to peak, {'hardly less' if self.alike else self._less}"

    @property
    def _less(self) -> str:
        """By how much the error is less: a factor where percent would all be 99 and some."""
        ratio = _peak(self.base) / _peak(self.best)
        if ratio > MANY * MANY:
            return "less than a hundredth"
        percent = f"{_difference(self.base, self.best)} less".replace(" ", "\u00a0")
        return f"by a factor of {number(ratio, digits=2)}" if ratio > MANY else percent


def about_loop(gain: Gain | None, following: Following | None, kind: Kind) -> list[str]:
    """Return how the axis followed its reference, how it does in simulation, and what compensation gains there.

    Where the simulation does not follow as the log does, no gain is told.
    """
    gained = [] if gain is None else gain.sentences()
    if following is None:
        return gained
    if following.contradiction is not None:
        return [f"No gain is promised: {message(following.contradiction)}."]
    unit = unit_of("length", kind)
    beside = "" if following.simulated is None else f"; the simulated loop has {_both(following.simulated, unit)}"
    return [f"In the log, the following error is {_both(following.measured, unit)}{beside}.", *gained]


def gain_lines(simulation: SimulationResult | None, following: Following | None, kind: Kind) -> list[str]:
    """Return the same for a first page: the errors in the log and in simulation, and the effort."""
    if following is None:
        return [NOT_SIMULATED]
    lines = [f"following error, peak to peak: {length_text(following.measured.peak_to_peak, kind)} in the log"]
    if following.contradiction is not None:
        return [*lines, f"no gain is promised: {message(following.contradiction)}"]
    if following.simulated is not None and following.compensated is not None:
        before, after = (length_text(error.peak_to_peak, kind) for error in (following.simulated, following.compensated))
        lines.append(f"simulated: {before} as recorded, {after} compensated")
    names = [] if simulation is None else [variant.name for variant in simulation.experiment.variants]
    efforts = [simulation.variants[name].effort for name in (*names[:1], *names[-1:])] if simulation is not None else []
    if efforts and all(np.all(np.isfinite(effort)) for effort in efforts):
        before, after = (fixed(float(np.sqrt(np.mean(effort**2))), unit_of("force", kind)) for effort in efforts)
        lines.append(f"effort, root mean square: {before} as recorded, {after} compensated")
    return lines


def _both(error: Statistics, unit: str) -> str:
    return f"{with_unit(error.peak_to_peak, unit)} peak to peak and {with_unit(error.rms, unit)} root mean square"


def _times(before: float, after: float) -> str:
    return f", by a factor of {number(before / after, digits=2)}" if 0.0 < after < before else ""


def pair_of(experiment: Experiment, compensated: Variant | None = None) -> tuple[Variant, Variant] | None:
    """Return a variant with friction fed forward, the first by default, and before it the one that lacks just that.

    Where no variant differs in that alone, the first one without friction fed forward; None where there is none of
    either.
    """
    plain = [variant for variant in experiment.variants if variant.feedforward.friction is None]
    compensated = compensated or next((variant for variant in experiment.variants if variant.feedforward.friction is not None), None)
    if compensated is None or not plain:
        return None
    return next((variant for variant in plain if _is_pair(variant, compensated)), plain[0]), compensated


def _is_pair(before: Variant, after: Variant) -> bool:
    """Return whether two variants differ in the friction fed forward alone."""
    return before.feedforward.mass == after.feedforward.mass and before.controller == after.controller


def pair_in(simulation: SimulationResult) -> tuple[Variant, Variant] | None:
    """Return the pair of the variant with friction fed forward that errs least."""
    fed = [variant for variant in simulation.experiment.variants if variant.feedforward.friction is not None]
    completed = [variant for variant in fed if simulation.variants[variant.name].status is not Status.NOT_FINITE]
    return pair_of(simulation.experiment, min(completed, key=lambda variant: _peak(simulation.variants[variant.name]), default=None))


def variant_of(simulation: SimulationResult, name: str) -> Variant:
    """Return a variant of an experiment by its name."""
    return next(variant for variant in simulation.experiment.variants if variant.name == name)


def gain_of(simulation: SimulationResult) -> Gain | None:
    """Return what compensation gains; None where the variants do not show it."""
    experiment, pair = simulation.experiment, pair_in(simulation)
    if pair is None:
        return None
    (before, after), first = pair, experiment.variants[0]
    # What another law gains is no gain of what is fed forward.
    chosen = pair if first in pair or _law(first) != _law(before) else (first, *pair)
    results = [simulation.variants[variant.name] for variant in chosen]
    diverged = any(result.status is Status.NOT_FINITE for result in results)
    steps = () if diverged else tuple(_errors(*step) for step in zip(chosen, results, strict=True))
    return Gain(steps, experiment.kind, _caveat(after), _is_pair(before, after), after.controller.values.get("k_ff", 0.0) > 0.0)


def _law(variant: Variant) -> tuple[str, dict[str, str]]:
    """Return the control law without what it feeds forward."""
    law = variant.controller
    return law.name, {name: repr(value) for name, value in law.values.items() if name != "k_ff"}


def _errors(variant: Variant, result: VariantResult) -> Errors:
    judged = slice(round(variant.run.settle / variant.run.sample_time), None)
    error = (result.reference - result.measured)[judged]
    velocity = np.gradient(result.reference, variant.run.sample_time)[judged]
    power, square = float(velocity @ velocity), float(error @ error)
    lag = float(error @ velocity) / power if power > 0.0 else 0.0
    beyond = error - lag * velocity
    share = 1.0 - float(beyond @ beyond) / square if square > 0.0 else 0.0
    return Errors(variant.name, result.following_error.peak_to_peak, float(np.ptp(beyond)), lag, share)


def _caveat(compensated: Variant) -> str:
    if compensated.disturbance is not None:
        return (
            "The simulated axis is disturbed by what the model does not explain of the log, so the compensation is not "
            "judged by its own model alone. It is a simulation all the same: confirm the gain on the machine."
        )
    if compensated.friction == compensated.feedforward.friction:
        return (
            "The simulated axis has exactly the friction that is fed forward: take this gain as the most to be hoped "
            "for, and confirm it on the machine."
        )
    return "This is a simulation: confirm the gain on the machine."


def standing(result: SimulationResult) -> Standing | None:
    """Return the loop as it stands and the best one along the same reference; None where that loop did not complete."""
    base = _base(result) if result.variants else None
    if base is None or not _is_done(base):
        return None
    references = {variant.name: variant.reference for variant in result.experiment.variants}
    best = min((one for one in _completed(result) if references[one.name] == references[base.name]), key=_peak)
    return Standing(base, best, best is base or is_alike(best, base))


def closing_sentences(result: SimulationResult) -> list[str]:
    """Return what to take from the variants of an experiment: what compensation gains, and which variant is best."""
    gain, best = gain_of(result), best_sentences(result)
    if gain is None:
        return best
    *before, last = gain.sentences()
    return [*before, *best, last] if gain.steps else [last, *best]


def best_sentences(result: SimulationResult) -> list[str]:
    """Return which variant has the smallest following error, against the loop as it stands; nothing for one alone.

    Several runs that scatter as much as two variants differ do not tell them apart: nothing is called better then.
    """
    completed = _completed(result)
    if len(completed) < 2:
        return []
    best, base = min(completed, key=_peak), _base(result)
    alike = [variant for variant in completed if variant is not best and is_alike(best, variant)]
    least = f"Of {len(completed)} variants, {best.name} errs least: {_error_text(best)} peak to peak"
    if base is None or not _is_done(base):
        return [f"{least}. {base.name if base else BASE}, against which it would be measured, did not complete."]
    if best is base:
        nearest = min((variant for variant in completed if variant is not base), key=_peak)
        more = "about as much as" if nearest in alike else f"{_difference(base, nearest)} more than"
        return [
            f"No variant errs less than {base.name}: {_error_text(base)} peak to peak. The nearest, "
            f"{nearest.name}, errs by {_error_text(nearest)}, {more} that{_runs(base)}."
        ]
    less = "hardly less" if base in alike else f"{_difference(base, best)} less"
    ties = [variant.name for variant in sorted(alike, key=_peak) if variant is not base]
    about_ties = [f"About as little {'errs' if len(ties) == 1 else 'err'} {several(ties)}."] if ties else []
    return [f"{least}, {less} than {base.name} with {_error_text(base)}{_runs(best)}.", *about_ties]


def several(names: Sequence[object], most: int = NAMES_MAX) -> str:
    """Return names in a list, as many as are read, and how many more there are."""
    return ", ".join(map(str, names[:most])) + (f" and {len(names) - most} more" if len(names) > most else "")


def _base(result: SimulationResult) -> VariantResult | None:
    """Return the loop as it stands: the variant of that name, else the first; None where it was not simulated."""
    named = BASE in result.variants or BASE in result.refused
    return result.variants.get(BASE) if named else result.variants[result.experiment.variants[0].name]


def _completed(result: SimulationResult) -> list[VariantResult]:
    return [variant for variant in result.variants.values() if _is_done(variant)]


def _is_done(variant: VariantResult) -> bool:
    return variant.status is not Status.NOT_FINITE and math.isfinite(_peak(variant))


def _peak(variant: VariantResult) -> float:
    return variant.following_error.peak_to_peak


def _spread(variant: VariantResult) -> float:
    return float(variant.spread["following_error"]["peak_to_peak"]) if variant.spread else 0.0


def is_alike(best: VariantResult, variant: VariantResult) -> bool:
    """Return whether two variants are not told apart: by as much as nobody minds, or as their runs scatter."""
    return _peak(variant) - _peak(best) <= max(NO_CHANGE * _peak(variant), _spread(best) + _spread(variant))


def _error_text(variant: VariantResult) -> str:
    """Return the error with its unit, and the standard deviation over the runs."""
    unit = unit_of("length", variant.kind)
    scale = scale_of(unit, _peak(variant))
    peak, spread = _peak(variant) * scale.factor, _spread(variant) * scale.factor
    return f"{number(peak, spread)} ± {number(spread, spread)} {scale.unit}" if spread else with_unit(_peak(variant), unit)


def _difference(base: VariantResult, variant: VariantResult) -> str:
    """Return by how much the error of another variant differs from that of the base, in percent of that."""
    ratio = _peak(variant) / _peak(base) if _peak(base) else math.inf
    percent = 100.0 * abs(1.0 - ratio)
    spread = 100.0 * ratio * math.hypot(*(_spread(loop) / _peak(loop) if _peak(loop) else 0.0 for loop in (base, variant)))
    # What is left tells as much as what is gone: 99.6 % is not 100 %.
    left = 100.0 - percent if 99.0 < percent < 100.0 else None
    return f"{number(percent, spread)} ± {number(spread, spread)} %" if spread else f"{number(percent, left, 2)} %"


def _runs(variant: VariantResult) -> str:
    return f" (mean ± standard deviation over {variant.runs} runs)" if _spread(variant) else ""
