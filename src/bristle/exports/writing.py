"""Export of a model: checks of the request, the target's `write`, and checks of the product."""

from dataclasses import replace

import numpy as np

from bristle.core import InputError, Readable, did_you_mean
from bristle.core.experiment import RESTS, Variant
from bristle.exports.c_code import RESERVED
from bristle.exports.described import Request, Source, hash_of_model
from bristle.exports.effect import (
    FAR,
    WORSE,
    Effect,
    effect_of_files,
    effect_of_law,
    length_text,
    with_best_rule,
)
from bristle.exports.law import hash_of_law, law_of
from bristle.exports.loops import cycle_of, late_of, lead_of, loop_for, reach_for
from bristle.exports.targets import TARGETS, VALID_NAME, Product, Target
from bristle.exports.tunable import refuse_beyond_single, single_note
from bristle.files import SUMMARY, code_at, declared_in
from bristle.files.owned import is_plain
from bristle.identification.parameters import Role, acts_in_sliding
from bristle.models.friction.resting import rest_rule
from bristle.models.friction.slots import scaled
from bristle.prediction.claims import CONSTANT_GAINS, LEAST, rule_for

MEND = 'End the file with TARGET = Target(name="my_drive", description="...", write=write)'


def load_target_file(path: Readable) -> Target:
    """Return the target that a Python file defines as ``TARGET``.

    Parameters
    ----------
    path : path-like, bytes, file object or Content
        A Python file with ``TARGET = Target(name=..., description=..., write=write)``, from `bristle.exports`. bristle
        executes the file.

    Returns
    -------
    Target
        The target, for `bristle.export`.

    Raises
    ------
    InputError
        If the file cannot be read or run, defines no target, or names it with an invalid name.
    """
    content = code_at(path)
    target = declared_in(content, "TARGET", Target, title="target of the export", mend=MEND)
    source = str(content.source)
    if target.name in TARGETS:
        raise InputError(
            "TARGET has the name of a target of bristle",
            path=source,
            value=target.name,
            mend="Choose another name",
        )
    return target


SEEN = ("identified", "held")
USELESS = 50.0  # force error above which files are useless [% of the sliding friction]
SAID_OF_REST = {
    "held": "at rest (v = 0) the model keeps the force of the last direction; --rest middle writes the mean of both directions",
    "middle": "at rest (v = 0) the model gives the mean of both directions; --rest held writes the force of the last direction",
}


def target_named(name: str | Target) -> Target:
    """Return the target of bristle with this name; a `Target` is returned unchanged."""
    if isinstance(name, Target):
        return name
    if name not in TARGETS:
        raise InputError(
            "no such target",
            path="to",
            value=name,
            mend=did_you_mean(name, TARGETS),
            allowed=f"{', '.join(TARGETS)}, or a file my_target.py that defines a target",
        )
    return TARGETS[name]


def files_for(to: str | Target, request: Request, *, accept_harm: bool = False) -> Product:
    """Return the files of a model for a target."""
    target = target_named(to)
    operator = ""
    if request.model.component.family == "hysteresis":
        operator = request.model.name
    demands = {
        "tunable": request.tunable,
        "single": request.single,
        "derivatives": request.derivatives,
        "rest": request.rest,
    }
    _refuse_beyond(target, **demands, compares=request.log is not None, operators=operator)
    if request.single:
        refuse_beyond_single(request.model.values)
    request, effect = _with_best_share(target, request)
    if target.pushes and not accept_harm:
        _refuse_harm(
            effect,
            target.name,
            has_memory=target.reads is None and rest_rule(request.sampled) == "",
        )
    remarks = _unseen(request)
    if effect:
        remarks += effect.lines()
    if (
        (target.pushes or target.rest)
        and not target.of_cogging
        and request.model.component.family == "friction"
    ):
        remarks += (*_share_text(target, request), _ahead_text(request))
    rule = rest_rule(request.sampled)
    if rule:
        remarks += (SAID_OF_REST[rule],)
    source = replace(request.source, remarks=remarks, model_hash=hash_of_model(request.friction))
    product = checked_product(target.write(replace(request, source=source)), target)
    if not accept_harm:
        _refuse_useless(product, target.name)
    return replace(product, notes=(*remarks, *product.notes), effect=effect)


def _with_best_share(target: Target, request: Request) -> tuple[Request, Effect | None]:
    """Return the request with its share and rule, and the effect: of a constant share, the one that promises the shortest moves."""
    if target.reads is None:
        return _with_rule(target, with_share(target, request))
    tried = (_with_rule(target, with_share(target, request, gain)) for gain in CONSTANT_GAINS)
    return min(tried, key=_shortest_promise)


def _shortest_promise(ruled: tuple[Request, Effect | None]) -> float:
    """Return the shortest promised move of a request with its effect [m or rad]; 0 without an effect."""
    _, effect = ruled
    if effect is None:
        return 0.0
    return max(effect.least_distance, LEAST * effect.reach)


