"""Which friction models a test runs among the fast ones: those it names, and every model that is new."""

import pytest

from bristle import friction

KNOWN = frozenset(
    [
        "coulomb",
        "viscous",
        "coulomb_viscous",
        "stribeck",
        "stribeck_free",
        "dahl",
        "reformed_dahl",
        "bouc_wen",
        "bouc_wen_classic",
        "lugre",
        "elastoplastic",
        "maxwell_slip",
        "maxwell_stribeck",
        "gms",
        "gap_slider",
        "preisach_contact",
        "preisach_lugre",
        "leuven",
        "efficiency",
    ]
)
"""Models that were slow-tested before: all others run among the fast tests until they are named here."""


def with_fast(*fast, form="{}", unfit=()):
    """Return the names of all models but the unfit, in this form; known models that are not `fast` are marked slow."""
    return [
        pytest.param(
            form.format(name), marks=[pytest.mark.slow] * (name in KNOWN and name not in fast)
        )
        for name in friction.MODELS
        if name not in unfit
    ]
