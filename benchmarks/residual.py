r"""Does a passive residual model gain on an unseen record? ``python -m benchmarks.residual [NAME ...]``.

The residual model of `benchmarks.passive` extends the best of three identified models. It is kept if held-out blocks,
other tests or a second record gain more than the half-width of their 95 % block bootstrap. An unseen record judges it.
Two residual models without proof have the same state and the same rule: sparse regression and gradient boosting.
BRISTLE_DATA names the folder of the measured logs. The tests of the damper at 0 lb are left out: some have a faulty tension.
"""

from __future__ import annotations

import fnmatch
import os
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np

from benchmarks import arm, outside
from benchmarks.passive import NEAR, Grid, Passive, Rows, rows_of, slipping
from benchmarks.second_records import FIRST, cut
from benchmarks.timing import EXAMPLES
from bristle.apps.arm.identify import identify_arm, read_joints
from bristle.core import Axis, content_of
from bristle.core.least_squares import unbounded
from bristle.files import axes_in, read_axis
from bristle.identification import Identification, identify
from bristle.identification.dataset import Dataset
from bristle.logs import read_log
from bristle.logs.log import Log
from bristle.prediction.predict import TREATED, rows_as_fitted

BASES = "stribeck_free+position+asymmetry,lugre+asymmetry,maxwell_slip+position"
SEEDS = (11,)  # of the simulated axes; the method was developed on seeds 1 and 2
FOLDS, BLOCKS, DRAWS, TERMS = 5, 20, 1000, 5
SINGLE = {
    "EMPS": ("emps/DATA_EMPS.mat", "emps"),
    "pendulum, 200 g": ("servo_pendulum/arm_200g.json", "servo_pendulum"),
    "pendulum, 400 g": ("servo_pendulum/arm_400g.json", "servo_pendulum"),
    "cogging": ("cogging/speed_test1.txt", "cogging"),
    "tribometer": ("tribometer/test_data_2.txt", "tribometer"),
}
DAMPERS = {
    "2, 30 lb": "dataset-2__*Hz30lb",
    "2, 36 lb": "dataset-2__*Hz36lb",
    "3, 30 lb": "dataset-3__*Hz30lb",
}


class Task(NamedTuple):
    """Logs to fit, logs to decide whether the residual model is kept (if any), and unseen logs."""

    first: Sequence[Log]
    second: Sequence[Log]
    unseen: Sequence[Log]
    axis: Axis
    axis_of_unseen: Axis


class Residual(Protocol):
    """A residual model: `fit` to rows, then the residual effort [N or N*m] of other rows."""

    def fit(self, rows: Rows) -> Residual: ...
    def effort(self, rows: Rows) -> np.ndarray: ...


class Sparse:
    """Orthogonal least squares: the `TERMS` most useful of a dictionary of products of the state."""

    def fit(self, rows: Rows) -> Residual:
        """Choose the terms one by one."""
        self.speed = float(np.max(np.abs(rows.state[:, -1])))
        A, target = self._terms(rows), rows.effort - rows.explained
        self.chosen, left = (
            list[int](),
            A / np.maximum(np.linalg.norm(A, axis=0), np.finfo(float).tiny),
        )
        for _ in range(TERMS):
            size = np.linalg.norm(left, axis=0)
            seen = size > 1e-6
            pull = np.abs(left.T @ target)
            self.chosen.append(
                int(np.argmax(np.where(seen, pull / np.where(seen, size, 1.0), -1.0)))
            )
            unit = left[:, self.chosen[-1]] / size[self.chosen[-1]]
            left = left - np.outer(unit, unit @ left)
        self.weights = unbounded(A[:, self.chosen], target)
        return self

    def effort(self, rows: Rows) -> np.ndarray:
        """Return the residual effort."""
        return self._terms(rows)[:, self.chosen] @ self.weights

    def _terms(self, rows: Rows) -> np.ndarray:
        v, e = rows.state[:, -1:] / self.speed, rows.state[:, :-1:3]
        speed = np.abs(v)
        products = [e, e * speed, e * v, e**2, e**3, e * np.exp(-speed)]
        return np.hstack(
            [np.ones_like(v), v, speed, v * speed, v**3, np.sign(v) * np.sqrt(speed), *products]
        )


class Boosting:
    """Gradient boosting of scikit-learn, with its own settings."""

    def fit(self, rows: Rows) -> Residual:
        """Grow the trees."""
        from sklearn.ensemble import HistGradientBoostingRegressor

        self.trees = HistGradientBoostingRegressor(random_state=0).fit(
            rows.state, rows.effort - rows.explained
        )
        return self

    def effort(self, rows: Rows) -> np.ndarray:
        """Return the residual effort."""
        return self.trees.predict(rows.state)


