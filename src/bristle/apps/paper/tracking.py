"""The loop of the rig, simulated once for all its figures; the same loop with sound margins; and figure 7."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.apps.paper.bench import bench_of
from bristle.apps.paper.reproduced import Reproduced, in_micrometres
from bristle.apps.paper.rig import SETS
from bristle.apps.paper.rig_layout import Mechanics, rig_layout
from bristle.apps.paper.setting import Setting
from bristle.core import (
    BristleError,
    Experiment,
    InputError,
    Origin,
    Status,
    Variant,
    cached_property,
    number,
    with_unit,
)
from bristle.files import read_experiment
from bristle.report.figures.loop_rows import error_over, tracking_error
from bristle.report.table import Table
from bristle.simulation import SimulationResult, VariantResult, assess, simulate

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BEFORE = "none"
PRINTED = "printed"
WITH_CONSTANT = "printed_constant"
CALIBRATED = "paper"
PUBLISHED = (BEFORE, PRINTED, WITH_CONSTANT, CALIBRATED)  # The loops in figures
NAMES = {
    BEFORE: "no compensator",
    PRINTED: "(5)–(7) as printed",
    WITH_CONSTANT: "(5)–(7) and a constant",
    CALIBRATED: "calibrated, × 0.64",
    "lugre": "LuGre",
    "gate": "(5)–(7) with a gate",
    "identified": "model identified on the rig",
    "observer": "observer, no model",
    "observer_feedforward": "observer and identified model",
}
COMPENSATED = "compensated"
IN_PAPER = {BEFORE: 1.46e-6, COMPENSATED: 0.69e-6}  # peak to peak [m]


class DivergedError(BristleError):
    """A loop of a figure diverged."""

    exit_code = 1


@dataclass
class Tracked:
    """The tracking experiment, simulated once for all its figures."""

    source: Path
    allow_code: bool = False
    needed: tuple[str, ...] = PUBLISHED
    report: Callable[[float, str], None] | None = None

    @cached_property
    def experiment(self) -> Experiment:
        """The experiment."""
        experiment = read_experiment(self.source, allow_code=self.allow_code)
        names = [variant.name for variant in experiment.variants]
        for name in self.needed:
            if name not in names:
                raise InputError(
                    "is missing, but the figures of the paper need it",
                    path=f"{self.source}: compare.{name}",
                )
        return experiment

    @property
    def origin(self) -> Origin:
        """Name and checksum of the experiment file."""
        return self.experiment.origins["experiment"][0]

    @cached_property
    def result(self) -> SimulationResult:
        """All variants, simulated."""
        result = simulate(self.experiment, self.report)
        for name, loop in result.variants.items():
            if loop.status is Status.NOT_FINITE:
                raise DivergedError(f"{self.source}: compare.{name}: {loop.status.sentence}")
        return result

    @property
    def published(self) -> dict[str, VariantResult]:
        """The loops in figures, by name."""
        return {name: self.result.variants[name] for name in PUBLISHED}

    @property
    def pictured(self) -> dict[str, VariantResult]:
        """The same loops, with the names of their panels."""
        return {NAMES[name]: loop for name, loop in self.published.items()}

    @property
    def settle(self) -> float:
        """Omitted time at the start [s]."""
        return self.experiment.variants[0].run.settle

    @property
    def arm(self) -> float:
        """Torque of the screw over force at the table [m/rad]."""
        return SETS["set_a"].lead / (2.0 * math.pi)

    def turn(self, before: float, after: float) -> tuple[float, float]:
        """Return two times around the highest point of the reference [s]."""
        loop = self.result.variants[BEFORE]
        judged = loop.time >= self.settle
        top = float(loop.time[judged][np.argmax(loop.reference[judged])])
        return top - before, top + after


def spread_of(loop: VariantResult, *keys: str) -> float:
    """Return the standard deviation over the runs of a number of `VariantResult.as_dict`; NaN for one run."""
    value: Any = loop.spread
    for key in keys:
        if isinstance(value, Mapping):
            value = value.get(key, {})
    if not isinstance(value, float):
        return math.nan
    return float(value)


def with_spread(value: float, spread: float, step: float = 0.01) -> str:
    """Return a number with its spread as text, both rounded to this step; without NaN spread."""
    text = number(value, resolution=step)
    if math.isnan(spread):
        return text
    return f"{text} ± {number(spread, resolution=step)}"


def quoted(loop: VariantResult, *keys: str, factor: float = 1e6, step: float = 0.01) -> str:
    """Return a scaled number of `VariantResult.as_dict`, with its spread over the runs, as text."""
    value: Any = loop.as_dict()
    for key in keys:
        value = value[key]
    return with_spread(factor * value, factor * spread_of(loop, *keys), step)


@dataclass(frozen=True)
class Sound:
    """Two experiments in addition to that of figures 11 to 14."""

    loop: Tracked
    levels: Tracked

    @cached_property
    def margins(self) -> dict[str, tuple[float, float]]:
        """Smallest phase margin [degrees] and gain margin of each variant, independent of friction."""
        return {variant.name: least_margins(variant) for variant in self.loop.experiment.variants}

    @property
    def at_levels(self) -> list[tuple[float, VariantResult]]:
        """Break-away torque at the screw [N*m] and the loop with it."""
        return [
            (
                self.levels.arm * variant.feedforward.friction.values["F_S"],
                self.levels.result.variants[variant.name],
            )
            for variant in self.levels.experiment.variants
            if variant.feedforward.friction is not None
        ]

    @property
    def numbers(self) -> dict[str, Any]:
        """The results, for the summary."""
        errors = [(level, loop.following_error) for level, loop in self.at_levels]
        levels = [
            {"break_away": level, "peak_to_peak": error.peak_to_peak, "mean": error.mean}
            for level, error in errors
        ]
        margins = {
            name: {"phase_deg": phase, "gain": gain} for name, (phase, gain) in self.margins.items()
        }
        loops = {name: loop.as_dict() for name, loop in self.loop.result.variants.items()}
        return {"at_sound_margins": loops, "margins": margins, "over_break_away": levels}


def sound_table(sound: Sound) -> Table:
    """Return the gain of each part of the control at sound margins."""
    rows = []
    for name, loop in sound.loop.result.variants.items():
        phase, gain = sound.margins[name]
        cells = [quoted(loop, key, "peak_to_peak") for key in ("following_error", "true_error")]
        rows.append(
            (name, NAMES.get(name, ""), *cells, number(phase, digits=3), number(gain, digits=3))
        )
    heads = (
        "Variant",
        "Friction compensation",
        "Peak to peak [µm]",
        "True error [µm]",
        "Phase margin [°]",
        "Gain margin",
    )
    return Table("The same motion in a loop with sound margins", heads, rows)


def sound_extra(sound: Sound) -> tuple[Callable[[], Figure], str, str]:
    """Return the following error at sound margins: drawing, description, caption."""
    loops = {
        NAMES[name]: loop for name, loop in sound.loop.result.variants.items() if name in NAMES
    }
    least = min(phase for phase, _ in sound.margins.values())
    return (
        lambda: tracking_error(loops, sound.loop.settle),
        "Following error over time in a loop with sound margins, by friction compensation",
        f"The same motion with practical gains, at phase margins of {number(least, digits=2)}° and more: "
        "the gain of each part of the control.",
    )


def break_away_extra(sound: Sound) -> tuple[Callable[[], Figure], str, str]:
    """Return the error over the break-away torque: drawing, description, caption."""

    def draw() -> Figure:
        errors = np.array([loop.following_error.peak_to_peak for _, loop in sound.at_levels])
        spreads = np.nan_to_num(
            [spread_of(loop, "following_error", "peak_to_peak") for _, loop in sound.at_levels]
        )
        errors_found = {
            "found": 1e6 * np.column_stack([errors, errors - spreads, errors + spreads])
        }
        reported = {"the paper reports": 1e6 * IN_PAPER[COMPENSATED]}
        levels = [1e3 * level for level, _ in sound.at_levels]
        return error_over(
            levels,
            errors_found,
            reported,
            "Break-away torque of (7) [mN·m]",
            "Error, peak to peak [µm]",
        )

    return (
        draw,
        "Following error with the printed equations over their break-away torque",
        "Equations (5) to (7) with gain 1, over their break-away torque, which the paper omits. Bars: standard deviation over the runs.",
    )


def least_margins(variant: Variant) -> tuple[float, float]:
    """Return the smallest phase margin [degrees] and gain margin; infinite without a crossover of the open loop."""
    margins = [point.margins for point in assess(variant).points]
    phase = min((margin.phase for margin in margins if margin.phase is not None), default=math.inf)
    return phase, min(
        (margin.gain for margin in margins if margin.gain is not None), default=math.inf
    )


def figure_7(tracked: Tracked, setting: Setting) -> Reproduced:
    """Return figure 7: the rig and its control scheme, drawn from their experiments."""
    variant = next(variant for variant in tracked.experiment.variants if variant.name == PRINTED)
    run = variant.run
    resolution = float(variant.sensor.values["resolution"])
    law = variant.controller.name.replace("_", " ")
    compensator = "none"
    if variant.feedforward.friction:
        compensator = variant.feedforward.friction.name.replace("_", " ")
    bench = bench_of(setting)
    lead = 2.0 * math.pi * setting.arm
    total, before = (with_unit(inertia, "kg*m^2") for inertia in (bench.J, bench.J_m))
    return Reproduced(
        number=7,
        verdict="shown",
        found=[
            f"A screw with a lead of {with_unit(lead, 'm')}. The total inertia at the screw is {total}, or "
            f"{number(bench.J / setting.arm**2, digits=3)} kg at the table. Of it {before} is on the motor side of the torque sensor.",
            f"A loop at {number(1e-3 / run.sample_time, digits=2)} kHz with {run.delay} sample of delay and an encoder "
            f"of {in_micrometres(resolution)}; control law {law}, compensator {compensator}.",
        ],
        draw=lambda: rig_layout(
            Mechanics(lead, bench.J, bench.J_m, bench.cutoff, resolution), variant
        ),
        origin=tracked.origin,
        numbers={"sample_time": run.sample_time, "delay": run.delay, "resolution": resolution}
        | {"lead": lead, "inertia": bench.J, "inertia_before_sensor": bench.J_m},
    )
