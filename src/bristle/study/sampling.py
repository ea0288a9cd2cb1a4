"""Numbers between 0 and 1 for the draws of a study: each a function of the seed and of the number of its draw alone."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle.core.lazy import cached_property
from bristle.core.random_numbers import SEED_MAX

SAMPLINGS = ("random", "latin_hypercube", "sobol")
PER_COUNT = 4  # numbers that the generator makes of one count
SMALLEST = 2.0**-54  # half the distance of the numbers of the generator, which begin at 0


@dataclass(frozen=True)
class Sampling:
    """How draws fill their space."""

    method: str
    seed: int
    names: tuple[str, ...]
    rows: int
    indices: bool = False

    @property
    def per_row(self) -> int:
        """Draws that one point becomes."""
        return len(self.names) + 2 if self.indices else 1

    @property
    def count(self) -> int:
        """Draws in all."""
        return self.rows * self.per_row

    def numbers(self, first: int, last: int) -> np.ndarray:
        """Return the numbers of the draws from `first` to before `last`, shape (draw, cause)."""
        if not self.indices:
            return self._points(first, last)
        row, width = first // self.per_row, len(self.names)
        pairs = self._points(row, -(-last // self.per_row))
        own, second = pairs[:, :width], pairs[:, width:]
        exchanged = [np.where(np.arange(width) == place, second, own) for place in range(width)]
        draws = np.stack((own, second, *exchanged), axis=1).reshape(-1, width)
        return draws[first - row * self.per_row : last - row * self.per_row]

    def checksum(self) -> str:
        """Return a checksum of what another release of a library might draw otherwise; empty where none draws."""
        return "" if self.method == "random" else hashlib.sha256(self._all.tobytes()).hexdigest()

    @property
    def _dimensions(self) -> tuple[str, ...]:
        return (*self.names, *(f"{name} of the second point" for name in self.names if self.indices))

    def _points(self, first: int, last: int) -> np.ndarray:
        """Return points, random ones from a stream of its own for each seed and name.

        So a further cause leaves the others as they are, and each block of runs draws its own numbers.
        """
        if self.method != "random":
            return self._all[first:last]
        points, begin = np.empty((last - first, len(self._dimensions))), first // PER_COUNT
        for place, name in enumerate(self._dimensions):
            key = int.from_bytes(hashlib.sha256(f"{self.seed} {name}".encode()).digest()[:16], "little")
            generator = np.random.Generator(np.random.Philox(key=key, counter=begin))
            points[:, place] = generator.random(last - begin * PER_COUNT)[first - begin * PER_COUNT :]
        return np.maximum(points, SMALLEST)

    @cached_property
    def _all(self) -> np.ndarray:
        from scipy.stats import qmc

        if not self.names:
            return np.empty((self.rows, 0))
        method = qmc.LatinHypercube if self.method == "latin_hypercube" else qmc.Sobol
        generator: Any = {"seed": np.random.default_rng(self.seed)}  # later releases call it rng, and take both
        points = method(len(self._dimensions), **generator).random(self.rows)
        return np.clip(points, SMALLEST, 1.0 - SMALLEST)


def seed_of_run(seed: int, number: int) -> int:
    """Return the seed of a run: a function of the seed of the study and of the number of the run alone.

    Examples
    --------
    >>> seed_of_run(7, 4711), seed_of_run(7, 4712), seed_of_run(8, 4711)
    (708275689, 1655017973, 360334804)
    """
    letters = hashlib.sha256(f"{seed} {number}".encode()).digest()
    return int.from_bytes(letters[:8], "little") % SEED_MAX
