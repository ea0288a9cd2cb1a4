"""Thresholds of an identification.

They decide from where on bristle reports, doubts or omits a result, and change no parameter value. There are two
exceptions. The thresholds of the channels in time decide when a delay, a filter and an inertia count as known. Those of
validation may change the order of the models. Settings of a method (number of starts, seed, tolerance) are in its module.
"""

from dataclasses import dataclass

from bristle.core.values import threshold as _set
from bristle.logs.look import CheckThresholds


@dataclass(frozen=True)
class Settings(CheckThresholds):
    """The thresholds of an identification; `Settings.described` lists them with their meaning.

    Examples
    --------
    >>> Settings(unsure_std=0.3).unsure_std, Settings().unsure_std
    (0.3, 0.5)
    """

    # Parameters: when they count as identified.
    unsure_std: float = _set(0.5, "largest relative standard error of an identified parameter")
    beyond_effort: float = _set(
        1.2, "largest friction force that a log can show, as a share of its largest effort"
    )
    inseparable: float = _set(
        0.99, "correlation from which bristle reports two parameters as confounded", most=1.0
    )

    # Excitation: the smallest motion that a log can show.
    zone_noise: float = _set(
        10.0, "smallest pre-sliding zone, in standard deviations of the position noise", "σ"
    )
    zone_counts: float = _set(5.0, "smallest pre-sliding zone, in encoder steps", "steps")
    blurred_share: float = _set(
        0.05,
        "largest share of an identified stiffness in elements that slip within the smallest pre-sliding zone",
        most=1.0,
    )

    # Channels in time.
    delay_rough: float = _set(
        0.7,
        "half-width of the 95 % interval of a delay from which bristle reports the delay as uncertain",
        "samples",
    )
    delay_unsure: float = _set(
        4.0, "largest half-width of the 95 % interval of a delay that bristle removes", "samples"
    )
    inertia_unsure: float = _set(
        0.03,
        "relative half-width of the measured inertia from which each model fits the inertia separately",
        most=1.0,
    )
    stages_differ: float = _set(
        3.0,
        "largest difference between the fitted and the measured inertia, in joint standard errors",
        "σ",
    )
    stages_apart = 0.02  # the same as a share of the inertia

    # Noise and residual.
    acceleration_noise: float = _set(
        0.01,
        "share of noise in the mean square acceleration from which bristle reports this noise",
        most=1.0,
    )
    noisy_inertia = 0.05  # share of noise in the mean square acceleration above which a fit does not identify the inertia
    poor_error: float = _set(
        40.0, "error of the effort from which bristle doubts units and signs", "%"
    )
    usable_error: float = _set(
        20.0, "largest model error relative to friction for the verdict Usable", "%"
    )
    useless_error: float = _set(
        60.0, "largest model error relative to friction for the verdict Use with care", "%"
    )
    missing_force: float = _set(
        0.006, "smallest missing force that matters: its rms as a share of friction"
    )
    missing_evidence: float = _set(
        0.0016,
        "smallest reported missing force: its share of friction times its share of the residual",
    )
    # level at which such a cause must explain more than with random signs for each half-cycle; P. Kline, A. Santos, Journal of
    # Econometric Methods 1(1), 2012, doi:10.1515/2156-6674.1006
    missing_level = 0.99

    # Validation and comparison of models.
    held_out_rows: float = _set(
        20.0, "smallest held-out block, without its margins", "rows", least=2.0
    )
    same_error: float = _set(
        1e-3, "largest relative difference between held-out errors that count as equal"
    )
    lines_gain: float = _set(
        1e-3,
        "smallest relative fall of the held-out error for lines that bristle takes into the axis; 1 disables the search for forces "
        "beside friction",
        most=1.0,
    )
    doubtful_share: float = _set(
        0.5, "share of unidentified parameters from which a simpler model is preferred"
    )

    # The loop in simulation.
    loop_differs: float = _set(
        0.15,
        "largest relative difference of measured and simulated following error for a predicted gain",
    )


DEFAULT = Settings()
