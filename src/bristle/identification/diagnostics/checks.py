"""What the log says against itself before anything is fitted, beside a fit: which of its parameters that concerns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from bristle.core.axis import Axis
from bristle.core.diagnostic import Diagnostic
from bristle.identification.parameters import PriorKnowledge
from bristle.identification.result import Fit
from bristle.identification.roles import Role, names_of
from bristle.identification.settings import Settings
from bristle.logs.check import checked
from bristle.logs.log import Log

__all__ = ["checks_of", "with_checks"]

TRADED = {
    "one_speed": ("sliding", "speed", "stribeck"),
    "one_direction": ("sliding", "stribeck"),
    "level_drifts": ("sliding", "speed", "stribeck"),
    "never_slides": ("acceleration", "sliding", "speed", "stribeck"),
}
"""By code, what it takes to tell the parameters that trade places in such a log."""
BY_THE_LOG = ("held-one-direction", "held-one-speed")
"""Why a parameter is held that such a log does not tell."""
SAID = {"repeats_one_motion": ("motion-repeats", "one-amplitude")}
"""Codes of a fit that say the same with more."""


def checks_of(
    pairs: Sequence[tuple[Log, Axis | None]], prior: PriorKnowledge, settings: Settings
) -> tuple[Diagnostic, ...]:  # fmt: skip
    """Return what the logs of an identification say before it, of each code the first."""
    found: dict[str, Diagnostic] = {}
    mass = sum(prior.values[name] for name in names_of(Role.INERTIA, prior.plant.variables) if name in prior.values)
    for log, axis in pairs:
        known = replace(axis or Axis(kind=log.kind), mass=mass or None)
        for diagnostic in checked(log, known, settings):
            found.setdefault(diagnostic.code, diagnostic)
    return tuple(found.values())


def with_checks(fit: Fit, found: Sequence[Diagnostic]) -> Fit:
    """Return a fit with what its logs say against themselves, and which of its parameters that concerns."""
    said = {diagnostic.code for diagnostic in fit.diagnostics}
    told = [_naming(fit, one) for one in found if not said.intersection(SAID.get(one.code, ()))]
    return replace(fit, diagnostics=(*fit.diagnostics, *told))


def _naming(fit: Fit, found: Diagnostic) -> Diagnostic:
    """Return a diagnostic with the names of all parameters that trade places where it holds."""
    variables = {**fit.plant.component.variables, **fit.friction.component.variables}
    names = tuple(
        one.name
        for one in fit.estimates
        # A fit with elements has further parameters than its models ask for.
        if one.name in variables
        and variables[one.name].excitation in TRADED.get(found.code, ())
        and (one.status != "held" or (one.reason is not None and one.reason.code in BY_THE_LOG))
    )
    return replace(found, numbers={**found.numbers, "names": names}) if names else found
