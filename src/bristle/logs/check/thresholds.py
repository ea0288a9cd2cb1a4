"""From where on a check of a log says something."""

from __future__ import annotations

from dataclasses import dataclass

from bristle.core.values import Thresholds, threshold

__all__ = ["DEFAULT", "CheckThresholds"]


@dataclass(frozen=True)
class CheckThresholds(Thresholds):
    """The thresholds of the checks before a fit; `bristle.core.values.thresholds` tells what each of them is."""

    # A log by itself, before anything is fitted.
    reversed_work: float = threshold(
        0.1, "share of the work over closed motion, taken as put in, from which the sign of the effort is doubted", most=1.0
    )
    kept_work: float = threshold(
        0.3, "share of the work over closed motion that stays in the axis below which it may be a spring", most=1.0
    )
    spring_likeness: float = threshold(0.6, "correlation of effort and position from which an effort is that of a spring", most=1.0)
    one_way: float = threshold(0.03, "share of the way that goes in the lesser direction below which a log has one", most=0.5)
    one_speed: float = threshold(1.3, "ratio of the 90 % to the 10 % quantile of the speed below which a log has one", least=1.0)
    steady_share: float = threshold(0.35, "share of the way at steady speeds from which one speed is told", most=1.0)
    steps_of_motion: float = threshold(
        10.0, "encoder steps of a way between two reversals below which a motion is below the resolution", "steps"
    )
    repeated: float = threshold(0.98, "correlation from which two motions are the same", most=1.0)
    repeated_periods: float = threshold(3.0, "periods in a log from which it repeats itself", "periods", least=2.0)
    clipped_samples: float = threshold(10.0, "samples in a row at an extreme from which an effort is clipped", "samples")
    soft_limit: float = threshold(0.2, "share by which the largest effort reads too little from which a channel bends over")
    lost_step: float = threshold(8.0, "times what the steps around it scatter by that a step of the position must stand out to be a loss")
    velocity_scale: float = threshold(0.05, "relative deviation of a recorded velocity from that of the position")
    velocity_likeness: float = threshold(
        0.8, "correlation with the velocity of the position below which a recorded one is another signal", most=1.0
    )
    velocity_delay: float = threshold(0.005, "time between a recorded velocity and that of the position from which it is told", "s")
    mass_ratio: float = threshold(
        1.15, "ratio of the known mass or inertia to the one that the log shows from which they contradict", least=1.0
    )
    mass_error: float = threshold(0.05, "relative standard error of the mass that the log shows up to which it is compared", most=1.0)
    inertia_share: float = threshold(0.06, "share of the scatter of the effort that inertia must have for a mass to be compared", most=1.0)
    gear_near: float = threshold(0.06, "relative deviation from 2, pi, 60 and the like that is a gear", most=0.2)
    fastest: float = threshold(20.0, "speed of a linear axis above which the unit of the position is doubted", "m/s")
    fastest_turning: float = threshold(2500.0, "speed of a rotary axis above which the unit of the position is doubted", "rad/s")
    shortest_sample: float = threshold(1e-5, "time between samples below which the unit of time is doubted", "s")
    longest_sample: float = threshold(0.5, "time between samples above which the unit of time is doubted", "s")
    level_drift: float = threshold(0.1, "share of the level of friction by which it must change over time, or over the range, to be told")
    sure: float = threshold(5.0, "standard errors by which what a line through the log shows must differ from none", "σ")


DEFAULT = CheckThresholds()
