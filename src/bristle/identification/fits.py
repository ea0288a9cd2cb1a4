"""The fits of several models to one log, as far as the work came."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter

from bristle.core.contracts import FrictionModel
from bristle.core.errors import InputError
from bristle.identification.estimation import Context, Estimation
from bristle.identification.excitation import spread_between_repeats
from bristle.identification.fitting import fit
from bristle.identification.found_terms import Beside
from bristle.identification.intervals import NUMERIC, message_of
from bristle.identification.result import Fit
from bristle.identification.screening import screened
from bristle.identification.structure import next_models
from bristle.identification.validation import in_order, with_information
from bristle.identification.work import Work
from bristle.models.friction import find

WITHOUT_SLOTS = "the search for models with slots is incomplete"
TURNS = 2  # rounds of slots added to the best model
SLOTTED = 15  # parameters of the models that the rounds usually add


@dataclass
class Collected:
    """The names of all models to fit, with the fits, their estimations, and the reasons for omitted models so far."""

    names: list[str]
    fits: list[Fit] = field(default_factory=list)
    estimations: dict[str, Estimation] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)

    def in_words(self) -> str:
        """Return how far interrupted work came."""
        complete = sum(not model.unfinished for model in self.fits)
        remarks = [
            f"the fit of {model.name} is incomplete" for model in self.fits if model.unfinished
        ]
        missing = [
            name
            for name in self.names
            if name not in self.estimations and name not in self.left_out
        ]
        if missing:
            remarks.append(
                f"{', '.join(missing)} {'was' if len(missing) == 1 else 'were'} not fitted"
            )
        return "; ".join(
            [
                f"interrupted: {complete} of {len(self.names)} models fitted",
                *(remarks or [WITHOUT_SLOTS]),
            ]
        )


def all_fits(
    context: Context,
    components: Sequence[FrictionModel],
    extended: bool,
    blocks: int,
    work: Work,
    collected: Collected,
    tell: Callable[[Fit], None],
) -> str:
    """Fit several models, `extended` by slots if requested; return a remark about interrupted work."""
    try:
        _fits(
            context,
            screened(context, components, blocks),
            blocks,
            work,
            collected,
            tell,
            SLOTTED * extended,
        )
        if extended:
            _with_slots(context, blocks, work, collected)
    except KeyboardInterrupt:
        if not collected.fits:
            raise
        return collected.in_words()
    finally:
        collected.fits.sort(key=lambda fit: collected.names.index(fit.name))
    return ""


def _fits(
    context: Context,
    components: Sequence[FrictionModel],
    blocks: int,
    work: Work,
    collected: Collected,
    tell: Callable[[Fit], None] = lambda fit: None,
    further: int = 0,
) -> None:
    """Fit several models, more with `further` parameters to follow; of several, tell each fit that is the best so far."""
    errors: list[Exception] = []
    sizes = [len(component.variables) for component in components]
    for place, component in enumerate(components):
        work.ahead, begun = (
            work.lasting(sum(sizes[place + 1 :]) + further) + work.after_fits,
            perf_counter(),
        )
        try:
            done = f"{len(collected.fits)} of {len(collected.names)} models fitted"
            report = work.task(f"fitting {component.name}, {done}", work.lasting(sizes[place]))
            model_fit, estimation = fit(context, component, blocks, report)
            work.paces.append((perf_counter() - begun) / sizes[place])
        except NUMERIC as error:
            if isinstance(error, InputError) and error.path not in ("model", *component.variables):
                raise
            errors.append(error)
            collected.left_out[component.name] = message_of(error)
            continue
        collected.estimations[model_fit.name] = estimation
        collected.fits.append(model_fit)
        if model_fit.unfinished:
            raise KeyboardInterrupt
        if len(collected.names) > 1 and model_fit is min(
            collected.fits, key=lambda model: model.error_percent
        ):
            tell(model_fit)
    if errors and not collected.fits:
        raise errors[0]


def ranked(fits: Sequence[Fit], context: Context) -> list[Fit]:
    """Return fits with their ranks, best first, by their errors with the terms that are no part of the models."""
    compared = fits
    if context.beside is not None:
        components = [fit.friction.component for fit in fits]
        compared = [with_terms_beside(fit, components, context.beside) for fit in fits]
    by_name = {fit.name: fit for fit in fits}
    in_rank = in_order(compared, context.settings, spread_between_repeats(context.dataset))
    order = [by_name[fit.name] for fit in in_rank]
    return [replace(fit, rank=rank) for rank, fit in enumerate(with_information(order), 1)]


def with_terms_beside(fit: Fit, components: Sequence[FrictionModel], beside: Beside) -> Fit:
    """Return a fit with the error of its model alone, without the terms that other models have."""
    share = beside.share_for(fit.friction.component, components)
    held_out = fit.held_out
    if held_out is not None:
        errors = [math.hypot(error, share) for error in held_out.block_errors_percent]
        mean = math.hypot(held_out.mean_percent, share)
        held_out = replace(held_out, block_errors_percent=tuple(errors), mean_percent=mean)
    error = math.hypot(fit.force_error_percent, share)
    return replace(fit, held_out=held_out, force_error_percent=error)


def _with_slots(context: Context, blocks: int, work: Work, collected: Collected) -> None:
    """Fit the best model with the slots suggested by its residual, in several rounds."""
    for _ in range(TURNS):
        best = ranked(collected.fits, context)[0]
        causes = context.beside.terms.causes if context.beside is not None else ()
        names = next_models(best, causes)
        further = [
            find(name)
            for name in names
            if name not in collected.estimations and name not in collected.left_out
        ]
        if not further:
            break
        collected.names += [model.name for model in further]
        _fits(context, further, blocks, work, collected)
