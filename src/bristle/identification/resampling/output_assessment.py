"""How sure a fit to a simulated signal is: intervals from twins of the log, and a cross-check."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from bristle.friction import is_static
from bristle.identification.output_error import OutputError
from bristle.identification.prediction_interval import Bands, half_width
from bristle.identification.resampling.assessment import at_odds, how_sure, with_interval
from bristle.identification.resampling.bootstrap import fitted_to_twins, seen_in
from bristle.identification.resampling.half_cycles import within_cycles
from bristle.identification.resampling.jackknife import jackknife_std
from bristle.identification.resampling.output_replicate import SignalReplicates, level_slope_of, moves_of
from bristle.identification.resampling.refit import Refit, Space
from bristle.identification.resampling.replicate import disturbance_of, lasting_of
from bristle.identification.resampling.whiteness import is_white
from bristle.identification.result import Fit, Resampling
from bristle.identification.settings import Settings

__all__ = ["assessed_output"]

CODES = {"closed": "intervals-loop", "open": "intervals-motion"}


def assessed_output(
    fit: Fit, error: OutputError, space: Space, draws: int, settings: Settings,
    report: Callable[[float], None] = lambda share: None,
) -> Fit:  # fmt: skip
    """Return a fit to a simulated signal with what resampling says of it.

    Parameters
    ----------
    fit : Fit
        The fit.
    error, space : OutputError, Space
        What was fitted, and the coordinates of the solution. Of friction without pre-sliding, and in open loop, a fit
        to a twin is taken for linear around it.
    draws : int
        Number of twins.
    settings : Settings
        The thresholds.
    report : callable
        Is told the share of the work done.
    """
    values = error.parameters.complete(space.values(space.theta))
    residual, groups = error.measured - error.simulated(values), moves_of(error)
    slope, dataset = level_slope_of(error, values), error.inverse.dataset
    disturbance = disturbance_of(dataset, seen_in(groups, slope, residual))
    twin = SignalReplicates(error, values, groups, disturbance, slope, residual)
    every, linear = np.ones(len(space.names), dtype=bool), error.loop == "open" or is_static(fit.friction)
    found = fitted_to_twins(
        twin, Refit(replace(space, linear=linear), every, slice(None)), slope, residual, draws, report=report
    )
    own = {name: one for name, one in found.members[0].items() if name not in error.parameters.loop}
    left = within_cycles(groups, slope, residual) if found.scatter.value > 0.0 else residual
    lacking = found.unexplained if error.loop == "closed" else 0.0
    bands = Bands(
        draws={name: np.array([one[name] for one in found.members]) for name in own}, scatter=found.scatter.value,
        noise=dataset.effort_noise, unexplained=lacking,
        lasting=lasting_of(left, dataset.sample_time, lacking),
    )  # fmt: skip
    width = half_width(bands, fit.plant, fit.friction, dataset)
    share = float(np.quantile(np.abs(fit.traces.residual) / width, 0.95))
    resampling = Resampling(
        bands=replace(bands, inflation=max(share, 1.0)),
        scatter=found.scatter,
        half_cycles=groups.count,
        resolution=found.disturbance.resolution,
        white=is_white(residual, settings),
        jackknife=jackknife_std(space, groups, residual),
    )
    variables = error.parameters.variables
    estimates = tuple(with_interval(one, found, variables.get(one.name)) for one in fit.estimates)
    return replace(
        fit, estimates=estimates, resampling=resampling,
        diagnostics=(
            *fit.diagnostics,
            *at_odds(estimates, found, resampling.jackknife, settings),
            how_sure(CODES[error.loop], fit, resampling, found.unexplained),
        ),
    )  # fmt: skip
