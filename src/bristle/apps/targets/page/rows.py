"""The rows of an identification for a page, which evaluates the fitted model along them with its module.

The model moves in intervals of several samples of the log, each in one direction; near a reversal each sample is an interval. A limit
on their number keeps the page small. The mean force of an interval counts. The filters of the identification combine the forces
around a row, and the plant adds its effort, in steps much smaller than the residual. Positions are whole numbers times a step, so that
the page uses exactly the numbers of this module.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from bristle.apps.targets.page.packing import differences, packed_numbers
from bristle.core.axis import Axis
from bristle.engine.contact import state_at
from bristle.exports.cycle import STATE
from bristle.identification.dataset import Dataset
from bristle.identification.result import Fit
from bristle.logs.log import Log
from bristle.logs.turns import turning_points
from bristle.prediction.predict import rows_as_fitted
from bristle.simulation.statistics import relative_error_percent

# Intervals of the motion and rows that a page carries at most.
MOST_INTERVALS = 30_000
MOST_ROWS = 12_000
FINE = 2**20  # steps in the longest interval
NEGLIGIBLE = 1e-6  # of the largest effort, for signals that are linear in a parameter


def _sampled(ways: Sequence[np.ndarray], finest: float, near: int) -> list[np.ndarray]:
    """Return the kept samples: those near turns (without shallow turns if there are too many), and evenly spaced others."""
    around = np.arange(-near, near + 1)
    depth = 0.0
    while True:
        turns = [
            np.unique(np.clip(turns_of(x, depth)[:, None] + around, 0, x.size - 1)) for x in ways
        ]
        left = MOST_INTERVALS - sum(map(len, turns))
        if left >= 0.5 * MOST_INTERVALS:
            break
        depth = max(2.0 * depth, finest)
    stride = -(-sum(x.size for x in ways) // left)
    return [
        np.union1d(turn, np.arange(0, x.size, stride)) for x, turn in zip(ways, turns, strict=True)
    ]


def turns_of(x: np.ndarray, depth: float) -> np.ndarray:
    """Return the indices of both ends and of the turns of a motion that are deeper than `depth`."""
    return np.unique([0, *turning_points(x, depth), x.size - 1])


class Stretch(NamedTuple):
    """A motion without a gap, in intervals; samples count from 0 at `time` [s]."""

    origin: float
    time: float
    ends: np.ndarray  # samples at the ends of the intervals
    positions: np.ndarray  # at the ends, in steps from `origin` [m or rad]
    rows: np.ndarray  # samples
    begin: list[tuple[int, float]]  # initial state of a contact that is not virgin, (index, number)


class Column(NamedTuple):
    """A signal over the rows that multiplies a parameter of the plant: whole numbers times a step."""

    name: str
    step: float
    numbers: np.ndarray


class FittedRows(NamedTuple):
    """The rows of a log in the fit of a model."""

    sample_time: float
    step: float
    response: np.ndarray
    stretches: list[Stretch]
    measured: Column
    mechanical: list[Column]
    rms: float
    percent: float

    def as_data(self) -> dict[str, Any]:
        """Return the rows in packed form for a page."""
        parts: list[np.ndarray] = []
        for stretch in self.stretches:
            parts += [
                differences(column, times)
                for column, times in ((stretch.ends, 2), (stretch.positions, 2), (stretch.rows, 2))
            ]
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
            "mechanical": [
                {"name": column.name, "step": column.step} for column in self.mechanical
            ],
        }


def fitted_rows(
    fit: Fit, log: Log, axis: Axis | None, treatment: Mapping[str, Any]
) -> FittedRows | None:
    """Return the rows of a log in the fit of a model; None if the module cannot reproduce them."""
    if any(surrounding.field != "x" for surrounding in fit.friction.component.surroundings):
        return None
    decimation = treatment.get("decimation")
    if decimation is not None:
        decimation = int(decimation)
    dataset = rows_as_fitted(log, axis, treatment, decimation)
    traces = fit.traces
    count = dataset.time.size
    # The preprocessing of a user or of another version cannot be reproduced completely.
    if not np.array_equal(dataset.time, traces.time[:count]):
        return None
    spacing = math.ceil(count / MOST_ROWS)
    # Decimated samples per row.
    segment = dataset.segment_of_row
    sample = dataset.sampled([np.arange(s.time.size) for s in dataset.segments])
    is_shown = (sample - dataset.dropped) // dataset.decimation % spacing == 0
    selection = [np.flatnonzero((segment == i) & is_shown) for i in range(len(dataset.segments))]
    summed = np.cumsum(dataset.response)
    middle = dataset.response.size // 2
    # Share of the response of the filters that is left out on either side.
    left = np.flatnonzero(np.abs(summed[:middle]) > 1e-4)
    reach = 0
    if left.size:
        reach = middle - int(left[0])
    # Summed up from its first sample on, without its tails.
    response = summed[middle - reach : middle + reach + 1]
    stretches, step = _stretches(dataset, fit, selection, response)
    chosen = np.concatenate(selection)
    residual = traces.residual[:count]
    measured = traces.measured[:count]
    rms = float(np.sqrt(np.mean(residual**2)))
    # 64 steps in what the model leaves over
    finest = rms / 64.0 or NEGLIGIBLE * float(np.max(np.abs(measured)))
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


def _stretches(
    dataset: Dataset, fit: Fit, selection: Sequence[np.ndarray], response: np.ndarray
) -> tuple[list[Stretch], float]:
    """Return the motion of each segment, and the step of its positions."""
    dt = dataset.sample_time
    runs = []
    for (
        segment
    ) in dataset.segments:  # where a contact has come to after each sample, its first cycle ahead
        velocity = np.concatenate([segment.velocity[: segment.first_cycle], segment.velocity])
        runs.append(segment.position[0] + dt * np.cumsum(velocity))
    samples = dataset.sampled([np.arange(segment.time.size) for segment in dataset.segments])
    if sum(map(len, runs)) <= MOST_INTERVALS:
        ends = [np.arange(run.size) for run in runs]
    else:  # an interval ends after each sample near a turn, and as often as there is room for elsewhere
        # Around a turn nine tenths of the response of the filters are looked at sample by sample.
        near = int(np.searchsorted(response[response.size // 2 :], 0.9))
        ends = _sampled(runs, max(float(np.ptp(run)) for run in runs) / FINE, near)
    step = max(
        float(np.max(np.abs(np.diff(run[end])), initial=0.0))
        for run, end in zip(runs, ends, strict=True)
    )
    step = (step or 1.0) / FINE
    stretches = []
    contacts = dataset.contacts(fit.friction, fit.plant)
    for segment, run, end, rows, contact in zip(
        dataset.segments, runs, ends, selection, contacts, strict=True
    ):
        origin = float(segment.position[0])
        start = float(segment.time[0]) - dt * segment.first_cycle
        state = ()
        if contact:
            state = state_at(fit.friction, contact)
        begin = [(STATE + i, float(number)) for i, number in enumerate(state)]
        positions = np.round((run[end] - origin) / step)
        stretches.append(
            Stretch(origin, start, end, positions, samples[rows] + segment.first_cycle, begin)
        )
    return stretches, step


def _mechanical(dataset: Dataset, fit: Fit, chosen: np.ndarray, finest: float) -> list[Column]:
    """Return what the plant takes for 1 of each identified parameter that it is linear in, and the rest of it."""
    plant = fit.plant
    columns = []
    effort = dataset.mechanical_rows(plant)
    rest = effort.copy()
    negligible = NEGLIGIBLE * float(np.max(np.abs(fit.traces.measured)))
    for name in plant.component.variables:
        estimate = fit.parameters.get(name)
        value = plant.values[name]
        if (
            estimate is None
            or estimate.status != "identified"
            or isinstance(value, str)
            or np.ndim(value)
        ):
            continue
        change = 0.1 * (abs(value) or 1.0)
        once, twice = (
            dataset.mechanical_rows(plant.with_values(**{name: value + i * change})) - effort
            for i in (1, 2)
        )
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
