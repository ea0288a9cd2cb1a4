"""What is exported is looked at before a target writes it, and what a target wrote before it becomes a result."""

from __future__ import annotations

import re
from collections.abc import Callable

from bristle.core.errors import InputError, did_you_mean
from bristle.core.experiment import Experiment, Variant
from bristle.exports.described import Source
from bristle.exports.names import RESERVED
from bristle.exports.target import Product, Request, Target
from bristle.exports.targets import TARGETS
from bristle.files.owned import is_plain
from bristle.files.results import SUMMARY

__all__ = ["files_for", "law_for", "name_for", "target_named", "variant_of"]

NAME = re.compile(r"[a-z][a-z0-9_]{0,40}")


def target_named(name: str | Target) -> Target:
    """Return the target of bristle with this name; one of a user's own is handed in itself.

    Raises
    ------
    InputError
        If there is no such target.
    """
    if isinstance(name, Target):
        return name
    if name not in TARGETS:
        raise InputError("no such target", path="to", value=name, mend=did_you_mean(name, TARGETS),
                         allowed=f"{', '.join(TARGETS)}, or a file my_target.py with one of your own")  # fmt: skip
    return TARGETS[name]


def files_for(to: str | Target, request: Request) -> Product:
    """Return the files of a model for a target.

    Raises
    ------
    InputError
        If there is no such target, or it does not hold what is asked for.
    """
    target = target_named(to)
    _refuse_arithmetic(target, tunable=request.tunable, single=request.single)
    _refuse(target, request.log is not None, lambda able: able.compares, "is no table that could be compared on a log",
            "Leave the log out")  # fmt: skip
    _refuse(target, request.draws > 0, lambda able: able.takes_draws, "holds one model, not draws of it",
            "Leave draws out")  # fmt: skip
    _refuse(target, request.model.component.family == "hysteresis", lambda able: able.operators,
            "holds no hysteresis operator", value=request.model.name)  # fmt: skip
    return checked_product(target.write(request), target)


def _refuse_arithmetic(target: Target, *, tunable: bool, single: bool) -> None:
    _refuse(target, tunable, lambda able: able.tunable, "has no parameters that may be changed at run time",
            "Leave tunable out")  # fmt: skip
    _refuse(target, single, lambda able: able.single, "is not written in single precision", "Leave float32 out")


def _refuse(
    target: Target, wanted: bool, able: Callable[[Target], bool], message: str, mend: str = "", value: str | None = None
) -> None:  # fmt: skip
    """Refuse what is wanted of a target that is not able to do it, and name those of bristle that are."""
    if wanted and not able(target):
        allowed = ", ".join(name for name, candidate in TARGETS.items() if able(candidate))
        raise InputError(message, path=target.name, value=value, allowed=allowed, mend=mend)


def checked_product(product: Product, target: Target) -> Product:
    """Return what a target wrote, if it can become a result: files with plain names, text or bytes, notes in words.

    Raises
    ------
    InputError
        If it cannot.
    """
    if not isinstance(product, Product) or not isinstance(product.files, dict):
        raise InputError("returned no files", path=target.name, value=type(product).__name__,
                         mend='Return Product({"name.txt": text}, ("a note",))')  # fmt: skip
    if not product.files:
        raise InputError("wrote no file", path=target.name, mend="Refuse with an InputError what it cannot hold")
    for name, content in product.files.items():
        if not isinstance(name, str) or not (is_plain(name) and name.isprintable()) or name == SUMMARY:
            raise InputError("gives a file a name that it cannot have", path=target.name, value=name,
                             allowed=f"the plain name of a file in the folder, not {SUMMARY}")  # fmt: skip
        if not isinstance(content, (str, bytes)):
            raise InputError(f"wrote no content for {name}", path=target.name, value=type(content).__name__,
                             allowed="text or bytes")  # fmt: skip
    if not isinstance(product.notes, tuple) or not all(isinstance(note, str) for note in product.notes):
        raise InputError("has notes that are no text", path=target.name, value=product.notes,
                         mend='Write ("a note",), with a comma behind it')  # fmt: skip
    return product


def law_for(
    to: str | Target, variant: Variant, name: str, source: Source, *, tunable: bool = False, single: bool = False
) -> Product:
    """Return the files of the control law of a variant for a target; its options are those of a `Request`.

    Raises
    ------
    InputError
        If the target holds no law, or the variant has none that can be exported.
    """
    import numpy as np

    from bristle.exports.law import law_of
    from bristle.exports.single import single_note

    target = target_named(to)
    if target.write_law is None:
        holding = ", ".join(candidate.name for candidate in TARGETS.values() if candidate.write_law)
        raise InputError("holds no control law", path="to", value=target.name, allowed=holding)
    _refuse_arithmetic(target, tunable=tunable, single=single)
    law = law_of(variant, tunable=tunable, single=single)
    ahead = [name for name in law.inputs if name.endswith("_ahead")]
    samples = f"the next {law.samples_ahead} samples" if law.samples_ahead > 1 else "the next sample"
    notes = [f"the law is told {samples} of the desired motion: {', '.join(ahead)}"] if ahead else []
    notes += [single_note("effort")] if single else []
    if tunable and np.any(law.memory):
        notes.append("what the compensator was brought through before it begins is that of the exported parameters")
    return checked_product(Product(target.write_law(law, name, source), tuple(notes)), target)


def variant_of(experiment: Experiment, name: str | None) -> Variant:
    """Return the variant of this name; the only one where none is named.

    Raises
    ------
    InputError
        If there is no such variant, or several and none is named.
    """
    variants = {variant.name: variant for variant in experiment.variants}
    if name is None and len(variants) == 1:
        return experiment.variants[0]
    if name not in variants:
        reason = "must be named: the experiment has several" if name is None else "is not in the experiment"
        raise InputError(reason, path="variant", value=name or "", allowed=", ".join(variants),
                         mend=did_you_mean(name, variants) if name else "")  # fmt: skip
    return variants[name]


def name_for(text: str) -> str:
    """Return a name that files, types and functions can have.

    Raises
    ------
    InputError
        If they cannot.
    """
    if not NAME.fullmatch(text) or text in RESERVED:
        raise InputError("cannot be the name of a function", path="name", value=text,
                         allowed="small letters, digits and _, a letter first, no word of C")  # fmt: skip
    return text
