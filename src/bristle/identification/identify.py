"""From a log to friction models with their uncertainty, best first."""

from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import replace
from functools import partial
from operator import attrgetter
from os import PathLike
from typing import Any

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import FrictionModel
from bristle.core.cores import cores_for_simulations
from bristle.core.diagnostic import to_the_end
from bristle.core.edge import NAMES, Progress, among, between, guarded, instance, optional, whole
from bristle.core.errors import InputError
from bristle.files.arguments import logs_and_axes
from bristle.identification import request
from bristle.identification.axis_lines import about_lines, with_lines
from bristle.identification.dataset import Alignment, Dataset
from bristle.identification.elasticity import Elastic, elastic_coupling
from bristle.identification.estimation import (
    Context,
    along_the_motion,
    context_of,
    with_harmonics,
    with_harmonics_of,
)
from bristle.identification.excitation import about_logs, checks_of, with_checks
from bristle.identification.first_stage import alignment_of
from bristle.identification.fits import Collected, all_fits, ranked
from bristle.identification.found_terms import (
    Beside,
    Terms,
    about_terms,
    terms_of,
    with_explained,
    with_split,
)
from bristle.identification.half_cycles import blocks_for
from bristle.identification.intervals import WITHOUT_DRAWS, Passed, durations_of, with_intervals
from bristle.identification.least_squares import Report, silent
from bristle.identification.one_encoder import with_masses
from bristle.identification.output_error import Simulation, loop_of
from bristle.identification.parameters import PriorKnowledge, Role, names_of, offset_of
from bristle.identification.position_loop import stiffness_in
from bristle.identification.preprocessing import (
    CUTOFF_SHARE,
    aligned,
    calmed,
    long_enough,
    treat_all,
)
from bristle.identification.result import Fit, Identification, SecondPass
from bristle.identification.settings import Settings
from bristle.identification.structure import with_structure
from bristle.identification.term_search import WARM_UP
from bristle.identification.two_masses import apart, with_masses_of, with_two_masses
from bristle.identification.validation import TOO_SHORT
from bristle.identification.work import Work
from bristle.logs.check import parted
from bristle.logs.log import Log
from bristle.models.friction import DEFAULT_MODELS, find

FEWEST_DRAWS, MOST_DRAWS = 20, 100_000
WITHOUT_LOAD = "interrupted: the friction of motor and load is missing"
TELLS_CHANNEL = "lugre"
OF_LEVEL = ("level_drifts", "level_over_position")
HIGHEST = 100.0  # [Hz]: frequencies in which terms are sought, at most
FEWEST_PERIODS = 40.0  # of the lowest cut-off of an elastic axis in the log
ALONE = 0.4  # share of the work for one mass of a log with two encoders


