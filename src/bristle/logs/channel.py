"""`Channel`: one recorded signal, with its unit and the column it came from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from bristle.core.axis import CHANNELS
from bristle.core.edge import TEXT, Converter, array, guarded
from bristle.core.tabular import ranged
from bristle.core.variable import KINDS, Kind, unit_of

__all__ = ["CHANNELS", "Channel", "channel", "clear_step", "quantisation"]


ROUNDING = 1e-12  # of the largest value: less is no step
FEW_STEPS = 20  # between samples that differ: half of them are no farther apart where steps are clear
OFF_STEP = 0.01  # of a step: how far a multiple of it may be off


def quantisation(values: np.ndarray) -> float:
    """Return the smallest difference between two values that differ, zero if none do."""
    steps = np.diff(np.unique(values))
    steps = steps[steps > ROUNDING * np.max(np.abs(values), initial=0.0)]
    return float(steps.min()) if steps.size else 0.0


def clear_step(values: np.ndarray, *, most: float = FEW_STEPS) -> float:
    """Return the step that all values are multiples of, where few lie between samples; 0 where there is none."""
    finite = np.asarray(values, dtype=float)[np.isfinite(values)]
    step = quantisation(finite)
    if not step:
        return 0.0
    multiples = (finite - finite.min()) / step
    moves = np.abs(np.diff(multiples))
    is_clear = np.median(moves[moves > OFF_STEP]) <= most
    return step if is_clear and np.max(np.abs(multiples - np.round(multiples))) < OFF_STEP else 0.0


COLUMN = array(finite=False)  # what a file holds is looked at, and its place told, before it becomes a log


@guarded(values=COLUMN, unit=TEXT, column=TEXT)
@dataclass(frozen=True, eq=False)
class Channel(NDArrayOperatorsMixin):
    """One recorded signal; to numpy, to plots and in calculations it is the array of its samples.

    Parameters
    ----------
    values : ndarray, shape (sample_count,)
        The samples, read-only, in `unit`.
    unit : str
        SI of the kind of axis.
    column : str
        Name of the column in the file.
    recorded_step : float, optional
        The smallest difference between two samples that differ, as they were recorded, where `values` are others: of
        samples between them it says nothing.
    """

    values: np.ndarray
    unit: str
    column: str
    recorded_step: float | None = None

    def __post_init__(self) -> None:
        values = np.array(self.values, dtype=float)
        values.flags.writeable = False
        object.__setattr__(self, "values", values)

    @property
    def step(self) -> float:
        """The smallest difference between two samples that differ, which is that of an encoder; 0 where none do."""
        return quantisation(self.values) if self.recorded_step is None else self.recorded_step

    # Two channels are one or not; what their samples are is asked of `values`.
    def __eq__(self, channel: object) -> bool:
        return self is channel

    def __ne__(self, channel: object) -> bool:
        return self is not channel

    def __hash__(self) -> int:
        return id(self)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return np.array(self.values, dtype=dtype) if copy else np.asarray(self.values, dtype=dtype)

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **arguments: Any) -> Any:
        plain = (operand.values if isinstance(operand, Channel) else operand for operand in inputs)
        return getattr(ufunc, method)(*plain, **arguments)

    def __len__(self) -> int:
        return self.values.size

    def __getitem__(self, place: Any) -> Any:
        return self.values[place]

    def __iter__(self) -> Iterator[float]:
        return iter(self.values)

    def __repr__(self) -> str:
        return f"Channel({len(self)} samples, {ranged(self.values, self.unit)}, column {self.column!r})"


def channel(name: str) -> Converter:
    """Return what takes a `Channel`, or the numbers of one in SI of the kind of axis."""

    def convert(value: Any, path: str, kind: Kind | None) -> Channel:
        unit = unit_of(CHANNELS[name], kind or KINDS[0])
        candidate = value if isinstance(value, Channel) else Channel(COLUMN(value, path, kind), unit, name)
        array()(candidate.values, path, kind)
        return candidate

    return convert
