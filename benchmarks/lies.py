"""Records that lie, by another hand: each is refused, or told, or what is identified of it still holds.

A parameter is a silent miss where it is called identified, its 95 % interval misses the truth by more than its own
width, and no warning that concerns the lie is among the diagnostics.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from typing import NamedTuple

import bristle as br
from benchmarks.coverage import Share
from benchmarks.strange_logs import MODELS, STROKES, table_of, true_values
from benchmarks.strangers import LIES, make
from bristle.core.cores import core_count
from bristle.core.errors import InputError
from bristle.report.judgement import DOUBTS

__all__ = ["Outcome", "judged", "lies"]

LOGS, DRAWS = 8, 30


class Outcome(NamedTuple):
    """What became of a record: why it was refused, codes of its warnings, parameters that miss in silence."""

    refused: str
    codes: tuple[str, ...]
    missed: tuple[str, ...]

    @property
    def well(self) -> bool:
        return bool(self.refused) or bool(set(DOUBTS).intersection(self.codes)) or not self.missed


def judged(name: str, seed: int) -> Outcome:
    """Identify a record with one lie; nothing is told but whether the axis turns, and a mass where that is the lie."""
    family = list(MODELS)[seed % 2]
    honest, record = make(seed, family, STROKES[seed % len(STROKES)])
    lied = LIES[name](honest, record, seed)
    truth = lied.truth
    table = table_of(truth, lied.record)
    if name == "velocity_scale" and lied.record.velocity is not None:
        table["velocity"] = lied.record.velocity
    axis = br.Axis(
        kind="translational" if truth.axis.linear else "rotational", mass=lied.claimed_mass
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            found = br.identify(table, MODELS[family], axis=axis, blocks=0, draws=DRAWS)
        except InputError as error:
            return Outcome(str(error), (), ())
    missed, known = [], true_values(truth, record)
    for parameter, estimate in found.parameters.items():
        if estimate.status == "identified" and estimate.interval is not None and parameter in known:
            low, high = estimate.interval
            if max(low - known[parameter], known[parameter] - high) > high - low:
                missed.append(parameter)
    codes = tuple(one.code for one in found.best.diagnostics if one.severity != "note")
    return Outcome("", codes, tuple(missed))


def lies() -> Iterator[Share]:
    """Share of records of each lie that are refused, told, or held."""
    names = [name for name in LIES for _ in range(LOGS)]
    with ProcessPoolExecutor(core_count()) as pool:
        found = list(pool.map(judged, names, [*range(LOGS)] * len(LIES)))
    for name in LIES:
        outcomes = [one for lie, one in zip(names, found, strict=True) if lie == name]
        told = sum(bool(set(DOUBTS).intersection(one.codes)) for one in outcomes)
        remark = f"{sum(bool(one.refused) for one in outcomes)} refused, {told} reported"
        yield Share(
            name, 100.0 * sum(one.well for one in outcomes) / LOGS, 100.0, 100.0, LOGS, remark
        )
