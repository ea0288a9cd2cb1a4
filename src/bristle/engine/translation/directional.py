"""Tangents in one direction, for other targets: kernels of numbers with the names of `bristle.core.tangent`."""

import math
from collections.abc import Sequence

from bristle.core.kernel import kernel
from bristle.engine.translation.build import Builder
from bristle.engine.translation.derivative import (
    Activity,
    Derivatives,
    Derived,
    is_active,
    type_of_tangent,
)
from bristle.engine.translation.tree import Function


@kernel
def still():
    """Return the tangent of a constant."""
    return 0.0


@kernel
def tangent_sum(a, b):
    """Return the sum of two tangents."""
    return a + b


@kernel
def tangent_difference(a, b):
    """Return the difference of two tangents."""
    return a - b


@kernel
def tangent_scaled(a, b):
    """Return a tangent times a number `a`."""
    return a * b


@kernel
def tangent_combined(a, b, c, d):
    """Return `a` times one tangent and `c` times another."""
    return a * b + c * d


@kernel
def tangent_at(a, b):
    """Return the tangent of number `b` of an array of tangents."""
    return a[b]


@kernel
def keep_tangent(a, b, c):
    """Store a tangent for number `b` in an array of tangents."""
    a[b] = c


DIRECTIONAL = (
    keep_tangent,
    still,
    tangent_at,
    tangent_combined,
    tangent_difference,
    tangent_scaled,
    tangent_sum,
)


def derived_in(
    builder: Builder, function: Function, entering: Sequence[Activity]
) -> tuple[Derived, Function]:
    """Return a function with its tangent in one direction, for arguments of these activities, also as a function of the tree."""
    derivatives = Derivatives(
        scope={"__name__": "derived", "math": math} | {rule.__name__: rule for rule in DIRECTIONAL},
        portable=True,
    )
    derived, types = (
        derivatives.of(function, entering),
        [parameter.type for parameter in function.parameters],
    )
    tangents = [
        type_of_tangent(kind, part)
        for kind, part in zip(types, entering, strict=True)
        if is_active(part)
    ]
    return derived, builder.function(derivatives.scope[derived.name], [*types, *tangents])