@guarded(
    blocks=optional(whole(2, 10_000, none=True)),
    free=NAMES,
    draws=whole(FEWEST_DRAWS, MOST_DRAWS, none=True),
    method=optional(among(*request.METHODS)),
    settings=optional(instance((Settings, Mapping), "a dictionary of thresholds")),
)
@cores_for_simulations()
def identify(
    log: Log | str | PathLike[str] | Sequence[Log | str | PathLike[str]],
    model: Any = DEFAULT_MODELS,
    *,
    axis: Axis | str | PathLike[str] | Sequence[Axis | str | PathLike[str]] | None = None,
    cutoff: float | str | None = None,
    decimation: int | None = None,
    blocks: int | None = None,
    offset: float | str | None = None,
    mass: float | str | None = None,
    free: str | Sequence[str] = (),
    draws: int = 100,
    method: str | None = None,
    settings: Settings | Mapping[str, float] | None = None,
    progress: Progress | None = None,
    answer: Callable[[Identification], None] | None = None,
) -> Identification:
    """Identify one friction model or several from a log, with the inertia, and rank them.

    Parameters
    ----------
    log : Log, path-like, or table of columns; or list of these
        Position and effort, or a file with them. A data frame or a dictionary of arrays has columns ``time``,
        ``position`` and ``effort``, and optionally ``velocity`` and ``reference``, in SI. It needs no axis. Several
        logs count as one experiment.
    model : str, FrictionModel, or list of either
        ``"lugre"``, ``"lugre,maxwell_slip+asymmetry"``, or your model; ``"all"`` for every model of bristle with
        useful slots.
    axis : Axis or path-like, or list of either, optional
        A single axis for all logs, or an axis for each log: an axis or its file, with known mass, offset, encoder
        resolution, cut-off and decimation.
    cutoff : float or str, optional
        Cut-off of the zero-phase filter [Hz], or text such as ``"100 Hz"``; a tenth of the sampling frequency by
        default.
    decimation : int, optional
        Number of samples per row; 10 by default, more if position noise would hide friction.
    blocks : int, optional
        Number of time blocks of each log. bristle holds out each block in turn, and ranks models by the held-out error; 0
        disables this validation. The default is 5, fewer for a short log.
    offset : float, str or "identify", optional
        Constant part of the force [N or N*m] if known, or text with a unit; by default the value of the axis.
    mass : float or str, optional
        Moving mass [kg] or inertia [kg*m^2] if known, or text with a unit; by default the value of the axis.
    free : str or sequence of str
        Shape parameters to identify instead of keeping their default, such as ``"exponent"`` of the Dahl model;
        separate several by commas.
    draws : int
        Number of logs simulated with the best model and fitted again, for its 95 % intervals; 0 disables them.
    method : {"prediction_error", "inverse_dynamics", "output_error"}, optional
        The error that is minimised. ``"inverse_dynamics"``: error of the effort along the measured motion.
        ``"prediction_error"``: first ``"inverse_dynamics"``; then, for the best model with pre-sliding and if `draws` is
        not 0, the error of the position predicted by an observer. ``"output_error"``: error of a simulation. The default
        is the method of the axis.
    settings : Settings or mapping of str to float, optional
        Thresholds of diagnostics, by name; by default the thresholds of the axis, else the default values.
    progress : callable, optional
        Called with the passed share of the whole time, 0 while the remaining time is unknown, and the current task. If it
        raises `KeyboardInterrupt`, as after a time limit of yours, `identify` returns the models fitted so far.
    answer : callable, optional
        Of several models, called with the first one as soon as it is fitted, without the intervals from simulated logs. A
        linear regression chooses which model is fitted first.

    Returns
    -------
    Identification
        The models, best first; ``bristle.identify`` returns an `Identified`, which also predicts and can be saved.

    Raises
    ------
    InputError
        If the log, the axis or the model is invalid.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(4000) * 1e-3
    >>> position = 0.02 * np.sin(3.0 * t) + 0.01 * np.sin(11.0 * t)
    >>> velocity = 0.06 * np.cos(3.0 * t) + 0.11 * np.cos(11.0 * t)
    >>> effort = 12.0 * np.gradient(velocity, t) + 5.0 * np.sign(velocity) + 80.0 * velocity
    >>> best = identify({"time": t, "position": position, "effort": effort}, draws=0).best
    >>> best.parameters["M"].status, round(best.parameters["M"].value, 1), best.parameters["M"].unit
    ('identified', 12.0, 'kg')
    """
    request.refuse_without_draws(method, draws)
    recorded = logs_and_axes(log, axis)
    treated = request.treatment_of(cutoff, decimation, recorded[0][0].kind)
    pairs, of_load = apart(request.with_method(long_enough(recorded, *treated), method))
    total, progress = progress, between(progress, 0.0, ALONE) if progress and of_load else progress
    chosen = request.settings_of(pairs[0][1], settings)
    transmits = all(
        axis is not None and (axis.gravity or axis.spring or axis.regressors) for _, axis in pairs
    )
    components, extended = (
        request.models_of(model, transmits=transmits),
        request.asks_for_all(model),
    )
    for entry, _ in pairs:
        if entry.effort is None:
            mend = "Name the column of force, torque or current in an axis file: bristle log LOG --write AXIS.toml proposes one"
            raise InputError(
                "has no effort, which inverse dynamics needs",
                path=f"log {entry.source.name}".strip(),
                mend=mend,
            )
    (first_log, _), kind = pairs[0], pairs[0][0].kind
    shapes = request.freed(free, components)

    def prior_of(axis: Axis | None) -> PriorKnowledge:
        return replace(request.prior_knowledge_of(axis, mass, offset, kind), free=shapes)

    work = Work(progress or silent)
    parts = [(parted(log, axis), axis) for log, axis in pairs]
    coupling = with_masses(elastic_coupling(*map(list, zip(*parts, strict=True))), parts)
    terms, second = None, None
    if chosen.lines_gain < 1.0 and not _simulates(pairs):
        work.task("explaining the log")(0.0)
        terms, second = _terms_in(parts, coupling, components, chosen.lines_gain)
    if second is not None:
        pairs = with_lines(pairs, second)

    def tell(best: Passed) -> None:
        work.after_fits = bool(draws) * sum(durations_of(best, draws, pairs))
        if answer is not None and len(best.estimations) == 1:
            answer(_result(best._replace(fits=best.judged(())), first_log, chosen))

    better = _passed(
        pairs,
        components=components,
        extended=extended,
        blocks=blocks,
        settings=chosen,
        prior_of=prior_of,
        treatment=treated,
        work=work,
        coupling=coupling,
        terms=terms,
        second=second,
        after_best=tell,
    )
    unfinished = better.unfinished or WITHOUT_DRAWS * (better.interrupted and bool(draws))
    if draws and not unfinished:
        better, unfinished = with_intervals(better, draws, chosen, pairs, work)
    result = _result(better, first_log, chosen, unfinished, second)
    if not of_load:
        return with_masses_of(result, pairs, coupling)
    if unfinished:
        return result

    def of_side(*logs: Any, **options: Any) -> Identification:
        return identify(
            *logs, model=model, free=free, draws=draws, settings=settings, **options
        ).finished

    try:
        return with_two_masses(result, of_load, of_side, total, coupling)
    except KeyboardInterrupt:
        return replace(result, unfinished=WITHOUT_LOAD)


