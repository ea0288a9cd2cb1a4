"""The certificates of a model as a table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from bristle.core.typography import with_unit
from bristle.report.table import Table

if TYPE_CHECKING:
    from bristle.certificates import Certificate

__all__ = ["certificate_table"]

VERDICTS = {True: "passed", False: "FAILED", None: "does not apply"}


USES = {
    "well_posed": "every use",
    "passive": "a simulation that must not gain energy, friction fed forward along the measured motion",
    "drift": "a simulation of an axis that holds a load",
    "closure": "a simulation of small motions inside large ones",
    "dissipation": "a simulation that must not gain energy, friction fed forward along the measured motion",
}
"""What a certificate is asked for; a feedforward along the desired motion needs a well-posed model, no more."""


def certificate_table(name: str, certificates: Mapping[str, Certificate]) -> Table:
    """Return whether a model is fit to be used, question by question, and what would make it so."""
    rows = [
        (
            key,
            VERDICTS[certificate.passed],
            _text(certificate.value, certificate.unit),
            _text(certificate.threshold, certificate.unit),
            certificate.advice,
            USES[key],
        )
        for key, certificate in certificates.items()
    ]
    heads = ("Certificate", "Verdict", "Found", "Limit", "What it means, what to do", "Matters for")
    return Table(f"Is it fit to be used: {name}", heads, rows)


def _text(value: float | None, unit: str) -> str:
    return "" if value is None else with_unit(value, unit)
