"""The rows of an identification for a page: the motion along which its model is led, and what makes a row of forces.

A model is led along the motion by its module, in intervals of some samples of the log, each of one direction; around a
turn every sample is one. The mean force of each counts. Filters of the identification make a row of the forces around
it, and the plant adds what it takes there. All of it is whole numbers, times a step that is small beside what the model
leaves over.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from bristle.core.axis import Axis
from bristle.engine.contact import state_at
from bristle.exports.cycle import STATE
from bristle.identification.dataset import Dataset, Segment
from bristle.identification.result import Fit
from bristle.lab.packing import differences, packed_numbers
from bristle.lab.replay import turns_of
from bristle.logs.log import Log
from bristle.prediction.predict import rows_as_fitted
from bristle.simulation.result import relative_error_percent

__all__ = ["MOST_INTERVALS", "MOST_ROWS", "Column", "FittedRows", "Stretch", "fitted_rows"]

MOST_INTERVALS, MOST_ROWS = 30_000, 12_000
"""Intervals of the motion and rows that a page carries at most."""
FINE = 2**20  # steps in the longest way of an interval
STEPS = 64.0  # steps in the root mean square of what the model leaves over
TURNS = 0.5  # share of the intervals that are around turns at most
AROUND_TURN = 0.9  # share of the response of the filters that is looked at sample by sample around a turn
TAIL = 1e-4  # share of the response of the filters that is left out on either side
NEGLIGIBLE = 1e-6  # of the largest effort, for what is linear in a parameter
CHANGE = 0.1  # of a parameter, by which that is looked at


class Stretch(NamedTuple):
    """A motion without a gap.

    Its samples are counted from 0 at `time` [s]. Intervals end at `ends`, where the contact has come to `positions`,
    in steps from `origin` [m or rad] on; `rows` are at samples. What lasts of a contact begins as `begin` says, (place,
    number), where it is not virgin.
    """

    origin: float
    time: float
    ends: np.ndarray
    positions: np.ndarray
    rows: np.ndarray
    begin: list[tuple[int, float]]


class Column(NamedTuple):
    """A signal over the rows, for one of which a parameter of the plant counts: whole numbers times a step."""

    name: str
    step: float
    numbers: np.ndarray


class FittedRows(NamedTuple):
    """The rows of a log that a model was fitted to."""

    sample_time: float
    step: float
    response: np.ndarray
    stretches: list[Stretch]
    measured: Column
    mechanical: list[Column]
    rms: float
    percent: float

    def as_data(self) -> dict[str, Any]:
        """Return them as a page unpacks them."""
        parts: list[np.ndarray] = []
        for stretch in self.stretches:
            parts += [differences(column, times) for column, times in ((stretch.ends, 2), (stretch.positions, 2), (stretch.rows, 2))]
        parts += [differences(column.numbers, 1) for column in (self.measured, *self.mechanical)]
        return {
            "numbers": packed_numbers(parts),
            "sampleTime": self.sample_time,
            "step": self.step,
            "response": [round(float(share), 6) for share in self.response],
            "stretches": [
                {
                    "origin": stretch.origin,
                    "time": stretch.time,
                    "begin": stretch.begin,
                    "intervals": stretch.ends.size,
                    "rows": stretch.rows.size,
                }
                for stretch in self.stretches
            ],
            "measured": self.measured.step,
            "rms": self.rms,
            "percent": self.percent,
            "mechanical": [{"name": column.name, "step": column.step} for column in self.mechanical],
        }


def fitted_rows(fit: Fit, log: Log, axis: Axis | None, treatment: Mapping[str, Any]) -> FittedRows | None:
    """Return the rows of a log that a model was fitted to; None where its module cannot be led along them."""
    if any(surrounding.field != "x" for surrounding in fit.friction.component.surroundings):
        return None
    dataset = rows_as_fitted(log, axis, treatment, _integer(treatment.get("decimation")))
    traces, count = fit.traces, dataset.time.size
    # A person's own treatment, or another version's, is not repeated by halves.
    if not np.array_equal(dataset.time, traces.time[:count]):
        return None
    spacing = math.ceil(count / MOST_ROWS)
    selection = _chosen_rows(dataset, spacing)
    response = _summed(dataset.response)
    stretches, step = _stretches(dataset, fit, selection, response)
    chosen = np.concatenate(selection)
    residual, measured = traces.residual[:count], traces.measured[:count]
    rms = float(np.sqrt(np.mean(residual**2)))
    finest = rms / STEPS or NEGLIGIBLE * float(np.max(np.abs(measured)))
    return FittedRows(
        dataset.sample_time,
        step,
        response,
        stretches,
        _column("", measured[chosen], finest),
        _mechanical(dataset, fit, chosen, finest),
        rms,
        relative_error_percent(measured, measured - residual),
    )


def _integer(number: float | None) -> int | None:
    return None if number is None else int(number)


def _chosen_rows(dataset: Dataset, spacing: int) -> list[np.ndarray]:
    """Return which rows of each segment are shown: one of so many decimated samples, where it is a row."""
    segment, sample = dataset.segment_of_row, dataset.sampled([np.arange(s.time.size) for s in dataset.segments])
    thinned = (sample - dataset.dropped) // dataset.decimation
    return [np.flatnonzero((segment == i) & (thinned % spacing == 0)) for i in range(len(dataset.segments))]


def _summed(response: np.ndarray) -> np.ndarray:
    """Return the response of the filters summed up from its first sample on, without its tails."""
    summed, middle = np.cumsum(response), response.size // 2
    left = np.flatnonzero(np.abs(summed[:middle]) > TAIL)
    reach = middle - int(left[0]) if left.size else 0
    return summed[middle - reach : middle + reach + 1]


def _stretches(dataset: Dataset, fit: Fit, selection: Sequence[np.ndarray], response: np.ndarray) -> tuple[list[Stretch], float]:
    """Return the motion of each segment, and the step of its positions."""
    runs = [_run(segment, dataset.sample_time) for segment in dataset.segments]
    samples = dataset.sampled([np.arange(segment.time.size) for segment in dataset.segments])
    middle = response.size // 2
    near = int(np.searchsorted(response[middle:], AROUND_TURN))
    ends = _ends(runs, near)
    step = max(float(np.max(np.abs(np.diff(run[end])), initial=0.0)) for run, end in zip(runs, ends, strict=True))
    step = (step or 1.0) / FINE
    stretches = []
    for segment, run, end, rows, contact in zip(
        dataset.segments, runs, ends, selection, dataset.contacts(fit.friction, fit.plant), strict=True
    ):
        origin = float(segment.position[0])
        stretches.append(
            Stretch(
                origin,
                float(segment.time[0]) - dataset.sample_time * segment.first_cycle,
                end,
                np.round((run[end] - origin) / step),
                samples[rows] + segment.first_cycle,
                _begin(fit, contact),
            )
        )
    return stretches, step


def _ends(runs: Sequence[np.ndarray], near: int) -> list[np.ndarray]:
    """Return where intervals end: after each sample near a turn, and as often as there is room for elsewhere."""
    around, depth, samples = np.arange(-near, near + 1), 0.0, sum(map(len, runs))
    if samples <= MOST_INTERVALS:
        return [np.arange(run.size) for run in runs]
    travel = max(float(np.ptp(run)) for run in runs)
    while True:
        fine = [np.unique(np.clip(turns_of(run, depth)[:, None] + around, 0, run.size - 1)) for run in runs]
        budget = MOST_INTERVALS - sum(map(len, fine))
        if budget >= (1.0 - TURNS) * MOST_INTERVALS:
            break
        depth = max(2.0 * depth, travel / FINE)
    stride = -(-samples // budget)
    return [np.union1d(end, np.arange(0, run.size, stride)) for run, end in zip(runs, fine, strict=True)]


def _run(segment: Segment, dt: float) -> np.ndarray:
    """Return where a contact has come to after each sample, its first cycle ahead: the sum of the velocities."""
    velocity = np.concatenate([segment.velocity[: segment.first_cycle], segment.velocity])
    return segment.position[0] + dt * np.cumsum(velocity)


def _begin(fit: Fit, contact: float | None) -> list[tuple[int, float]]:
    if contact is None or not contact:
        return []
    return [(STATE + i, float(number)) for i, number in enumerate(state_at(fit.friction, contact))]


def _mechanical(dataset: Dataset, fit: Fit, chosen: np.ndarray, finest: float) -> list[Column]:
    """Return what the plant takes for 1 of each identified parameter that it is linear in, and the rest of it."""
    plant, columns = fit.plant, []
    effort = dataset.mechanical_rows(plant)
    rest, negligible = effort.copy(), NEGLIGIBLE * float(np.max(np.abs(fit.traces.measured)))
    for name in plant.component.variables:
        estimate, value = fit.parameters.get(name), plant.values[name]
        if estimate is None or estimate.status != "identified" or isinstance(value, str) or np.ndim(value):
            continue
        change = CHANGE * (abs(value) or 1.0)
        once, twice = (dataset.mechanical_rows(plant.with_values(**{name: value + i * change})) - effort for i in (1, 2))
        if float(np.max(np.abs(twice - 2.0 * once))) <= negligible:
            columns.append(_column(name, once[chosen] / change, finest / abs(value or 1.0)))
            rest -= value / change * once
    if float(np.max(np.abs(rest))) > negligible:
        columns.append(_column("", rest[chosen], finest))
    return columns


def _column(name: str, values: np.ndarray, step: float) -> Column:
    # No more steps than a whole number of 32 bits holds, with a margin for the differences of it.
    step = max(step, float(np.max(np.abs(values), initial=0.0)) / 2**27) or 1.0
    return Column(name, step, np.round(values / step))