def with_share(target: Target, request: Request, constant: float = CONSTANT_GAINS[0]) -> Request:
    """Return a request with the share of the friction that its target feeds forward, for a model that is from a log.

    A compensator with a state follows the rule of `bristle.prediction.claims`. The values of a drive without one describe a
    `constant` share. A target that describes friction describes all of it.
    """
    if (
        not (target.pushes and request.is_from_log)
        or target.of_cogging
        or request.model.component.family != "friction"
    ):
        return request
    if target.reads is None:
        return replace(request, rule=rule_for(request.model, reach_for(request)))
    share = scaled(request.model, constant, whole=True)
    return replace(
        request,
        model=share,
        undivided=request.model,
        rule=rule_for(request.model, None)._replace(gain=constant),
    )


def _share_text(target: Target, request: Request) -> tuple[str, ...]:
    """Return a sentence on the share of the friction that is fed forward; empty for all of it."""
    rule = request.rule
    if rule is None:
        return ()
    share = f"{rule.gain:g} of the friction, and the constant and the viscous part whole"
    if target.reads is not None:
        return (f"the values contain {share}",)
    if rule.return_distance:
        travel = length_text(rule.return_distance, request.model.kind)
        return (
            f"the feed has {share}; the share fades at rest with {rule.fade_time:g} s and returns over {travel}",
        )
    if reach_for(request) is not None:
        return (f"the feed has {share}",)
    doubt = "the stiffness of the position loop is unknown, so bristle promises nothing: write [controller] into the axis file"
    return (f"the feed has {share}; {doubt}",)


def _ahead_text(request: Request) -> str:
    """Return a sentence on the lead of the desired motion."""
    ahead = lead_of(request)
    late = late_of(request)
    cycle = cycle_of(request)
    samples = "samples"
    if ahead == 1:
        samples = "sample"
    of_log = ", the sample time of the log"
    if request.axis is not None and request.axis.cycle:
        of_log = ""
    head = f"feed the desired motion {ahead} {samples} of {1e3 * cycle:g} ms ahead"
    rest = "0 for delay and lag, which are unknown"
    if late or request.is_from_log:
        rest = f"{ahead - 1} for {1e3 * late:.3g} ms of delay and lag"
    return f"{head}{of_log}: 1 for the next step, {rest}"


def _with_rule(target: Target, request: Request) -> tuple[Request, Effect | None]:
    """Return the request with its rule at rest, and the effect; without a requested rule, the better one in a known loop."""

    def effect(ruled: Request, *, promises: bool) -> Effect | None:
        if target.reads is None:
            if target.rest:
                return effect_of_files(ruled, None, promises=promises)
            return None
        drive = target.reads(checked_product(target.write(ruled), target).files, ruled)
        if drive is None:
            return None
        return effect_of_files(ruled, drive, of_cogging=target.of_cogging, promises=promises)

    def finished(ruled: Request) -> tuple[Request, Effect | None]:
        if target.pushes and target.reads is None and target.rest:
            return with_best_rule(ruled)
        return ruled, effect(ruled, promises=target.pushes)

    usual = replace(request, rest=request.rest or target.rest)
    matters = (
        target.pushes
        and loop_for(usual) is not None
        and (target.reads is not None or rest_rule(usual.sampled) != "")
    )
    rules = (usual.rest,)
    if target.rest and matters and not request.rest:
        rules = dict.fromkeys((target.rest, *RESTS))
    requests = [replace(request, rest=rule) for rule in rules]
    if len(requests) == 1:
        return finished(requests[0])
    tried = [(ruled, effect(ruled, promises=False)) for ruled in requests]
    best = tried[0]
    for ruled, with_it in tried[1:]:
        if with_it is not None and best[1] is not None and WORSE * with_it.ratio < best[1].ratio:
            best = ruled, with_it
    return finished(best[0])


def _refuse_harm(effect: Effect | None, name: str, *, has_memory: bool) -> None:
    """Refuse an export that makes the following error larger far beyond pre-sliding, or along the motion of the log."""
    if effect is not None and effect.is_harmful:
        mend = "Export a model with memory (--to c, --law)"
        if has_memory:
            mend = (
                "Lower the integral gain of the controller, or identify the friction more closely"
            )
        raise InputError(
            f"makes the error larger ({'; '.join(effect.lines()[:2])})",
            path=name,
            allowed=f"no larger error along the log and in moves of {FAR:g} times the friction over the stiffness of the loop",
            mend=f"{mend}; to write the files anyway, add --accept-harm",
        )


def _refuse_useless(product: Product, name: str) -> None:
    """Refuse files that describe less than half of the friction."""
    rms = 0.0
    if product.error is not None:
        rms = product.error["rms"]
    if rms > USELESS:
        raise InputError(
            f"describes the friction with an error of {rms:.3g} % rms",
            path=name,
            allowed=f"{USELESS:g} % or less",
            mend="Export a model that this target can represent, or another target; to write the files anyway, add --accept-harm",
        )