def _simulates(pairs: Sequence[tuple[Log, Axis | None]]) -> bool:
    """Return whether the error of a simulation is minimised."""
    return any(axis is not None and axis.method == "output_error" for _, axis in pairs)


def _terms_in(
    pairs: Sequence[tuple[Log, Axis | None]],
    coupling: Elastic | None,
    components: Sequence[FrictionModel],
    gain: float,
) -> tuple[Terms | None, SecondPass | None]:
    """Return the terms that logs show beside friction, and the lines of the axis for them."""
    highest = HIGHEST if coupling is None else min(HIGHEST, coupling.one_mass)
    terms = terms_of(pairs, highest, components)
    if terms is None or not terms.lines:
        return terms, None
    if terms.error_with >= (1.0 - gain) * terms.error_without:
        return None, None
    return terms, SecondPass(terms.lines, terms.error_without, terms.error_with, taken=True)


def _result(
    passed: Passed,
    log: Log,
    settings: Settings,
    unfinished: str = "",
    second: SecondPass | None = None,
) -> Identification:
    """Return the identification of a pass over a log, and over further logs."""
    best, *rest = passed.fits
    dataset = passed.context.dataset
    if passed.context.beside is not None:
        best = with_split(best, passed.context.beside)
    treatment = {
        "cutoff": dataset.cutoff,
        "decimation": float(dataset.decimation),
        "dropped": float(dataset.dropped),
        "rows": float(dataset.effort.size),
        "rest_percent": 100.0 * dataset.rest_share,
        "velocity_max": float(np.max(np.abs(dataset.velocity))),
        **(dataset.alignment.as_data() if dataset.alignment else {}),
        **({"lag": best.lag} if best.lag is not None else {}),
        **_stiffness_of([entry for entry, _ in passed.pairs]),
        **(passed.context.coupling.facts if passed.context.coupling is not None else {}),
    }
    broken = dataset.break_aways(
        best.plant, offset_of(best.friction.component.variables, best.friction.values)
    )
    logs = tuple(further for further, _ in passed.pairs[1:])
    beside = passed.context.beside
    return Identification(
        (best, *rest),
        log,
        treatment,
        logs,
        unfinished,
        broken,
        passed.left_out,
        settings,
        second,
        explanation=beside.terms.explanation if beside else None,
    )


