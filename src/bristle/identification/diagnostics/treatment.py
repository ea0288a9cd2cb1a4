"""How the log was treated: what the numbers of a fit rest on."""

from __future__ import annotations

from bristle.core.diagnostic import Diagnostic
from bristle.identification.dataset import Regression

__all__ = ["about_treatment"]


def about_treatment(regression: Regression) -> tuple[Diagnostic, ...]:
    """Return what was done to a log before a model was fitted to it."""
    found = [
        Diagnostic("filtered", severity="note", numbers={
            "cutoff": regression.cutoff, "dropped": regression.dropped, "decimation": regression.decimation,
        })
    ]  # fmt: skip
    if regression.delay:
        samples = regression.delay / regression.sample_time
        found.append(
            Diagnostic("delay-found", severity="note", numbers={"delay": regression.delay, "samples": samples})
        )
    if regression.rest_share > 0.0 and not regression.keeps_rests:
        found.append(Diagnostic("rests-left-out", severity="note", numbers={"percent": 100.0 * regression.rest_share}))
    return (*found, Diagnostic("standard-errors", severity="note"))