def _unseen(request: Request) -> tuple[str, ...]:
    """Return a sentence for each level of friction that no log has shown, according to the model file."""
    notes = []
    for name, variable in request.model.component.variables.items():
        entry = request.source.uncertainty.get(name, {})
        doubt = entry.get("note")
        if not doubt and entry.get("status", "identified") not in SEEN:
            doubt = "not identified"
        of_sliding = acts_in_sliding(variable) and not Role.BREAK_AWAY.fits(variable)
        if of_sliding and entry.get("status") != "held" and doubt:
            notes.append(f"do not use {name} until a log determines this force: {doubt}")
    return tuple(notes)


ABILITIES = {
    "tunable": ("does not support parameters that change at run time", "Omit tunable"),
    "single": ("does not support single precision", "Omit float32"),
    "derivatives": ("does not support derivatives", "Omit derivatives"),
    "rest": (
        "does not evaluate the model sample by sample, so it has no rule at rest",
        "Omit rest",
    ),
    "compares": (
        "is not a table, so bristle cannot compare it with the model along a log",
        "Omit the log",
    ),
    "operators": ("does not support hysteresis operators", ""),
    "write_law": ("does not support control laws", ""),
}


def _refuse_beyond(target: Target, **demands: bool | str) -> None:
    """Refuse a demand that the target cannot meet, and name the targets of bristle that can."""
    for ability, value in demands.items():
        if value and not getattr(target, ability):
            allowed = ", ".join(
                name for name, candidate in TARGETS.items() if getattr(candidate, ability)
            )
            if not isinstance(value, str):
                value = None
            message, mend = ABILITIES[ability]
            raise InputError(message, path=target.name, value=value, allowed=allowed, mend=mend)


def checked_product(product: Product, target: Target) -> Product:
    """Return the product of a target if it is valid: files with plain names, text or bytes, notes as text."""
    if not isinstance(product, Product) or not isinstance(product.files, dict):
        raise InputError(
            "returned no files",
            path=target.name,
            value=type(product).__name__,
            mend='Return Product({"name.txt": text}, ("a note",))',
        )
    if not product.files:
        raise InputError(
            "wrote no file",
            path=target.name,
            mend="Raise an InputError for a model that the target does not support",
        )
    for name, content in product.files.items():
        if (
            not isinstance(name, str)
            or not (is_plain(name) and name.isprintable())
            or name == SUMMARY
        ):
            raise InputError(
                "gives a file an invalid name",
                path=target.name,
                value=name,
                allowed=f"a plain file name without a folder, other than {SUMMARY}",
            )
        if not isinstance(content, (str, bytes)):
            raise InputError(
                f"wrote no content for {name}",
                path=target.name,
                value=type(content).__name__,
                allowed="text or bytes",
            )
    if not isinstance(product.notes, tuple) or not all(
        isinstance(note, str) for note in product.notes
    ):
        raise InputError(
            "has notes that are not text",
            path=target.name,
            value=product.notes,
            mend='Write ("a note",), with a comma after the text',
        )
    return product


def law_for(
    to: str | Target,
    variant: Variant,
    name: str,
    source: Source,
    *,
    tunable: bool = False,
    single: bool = False,
    accept_harm: bool = False,
) -> Product:
    """Return the files of the control law of a variant for a target, with the options of a `Request`."""
    target = target_named(to)
    _refuse_beyond(target, write_law=True, tunable=tunable, single=single)
    if single:
        refuse_beyond_single(variant.controller.values)
    law = law_of(variant, tunable=tunable, single=single)
    effect = effect_of_law(law.variant)
    if not accept_harm:
        _refuse_harm(effect, target.name, has_memory=True)
    remarks = ()
    if effect:
        remarks = effect.lines()
    ahead = [name for name in law.inputs if name.endswith("_ahead")]
    samples = "the next sample"
    if law.samples_ahead > 1:
        samples = f"the next {law.samples_ahead} samples"
    notes = []
    if ahead:
        notes = [f"feed the law {samples} of the desired motion: {', '.join(ahead)}"]
    if single:
        notes += [single_note("effort")]
    if tunable and np.any(law.memory):
        notes.append(
            "the initial state of the compensator was computed with the exported parameters; new parameters do not change it"
        )
    assert target.write_law is not None
    written = target.write_law(
        law, name, replace(source, remarks=remarks, model_hash=hash_of_law(law_of(variant)))
    )
    if not isinstance(written, Product):
        written = Product(written)
    product = checked_product(written, target)
    return replace(
        product, notes=tuple(dict.fromkeys((*remarks, *notes, *product.notes))), effect=effect
    )


def name_for(text: str) -> str:
    """Return a valid name for files, types and functions."""
    if not VALID_NAME.fullmatch(text) or text in RESERVED:
        raise InputError(
            "cannot name a function",
            path="name",
            value=text,
            allowed="small letters, digits and _, a letter first, not a keyword of C",
        )
    return text
