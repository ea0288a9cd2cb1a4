r"""From a log to friction models with their uncertainty, by inverse dynamics.

.. math:: u = M \ddot q + F(\dot q, \dots) + \text{offset}

holds in every row of a regression; the parameters minimise the sum of squares of what is left over. No simulation is
involved, and the controller that was running does not matter.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from os import PathLike
from typing import Any

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import FrictionModel
from bristle.core.cores import cores_for_simulations
from bristle.core.edge import FLAG, NAMES, PROGRESS, among, guarded, instance, optional, whole
from bristle.core.errors import InputError
from bristle.core.interruption import obey
from bristle.identification.break_away import break_aways
from bristle.identification.dataset import Dataset
from bristle.identification.held_out import TOO_SHORT, blocks_for
from bristle.identification.information_criteria import with_information
from bristle.identification.inputs import logs_and_axes, treatment_of
from bristle.identification.merging import treat_all
from bristle.identification.output_error import one_period, simulated_loop
from bristle.identification.ranking import in_order
from bristle.identification.request import (
    METHODS,
    PriorKnowledge,
    as_asked,
    freed,
    prior_knowledge_of,
    models_of,
    settings_of,
)
from bristle.identification.result import Fit, Identification
from bristle.identification.search import Report
from bristle.identification.settings import Settings
from bristle.identification.workbench import Simulated, Workbench
from bristle.logs.log import Log

__all__ = ["identify"]

FEWEST_DRAWS, MOST_DRAWS = 20, 100_000

Progress = Callable[[float, str], None]


@guarded(
    blocks=optional(whole(2, 10_000, none=True)), free=NAMES, draws=whole(FEWEST_DRAWS, MOST_DRAWS, none=True),
    method=optional(among(*METHODS)), global_search=optional(FLAG),
    settings=optional(instance((Settings, Mapping), "a dictionary of thresholds")), progress=PROGRESS,
)  # fmt: skip
@cores_for_simulations()
def identify(
    log: Log | str | PathLike[str] | Sequence[Log | str | PathLike[str]], model: Any = "coulomb_viscous", *,
    axis: Axis | str | PathLike[str] | Sequence[Axis | str | PathLike[str]] | None = None,
    cutoff: float | str | None = None, decimation: int | None = None, blocks: int | None = None,
    offset: float | str | None = None, mass: float | str | None = None, free: str | Sequence[str] = (),
    draws: int = 100, method: str | None = None, global_search: bool | None = None,
    settings: Settings | Mapping[str, float] | None = None, progress: Progress | None = None,
) -> Identification:  # fmt: skip
    """Identify one friction model or several from a log, with the inertia, and rank them.

    Parameters
    ----------
    log : Log or path-like, or list of either
        Position and effort, or the file that holds them. Of several logs, each is held out in turn.
    model : str, FrictionModel, or list of either
        ``"lugre"``, ``"coulomb_viscous,stribeck+asymmetry"``, a model of your own; ``"all"`` for every one of bristle.
    axis : Axis or path-like, or list of either, optional
        One for all logs, or one for each. What is known, or the file that says it: mass, offset, encoder resolution,
        cut-off and decimation.
    cutoff : float or str, optional
        Cut-off of the zero-phase filter [Hz], or text such as ``"100 Hz"``; a tenth of the sampling frequency by
        default.
    decimation : int, optional
        Of how many samples one row is kept; 10 by default.
    blocks : int, optional
        Time blocks, each held out in turn, by whose error models are ranked; 0 for none. Five, or as many as a short
        log has room for, where not given.
    offset : float, str or "identify", optional
        Constant part of the force [N or N*m] if known, or text with a unit; the axis decides where it is not given.
    mass : float or str, optional
        Moving mass [kg] or inertia [kg*m^2] if known, or text with a unit; the axis decides where it is not given.
    free : str or sequence of str
        Shapes that are identified too, instead of being kept at their default: ``"exponent"`` of the Dahl model;
        several separated by commas.
    draws : int
        Logs that are simulated with the best model and fitted again, for its 95 % intervals; 0 for none.
    method : {"inverse_dynamics", "output_error"}, optional
        What is made small: the error of the effort along the measured motion, or that of a simulation; the axis decides
        where it is not given.
    global_search : bool, optional
        Whether the whole range of each parameter is looked at, where a search is needed at all; the axis decides where
        it is not given.
    settings : Settings or mapping of str to float, optional
        Thresholds from where on something is said or doubted, by name; those that are not given are as the axis says,
        or at their defaults.
    progress : callable, optional
        Called with the share of the work done and what is being done.

    Returns
    -------
    Identification
        The models, best first.

    Raises
    ------
    InputError
        If the log or the axis does not serve, or there is no such model.

    References
    ----------
    .. [1] A. Janot, P.-O. Vandanjon, M. Gautier, "A generic instrumental variable approach for industrial robot
       identification", IEEE Transactions on Control Systems Technology 22(1), 2014. doi:10.1109/TCST.2013.2246163
    """
    given = as_asked(logs_and_axes(log, axis), method, global_search)
    chosen = settings_of(given[0][1], settings)
    logs, axes = [log for log, _ in given], [axis for _, axis in given]
    components = models_of(model)
    _refuse_without_effort(logs)
    kind = logs[0].kind
    known = replace(prior_knowledge_of(axes[0], mass, offset, kind), free=freed(free, components))
    workbench = replace(_workbench(given, known, *treatment_of(cutoff, decimation, kind)), settings=chosen)
    dataset, held_out = workbench.dataset, blocks_for(workbench.dataset, blocks, chosen)
    count = len(components) + bool(draws)
    fits, left_out = _fits(workbench, components, held_out, partial(_share, progress, count))
    first, *others = (replace(fit, rank=rank) for rank, fit in enumerate(with_information(in_order(fits, chosen)), 1))
    if blocks is None and not held_out:
        first = replace(first, diagnostics=(TOO_SHORT, *first.diagnostics))
    unfinished = _unfinished(fits, [one.name for one in components if one.name not in left_out])
    if draws and not unfinished:
        report = _share(progress, count, len(components), f"fitting {first.name} to simulated logs")
        first, unfinished = _assessed(workbench, first, draws, report)
    treatment, away = _treatment(dataset, first), break_aways(dataset, first.plant, first.friction)
    return Identification((first, *others), logs[0], treatment, tuple(logs[1:]), unfinished, away, left_out, chosen)


def _workbench(
    given: Sequence[tuple[Log, Axis | None]], known: PriorKnowledge, cutoff: float | None, decimation: int | None
) -> Workbench:
    """Return what the fits of all models to some logs share."""
    logs, axes = [log for log, _ in given], [axis for _, axis in given]
    simulated = _simulated(logs, axes)
    opened = simulated is not None and simulated.loop == "open"
    treated = [one_period(log, axis) for log, axis in given] if opened else logs
    everywhere = any(axis is not None and axis.global_search for axis in axes)
    return Workbench.of(treat_all(treated, axes, cutoff, decimation), known, simulated, everywhere=everywhere)


def _simulated(logs: Sequence[Log], axes: Sequence[Axis | None]) -> Simulated | None:
    """Return what is simulated to be compared with the logs; None where nothing is."""
    if not any(axis is not None and axis.method == "output_error" for axis in axes):
        return None
    return Simulated(logs, axes, simulated_loop(logs, axes))


def _assessed(workbench: Workbench, fit: Fit, draws: int, report: Report) -> tuple[Fit, str]:
    """Return a fit with its intervals, and what was interrupted, in words."""
    try:
        return workbench.assessed(fit, draws, report), ""
    except KeyboardInterrupt as error:
        obey(error)
        return fit, "interrupted: the intervals are not those of simulated logs"


def _fits(
    workbench: Workbench, components: Sequence[FrictionModel], blocks: int, share: Callable[[int, str], Report]
) -> tuple[list[Fit], dict[str, str]]:
    """Return the fits of several models, as many as a person waits for, and why others cannot be compared."""
    fits: list[Fit] = []
    left_out: dict[str, InputError] = {}
    for number, component in enumerate(components):
        try:
            fits.append(workbench.fit(component, blocks, share(number, f"fitting {component.name}")))
        except InputError as error:
            if error.path != "model":
                raise
            left_out[component.name] = error
        except KeyboardInterrupt as error:
            obey(error, anything=bool(fits))
            break
        if fits and fits[-1].unfinished:
            break
    if left_out and not fits:
        raise next(iter(left_out.values()))
    return fits, {name: error.message for name, error in left_out.items()}


def _treatment(dataset: Dataset, best: Fit) -> dict[str, float]:
    found = {
        "cutoff": dataset.cutoff,
        "decimation": float(dataset.decimation),
        "dropped": float(dataset.dropped),
        "rows": float(dataset.effort.size),
        "rest_percent": 100.0 * dataset.rest_share,
        "velocity_max": float(np.max(np.abs(dataset.velocity))),
    }
    found |= {"delay": dataset.delay} if dataset.delay else {}
    return found | ({"lag": best.lag} if best.lag is not None else {})


def _refuse_without_effort(logs: Sequence[Log]) -> None:
    for one in logs:
        if one.effort is None:
            raise InputError("has no effort, which inverse dynamics needs", path=f"log {one.source.name}".strip(),
                             mend="Name the column of force, torque or current in the axis file")  # fmt: skip


def _unfinished(fits: Sequence[Fit], asked: Sequence[str]) -> str:
    """Return what was interrupted, in words; nothing where all was done."""
    missing = asked[len(fits) :]
    said = [f"{fit.name} is the best found until then" for fit in fits if fit.unfinished]
    said += [f"{', '.join(missing)} {'was' if len(missing) == 1 else 'were'} not fitted"] if missing else []
    return f"interrupted: {'; '.join(said)}" if said else ""


def _share(progress: Progress | None, count: int, number: int, what: str) -> Report:
    def report(share: float, remark: str = "") -> None:
        if progress is not None:
            progress((number + share) / count, f"{what}{remark and f', {remark}'}")

    return report
