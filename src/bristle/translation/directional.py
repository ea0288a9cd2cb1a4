"""Tangents in one direction, for other targets: kernels of numbers with the names of `bristle.core.tangent`."""

from bristle.core.kernel import kernel


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


DIRECTIONAL = keep_tangent, still, tangent_at, tangent_combined, tangent_difference, tangent_scaled, tangent_sum
