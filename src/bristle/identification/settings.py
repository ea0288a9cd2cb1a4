"""Thresholds of an identification: from where on something is said, doubted or left out.

None of them changes the value of a parameter of a model, but those of the channels in time, which say when a delay, a
filter and an inertia are known; those of validation may change which model comes first. What methods need to work
(numbers of starts, seeds, tolerances) stands with the methods.
"""

from dataclasses import dataclass

from bristle.core.values import threshold as _set
from bristle.logs.look import CheckThresholds


@dataclass(frozen=True)
class Settings(CheckThresholds):
    """The thresholds; `Settings.described` tells what each of them is.

    Examples
    --------
    >>> Settings(unsure_std=0.3).unsure_std, Settings().unsure_std
    (0.3, 0.5)
    """

    # Told so to a person who sets them still.
    fixed = frozenset(
        (
            *("hopeless_std", "delay_inertia", "filter_seen", "nested_loop", "amplitude_half_cycles", "tremble"),
            *("repeated", "repeated_periods", "repeated_size", "repeated_overlap", "moved", "flat_rise", "follows", "at_odds", "seen_rise"),
            *("white_lags", "white_level", "unfinished_error", "kept_work", "spring_likeness", "one_way", "steady_share"),
            *("steps_of_motion", "clipped_samples", "soft_limit", "lost_step", "velocity_scale", "velocity_likeness"),
            *("missing_share", "missing_share_around", "missing_effort", "missing_slow_share", "missing_slow_force", "missing_flanks"),
            *("missing_slow_share_around", "missing_slow_force_around", "missing_sought_force", "reversal_error", "reversal_periods"),
            *("reversal_share", "reversal_excess", "reversal_lag"),
            *("velocity_delay", "mass_error", "inertia_share", "gear_near", "shortest_sample", "longest_sample"),
        )
    )

    # Parameters: which of them count as identified.
    unsure_std: float = _set(0.5, "relative standard error above which a parameter counts as not identified")
    beyond_effort: float = _set(1.2, "share of the largest effort beyond which a friction force counts as one that never acted")
    inseparable: float = _set(0.99, "correlation above which two parameters are told to be hardly separable", most=1.0)

    # Excitation: what a log shows at all.
    zone_noise: float = _set(10.0, "standard deviations of the noise of the position that a pre-sliding zone must exceed", "σ")
    zone_counts: float = _set(5.0, "encoder steps that a pre-sliding zone must exceed", "steps")
    blurred_share: float = _set(0.05, "share of the stiffness of elements within so many steps, from which it is not identified", most=1.0)

    # Channels in time.
    delay_rough: float = _set(0.7, "half-width of the 95 % interval of a delay beyond which it is told as unknown", "samples")
    delay_unsure: float = _set(4.0, "half-width of a delay up to which it is taken out", "samples")
    inertia_unsure: float = _set(0.03, "half-width of the inertia, as a share, beyond which each model has its own", most=1.0)
    stages_differ: float = _set(3.0, "joint standard errors by which the rows of a fit may want another inertia", "σ")
    stages_apart = 0.02  # share of the inertia by which the rows of a fit may want another one

    # Noise and residual.
    acceleration_noise: float = _set(0.01, "share of noise in the mean square acceleration from which it is told", most=1.0)
    noisy_inertia = 0.05  # share of noise in the mean square acceleration beyond which a fit does not tell the inertia
    poor_error: float = _set(40.0, "error of the effort from which units and signs are doubted", "%")
    usable_error: float = _set(20.0, "error of a model, of what friction takes, above which it is used with care", "%")
    useless_error: float = _set(60.0, "error of a model, of what friction takes, above which it is not used", "%")
    missing_force: float = _set(0.006, "share of the friction force, root mean square, below which a missing force is too small to matter")
    missing_evidence: float = _set(0.0016, "share of friction of a missing force, times the share that it tells of what is left over")
    # level at which such a cause must take more than with signs drawn by chance for each half-cycle; P. Kline, A. Santos, Journal of
    # Econometric Methods 1(1), 2012, doi:10.1515/2156-6674.1006
    missing_level = 0.99

    # Validation and comparison of models.
    held_out_rows: float = _set(20.0, "rows that a held-out block has at least, its margins apart", "rows", least=2.0)
    same_error: float = _set(1e-3, "relative difference of held-out errors that is none")
    doubtful_share: float = _set(0.5, "share of parameters not identified from which a model gives way to simpler ones")

    # The loop in simulation.
    loop_differs: float = _set(0.15, "relative difference of measured and simulated following error from which no gain is promised")


DEFAULT = Settings()
