"""What the log says against itself before anything is fitted, beside a fit: which of its parameters that concerns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from bristle.core.axis import Axis
from bristle.core.diagnostic import Diagnostic
from bristle.core.variable import Variable
from bristle.identification.parameters import PriorKnowledge, Role, acts_in_sliding, names_of
from bristle.identification.result import Fit
from bristle.identification.settings import Settings
from bristle.logs.check import checked
from bristle.logs.log import Log

__all__ = ["checks_of", "with_checks"]

TRADED = {
    "one_speed": ("sliding", "speed", "stribeck"),
    "one_direction": ("sliding", "stribeck"),
    "level_drifts": ("sliding", "speed", "stribeck"),
    "clipped": ("acceleration", "sliding", "speed", "stribeck"),
    "saturates": ("acceleration", "sliding", "speed", "stribeck"),
    "never_slides": ("acceleration", "sliding", "speed", "stribeck"),
}
"""By code, what it takes to tell the parameters that trade places in such a log."""
BY_THE_LOG = ("held_one_direction", "held_one_speed")
"""Why a parameter is held that such a log does not tell."""
TOLD_MORE_FULLY = {"repeats_one_motion": ("motion_repeats", "one_amplitude")}
"""Codes of a fit that say the same with more."""


def checks_of(pairs: Sequence[tuple[Log, Axis | None]], prior: PriorKnowledge, settings: Settings) -> tuple[Diagnostic, ...]:
    """Return what the logs of an identification say before it, of each code the first."""
    by_code: dict[str, Diagnostic] = {}
    mass = sum(prior.values[name] for name in names_of(Role.INERTIA, prior.plant.variables) if name in prior.values)
    for log, axis in pairs:
        as_known = replace(axis or Axis(kind=log.kind), mass=mass or None)
        for diagnostic in checked(log, as_known, settings):
            by_code.setdefault(diagnostic.code, diagnostic)
    return tuple(by_code.values())


def with_checks(fit: Fit, diagnostics: Sequence[Diagnostic]) -> Fit:
    """Return a fit with what its logs say against themselves, and which of its parameters that concerns."""
    of_fit = {diagnostic.code for diagnostic in fit.diagnostics}
    added = [_naming(fit, diagnostic) for diagnostic in diagnostics if not of_fit.intersection(TOLD_MORE_FULLY.get(diagnostic.code, ()))]
    return replace(fit, diagnostics=(*fit.diagnostics, *added))


def _naming(fit: Fit, diagnostic: Diagnostic) -> Diagnostic:
    """Return a diagnostic with the names of all parameters that trade places where it holds."""
    variables = {**fit.plant.component.variables, **fit.friction.component.variables}
    names = tuple(
        estimate.name
        for estimate in fit.estimates
        # A fit with elements has further parameters than its models ask for.
        if estimate.name in variables
        and _trades(variables[estimate.name], diagnostic.code)
        and (estimate.status != "held" or (estimate.reason is not None and estimate.reason.code in BY_THE_LOG))
    )
    return replace(diagnostic, numbers={**diagnostic.numbers, "names": names}) if names else diagnostic


def _trades(variable: Variable, code: str) -> bool:
    """Return whether a parameter is one that a log with this finding does not tell apart from others."""
    of_sliding = code == "never_slides" and acts_in_sliding(variable)
    return of_sliding or variable.excitation in TRADED.get(code, ())
