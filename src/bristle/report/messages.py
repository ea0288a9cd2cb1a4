"""Sentences of diagnostics, one for each code, with their numbers in readable units."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from string import Formatter
from typing import TYPE_CHECKING, Any

from bristle.core import NAMES, Diagnostic, Kind, number, unit_of, with_unit
from bristle.report.sentences import SENTENCES
from bristle.report.sentences.loops import counted
from bristle.report.table import capital, stiffness_text

if TYPE_CHECKING:
    from bristle.identification import Estimate, Fit
    from bristle.simulation import Prediction

OF_TERMS = ("second_pass", "terms_beside")
"""Codes about the forces beside friction."""
_HEADS = {
    ("parameter", "warning"): "{parameter:parameter} cannot be identified: ",
    ("parameter", "note"): "{parameter:parameter} is held constant at {value:unit}: ",
    ("edge", "warning"): "{parameter:parameter} has no standard error: ",
}


def message(diagnostic: Diagnostic) -> str:
    """Return a diagnostic as a sentence.

    Examples
    --------
    >>> message(Diagnostic("low_speed", "F_v", numbers={"speed": 628e-6}))
    'F_v cannot be identified: the log never exceeds 628 µm/s'
    >>> message(Diagnostic("held_known", "M", "note", {"value": 12.0, "unit": "kg"}))
    'M is held constant at 12 kg: given as known'
    """
    head = _HEADS.get((SENTENCES[diagnostic.code].about, diagnostic.severity), "")
    return _formatted(head, diagnostic) + clause(diagnostic)


def whole_sentence(diagnostic: Diagnostic) -> str:
    """Return a diagnostic as a sentence, with a capital and a full stop."""
    return f"{capital(message(diagnostic))}."


def clause(diagnostic: Diagnostic) -> str:
    """Return a diagnostic without its parameter, for a table with one row for each parameter.

    Examples
    --------
    >>> clause(Diagnostic("low_speed", "F_v", numbers={"speed": 628e-6}))
    'the log never exceeds 628 µm/s'
    """
    return _formatted(SENTENCES[diagnostic.code].template(diagnostic.numbers), diagnostic)


def advice_of(codes: Iterable[str]) -> list[str]:
    """Return the advice on codes, without repetitions."""
    return [
        advice
        for advice in dict.fromkeys(SENTENCES[code].advice for code in codes)
        if advice != "nothing"
    ]


def note_of(estimate: Estimate) -> str:
    """Return why a parameter is held constant, at an edge or unidentifiable; empty if it is identified."""
    return "" if estimate.reason is None else clause(estimate.reason)


def why_effective(fit: Fit) -> str:
    """Return the reason for effective parameters: the model lacks a force, or the recorded effort is doubtful."""
    recorded = next((code for code in fit.lacking if code != "structure"), "")
    reasons = [SENTENCES[recorded].means] if recorded else []
    return " and ".join(
        reasons
        + (["the model lacks a force"] if "structure" in fit.lacking or not recorded else [])
    )


def warnings_of(fit: Fit) -> tuple[str, ...]:
    """Return the warnings and errors of a fit as sentences, errors first."""
    errors_first = sorted(fit.diagnostics, key=lambda diagnostic: diagnostic.severity != "error")
    return tuple(
        message(diagnostic) for diagnostic in errors_first if diagnostic.severity != "note"
    )


def terms_in(fit: Fit) -> str:
    """Return sentences about the forces beside friction: lines of the axis, and those out of the effort; empty without them."""
    found = [
        whole_sentence(diagnostic) for diagnostic in fit.diagnostics if diagnostic.code in OF_TERMS
    ]
    return " ".join(found)


def assumptions_of(fit: Fit) -> tuple[str, ...]:
    """Return the assumptions of a fit as sentences."""
    notes = (
        diagnostic
        for diagnostic in fit.diagnostics
        if diagnostic.severity == "note" and diagnostic.code not in OF_TERMS
    )
    return tuple(map(message, notes))


def notes_of(prediction: Prediction) -> tuple[str, ...]:
    """Return the remarks on a prediction as sentences; warnings begin with ``warning:``."""
    return tuple(
        message(diagnostic)
        if diagnostic.severity == "note"
        else f"{diagnostic.severity}: {message(diagnostic)}"
        for diagnostic in prediction.diagnostics
    )


def as_data(diagnostics: Iterable[Diagnostic]) -> list[dict[str, Any]]:
    """Return diagnostics for JSON: ``code``, ``parameter``, ``severity``, ``numbers``, ``message``."""
    return [diagnostic.as_data() | {"message": message(diagnostic)} for diagnostic in diagnostics]


def picked(item: object, *names: str) -> dict[str, Any]:
    """Return some attributes of an object by name, for JSON."""
    return {name: getattr(item, name) for name in names}


def fields_of(code: str) -> dict[str, str]:
    """Return the numbers in the sentence of a code, each with its format: a quantity, or a format of `_Words`."""
    fields: dict[str, str] = {}
    for text in SENTENCES[code].texts:
        fields |= {
            name.split("[")[0]: spec or "" for _, name, spec, _ in Formatter().parse(text) if name
        }
    fields |= dict.fromkeys(SENTENCES[code].also, "")
    return {name: spec for name, spec in fields.items() if name != "parameter"}


def _formatted(template: str, diagnostic: Diagnostic) -> str:
    values: dict[str, Any] = {"parameter": diagnostic.parameter, **diagnostic.numbers}
    if "cause" in values:
        cause = Diagnostic(
            values.pop("cause"), diagnostic.parameter, "warning", values, diagnostic.kind
        )
        values = values | {"cause": clause(cause)}
    return _Words(diagnostic.kind, str(values.get("unit", "1"))).vformat(template, (), values)


class _Words(Formatter):
    """Formats numbers by their quantity."""

    # The format is a generalised quantity (`length/time`), `unit` for the unit among the numbers, `lead` for a travel
    # as in an axis file, `parameter` for a name that is a word, `list` or `and` for names, `whole numbers`, `samples` for
    # a count in words, `2 digits`, or a
    # format of Python. `!m` is the magnitude.

    def __init__(self, kind: Kind, unit: str) -> None:
        self.kind: Kind = kind
        self.unit = unit

    def convert_field(self, value: Any, conversion: str | None) -> Any:
        """Return the magnitude of a number for the conversion `!m`."""
        return abs(value) if conversion == "m" else super().convert_field(value, conversion)  # pyright: ignore[reportArgumentType]

    def format_field(self, value: Any, format_spec: str) -> str:
        """Return one number in words."""
        named: dict[str, Callable[[], str]] = {
            "list": lambda: ", ".join(value),
            "and": lambda: " and ".join(value),
            "whole numbers": lambda: ", ".join(str(int(order)) for order in value),
            "lead": lambda: f"{number(1e3 * value)} mm",
            "unit": lambda: value if isinstance(value, str) else with_unit(value, self.unit),
            "parameter": lambda: (
                f"parameter {value}"
                if value.isalpha() and value.islower() and len(value) > 2
                else value
            ),
            "percents": lambda: ", ".join(f"{number(share, 10.0)} %" for share in value),
            "samples": lambda: counted(int(value)),
            "stiffness of an axis": lambda: stiffness_text(value, self.kind),
        }
        if format_spec in named:
            return named[format_spec]()
        if format_spec.endswith(" digits"):
            return number(value, digits=int(format_spec.split()[0]))
        if re.split(r"[*/]", format_spec)[0] in NAMES:
            values = value if isinstance(value, tuple) else (value,)
            return ", ".join(
                with_unit(number_in_unit, unit_of(format_spec, self.kind))
                for number_in_unit in values
            )
        text = super().format_field(value, format_spec)
        short = re.fullmatch(r"\.(\d)g", format_spec)
        if short and isinstance(value, float) and "e+" in text:
            written = number(value, digits=int(short[1]))  # "320 %" in place of "3.2e+02 %"
            return text if "e" in written else written
        return text
