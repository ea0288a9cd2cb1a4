"""What is to be said of the loops of an experiment, once for alike ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from bristle.core.diagnostic import Diagnostic
from bristle.report.messages import message
from bristle.stability import Verdict, doubts_of, verdict_of

if TYPE_CHECKING:
    from bristle.stability import Assessment

__all__ = ["about_loops", "loop_warnings"]


def about_loops(judged: Mapping[str, Assessment], further: Mapping[str, Diagnostic]) -> list[Diagnostic]:
    """Return what to know of loops, those that are unstable or have small margins: ``variants`` are their names.

    Parameters
    ----------
    judged : mapping of str to Assessment
        The loop of each variant.
    further : mapping of str to Diagnostic
        What else is to be said of a variant.
    """
    found: list[tuple[Diagnostic, list[str]]] = []
    for name, one in judged.items():
        for told in doubts_of(one) if one.verdict is Verdict.STABLE else (verdict_of(one),):
            # Two that read alike are told as one.
            names = next((names for other, names in found if message(other) == message(told)), None)
            if names is None:
                found.append((told, [name]))
            else:
                names.append(name)
    every = [*found, *((one, [name]) for name, one in further.items())]
    return [replace(one, numbers={**one.numbers, "variants": tuple(names)}) for one, names in every]


def loop_warnings(diagnostics: Sequence[Diagnostic]) -> list[str]:
    """Return the same in sentences, the names of the variants before each."""
    return [f"{', '.join(map(str, _names(one)))}: {_prefix(one)}{message(one)}" for one in diagnostics]


def _names(one: Diagnostic) -> Sequence[object]:
    names = one.numbers["variants"]
    return names if isinstance(names, tuple) else (names,)


def _prefix(one: Diagnostic) -> str:
    return "warning: " if one.severity == "warning" else ""
