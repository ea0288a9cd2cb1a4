"""Elastic drives: are antiresonance, resonance and the sum of the masses reported, and rigid axes left alone?

The drives are those of `benchmarks.two_mass`, a simulator that shares no code with bristle. Each drive is simulated twice:
with its spring, and as a rigid axis with the same loop, motion and friction. A third of the drives have play, at which
the apparent antiresonance depends on the amplitude. ``python -m benchmarks.elastic [FIRST COUNT]`` prints the figures.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from typing import Any, NamedTuple

import numpy as np

import bristle as br
from benchmarks.coverage import Share
from benchmarks.two_mass import columns_of, drive_of
from bristle.core.cores import core_count

__all__ = ["Tried", "elastic", "tried"]

FIRST, COUNT = 500, 60
NARROWEST, WIDEST = 92.0, 98.0  # % of the intervals that hold the true value
CLOSE, CLOSE_MASS = 3.0, 1.0  # % of the frequencies, and of the sum of the masses


class Tried(NamedTuple):
    """The report on one drive: its errors [%], the models that bristle suggests, and whether elasticity is named first."""

    reported: bool
    antiresonance: float
    resonance: float
    ratio: float
    mass: float
    suggested: tuple[str, ...]
    first: bool
    play: bool
    inside: tuple[bool, ...]

    @property
    def close(self) -> bool:
        return self.reported and abs(self.antiresonance) < CLOSE and abs(self.resonance) < CLOSE


def tried(seed: int, elastic: bool) -> Tried:
    """Identify one drive from the log of its motor."""
    drive = drive_of(seed, elastic=elastic)
    columns: Any = columns_of(drive)
    axis = br.Axis(resolution=drive.step)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = br.identify(columns, "coulomb_viscous,stribeck", axis=axis, blocks=0, draws=0)
    facts, codes = found.treatment, [item.code for item in found.best.diagnostics]
    pairs = {"antiresonance": drive.antiresonance, "resonance": drive.resonance, "inertia_ratio": drive.load / drive.motor}
    antiresonance, resonance, ratio = (
        100.0 * (facts[name] / truth - 1.0) if "antiresonance" in facts else np.nan for name, truth in pairs.items()
    )
    inside = [abs(facts[name] - truth) < facts[f"{name}_half_width"] for name, truth in pairs.items() if "antiresonance" in facts]
    ends = found.best.parameters["M"].ends
    inside += [ends[0] < drive.total < ends[1]] if inside and ends else []
    suggested = {str(item.numbers.get("model", "")) for item in found.best.diagnostics} - {""}
    mass = 100.0 * (found.best.parameters["M"].value / drive.total - 1.0)
    first = codes[:1] == ["elastic_load"]
    reported, models = "antiresonance" in facts, tuple(sorted(suggested))
    return Tried(reported, antiresonance, resonance, ratio, mass, models, first, drive.gap > 0.0, tuple(inside))


def elastic(first: int = FIRST, count: int = COUNT) -> Iterator[Share]:
    """Yield the rates of detection and the shares of close values."""
    seeds = list(range(first, first + count))
    with ProcessPoolExecutor(core_count()) as pool:
        drives, rigid = (list(pool.map(tried, seeds, [kind] * count)) for kind in (True, False))
    for kind, results in (("elastic", drives), ("rigid", rigid)):
        for seed, one in zip(seeds, results, strict=True):
            print(kind, seed, one, file=sys.stderr)
    play, tight = ([one for one in drives if one.play == has] for has in (True, False))
    reported = [one for one in drives if one.reported]
    yield _share("elastic drive, reported", [one.reported for one in drives], least=95.0)
    yield _share("elastic drive, both frequencies within 3 %", [one.close for one in drives])
    yield _share("the same without play", [one.close for one in tight], least=95.0)
    yield _share("the same with play", [one.close for one in play])
    yield _share("rigid axis, reported as elastic", [one.reported for one in rigid], most=2.0)
    yield _share("reported drive, elasticity first, no pre-sliding model", [one.first and not _cures(one) for one in reported], least=100.0)
    yield _share("true value in the 95 % interval", [part for one in reported for part in one.inside], NARROWEST, WIDEST)
    yield _share("sum of the masses within 1 %", [abs(one.mass) < CLOSE_MASS for one in reported])
    yield _share("the same without play", [abs(one.mass) < CLOSE_MASS for one in reported if not one.play])


def _cures(one: Tried) -> bool:
    return any(name.startswith(("lugre", "dahl", "maxwell", "gms")) for name in one.suggested)


def _share(name: str, holds: list[bool], least: float = 0.0, most: float = 100.0) -> Share:
    return Share(name, 100.0 * float(np.mean(holds)), least, most, len(holds))


if __name__ == "__main__":
    for share in elastic(*map(int, sys.argv[1:])):
        print(share.row())
