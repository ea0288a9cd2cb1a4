"""Figures 7 and 11 to 14: the loop of the rig, without and with the compensator of the paper."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from bristle.core.content import Origin
from bristle.core.errors import BristleError, InputError
from bristle.core.experiment import Experiment
from bristle.core.lazy import cached_property
from bristle.core.status import Status
from bristle.core.typography import number
from bristle.files.experiment import read_experiment
from bristle.paper.bench import SETS
from bristle.paper.reproduced import Reproduced, in_micrometres, percent
from bristle.report.table import Table
from bristle.simulation import SimulationResult, VariantResult, simulate

__all__ = ["DivergedError", "Tracked", "figure_7", "figure_11", "figure_12", "figure_13", "figure_14"]

BEFORE, AFTER = "none", "paper"
NAMES = {BEFORE: "without compensator", AFTER: "with compensator"}
PRINTED = {BEFORE: 1.46e-6, AFTER: 0.69e-6}  # peak to peak [m]
AS_PRINTED = 0.05e-6  # how near to the numbers of the paper counts as the same [m]
ALIKE = 0.05  # relative change of the effort that is none
CHATTER = 0.2  # shown close up [s]


class DivergedError(BristleError):
    """A loop that was to be shown left the finite numbers."""

    exit_code = 1


@dataclass(frozen=True)
class Tracked:
    """The tracking experiment, simulated once for all figures that show it.

    Parameters
    ----------
    source : Path
        The experiment file.
    allow_code : bool
        Whether models of a person's own that it names may run without having been allowed before.
    listeners : list of callable
        Called with the share done and the variant that comes next.
    """

    source: Path
    allow_code: bool = False
    listeners: list[Callable[[float, str], None]] = field(default_factory=list)

    @cached_property
    def experiment(self) -> Experiment:
        """The experiment.

        Raises
        ------
        InputError
            If it lacks one of the variants that the figures compare.
        """
        found = read_experiment(self.source, allow_code=self.allow_code)
        names = [one.name for one in found.variants]
        for name in NAMES:
            if name not in names:
                raise InputError(
                    "is missing, and the figures of the paper need it", path=f"{self.source}: compare.{name}"
                )
        return found

    @property
    def origin(self) -> Origin:
        """Name and checksum of its file."""
        return self.experiment.origins["experiment"][0]

    @cached_property
    def result(self) -> SimulationResult:
        """All variants, simulated.

        Raises
        ------
        DivergedError
            If a loop left the finite numbers.
        """
        found = simulate(self.experiment, self._tell)
        for name, one in found.variants.items():
            if one.status is Status.NOT_FINITE:
                raise DivergedError(f"{self.source}: compare.{name}: {one.status.sentence}")
        return found

    def _tell(self, share: float, text: str) -> None:
        for listener in self.listeners:
            listener(share, text)

    @property
    def pair(self) -> dict[str, VariantResult]:
        """The loop without and with the compensator, under the names that figures show."""
        return {shown: self.result.variants[name] for name, shown in NAMES.items()}

    @property
    def settle(self) -> float:
        """Time at the start that is left out [s]."""
        return self.experiment.variants[0].run.settle

    @property
    def arm(self) -> float:
        """Torque of the screw over force at the table [m/rad]."""
        return SETS["set_a"].lead / (2.0 * math.pi)

    def turn(self, before: float, after: float) -> tuple[float, float]:
        """Return two times around the highest point of the reference [s]."""
        one = self.result.variants[BEFORE]
        judged = one.time >= self.settle
        top = float(one.time[judged][np.argmax(one.reference[judged])])
        return top - before, top + after


def figure_7(tracked: Tracked) -> Reproduced:
    """Return figure 7: rig and control scheme, drawn from the experiment."""
    from bristle.figures import control_scheme

    variant = next(one for one in tracked.experiment.variants if one.name == AFTER)
    run, resolution = variant.run, variant.sensor.values["resolution"]
    law, fed = variant.controller.name.replace("_", " "), variant.feedforward.friction
    compensator = fed.name.replace("_", " ") if fed else "none"
    return Reproduced(
        number=7,
        verdict="shown",
        found=[
            f"A loop at {number(1e-3 / run.sample_time, digits=2)} kHz with {run.delay} sample of delay and an encoder "
            f"of {in_micrometres(resolution)}; control is {law}, the compensator {compensator}."
        ],
        draw=lambda: control_scheme(variant),
        origin=tracked.origin,
        numbers={"sample_time": run.sample_time, "delay": run.delay, "resolution": resolution},
    )  # fmt: skip


def figure_11(tracked: Tracked) -> Reproduced:
    """Return figure 11: command and position, without and with the compensator."""
    from bristle.figures import tracking

    reach = float(np.max(np.abs(tracked.result.variants[BEFORE].reference)))
    true = {name: tracked.result.variants[name].true_error.peak_to_peak for name in NAMES}
    return Reproduced(
        number=11,
        verdict="holds" if true[AFTER] < true[BEFORE] else "does not hold",
        found=[
            f"The command stays below {in_micrometres(reach, 2)}.",
            f"What the table really misses it by, which no encoder tells, goes from {in_micrometres(true[BEFORE])} to "
            f"{in_micrometres(true[AFTER])} peak to peak.",
        ],
        draw=lambda: tracking(tracked.pair, tracked.settle, tracked.turn(0.6, 0.9)),
        origin=tracked.origin,
        numbers={"amplitude": reach, "true_error": true},
    )


def figure_12(tracked: Tracked) -> Reproduced:
    """Return figure 12: the following error, and by direction."""
    from bristle.figures import tracking_error

    both = {name: tracked.result.variants[name] for name in NAMES}
    peaks = {name: one.following_error.peak_to_peak for name, one in tracked.result.variants.items()}
    worse = {name: one.by_direction["forward"].rms / one.by_direction["backward"].rms for name, one in both.items()}
    near = all(abs(peaks[name] - PRINTED[name]) <= AS_PRINTED for name in NAMES)
    return Reproduced(
        number=12,
        verdict="holds" if near and min(worse.values()) > 1.0 else "holds in part" if near else "does not hold",
        found=[
            f"Peak to peak {in_micrometres(peaks[BEFORE])} without and {in_micrometres(peaks[AFTER])} with the "
            f"compensator (the paper: {in_micrometres(PRINTED[BEFORE])} and {in_micrometres(PRINTED[AFTER])}), "
            f"{percent(1.0 - peaks[AFTER] / peaks[BEFORE], 1.0)} less (the paper: "
            f"{percent(1.0 - PRINTED[AFTER] / PRINTED[BEFORE], 1.0)}).",
            f"Root mean square forward over backward: {number(worse[BEFORE], digits=3)} without and "
            f"{number(worse[AFTER], digits=3)} with it.",
            _beyond(tracked),
        ],
        draw=lambda: tracking_error(tracked.pair, tracked.settle),
        origin=tracked.origin,
        numbers={"peak_to_peak": peaks, "forward_over_backward": worse},
        tables=(_by_variant(tracked), _by_direction(tracked)),
    )  # fmt: skip


def _beyond(tracked: Tracked) -> str:
    """Return what the other variants come to, in words."""
    told = [
        f"{name.replace('_', ' and ')} {in_micrometres(one.following_error.peak_to_peak)}"
        for name, one in tracked.result.variants.items()
        if name not in NAMES
    ]
    return f"Past the paper, on the same rig: {', '.join(told)}." if told else "Nothing else was run on this rig."


def _by_variant(tracked: Tracked) -> Table:
    rows = []
    for name, one in tracked.result.variants.items():
        error = one.following_error
        numbers = (error.peak_to_peak, error.mean, error.std, one.true_error.peak_to_peak)
        cells = [number(1e6 * value, resolution=0.01) for value in numbers]
        rows.append((name, *cells, number(1e3 * tracked.arm * one.effort_rms, resolution=1.0)))
    heads = ("Variant", "Peak to peak [µm]", "Mean [µm]", "Std [µm]", "True error [µm]", "Effort rms [mN·m]")
    runs = next(iter(tracked.result.variants.values())).runs
    return Table(f"Following error, mean over {runs} runs with other noise", heads, rows)


def _by_direction(tracked: Tracked) -> Table:
    rows = [
        (shown, direction, *(number(1e6 * value, resolution=0.01) for value in (e.mean, e.rms, e.peak_to_peak)))
        for shown, one in tracked.pair.items()
        for direction, e in one.by_direction.items()
    ]
    heads = ("Loop", "Reference moves", "Mean [µm]", "rms [µm]", "Peak to peak [µm]")
    return Table("Following error by direction", heads, rows)


def figure_13(tracked: Tracked) -> Reproduced:
    """Return figure 13: the distribution of the following error."""
    from bristle.figures import error_distribution

    both = {name: tracked.result.variants[name].following_error for name in NAMES}
    resolution = tracked.experiment.variants[0].sensor.values.get("resolution", 0.0)
    narrower = both[AFTER].std < both[BEFORE].std and abs(both[AFTER].mean) < abs(both[BEFORE].mean)
    return Reproduced(
        number=13,
        verdict="holds" if narrower else "does not hold",
        found=[
            f"{NAMES[name].capitalize()}: mean {in_micrometres(one.mean)}, standard deviation "
            f"{in_micrometres(one.std)}, range from {in_micrometres(one.min)} to {in_micrometres(one.max)}."
            for name, one in both.items()
        ],
        draw=lambda: error_distribution(tracked.pair, tracked.settle, resolution),
        origin=tracked.origin,
        numbers={name: asdict(one) for name, one in both.items()},
    )


def figure_14(tracked: Tracked) -> Reproduced:
    """Return figure 14: the control effort."""
    from bristle.figures import control_effort

    rms = {name: tracked.arm * tracked.result.variants[name].effort_rms for name in NAMES}
    peak = {name: tracked.arm * tracked.result.variants[name].effort_peak for name in NAMES}
    more = rms[AFTER] / rms[BEFORE] - 1.0
    return Reproduced(
        number=14,
        verdict="holds" if abs(more) < ALIKE else "does not hold",
        found=[
            f"Root mean square {_torque(rms[BEFORE])} without and {_torque(rms[AFTER])} with the compensator, "
            f"{percent(abs(more))} {'more' if more > 0.0 else 'less'}; peaks {_torque(peak[BEFORE])} and "
            f"{_torque(peak[AFTER])}.",
        ],
        draw=lambda: control_effort(
            tracked.pair, tracked.settle, tracked.turn(0.5 * CHATTER, 0.5 * CHATTER), tracked.arm, "rotational"
        ),
        origin=tracked.origin,
        numbers={"rms": rms, "peak": peak},
    )  # fmt: skip


def _torque(value: float) -> str:
    return f"{number(1e3 * value, digits=3)} mN·m"
