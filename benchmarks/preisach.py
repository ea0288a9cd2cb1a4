"""The Preisach operator against the same algorithm in C and against a grid of relays, as it is usually written."""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.timing import Ratio, side_by_side

SOURCE = Path(__file__).with_name("preisach.c")
COUNT = 1_000_000
GRID, GRID_SAMPLES = 100, 2_000
# Of the walk through the relays, in f_p/s: in pre-sliding, and into saturation.
AMPLITUDES = (0.5, 5.0)


class _Parameters(ctypes.Structure):
    _fields_ = (
        ("s", ctypes.c_double),
        ("f_p", ctypes.c_double),
        ("kernel", ctypes.c_long),
        ("tolerance", ctypes.c_double),
    )


def preisach() -> Iterator[Ratio]:
    """Time the Preisach operator on random walks."""
    from bristle import hysteresis, response

    walk = np.cumsum(np.random.default_rng(5).standard_normal(COUNT))
    walk *= 5.0 / np.max(np.abs(walk))
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "preisach.so"
        subprocess.run(
            ["gcc", "-O3", "-shared", "-fPIC", "-o", str(library), str(SOURCE), "-lm"], check=True
        )
        run = ctypes.CDLL(str(library)).preisach_run
        for kernel in ("dahl_masing", "reformed_dahl_exact"):
            operator = hysteresis.preisach(kernel=kernel, s=1.0, f_p=1.0)
            in_c, output = _in_c(run, operator.parameters, walk)
            ours, theirs, ratio = side_by_side(
                lambda operator=operator: response(operator, walk), in_c, 15
            )
            difference = np.max(np.abs(response(operator, walk) - output))
            yield Ratio(
                f"Preisach, {kernel}",
                ours / COUNT,
                theirs / COUNT,
                ratio,
                1.05,
                "the same algorithm in C, gcc -O3",
                f"largest difference {difference:.1e} f_p",
            )
    for amplitude in AMPLITUDES:
        yield _against_relays(walk, amplitude)


def _in_c(run: Any, p: Any, walk: np.ndarray) -> tuple[Any, np.ndarray]:
    parameters = _Parameters(p.s, p.f_p, p.kernel, p.tolerance)
    z, f, output = np.empty(p.capacity), np.empty(p.capacity), np.empty(walk.size)
    pointers = [one.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for one in (z, f, walk, output)]

    def in_c() -> None:
        lost = run(
            ctypes.byref(parameters),
            pointers[0],
            pointers[1],
            ctypes.c_long(p.capacity),
            pointers[2],
            pointers[3],
            ctypes.c_size_t(walk.size),
        )
        assert lost == 0

    return in_c, output


def _against_relays(walk: np.ndarray, amplitude: float) -> Ratio:
    from bristle import hysteresis, response

    operator = hysteresis.preisach(kernel="dahl_masing", s=1.0, f_p=1.0)
    part = walk[:GRID_SAMPLES] * amplitude / np.max(np.abs(walk[:GRID_SAMPLES]))
    grid = hysteresis.relays_of(operator, amplitude, GRID)
    switch = 0.5 * (grid.parameters.levels[1:] + grid.parameters.levels[:-1])
    i, j = np.tril_indices(GRID)
    alpha, beta, weights = switch[i], switch[j], grid.parameters.weights
    virgin = grid.component.new_memory(grid.parameters)

    def in_numpy() -> np.ndarray:
        relays, out = virgin.copy(), np.empty(part.size)
        for k, u in enumerate(part):
            relays[alpha <= u] = 1.0
            relays[(beta >= u) & (alpha > u)] = -1.0
            out[k] = weights @ relays
        return out

    many = np.tile(part, COUNT // GRID_SAMPLES)
    ours, theirs, ratio = side_by_side(lambda: response(operator, many), in_numpy, 5)
    exact = response(operator, part)
    error = np.sqrt(np.mean((in_numpy() - exact) ** 2))
    scale = GRID_SAMPLES / many.size
    return Ratio(
        f"Preisach, walk to {amplitude:g} f_p/s",
        ours / many.size,
        theirs / GRID_SAMPLES,
        ratio * scale,
        1.0 / 500.0,
        f"relays in numpy, N = {GRID}",
        f"the grid errs by {100.0 * error:.2f} % of f_p (rms)",
    )
