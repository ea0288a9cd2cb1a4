"""What is to be said of the loops of an experiment, once for alike ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from bristle.core.diagnostic import Diagnostic
from bristle.loop import Verdict, doubts_of, verdict_of
from bristle.report.messages import message, sentence_of

if TYPE_CHECKING:
    from bristle.loop import Assessment

__all__ = ["about_loops", "loop_doubts", "loop_warnings"]

NAMES_MAX = 3  # variants that are named in a line


def about_loops(judged: Mapping[str, Assessment], further: Mapping[str, Diagnostic]) -> list[Diagnostic]:
    """Return what to know of loops, those that are unstable or have small margins: ``variants`` are their names."""
    by_doubt: list[tuple[Diagnostic, list[str]]] = []
    for name, assessment in judged.items():
        for doubt in doubts_of(assessment) if assessment.verdict is Verdict.STABLE else (verdict_of(assessment),):
            # Two that read alike are told as one.
            names = next((names for earlier, names in by_doubt if message(earlier) == message(doubt)), None)
            if names is None:
                by_doubt.append((doubt, [name]))
            else:
                names.append(name)
    complete = [*by_doubt, *((diagnostic, [name]) for name, diagnostic in further.items())]
    return [replace(diagnostic, numbers={**diagnostic.numbers, "variants": tuple(names)}) for diagnostic, names in complete]


def loop_warnings(diagnostics: Sequence[Diagnostic]) -> list[str]:
    """Return the same in sentences, the names of the variants before each."""
    return [f"{', '.join(map(str, _names(diagnostic)))}: {_prefix(diagnostic)}{message(diagnostic)}" for diagnostic in diagnostics]


def loop_doubts(diagnostics: Sequence[Diagnostic]) -> list[str]:
    """Return the same in short: what is grave as it stands, what is warned of by what it means."""
    grave = [diagnostic for diagnostic in diagnostics if diagnostic.severity == "error"]
    doubts = [diagnostic for diagnostic in diagnostics if diagnostic.severity == "warning"]
    return loop_warnings(grave) + [f"{sentence_of(doubt.code).means}: {_in_short(_names(doubt))}" for doubt in doubts]


def _in_short(names: Sequence[object]) -> str:
    more = f" and {len(names) - NAMES_MAX} more" if len(names) > NAMES_MAX else ""
    return ", ".join(map(str, names[:NAMES_MAX])) + more


def _names(diagnostic: Diagnostic) -> Sequence[object]:
    names = diagnostic.numbers["variants"]
    return names if isinstance(names, tuple) else (names,)


def _prefix(diagnostic: Diagnostic) -> str:
    return "warning: " if diagnostic.severity == "warning" else ""
