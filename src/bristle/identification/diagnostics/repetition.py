"""What the motion of a log cannot tell, whatever is fitted to it: one amplitude only, and the same motion again."""

from __future__ import annotations

from itertools import permutations

import numpy as np

from bristle.core.contracts import Model
from bristle.core.diagnostic import Diagnostic
from bristle.friction import is_static
from bristle.identification.dataset import Dataset
from bristle.identification.settings import DEFAULT, Settings
from bristle.logs import repetition
from bristle.logs.repetition import by_lag
from bristle.logs.segmentation import alternating

__all__ = [
    "about_amplitudes",
    "about_repeated_logs",
    "about_repetition",
    "repeats_after",
    "spread_between_repeats",
    "stroke_lengths",
]

COMPARED = 4000  # samples of the longer of two logs
DESIGN = (1.0, 0.4, 0.7, 0.2, 1.0)  # of the amplitude: turning points that close loops inside one another


def stroke_lengths(dataset: Dataset, tremble: float = DEFAULT.tremble) -> np.ndarray:
    """Return how far the body goes between reversals [m or rad], shape (half-cycle,); a `tremble` of it is no way."""
    ways = []
    for segment, turns in zip(dataset.segments, dataset.reversals, strict=True):
        least = tremble * float(np.ptp(segment.position))
        ways.append(np.abs(np.diff(alternating(segment.position[list(turns)].tolist(), least))))
    return np.concatenate(ways)


def about_amplitudes(dataset: Dataset, friction: Model, settings: Settings) -> tuple[Diagnostic, ...]:
    """Return a warning where a model has pre-sliding and the log shows it at one amplitude only."""
    if is_static(friction):
        return ()
    ways = stroke_lengths(dataset, settings.tremble)
    if ways.size < settings.amplitude_half_cycles or np.min(ways) < settings.nested_loop * np.max(ways):
        return ()
    amplitude = float(np.median(ways))
    advised = tuple(share * amplitude for share in DESIGN)
    numbers = {"half_cycles": ways.size, "amplitude": amplitude, "advised": advised}
    return (Diagnostic("one_amplitude", numbers=numbers, kind=dataset.kind),)


def about_repetition(dataset: Dataset, settings: Settings) -> tuple[Diagnostic, ...]:
    """Return a warning where held-out blocks only repeat the motion that was fitted."""
    period = repeats_after(dataset, settings)
    return () if period is None else (Diagnostic("motion_repeats", numbers={"period": period}),)


def repeats_after(dataset: Dataset, settings: Settings = DEFAULT) -> float | None:
    """Return the period of a motion that repeats itself [s]; None where it does not."""
    position = max((segment.position for segment in dataset.segments), key=len)
    return repetition.repeats_after(position, dataset.sample_time, settings)


def spread_between_repeats(dataset: Dataset, settings: Settings = DEFAULT) -> float:
    """Return by how much the effort of one repeat differs from the next [% of it]; 0 where no motion repeats itself."""
    period = repeats_after(dataset, settings)
    if period is None:
        return 0.0
    effort = max((segment.effort for segment in dataset.segments), key=len)
    size, later = float(np.sqrt(np.mean(effort**2))), round(period / dataset.sample_time)
    return 100.0 * float(np.sqrt(np.mean((effort[later:] - effort[:-later]) ** 2))) / size if size > 0.0 else 0.0


def about_repeated_logs(dataset: Dataset, settings: Settings) -> tuple[Diagnostic, ...]:
    """Return a warning where logs that were held out only repeat the motion of others that were fitted."""
    motions: dict[int, np.ndarray] = {}
    for segment in sorted(dataset.segments, key=lambda segment: -segment.position.size):
        motions.setdefault(segment.log, segment.position)
    step = max(max(x.size for x in motions.values()) // COMPARED, 1)
    thinned = {log: x[::step] - np.mean(x) for log, x in motions.items()}
    repeated = {log for log, second in permutations(thinned, 2) if _repeats(thinned[log], thinned[second], settings)}
    if not repeated:
        return ()
    return (Diagnostic("logs_repeat", numbers={"repeated": len(repeated), "logs": len(motions)}),)


def _repeats(x: np.ndarray, y: np.ndarray, settings: Settings) -> bool:
    """Return whether two motions, each about its mean, are the same, one of them shifted in time."""
    shared, product, xx, yy = by_lag(x, y)
    long = (shared >= settings.repeated_overlap * min(x.size, y.size)) & (xx > 0.0) & (yy > 0.0)
    alike = long & (product >= settings.repeated * np.sqrt(xx * yy))
    most = settings.repeated_size**2
    return bool(np.any(alike & (xx <= most * yy) & (yy <= most * xx)))
