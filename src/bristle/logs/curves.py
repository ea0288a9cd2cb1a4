"""`Curves`: recorded hysteresis, output over input, along one path or several with the same start."""

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bristle.core.content import NOWHERE, Origin
from bristle.core.edge import CURVE, TEXT, among, guarded, instance, many, taken
from bristle.core.lazy import cached_property
from bristle.core.variable import KINDS, Kind


class Curve(NamedTuple):
    """Samples of the input along one path, and of the output.

    Parameters
    ----------
    u, f : ndarray, shape (sample,)
        Input `u` and output `f`, in SI units.
    """

    u: np.ndarray
    f: np.ndarray


@guarded()
@dataclass(frozen=True, eq=False)
class Curves:
    """Recorded hysteresis, without time: only the order of the samples counts.

    Parameters
    ----------
    curves : tuple of Curve
        The curves; before each, the hysteresis is in the state `start`.
    start : {"virgin", "saturated"}
        State before each curve. ``virgin``: without memory. ``saturated``: saturated at the end of the range towards which
        the curve moves, so that its first sample lies on the major branch.
    kind : {"translational", "rotational", "magnetic", "piezo"}
        Input and output are displacement and force, angle and torque, or field and moment.
    source : Path
        The file.
    origin : Origin
        Name and SHA-256 of the file, and the table in it.
    notes : tuple of str
        Notes on samples that bristle left out.
    name : str
        Name in the file that describes the curves.
    """

    curves: tuple[Curve, ...] = taken(
        many(lambda pair, path, kind: Curve(*CURVE(pair, path, kind)), least=1)
    )
    start: str = taken(among("virgin", "saturated"), "virgin")
    kind: Kind = taken(among(*KINDS, "magnetic", "piezo"), "translational")
    source: Path = taken(instance(Path, "a path", read=Path), Path())
    origin: Origin = taken(instance(Origin, "an Origin"), NOWHERE)
    notes: tuple[str, ...] = taken(many(TEXT), ())
    name: str = taken(TEXT, "hysteresis")

    @cached_property
    def full_scale(self) -> float:
        """Largest output of all curves."""
        return max(float(np.max(np.abs(curve.f))) for curve in self.curves)

    @cached_property
    def low(self) -> float:
        """Smallest input of all curves."""
        return min(float(np.min(curve.u)) for curve in self.curves)

    @cached_property
    def high(self) -> float:
        """Largest input of all curves."""
        return max(float(np.max(curve.u)) for curve in self.curves)

    def history(self, curve: Curve) -> np.ndarray:
        """Return the inputs of the operator before a curve, from its virgin state."""
        if self.start == "virgin":
            return np.empty(0)
        far = 10.0 * max(abs(self.low), abs(self.high))  # times the largest input of the record
        return np.array([far if curve.u[-1] >= curve.u[0] else -far])