Method = type[Passive] | type[Sparse] | type[Boosting]
METHODS: dict[str, Method] = {"passive": Passive, "sparse": Sparse, "boosting": Boosting}


class Gain(NamedTuple):
    """Reduction of the rms error, and the half-width of its 95 % interval [%]."""

    percent: float
    spread: float

    @classmethod
    def of(cls, before: np.ndarray, after: np.ndarray) -> Gain:
        """Return the gain from errors without and with a residual model, by the bootstrap of blocks of time."""
        sums = np.array(
            [
                [np.sum(part**2) for part in np.array_split(error, BLOCKS)]
                for error in (before, after)
            ]
        )
        draws = np.random.default_rng(0).integers(0, BLOCKS, (DRAWS, BLOCKS))
        drawn = sums[:, draws].sum(axis=2)
        ratio = np.sqrt(sums[1].sum() / sums[0].sum())
        return cls(100.0 * float(1.0 - ratio), 196.0 * float(np.std(np.sqrt(drawn[1] / drawn[0]))))


class Judged(NamedTuple):
    """Gain that decides, gain on the unseen record, and this gain near reversals [%]."""

    deciding: Gain
    unseen: Gain
    near: float

    @property
    def kept(self) -> bool:
        """Whether the residual model is kept."""
        return self.deciding.percent > self.deciding.spread

    @property
    def harms(self) -> bool:
        """Whether a kept residual model raises the error of the unseen record by more than the spread."""
        return self.kept and self.unseen.percent < -self.unseen.spread

    def __str__(self) -> str:
        kept = "kept" if self.kept else "left"
        return f"{kept} {self.unseen.percent:6.1f} ± {self.unseen.spread:4.1f}{'!' if self.harms else ' '}({self.near:5.1f})"


def deciding_gain(method: Method, first: Sequence[Rows], second: Sequence[Rows]) -> Gain:
    """Return the gain on the second record, else on each held-out record or block of the first."""
    before, after = list[np.ndarray](), list[np.ndarray]()
    for fitted, held_out in _folds(first, second):
        before.append(held_out.effort - held_out.explained)
        after.append(before[-1] - method().fit(fitted).effort(held_out))
    return Gain.of(np.concatenate(before), np.concatenate(after))


def judged(method: Method, first: Sequence[Rows], second: Sequence[Rows], unseen: Rows) -> Judged:
    """Decide whether a residual model is kept, and judge it on the unseen record."""
    error = unseen.effort - unseen.explained
    left = error - method().fit(Rows.joined(first)).effort(unseen)
    near = (
        100.0 * float(1.0 - np.linalg.norm(left[unseen.near]) / np.linalg.norm(error[unseen.near]))
        if unseen.near.any()
        else np.nan
    )
    return Judged(deciding_gain(method, first, second), Gain.of(error, left), near)


def _folds(first: Sequence[Rows], second: Sequence[Rows]) -> Iterator[tuple[Rows, Rows]]:
    """Yield rows to fit and rows held out: the second record, else each record in turn, else each block of time."""
    if second:
        yield Rows.joined(first), Rows.joined(second)
    elif len(first) > 1:
        for held_out in first:
            yield Rows.joined([one for one in first if one is not held_out]), held_out
    else:
        rows, index = first[0], np.arange(first[0].effort.size)
        for block in np.array_split(index, FOLDS):
            apart = (index < block[0] - rows.reach) | (index > block[-1] + rows.reach)
            yield rows.part(apart), rows.part(np.isin(index, block))


def treated(found: Identification, log: Log, axis: Axis) -> Dataset:
    """Return a log treated like those of an identification."""
    channels = {name: found.treatment[name] for name in TREATED if name in found.treatment}
    return rows_as_fitted(log, axis, channels, int(found.treatment["decimation"]))


class Extended(NamedTuple):
    """The best model of some logs, and the columns of residual models behind it."""

    found: Identification
    grid: Grid
    rows: list[Rows]

    @classmethod
    def of(cls, logs: Sequence[Log], axis: Axis) -> Extended:
        """Identify some logs."""
        found = identify(logs, BASES, axis=axis, draws=0)
        datasets = [treated(found, log, axis) for log in logs]
        grid = Grid.over(datasets)
        return cls(found, grid, [rows_of(one, found.best, grid) for one in datasets])


