"""Paths of an input, and the operators that they are run through."""

from itertools import pairwise

import numpy as np

from bristle import hysteresis
from bristle.models.hysteresis.everett import KERNELS

MASING = ("dahl_masing", "tip_masing", "exp_masing")


def of(kernel, **values):
    """The operator with stiffness and saturation 1."""
    return hysteresis.preisach(kernel=kernel, s=1.0, f_p=1.0, **values)


def along(turns, count=50):
    """A path through these inputs, `count` steps between neighbours, denser after each turn; exactly at the turns."""
    share = np.linspace(0.0, 1.0, count + 1)[1:] ** 2
    pieces = [a + (b - a) * share for a, b in pairwise(turns)]
    path = np.concatenate([[turns[0]], *pieces])
    path[::count] = turns
    return path


def walk(seed, count=2000, amplitude=4.0):
    """A random walk from 0 within this amplitude."""
    path = np.cumsum(np.random.default_rng(seed).standard_normal(count))
    return path * (amplitude / np.max(np.abs(path)))


OPERATORS = {name: item(**item.example) for name, item in hysteresis.OPERATORS.items()} | {
    f"preisach {kernel}": of(kernel) for kernel in KERNELS
}


def sized(operator, path):
    """The path in the size that the example of an operator is made for."""
    p = operator.parameters
    if operator.component.input == "force":
        return path * (0.2 * p.f_p if hasattr(p, "f_p") else 5.0)
    if hasattr(p, "f_p"):
        return path * p.f_p / p.s
    return path * 2.5e-6
