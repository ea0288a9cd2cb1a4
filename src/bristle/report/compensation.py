"""The gain of compensation and the best variant of a loop, in sentences."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from bristle.core import Experiment, Kind, Status, Variant, number, scale_of, unit_of, with_unit
from bristle.report.messages import message
from bristle.report.table import length_text, short_text

if TYPE_CHECKING:
    from bristle.prediction import Claim, Following
    from bristle.simulation import SimulationResult, Statistics, VariantResult

BASE = "base"
NO_BREAK = "\u00a0"
NO_CHANGE = 0.05  # smaller relative changes count as no change
NAMES_MAX = 4  # variants in a list of names
MANY = 10.0  # larger ratios are written as factors


def change_text(
    before: float, after: float, written: Callable[[float], str], statistic: str
) -> str:
    """Return a change of a number, such as ``12.3 → 4.1 µm, ×3``."""
    old, new = written(before), written(after)
    old = old.split(NO_BREAK)[0] if old.split(NO_BREAK)[1:] == new.split(NO_BREAK)[1:] else old
    times = (
        f", ×{number(before / after, digits=2)}"
        if 0.0 < after < (1.0 - NO_CHANGE) * before
        else ": no improvement"
    )
    return f"{old} → {new} {statistic}{times}"


class Errors(NamedTuple):
    """The following error of one variant after its settling time, and the lag in it."""

    name: str
    peak_to_peak: float
    beyond_lag: float
    lag: float
    lag_share: float


class Gain(NamedTuple):
    """The loop step by step: the first loop if it differs, the loop without friction feedforward, and the loop with it."""

    steps: tuple[Errors, ...]
    kind: Kind
    caveat: str
    alone: bool = True
    velocity_fed: bool = False
    subject: str = "following error"
    measure: str = "friction feedforward"

    @property
    def headline(self) -> str:
        """The gain of friction feedforward in a line, for the report, terminal, notebook and served lab."""
        before, after = (step.peak_to_peak for step in self.steps[-2:])
        measure = f"{self.measure[0].upper()}{self.measure[1:]}"
        return f"{measure}: {change_text(before, after, partial(length_text, kind=self.kind), 'peak to peak')}"

    def sentences(self) -> list[str]:
        """Return the effect of compensation on the following error, in sentences."""
        if not self.steps:
            return ["A simulated loop diverged, so the gain of compensation is unknown."]
        peaks, words = (
            [step.peak_to_peak for step in self.steps],
            [self._words(step.peak_to_peak) for step in self.steps],
        )
        lines = [self._about_friction()]
        if len(peaks) > 2:
            lines.append(
                f"With all feedforward, the {self.subject} goes from {words[0]} ({self.steps[0].name}) to {words[-1]}"
                f"{_times(peaks[0], peaks[-1])}."
            )
        # Most of the mean square of the error is proportional to velocity.
        return [
            *lines,
            *([self._about_lag()] if self.steps[-1].lag_share >= 0.5 else []),
            self.caveat,
        ]

    def _about_friction(self) -> str:
        before, after = (step.peak_to_peak for step in self.steps[-2:])
        old, new = (f"{self._words(step.peak_to_peak)} ({step.name})" for step in self.steps[-2:])
        change = f"the {self.subject} from {old} to {new} peak to peak"
        if not self.alone:
            return (
                f"In simulation, the {self.subject} goes from {old} to {new} peak to peak. The two variants differ in more than friction "
                "feedforward. Add a variant that differs only in friction feedforward to see its gain."
            )
        if after > (1.0 + NO_CHANGE) * before:
            return f"In simulation, {self.measure} raises {change}. Do not use this compensation."
        if after > (1.0 - NO_CHANGE) * before:
            return f"In simulation, {self.measure} hardly changes the {self.subject}: {old} without it, {new} with it."
        return f"In simulation, {self.measure} lowers {change}{_times(before, after)}."

    def _about_lag(self) -> str:
        before, compensated = self.steps[-2:]
        scale = scale_of(unit_of("length", self.kind), before.beyond_lag)
        old, new = (short_text(error.beyond_lag * scale.factor) for error in (before, compensated))
        # The error does not distinguish the two causes: both are proportional to velocity.
        cause = (
            "viscous friction without feedforward, or the remaining lag of the position loop. Velocity feedforward is already on: "
            "check the viscous friction of the compensator, F_v"
            if self.velocity_fed
            else "the lag of the position loop, which velocity feedforward removes, or viscous friction without feedforward"
        )
        return (
            f"{100.0 * compensated.lag_share:.3g} % of the mean square of the remaining error is proportional to velocity, like a lag of "
            f"{with_unit(compensated.lag, 's')}. Likely cause: {cause}. Without this lag, compensation changes the error from {old} to "
            f"{new} {scale.unit} peak to peak."
        )

    def _words(self, length: float) -> str:
        return with_unit(length, unit_of("length", self.kind))


class Standing(NamedTuple):
    """The present loop, and the variant with the smallest error."""

    base: VariantResult
    best: VariantResult
    alike: bool

    @property
    def instead(self) -> str:
        """The error of the best variant instead of that of the present loop, with the reduction.

        The reduction is in percent, or a factor if percent would always read 99.
        """
        new, old = (
            f"{length_text(_peak(loop), loop.kind)} ({loop.name})"
            for loop in (self.best, self.base)
        )
        errors = f"{self.best.error_word.lower()} {new} instead of {old} peak to peak"
        if self.alike:
            return f"{errors}, hardly less"
        left = _peak(self.best) / _peak(self.base)
        if left * MANY * MANY < 1.0:
            return f"{errors}, smaller by more than a factor of 100"
        if left * MANY < 1.0:
            return f"{errors}, smaller by a factor of {number(1.0 / left, digits=2)}"
        return f"{errors}, {number(100.0 * (1.0 - left), digits=2)}\u00a0% less"


def about_loop(gain: Gain | None, following: Following | None, kind: Kind) -> list[str]:
    """Return the measured and simulated following error, and the gain of compensation in simulation.

    The gain is left out if the simulation does not match the log.
    """
    gained = [] if gain is None else gain.sentences()
    if following is None:
        return gained
    if following.contradiction is not None:
        return [f"bristle predicts no gain: {message(following.contradiction)}."]
    unit = unit_of("length", kind)
    simulated = (
        []
        if following.simulated is None
        else [f"In simulation, it is {_error_text_of(following.simulated, unit)}."]
    )
    return [
        " ".join(
            [
                f"In the log, the following error is {_error_text_of(following.measured, unit)}.",
                *simulated,
            ]
        ),
        *gained,
    ]


def _error_text_of(error: Statistics, unit: str) -> str:
    return f"{with_unit(error.peak_to_peak, unit)} peak to peak and {with_unit(error.rms, unit)} root mean square"


def _times(before: float, after: float) -> str:
    return f", by a factor of {number(before / after, digits=2)}" if 0.0 < after < before else ""


def pair_of(
    experiment: Experiment, compensated: Variant | None = None
) -> tuple[Variant, Variant] | None:
    """Return a variant without and a variant with friction feedforward that otherwise agree.

    The second is the first variant with friction feedforward by default. If no variant differs only in feedforward, the
    first is the first variant without it. None if either kind is missing. With a wind-up, the first has friction feedforward of one mass.
    """
    plain = [variant for variant in experiment.variants if variant.feedforward.friction is None]
    compensated = compensated or next(
        (variant for variant in experiment.variants if variant.feedforward.friction is not None),
        None,
    )
    if compensated is not None and _winds_up(compensated):
        rigid = next(
            (variant for variant in experiment.variants if _is_wound_up(variant, compensated)), None
        )
        if rigid is not None:
            return rigid, compensated
    if compensated is None or not plain:
        return None
    return next(
        (variant for variant in plain if _is_pair(variant, compensated)), plain[0]
    ), compensated


def _is_pair(before: Variant, after: Variant) -> bool:
    """Return whether two variants differ only in friction feedforward, or in the wind-up with both masses."""
    winds = _is_wound_up(before, after)
    return before.controller == after.controller and (
        winds or before.feedforward.mass == after.feedforward.mass
    )


def _is_wound_up(before: Variant, after: Variant) -> bool:
    """Return whether the second variant feeds both masses forward, and the first one mass with friction."""
    return before.feedforward.friction is not None and _winds_up(after) and not _winds_up(before)


def _winds_up(variant: Variant) -> bool:
    plant = variant.feedforward.plant
    return plant is not None and plant.component.screw is not None


def pair_in(simulation: SimulationResult) -> tuple[Variant, Variant] | None:
    """Return the pair of the variant with friction feedforward and the smallest error."""
    fed = [
        variant
        for variant in simulation.experiment.variants
        if variant.feedforward.friction is not None
    ]
    completed = [
        variant
        for variant in fed
        if simulation.variants[variant.name].status is not Status.NOT_FINITE
    ]
    return pair_of(
        simulation.experiment,
        min(completed, key=lambda variant: _peak(simulation.variants[variant.name]), default=None),
    )


def variant_of(simulation: SimulationResult, name: str) -> Variant:
    """Return a variant of an experiment by its name."""
    return next(variant for variant in simulation.experiment.variants if variant.name == name)


def gain_of(simulation: SimulationResult) -> Gain | None:
    """Return the gain of compensation; None if the variants do not show it."""
    experiment, pair = simulation.experiment, pair_in(simulation)
    if pair is None:
        return None
    (before, after), first = pair, experiment.variants[0]
    # A gain of another law is no gain of feedforward.
    laws = [
        {name: repr(value) for name, value in variant.controller.values.items() if name != "k_ff"}
        for variant in (first, before)
    ]
    is_one = first.controller.name == before.controller.name and laws[0] == laws[1]
    chosen = pair if first in pair or not is_one else (first, *pair)
    results = [simulation.variants[variant.name] for variant in chosen]
    diverged = any(result.status is Status.NOT_FINITE for result in results)
    steps = () if diverged else tuple(_errors(*step) for step in zip(chosen, results, strict=True))
    caveat = "This is a simulation: confirm the gain on the machine."
    if after.disturbance is not None:
        caveat = (
            "The simulated axis includes the unexplained force of the log, so this test does not rely on the model alone. It is still a "
            "simulation: confirm the gain on the machine."
        )
    elif after.friction == after.feedforward.friction:
        caveat = (
            "The simulated axis has exactly the friction of the feedforward. Treat this gain as an upper limit, and confirm it on the "
            "machine."
        )
    velocity_fed, subject = (
        after.controller.values.get("k_ff", 0.0) > 0.0,
        results[0].error_word.lower(),
    )
    measure = (
        "feedforward of both masses" if _is_wound_up(before, after) else "friction feedforward"
    )
    return Gain(
        steps, experiment.kind, caveat, _is_pair(before, after), velocity_fed, subject, measure
    )


def _errors(variant: Variant, result: VariantResult) -> Errors:
    judged = slice(round(variant.run.settle / variant.run.sample_time), None)
    error = result.error[judged]
    velocity = np.gradient(result.reference, variant.run.sample_time)[judged]
    power, square = float(velocity @ velocity), float(error @ error)
    lag = float(error @ velocity) / power if power > 0.0 else 0.0
    beyond = error - lag * velocity
    share = 1.0 - float(beyond @ beyond) / square if square > 0.0 else 0.0
    return Errors(variant.name, _peak(result), float(np.ptp(beyond)), lag, share)


def standing(result: SimulationResult) -> Standing | None:
    """Return the present loop and the best loop with the same reference; None if the present loop did not complete.

    The present loop is the variant called ``base``, or else the first variant.
    """
    named = BASE in result.variants or BASE in result.refused
    base = (
        result.variants.get(BASE if named else next(iter(result.experiment.variants)).name)
        if result.variants
        else None
    )
    completed = [
        loop
        for loop in result.variants.values()
        if loop.status is not Status.NOT_FINITE and math.isfinite(_peak(loop))
    ]
    if base is None or not any(loop is base for loop in completed):
        return None
    references = {variant.name: variant.reference for variant in result.experiment.variants}
    eligible = [loop for loop in completed if loop is base or loop.name not in result.unstable]
    best = min(
        (loop for loop in eligible if references[loop.name] == references[base.name]), key=_peak
    )
    return Standing(base, best, best is base or is_alike(best, base))


def closing_sentences(result: SimulationResult) -> list[str]:
    """Return the conclusions of an experiment: the gain of compensation, and the best variant."""
    gain, rank = gain_of(result), standing(result)
    gained, best = [] if gain is None else gain.sentences(), []
    if rank is not None and rank.best is not rank.base:
        best = [f"The best variant is {rank.best.name}: {rank.instead}."]
    elif rank is not None and len(result.variants) > 1:
        best = [
            f"No variant is better than {rank.base.name}: {length_text(_peak(rank.base), rank.base.kind)} peak to peak."
        ]
    return [*gained[:-1], *best, *gained[-1:]]


def helped_text(claims: Sequence[Claim], kind: Kind, helps: str = "; it helps") -> str:
    """Return the moves that a feedforward helps as the end of a sentence, nothing without a promise."""
    moves = "; ".join(claim.text(length_text(claim.least_distance, kind)) for claim in claims)
    return f"{helps} {moves}" if claims else ""


def names_text(names: Sequence[object], most: int = NAMES_MAX) -> str:
    """Return a short list of names, and the number of further names."""
    return ", ".join(map(str, names[:most])) + (
        f" and {len(names) - most} more" if len(names) > most else ""
    )


def _peak(variant: VariantResult) -> float:
    return variant.compared_error.peak_to_peak


def is_alike(best: VariantResult, variant: VariantResult) -> bool:
    """Return whether the difference of two variants is negligible, or within the scatter of their runs."""
    spreads = [
        float(loop.spread[loop.compared]["peak_to_peak"]) if loop.spread else 0.0
        for loop in (best, variant)
    ]
    return _peak(variant) - _peak(best) <= max(NO_CHANGE * _peak(variant), sum(spreads))