def _stiffness_of(logs: Sequence[Log]) -> dict[str, float]:
    """Return the stiffness of the position loop for the treatment, from the log that shows it best; empty if no log shows it."""
    stiffness = min(
        filter(None, map(stiffness_in, logs)),
        key=lambda entry: entry.half_width / entry.value,
        default=None,
    )
    return (
        {}
        if stiffness is None
        else {"stiffness": stiffness.value, "stiffness_half_width": stiffness.half_width}
    )


def _passed(
    pairs: Sequence[tuple[Log, Axis | None]],
    *,
    components: Sequence[FrictionModel],
    extended: bool,  # by slots
    blocks: int | None,
    settings: Settings,
    prior_of: Callable[[Axis | None], PriorKnowledge],
    treatment: tuple[float | None, int | None],  # cut-off and decimation
    work: Work,
    coupling: Elastic | None,
    terms: Terms | None,
    second: SecondPass | None,
    after_best: Callable[[Passed], None] | None = None,
) -> Passed:
    """Return the fits of all models, with the lines that their axes got.

    `after_best` receives each fit that is the best so far of several, not yet judged.
    """
    prior = prior_of(pairs[0][1])
    of_logs, pairs = (
        checks_of(pairs, prior, settings),
        [(parted(log, axis), axis) for log, axis in pairs],
    )
    if terms is not None:
        # The explanation tells changes of the level better than a check of the log.
        drifts = ("level_drifts",) if WARM_UP in terms.forces else ()
        of_logs = [entry for entry in of_logs if entry.code not in OF_LEVEL or entry.code in drifts]
    context = _context(pairs, prior, settings, work, coupling, terms, *treatment)
    held_out = blocks_for(context.dataset, blocks, settings)
    short, names = blocks is None and not held_out, [log.source.name for log, _ in pairs]
    collected = Collected([component.name for component in components])

    def checked(fitted: Sequence[Fit]) -> list[Fit]:
        best, *rest = (
            with_checks(fit, (*about_logs(fit, context.dataset, names, settings), *of_logs))
            for fit in ranked(fitted, context)
        )
        names_of_rest = [fit.name for fit in rest]
        best = with_structure(
            best, collected.estimations[best.name], settings, names_of_rest, context.coupling
        )
        if context.beside is not None:
            about = about_terms(best, context.beside, names_of_rest)
            best = replace(best, diagnostics=(*best.diagnostics, *about))
        if second is not None and pairs[0][1] is not None:
            about = about_lines(second, pairs[0][1])
            best = replace(best, diagnostics=(*best.diagnostics, about))
        return [replace(best, diagnostics=(TOO_SHORT, *best.diagnostics)) if short else best, *rest]

    def judged(omitted: Container[str] = ()) -> list[Fit]:
        return checked([fit for fit in collected.fits if fit.name not in omitted])

    def tell(fit: Fit) -> None:
        if after_best is not None:
            after_best(Passed([fit], collected.estimations, {}, "", False, context, pairs, judged))

    unfinished = all_fits(context, components, extended, held_out, work, collected, tell)
    # A second interruption ends the work.
    chosen, interrupted = (judged(), True) if unfinished else to_the_end(judged)
    return Passed(
        chosen,
        collected.estimations,
        collected.left_out,
        unfinished,
        interrupted,
        context,
        pairs,
        judged,
    )