def tried(task: Task) -> tuple[str, float, float, dict[str, Judged]]:
    """Return the best model, its error on the unseen record [%], the least dissipation of an element, and the verdicts."""
    model = Extended.of(task.first, task.axis)
    unseen = [treated(model.found, log, task.axis_of_unseen) for log in task.unseen]
    second = [
        rows_of(treated(model.found, log, task.axis), model.found.best, model.grid)
        for log in task.second
    ]
    rows = Rows.joined([rows_of(one, model.found.best, model.grid) for one in unseen])
    error = 100.0 * float(
        np.linalg.norm(rows.effort - rows.explained) / np.linalg.norm(rows.effort)
    )
    lost = [
        _least_dissipation(model.grid, part.velocity, one.sample_time)
        for one in unseen
        for part in one.segments
    ]
    verdicts = {name: judged(method, model.rows, second, rows) for name, method in METHODS.items()}
    return model.found.best.name, error, min(lost), verdicts


def _least_dissipation(grid: Grid, v: np.ndarray, dt: float) -> float:
    """Return the least work of a step of any element that is not stored, over the energy at its limit."""
    return min(
        float(np.min(slipping(v, dt, limit)[1])) / (0.5 * r * r) for r, limit in grid.elements(v)
    )


def tasks(folder: Path | None, place: Path) -> dict[str, Callable[[], Task]]:
    """Return the measured axes, where `folder` names them, and the simulated axes; `place` is a folder for files."""
    found: dict[str, Callable[[], Task]] = {}
    if folder:
        found |= {
            name: partial(_halves, folder / file, example)
            for name, (file, example) in SINGLE.items()
        }
        found |= {
            f"damper {name}": partial(_damper, folder / "friction_damper/brfd_all.npz", one)
            for name, one in DAMPERS.items()
        }
        found |= {
            f"robot, joint {number}": partial(_joint, place, number) for number in range(1, 7)
        }
    return found | {
        f"simulated, {kind}, seed {seed}": partial(_simulated, kind, seed)
        for kind in outside.KINDS
        for seed in SEEDS
    }


def _halves(file: Path, example: str) -> Task:
    """Return a record cut in two."""
    axis = read_axis(EXAMPLES / example / "axis.toml")
    log = read_log(file, axis)
    middle = round(FIRST * len(log))
    return Task([cut(log, slice(0, middle))], [], [cut(log, slice(middle, len(log)))], axis, axis)


def _damper(file: Path, pattern: str) -> Task:
    """Return the tests of a damper below 2 Hz: those with an amplitude of one inch are unseen."""
    axis, tests = (
        read_axis(EXAMPLES / "friction_damper/axis.toml"),
        fnmatch.filter(np.load(file).files, f"{pattern}*"),
    )
    sides: Mapping[bool, list[Log]] = {True: [], False: []}
    for test in tests:
        if "__2Hz" not in test:
            sides[test.endswith("n1amplitude")].append(read_log(f"{file}::{test}", axis))
    return Task(sides[False], [], sides[True], axis, axis)


def _joint(place: Path, number: int) -> Task:
    """Return a joint of the robot: the other record is unseen."""
    if not (place / "val").exists():
        arm.inputs(place)
        robot, table = content_of(place / "robot.toml"), content_of(place / "joints.toml")
        found = identify_arm(place / "train.csv", robot, table)
        found.write(place / "train")
        replace(found, motion=read_joints(place / "val.csv", axes_in(table))[1]).write(
            place / "val"
        )
    first, unseen = (
        read_axis(place / part / f"joints/A{number}.toml") for part in ("train", "val")
    )
    return Task(
        [read_log(place / "train.csv", first)],
        [],
        [read_log(place / "val.csv", unseen)],
        first,
        unseen,
    )


def _simulated(kind: str, seed: int) -> Task:
    """Return three records of a simulated axis: the second decides."""
    first, second, unseen = ([outside.record(kind, seed, number)] for number in range(3))
    return Task(first, second, unseen, outside.AXIS, outside.AXIS)


def main(names: list[str]) -> int:
    """Print a line for each task; return 1 if a kept passive residual model harms, or an element returns energy."""
    folder: Any = os.environ.get("BRISTLE_DATA")
    print(
        f"reduction of the rms error on the unseen record [%] ± half-width (within {NEAR} s of reversals); ! marks harm"
    )
    fails = 0
    with warnings.catch_warnings(), tempfile.TemporaryDirectory() as place:
        warnings.simplefilter("ignore")
        for name, task in tasks(Path(folder) if folder else None, Path(place)).items():
            if names and not any(one in name for one in names):
                continue
            base, error, least, verdicts = tried(task())
            told = "  ".join(f"{method} {verdict}" for method, verdict in verdicts.items())
            print(f"{name:<28} {base:<34} {error:5.2f} %  {told}", flush=True)
            fails += verdicts["passive"].harms or least < -1e-9
    return int(fails > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
