"""The gain of compensation, and the best variant of a loop: every wording of how much less a loop errs than another."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from bristle.core import Kind, Status, number, scale_of, unit_of, with_unit
from bristle.report.messages import message
from bristle.report.table import fixed, length_text, short_text

if TYPE_CHECKING:
    from bristle.core import Experiment, Variant
    from bristle.prediction import Following
    from bristle.simulation import SimulationResult, Statistics, VariantResult

BASE = "base"
NO_CHANGE = 0.05  # relative change below which nothing is claimed
NAMES_MAX = 4  # names of variants that are listed
MANY = 10.0  # times less: told as a factor


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
        peaks, words = [step.peak_to_peak for step in self.steps], [self._words(step.peak_to_peak) for step in self.steps]
        lines = [self._about_friction()]
        if len(peaks) > 2:
            lines.append(
                f"The first loop, {self.steps[0].name}, has {words[0]}: with all that is fed forward "
                f"it becomes {words[-1]}{_times(peaks[0], peaks[-1])}."
            )
        # Most of the mean square of the error is in proportion to the velocity.
        return [*lines, *([self._about_lag()] if self.steps[-1].lag_share >= 0.5 else []), self.caveat]

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

    def _about_lag(self) -> str:
        before, compensated = self.steps[-2:]
        scale = scale_of(unit_of("length", self.kind), before.beyond_lag)
        old, new = (short_text(error.beyond_lag * scale.factor) for error in (before, compensated))
        # Which of the two it is cannot be told from the error: either rises with the velocity.
        cause = (
            "viscous friction that is not fed forward, or the rest of the lag of the position loop. Velocity is fed "
            "forward already: look at the viscous friction of the compensator, F_v"
            if self.velocity_fed
            else "the lag of the position loop, which velocity fed forward removes, or viscous friction that is not fed forward"
        )
        return (
            f"{100.0 * compensated.lag_share:.3g} % of the mean square of what is left is in proportion to the velocity, a lag of "
            f"{with_unit(compensated.lag, 's')}: {cause}. Beyond this lag the error goes from {old} to {new} {scale.unit} peak to peak."
        )

    def _words(self, length: float) -> str:
        return with_unit(length, unit_of("length", self.kind))


class Standing(NamedTuple):
    """The loop as it stands, and the variant that errs least."""

    base: VariantResult
    best: VariantResult
    alike: bool

    @property
    def instead(self) -> str:
        """The error of the best variant instead of that of the loop as it stands, and how much less that is.

        By a factor where percent would all be 99 and some.
        """
        new, old = (f"{length_text(_peak(loop), loop.kind)} ({loop.name})" for loop in (self.best, self.base))
        less, ratio = "hardly less", _peak(self.base) / _peak(self.best) if _peak(self.best) else math.inf
        if not self.alike:
            less = (
                f"{number(100.0 * (1.0 - 1.0 / ratio), digits=2)}\u00a0% less"
                if ratio <= MANY
                else f"by a factor of {number(ratio, digits=2)}"
            )
            less = "less than a hundredth" if ratio > MANY * MANY else less
        return f"following error {new} instead of {old} peak to peak, {less}"


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
    beside = "" if following.simulated is None else f"; the simulated loop has {_error_text_of(following.simulated, unit)}"
    return [f"In the log, the following error is {_error_text_of(following.measured, unit)}{beside}.", *gained]


def gain_lines(simulation: SimulationResult | None, following: Following | None, kind: Kind) -> list[str]:
    """Return the same for a first page: the errors in the log and in simulation, and the effort."""
    if following is None:
        return ["not simulated: that takes a log with a reference, and a controller in the axis file"]
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


def _error_text_of(error: Statistics, unit: str) -> str:
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
    # What another law gains, but for what it feeds forward, is no gain of what is fed forward.
    laws = [{name: repr(value) for name, value in variant.controller.values.items() if name != "k_ff"} for variant in (first, before)]
    is_one = first.controller.name == before.controller.name and laws[0] == laws[1]
    chosen = pair if first in pair or not is_one else (first, *pair)
    results = [simulation.variants[variant.name] for variant in chosen]
    diverged = any(result.status is Status.NOT_FINITE for result in results)
    steps = () if diverged else tuple(_errors(*step) for step in zip(chosen, results, strict=True))
    caveat = "This is a simulation: confirm the gain on the machine."
    if after.disturbance is not None:
        caveat = (
            "The simulated axis is disturbed by what the model does not explain of the log, so the compensation is not "
            "judged by its own model alone. It is a simulation all the same: confirm the gain on the machine."
        )
    elif after.friction == after.feedforward.friction:
        caveat = (
            "The simulated axis has exactly the friction that is fed forward: take this gain as the most to be hoped "
            "for, and confirm it on the machine."
        )
    return Gain(steps, experiment.kind, caveat, _is_pair(before, after), after.controller.values.get("k_ff", 0.0) > 0.0)


def _errors(variant: Variant, result: VariantResult) -> Errors:
    judged = slice(round(variant.run.settle / variant.run.sample_time), None)
    error = (result.reference - result.measured)[judged]
    velocity = np.gradient(result.reference, variant.run.sample_time)[judged]
    power, square = float(velocity @ velocity), float(error @ error)
    lag = float(error @ velocity) / power if power > 0.0 else 0.0
    beyond = error - lag * velocity
    share = 1.0 - float(beyond @ beyond) / square if square > 0.0 else 0.0
    return Errors(variant.name, result.following_error.peak_to_peak, float(np.ptp(beyond)), lag, share)


def standing(result: SimulationResult) -> Standing | None:
    """Return the loop as it stands and the best one along the same reference; None where that loop did not complete.

    It is the variant of that name, else the first.
    """
    named = BASE in result.variants or BASE in result.refused
    base = result.variants.get(BASE if named else next(iter(result.experiment.variants)).name) if result.variants else None
    done = [loop for loop in result.variants.values() if loop.status is not Status.NOT_FINITE and math.isfinite(_peak(loop))]
    if base is None or not any(loop is base for loop in done):
        return None
    references = {variant.name: variant.reference for variant in result.experiment.variants}
    best = min((loop for loop in done if references[loop.name] == references[base.name]), key=_peak)
    return Standing(base, best, best is base or is_alike(best, base))


def closing_sentences(result: SimulationResult) -> list[str]:
    """Return what to take from the variants of an experiment: what compensation gains, and which variant is best."""
    gain, rank = gain_of(result), standing(result)
    gained, best = [] if gain is None else gain.sentences(), []
    if rank is not None and rank.best is not rank.base:
        best = [f"{rank.best.name} errs least: {rank.instead}."]
    elif rank is not None and len(result.variants) > 1:
        best = [f"No variant errs less than {rank.base.name}: {length_text(_peak(rank.base), rank.base.kind)} peak to peak."]
    return [*gained[:-1], *best, *gained[-1:]]


def names_text(names: Sequence[object], most: int = NAMES_MAX) -> str:
    """Return names in a list, as many as are read, and how many more there are."""
    return ", ".join(map(str, names[:most])) + (f" and {len(names) - most} more" if len(names) > most else "")


def _peak(variant: VariantResult) -> float:
    return variant.following_error.peak_to_peak


def is_alike(best: VariantResult, variant: VariantResult) -> bool:
    """Return whether two variants are not told apart: by as much as nobody minds, or as their runs scatter."""
    spreads = [float(loop.spread["following_error"]["peak_to_peak"]) if loop.spread else 0.0 for loop in (best, variant)]
    return _peak(variant) - _peak(best) <= max(NO_CHANGE * _peak(variant), sum(spreads))
