"""The fits of several models to one log, as far as the work came."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from bristle.core.contracts import FrictionModel
from bristle.core.errors import InputError
from bristle.friction import find
from bristle.identification.estimation import Context, Estimation
from bristle.identification.excitation import spread_between_repeats
from bristle.identification.fitting import fit
from bristle.identification.intervals import NUMERIC, message_of
from bristle.identification.result import Fit
from bristle.identification.screening import screened, terms_of
from bristle.identification.structure import next_models
from bristle.identification.validation import in_order, with_information
from bristle.identification.work import Work

WITHOUT_SLOTS = "the search for models with slots is incomplete"
TURNS = 2  # rounds of slots added to the best model
# Durations in fits of a model with a state, measured on logs of 10 s to 30 s at 1 kHz.
STATIC, OF_SLOT, SEEKING_SLOTS, JUDGING = 0.05, 1.5, 5.0, 2.5


def duration_of(component: FrictionModel) -> float:
    """Return the duration of a fit, roughly."""
    has_shape = bool(terms_of(component) & {"fall", "elements"})
    return (1.0 if has_shape else STATIC) * (1.0 + OF_SLOT * component.name.count("+"))


@dataclass
class Found:
    """The names of all models to fit, with the fits, their estimations, and the reasons for omitted models so far."""

    asked: list[str]
    fits: list[Fit] = field(default_factory=list)
    estimations: dict[str, Estimation] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)

    def in_words(self) -> str:
        """Return how far interrupted work came."""
        whole, missing = 0, [name for name in self.asked if name not in self.estimations and name not in self.left_out]
        remarks = list[str]()
        for model in self.fits:
            whole += not model.unfinished
            remarks += [f"the fit of {model.name} is incomplete"] if model.unfinished else []
        remarks += [f"{', '.join(missing)} {'was' if len(missing) == 1 else 'were'} not fitted"] if missing else []
        return "; ".join([f"interrupted: {whole} of {len(self.asked)} models fitted", *(remarks or [WITHOUT_SLOTS])])


def all_fits(
    context: Context,
    components: Sequence[FrictionModel],
    extended: bool,
    blocks: int,
    work: Work,
    found: Found,
    tell: Callable[[Fit], None],
) -> str:
    """Fit several models, `extended` by slots if requested; return a remark about interrupted work."""
    try:
        _fits(context, screened(context, components, blocks), blocks, work, found, tell)
        if extended:
            _with_slots(context, blocks, work, found)
    except KeyboardInterrupt:
        if not found.fits:
            raise
        return found.in_words()
    finally:
        found.fits.sort(key=lambda fit: found.asked.index(fit.name))
    return ""


def _fits(
    context: Context,
    components: Sequence[FrictionModel],
    blocks: int,
    work: Work,
    found: Found,
    tell: Callable[[Fit], None] = lambda fit: None,
) -> None:
    """Fit several models; tell the first fit of all if more are to follow."""
    errors: list[Exception] = []
    for component in components:
        try:
            model_fit, estimation = fit(context, component, blocks, work.task(duration_of(component), f"fitting {component.name}"))
        except NUMERIC as error:
            if isinstance(error, InputError) and error.path not in ("model", *component.variables):
                raise
            errors.append(error)
            found.left_out[component.name] = message_of(error)
            continue
        found.estimations[model_fit.name] = estimation
        found.fits.append(model_fit)
        if model_fit.unfinished:
            raise KeyboardInterrupt
        if len(found.fits) == 1 < len(found.asked):
            tell(model_fit)
    if errors and not found.fits:
        raise errors[0]


def ranked(fits: Sequence[Fit], context: Context) -> list[Fit]:
    """Return fits with their ranks, best first."""
    order = in_order(fits, context.settings, spread_between_repeats(context.dataset))
    return [replace(fit, rank=rank) for rank, fit in enumerate(with_information(order), 1)]


def _with_slots(context: Context, blocks: int, work: Work, found: Found) -> None:
    """Fit the best model with the slots suggested by its residual, in several rounds."""
    ahead = work.ahead - SEEKING_SLOTS
    for _ in range(TURNS):
        best = ranked(found.fits, context)[0]
        names = next_models(best, found.estimations[best.name], context.settings, context.coupling)
        further = [find(name) for name in names if name not in found.estimations and name not in found.left_out]
        if not further:
            break
        found.asked += [model.name for model in further]
        _fits(context, further, blocks, work, found)
    work.ahead = min(work.ahead, ahead)