def _context(
    pairs: Sequence[tuple[Log, Axis | None]],
    prior: PriorKnowledge,
    settings: Settings,
    work: Work,
    coupling: Elastic | None,
    terms: Terms | None,
    cutoff: float | None,
    decimation: int | None,
) -> Context:
    """Return the data that the fits of all models share."""
    recorded, axes = map(list, zip(*pairs, strict=True))
    logs = recorded
    if terms is not None:
        names = tuple(terms.forces)
        logs = [terms.without(names, number, log) for number, log in enumerate(recorded)]
    described = [axis or Axis(kind=log.kind) for log, axis in pairs]
    estimator, treated = None, logs
    if "output_error" in map(attrgetter("method"), described):
        estimator = Simulation(logs, described, loop_of(logs, axes))
        treated = estimator.excerpts
    sought = all(axis.seeks_delay and not axis.delay for axis in described)
    stated = not sought and all(axis.cutoff is not None or cutoff is not None for axis in described)
    finds = estimator is None and not stated
    low = None
    if (
        coupling is not None
        and cutoff is None
        and estimator is None
        and all(axis.cutoff is None for axis in described)
    ):
        seconds = max(float(np.ptp(log.time.values)) for log in logs)
        low = min(
            max(coupling.one_mass, FEWEST_PERIODS / seconds),
            CUTOFF_SHARE / float(logs[0].sample_time),
        )
    treat = partial(treat_all, treated, axes, low or cutoff)
    dataset = treated_dataset = treat(decimation)
    if finds:
        alignment = alignment_of(
            logs, axes, settings, sought=sought, coupling=coupling if low else None
        )
        # Terms spoil delay and inertia of the first stage; without them, it is the sharper one.
        if terms is not None and terms.explanation.terms and low is None:
            most = settings.delay_unsure * logs[0].sample_time
            alignment = with_explained(alignment, terms.explanation, most)
        if decimation is None and set(map(attrgetter("decimation"), described)) == {None}:
            # Fewer rows, so that position noise does not hide friction.
            rows, noise = calmed(aligned(treated_dataset, alignment))
            treated_dataset = (
                replace(treat(rows), calmed_from=noise)
                if rows > treated_dataset.decimation
                else treated_dataset
            )
        dataset, prior = _aligned(
            treated_dataset, prior, alignment, settings, elastic=low is not None
        )
    if any(cogging.harmonics is None for axis in described for cogging in axis.cogging):
        prior = with_harmonics(prior, axes[0], dataset)
        if finds:
            # Waves of known length determine the delay better than waves found in the residual.
            axes = [axis and with_harmonics_of(prior.plant, axis) for axis in axes]
            alignment = alignment_of(
                logs, axes, settings, sought=sought, coupling=coupling if low else None
            )
            dataset, prior = _aligned(
                treated_dataset, prior, alignment, settings, elastic=low is not None
            )
    context = replace(context_of(dataset, prior, settings=settings), estimator=estimator)
    context = _of_channel(
        context, treated_dataset, work.task("looking for the channel that was filtered")
    )
    if terms is not None:
        decimation = treated_dataset.decimation
        beside = Beside(
            terms,
            recorded,
            partial(treat_all, axes=axes, cutoff=low or cutoff, decimation=decimation),
        )
        context = replace(context, beside=beside)
    return replace(context, coupling=coupling)


def _aligned(
    treated: Dataset,
    prior: PriorKnowledge,
    alignment: Alignment,
    settings: Settings,
    *,
    elastic: bool,
) -> tuple[Dataset, PriorKnowledge]:
    """Return the rows of a log with its channels aligned in time, and the prior knowledge with the measured inertia."""
    # Noise above half of the reported threshold biases the inertia in the fits; so does friction behind a spring.
    moved = aligned(treated, alignment)
    noisy = moved.acceleration_noise_share > 0.5 * settings.acceleration_noise
    unsure = 1.0 if noisy or elastic else settings.inertia_unsure
    measured, mass, half_width = {}, alignment.mass, alignment.mass_half_width
    if mass is not None and half_width is not None and half_width <= unsure * mass:
        names = names_of(Role.INERTIA, prior.plant.variables)
        measured = {name: (mass, half_width) for name in names if name not in prior.values}
    return moved, replace(prior, measured=measured)


def _of_channel(context: Context, treated: Dataset, report: Report) -> Context:
    """Return the context with the filter in the channel for which LuGre friction explains more."""
    # If the position is smoother than the effort, the effort was recorded before it acted, or the position was filtered.
    # The first stage cannot distinguish both; reversals of friction can.
    alignment = context.dataset.alignment
    if alignment is None or (alignment.smoothing or 0.0) >= 0.0:
        return context
    dataset = aligned(treated, replace(alignment, of_position=True))
    of_position = context_of(dataset, context.prior, settings=context.settings)
    report(0.0)
    return min((context, of_position), key=_left)


def _left(context: Context) -> float:
    """Return the share of the effort that LuGre friction does not explain; an unfinished fit is an interruption."""
    estimation = along_the_motion(context, find(TELLS_CHANNEL), silent)
    if estimation.solution.unfinished:
        raise KeyboardInterrupt
    return float(
        np.linalg.norm(estimation.problem.residual(estimation.solution.values))
        / np.linalg.norm(context.dataset.effort)
    )
