"""How the log was treated: what the numbers of a fit rest on."""

from __future__ import annotations

from bristle.core.diagnostic import Diagnostic
from bristle.identification.dataset import Dataset

__all__ = ["about_treatment"]


def about_treatment(dataset: Dataset) -> tuple[Diagnostic, ...]:
    """Return what was done to a log before a model was fitted to it."""
    remarks = [
        Diagnostic("filtered", severity="note", numbers={
            "cutoff": dataset.cutoff, "dropped": dataset.dropped, "decimation": dataset.decimation,
        })
    ]  # fmt: skip
    if dataset.delay:
        samples = dataset.delay / dataset.sample_time
        remarks.append(Diagnostic("delay-found", severity="note", numbers={"delay": dataset.delay, "samples": samples}))
    if dataset.rest_share > 0.0 and not dataset.keeps_rests:
        remarks.append(Diagnostic("rests-left-out", severity="note", numbers={"percent": 100.0 * dataset.rest_share}))
    return (*remarks, Diagnostic("standard-errors", severity="note"))
