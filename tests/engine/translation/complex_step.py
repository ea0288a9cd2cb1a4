r"""Derivatives of kernels by complex steps, as plain Python runs them: nothing here knows the tree.

.. math:: \frac{\partial g}{\partial x} = \frac{\operatorname{Im} g(x + \mathrm{i} h)}{h}

exactly to rounding, for h so small that products of imaginary parts underflow and the real part keeps its bits (W. Squire,
G. Trapp, SIAM Review 40(1), 1998, doi:10.1137/S003614459631241X). A question looks at the real part. One number carries
the imaginary parts of many runs side by side, one for each direction.
"""

import math
import operator
from contextlib import contextmanager
from unittest.mock import patch

import numpy as np

from bristle.core.dispatch import friction_commit, friction_trial
from bristle.core.mathematics import ROUNDER
from bristle.core.packing import pack
from bristle.core.surroundings import motion_with

STEP = 2.0**-650  # the square of it underflows


class Complex:
    """A real number and the imaginary parts of it in each direction."""

    __slots__ = ("imaginary", "real")
    __array_ufunc__ = None
    __hash__ = None  # pyright: ignore[reportAssignmentType]

    def __init__(self, real, imaginary):
        self.real, self.imaginary = float(real), imaginary

    def __add__(self, other):
        if not isinstance(other, Complex) and other == ROUNDER:
            return self.real + other  # the sum is a whole number: it has no derivative
        return Complex(self.real + real_of(other), self.imaginary + imaginary_of(other))

    __radd__ = __add__

    def __sub__(self, other):
        return Complex(self.real - real_of(other), self.imaginary - imaginary_of(other))

    def __rsub__(self, other):
        return Complex(other - self.real, -self.imaginary)

    def __mul__(self, other):
        if isinstance(other, Complex):
            return Complex(
                self.real * other.real, self.imaginary * other.real + other.imaginary * self.real
            )
        return Complex(self.real * other, self.imaginary * other)

    __rmul__ = __mul__

    def __truediv__(self, other):
        quotient = self.real / real_of(other)
        return Complex(quotient, (self.imaginary - imaginary_of(other) * quotient) / real_of(other))

    def __rtruediv__(self, other):
        quotient = other / self.real
        return Complex(quotient, -self.imaginary * quotient / self.real)

    def __neg__(self):
        return Complex(-self.real, -self.imaginary)

    def __pos__(self):
        return self

    def __abs__(self):
        return -self if math.copysign(1.0, self.real) < 0.0 else self

    def __bool__(self):
        return self.real != 0.0

    def __int__(self):
        return int(self.real)

    def __floor__(self):
        return math.floor(self.real)

    def __float__(self):
        raise TypeError("a conversion would lose the imaginary part")


def compared(operation):
    """Return a question, which looks at the real parts."""
    return lambda one, other: operation(one.real, real_of(other))


for name in ("lt", "le", "gt", "ge", "eq", "ne"):
    setattr(Complex, f"__{name}__", compared(getattr(operator, name)))


def real_of(number):
    return number.real if isinstance(number, Complex) else number


def imaginary_of(number):
    return number.imaginary if isinstance(number, Complex) else 0.0


SQRT, COPYSIGN, FREXP = math.sqrt, math.copysign, math.frexp


def root(x):
    """Return the square root; that of 0 has no derivative and stands still."""
    if not isinstance(x, Complex):
        return SQRT(x)
    value = SQRT(x.real)
    return Complex(value, x.imaginary * (0.5 / value if value else 0.0))


def signed(x, sign):
    size = abs(x)
    return -size if COPYSIGN(1.0, real_of(sign)) < 0.0 else size


def parts(x):
    if not isinstance(x, Complex):
        return FREXP(x)
    share, power = FREXP(x.real)
    return Complex(share, x.imaginary * 0.5**power), power


@contextmanager
def complex_mathematics():
    """Let the functions of `math` that kernels call take complex numbers."""
    functions = {
        "sqrt": root,
        "copysign": signed,
        "frexp": parts,
        "fabs": abs,
        "isinf": lambda x, real=math.isinf: real(real_of(x)),
        "isnan": lambda x, real=math.isnan: real(real_of(x)),
    }
    with patch.multiple(math, **functions):
        yield


def seeded(value, tangents):
    """Return a NamedTuple whose real numbers carry imaginary parts: the rows of `tangents`, as `pack` lays them out."""
    return _seeded(value, iter(tangents))


def _seeded(value, rows):
    fields = []
    for field in value:
        if hasattr(field, "_fields"):
            fields.append(_seeded(field, rows))
        elif isinstance(field, np.ndarray):
            next(rows)
            fields.append(
                np.array([number(x, next(rows)) for x in field] + [None], dtype=object)[:-1]
            )
        else:
            fields.append(number(field, next(rows)))
    return type(value)(*fields)


def number(real, direction):
    is_whole = isinstance(real, (int, np.integer)) or not math.isfinite(real)
    return real if is_whole else Complex(real, direction * STEP)


def slopes_of(function, *arguments):
    """Return the value of a kernel of real numbers and its derivatives to all of them."""
    rows = np.eye(len(arguments))
    with complex_mathematics():
        value = function(*(Complex(x, row * STEP) for x, row in zip(arguments, rows, strict=True)))
    return real_of(value), imaginary_of(value) / STEP + np.zeros(len(arguments))


def force_by_complex_steps(
    model, tangents, v, dt, x, *, state=None, state_tangents=None, motion_tangents=None, around=None
):
    """Return what `bristle.engine.derivatives.force_with_derivatives` does, from the plain kernels."""
    p, count = model.parameters, tangents.shape[1]
    state = model.component.initial_state(p) if state is None else state
    if state_tangents is not None:
        state = seeded(state, state_tangents)
    memory = model.component.new_memory(p).astype(object)
    p = seeded(p, tangents)
    signals = around or {}
    motion = motion_with(model.component.surroundings)
    force, derivatives = np.empty(len(v)), np.zeros((len(v), count))
    with complex_mathematics():
        for k in range(len(v)):
            velocity, position = float(v[k]), float(x[k])
            if motion_tangents is not None:
                velocity, position = (
                    number(*pair)
                    for pair in zip(
                        (velocity, position), (d[k] for d in motion_tangents), strict=True
                    )
                )
            moved = motion(
                velocity, position, **{name: float(signal[k]) for name, signal in signals.items()}
            )
            effort, move = friction_trial(state, memory, moved, dt, p)
            state = friction_commit(state, memory, move, p)
            force[k], derivatives[k] = real_of(effort), imaginary_of(effort) / STEP
    return force, derivatives


def directions_of(model):
    """Return one direction for each packed parameter that is a finite number, and its place among those."""
    rows = np.eye(pack(model.parameters).size)
    return rows[:, pack(_marked(model.parameters, 2.0)) != pack(_marked(model.parameters, 1.0))]


def _marked(value, mark):
    """Return a NamedTuple with a mark for each finite real number, and nothing for the rest."""
    if hasattr(value, "_fields"):
        return type(value)(*(_marked(field, mark) for field in value))
    if isinstance(value, np.ndarray):
        return np.full(value.size, mark)
    is_whole = isinstance(value, (int, np.integer)) or not math.isfinite(value)
    return 0.0 if is_whole else mark
