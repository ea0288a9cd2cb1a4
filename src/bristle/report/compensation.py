"""What feeding the friction forward gains, from the variants of one loop."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from bristle.core.status import Status
from bristle.core.typography import number, scale_of, with_unit
from bristle.core.variable import Kind, unit_of
from bristle.report.messages import message

if TYPE_CHECKING:
    from bristle.core.experiment import Experiment, Variant
    from bristle.prediction.following import Following
    from bristle.simulation.result import SimulationResult, Statistics, VariantResult

__all__ = ["Gain", "about_loop", "gain_of", "pair_in", "pair_of"]

NO_CHANGE = 0.05  # relative change below which nothing is claimed
MOSTLY_LAG = 0.5  # share of the mean square of the following error that is in proportion to velocity


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
        old, new = self._words(before), self._words(after)
        if not self.alone:
            return (
                f"In simulation, the following error goes from {old} ({self.steps[-2].name}) to {new} "
                f"({self.steps[-1].name}) peak to peak. The two differ in more than the friction fed forward: add a "
                "variant that differs in that alone to see what it gains."
            )
        if after > (1.0 + NO_CHANGE) * before:
            return (
                f"In simulation, feeding the friction forward raises the following error from {old} "
                f"({self.steps[-2].name}) to {new} ({self.steps[-1].name}) peak to peak: do not use this compensation "
                "as it is."
            )
        if after > (1.0 - NO_CHANGE) * before:
            return (
                f"In simulation, feeding the friction forward hardly changes the following error: {old} "
                f"({self.steps[-2].name}), then {new} ({self.steps[-1].name})."
            )
        return (
            f"In simulation, feeding the friction forward lowers the following error from {old} "
            f"({self.steps[-2].name}) to {new} ({self.steps[-1].name}) peak to peak{_times(before, after)}."
        )

    def _about_all(self) -> list[str]:
        if len(self.steps) < 3:
            return []
        first, last = self.steps[0].peak_to_peak, self.steps[-1].peak_to_peak
        return [
            f"The first loop, {self.steps[0].name}, has {self._words(first)}: with all that is fed forward "
            f"it becomes {self._words(last)}{_times(first, last)}."
        ]

    def _about_lag(self) -> list[str]:
        before, compensated = self.steps[-2:]
        if compensated.lag_share < MOSTLY_LAG:
            return []
        scale = scale_of(unit_of("length", self.kind), before.beyond_lag)
        old, new = (number(error.beyond_lag * scale.factor, digits=3) for error in (before, compensated))
        share, lag = 100.0 * compensated.lag_share, with_unit(compensated.lag, "s")
        # Which of the two it is cannot be told from the error: either rises with the velocity.
        cause = (
            "viscous friction that is not fed forward, or the rest of the lag of the position loop. Velocity is fed "
            "forward already: look at the viscous friction of the compensator, F_v"
            if self.velocity_fed
            else "the lag of the position loop, which velocity fed forward removes, or viscous friction that is not fed forward"
        )
        return [
            f"{share:.3g} % of the mean square of what is left is in proportion to the velocity, a lag of {lag}: "
            f"{cause}. Beyond this lag the error "
            f"goes from {old} to {new} {scale.unit} peak to peak."
        ]

    def _words(self, length: float) -> str:
        return with_unit(length, unit_of("length", self.kind))


def about_loop(gain: Gain | None, following: Following | None, kind: Kind) -> list[str]:
    """Return how the axis followed its reference, how it does in simulation, and what compensation gains there.

    Where the simulation does not follow as the log does, no gain is told.
    """
    gained = [] if gain is None else gain.sentences()
    if following is None:
        return gained
    if following.contradiction is not None:
        words = message(following.contradiction)
        return [f"No gain is promised: {words}."]
    unit = unit_of("length", kind)
    beside = "" if following.simulated is None else f"; the simulated loop has {_both(following.simulated, unit)}"
    return [f"In the log, the following error is {_both(following.measured, unit)}{beside}.", *gained]


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
    fed = (variant for variant in experiment.variants if variant.feedforward.friction is not None)
    compensated = compensated or next(fed, None)
    if compensated is None or not plain:
        return None
    mass, law = compensated.feedforward.mass, compensated.controller
    alike = [variant for variant in plain if variant.feedforward.mass == mass and variant.controller == law]
    return (alike or plain)[0], compensated


def pair_in(simulation: SimulationResult) -> tuple[Variant, Variant] | None:
    """Return the pair of the variant with friction fed forward that errs least."""
    completed = [
        variant
        for variant in simulation.experiment.variants
        if variant.feedforward.friction is not None and simulation.variants[variant.name].status is not Status.NOT_FINITE
    ]
    best = min(completed, key=lambda variant: simulation.variants[variant.name].following_error.peak_to_peak, default=None)
    return pair_of(simulation.experiment, best)


def gain_of(simulation: SimulationResult) -> Gain | None:
    """Return what compensation gains; None where the variants do not show it."""
    experiment = simulation.experiment
    pair = pair_in(simulation)
    if pair is None:
        return None
    first = experiment.variants[0]
    # What another law gains is no gain of what is fed forward.
    chosen = pair if first in pair or _law(first) != _law(pair[0]) else (first, *pair)
    results = [simulation.variants[variant.name] for variant in chosen]
    diverged = any(result.status is Status.NOT_FINITE for result in results)
    steps = () if diverged else tuple(_errors(*pair) for pair in zip(chosen, results, strict=True))
    before, after = pair
    alone = before.feedforward.mass == after.feedforward.mass and before.controller == after.controller
    velocity_fed = after.controller.values.get("k_ff", 0.0) > 0.0
    return Gain(steps, experiment.kind, _caveat(after), alone, velocity_fed)


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
