"""The trial: every truth under every condition in the loops of both sets, with compensators that know none of it."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from importlib.metadata import version
from itertools import zip_longest
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bristle.core.axis import Axis
from bristle.core.cores import Abreast, cores_for_simulations
from bristle.core.experiment import Variant
from bristle.core.fingerprint import digest
from bristle.files.experiment import read_experiment
from bristle.files.growing import Growing, growing_folder
from bristle.friction import find
from bristle.logs.log import Log
from bristle.paper.economy import Economy
from bristle.paper.robust.loops import (
    CHOSEN,
    COUNTS,
    FAMILIES,
    LOG,
    SETS,
    VARIANTS,
    Fitted,
    economy_on,
    fitted,
    is_measurable,
    log_of,
    loop,
    peak_to_peak,
    setting,
)
from bristle.paper.robust.truths import CONDITIONS, NOMINAL, Truth, under
from bristle.study.run import in_words

PARTS = "parts"


def part_of(folder: Growing, name: str, source: Mapping[str, Any]) -> Any:
    """Return what a part of a trial holds; None where it is not there or was made from something else."""
    content = folder.read(f"{PARTS}/{name}.json")
    part = None if content is None else json.loads(content)
    return part["content"] if part and part["made_from"] == dict(source) else None


def keep(folder: Growing, name: str, source: Mapping[str, Any], content: Any) -> None:
    """Write a part of a trial."""
    folder.write(f"{PARTS}/{name}.json", json.dumps({"made_from": dict(source), "content": content}) + "\n")


@contextmanager
def opened(path: str | Path) -> Iterator[Growing]:
    """Give a folder to write into, new or begun by an earlier trial, to this process alone."""
    used = {"summary.json", "report.html", PARTS, "figures"}
    with growing_folder(
        path, "robust trial", made_anew=lambda name: name.startswith(f"{PARTS}/"), used=lambda name: name.partition("/")[0] in used
    ) as (grown, damaged):
        grown.set_all_aside(damaged)
        yield grown


Progress = Callable[[float, str], None]
Task = Callable[[threading.Event], None]
ECONOMY_SEEDS = 4
PATIENCE = 0.2  # [s]: so often signals are looked for


class Cell(NamedTuple):
    """Runs that are made and kept together."""

    set: str
    truth: str
    condition: str
    variant: str
    family: str

    @property
    def file(self) -> str:
        """Name of its part."""
        return "-".join(filter(None, self))


@dataclass(frozen=True)
class Plan:
    """What is tried."""

    truths: tuple[Truth, ...]
    seeds: int
    conditions: tuple[str, ...] = tuple(CONDITIONS)
    sets: tuple[str, ...] = tuple(SETS)
    families: tuple[str, ...] = FAMILIES

    @property
    def compensators(self) -> tuple[str, ...]:
        """All families that are identified: the chosen one is, whichever else are."""
        return tuple(dict.fromkeys((*self.families, CHOSEN)))

    @property
    def cells(self) -> list[Cell]:
        """Everything that is simulated."""
        chosen = [
            Cell(name, truth.name, condition, variant, CHOSEN if "feedforward" in variant else "")
            for truth in self.truths
            for name in self.sets
            for condition in self.conditions
            for variant in VARIANTS
        ]
        # Fed forward, each family stands in.
        return chosen + [
            Cell(name, truth.name, NOMINAL, "feedforward", family)
            for truth in self.truths
            for name in self.sets
            for family in self.families
            if family != CHOSEN
        ]


@dataclass
class Trial:
    """What came out."""

    plan: Plan
    fits: dict[tuple[str, str], Fitted] = field(default_factory=dict)
    errors: dict[Cell, np.ndarray] = field(default_factory=dict)
    economy: dict[str, Economy] = field(default_factory=dict)


def run_trial(plan: Plan, store: Growing, progress: Progress | None = None) -> Trial:
    """Make what is missing of a trial, and keep each part as soon as it is there."""
    trial, tally = Trial(plan), Tally(progress)
    with cores_for_simulations():
        unfitted = _unfitted(trial, store)
        logs: dict[str, tuple[Log, Axis]] = {}

        def record(truth: Truth, stop: threading.Event) -> None:
            tally.tell(f"{truth.name}: its log")
            logs[truth.name] = log_of(truth)

        _abreast(partial(record, truth) for truth in plan.truths if truth.name in {name for name, _ in unfitted})
        fits = [partial(_fit, trial, store, tally, logs, *key, source) for key, source in unfitted.items()]
        # Fits keep a core busy with Python itself, loops do not: side by side they use both.
        sparing = [partial(_spare, trial, store, tally, truth) for truth in plan.truths if is_measurable(truth)]
        turns = zip_longest([*fits, *sparing], _missing(trial, store, tally, fed=False))
        _abreast(task for turn in turns for task in turn if task is not None)
        _abreast(_missing(trial, store, tally, fed=True))
    trial.economy = {truth.name: trial.economy[truth.name] for truth in plan.truths if truth.name in trial.economy}
    return trial


def _missing(trial: Trial, store: Growing, tally: Tally, *, fed: bool) -> list[Task]:
    """Return what simulates the runs that are missing: of loops that feed friction forward, or of the others."""
    plan, tasks = trial.plan, []
    settings, truths = {name: setting(name) for name in plan.sets}, {truth.name: truth for truth in plan.truths}
    for cell in plan.cells:
        fit = trial.fits.get((cell.truth, cell.family), Fitted(None))
        if bool(cell.family) != fed or (cell.family and fit.friction is None):
            continue
        truth = truths[cell.truth]
        variant = loop(settings[cell.set][cell.variant], truth, under(cell.condition, truth), fit.friction)
        source = {
            "bristle": version("bristle"),
            "friction": digest(variant.friction),
            "compensator": "" if fit.friction is None else digest(fit.friction),
            "loop": "-".join(map(digest, (variant.plant, variant.controller, variant.sensor, variant.reference))),
            "run": repr(variant.run),
        }
        present = [float(error) for error in part_of(store, cell.file, source) or []]
        trial.errors[cell] = np.array(present[: plan.seeds])
        if len(present) < plan.seeds:
            tasks.append(partial(_simulate, trial, store, tally, cell, variant, source, present))
    tally.expect(plan, trial)
    return tasks


def _simulate(
    trial: Trial,
    store: Growing,
    tally: Tally,
    cell: Cell,
    variant: Variant,
    source: Mapping[str, str],
    known: Sequence[float],
    stop: threading.Event,
) -> None:
    """Simulate the runs of a cell that are missing, until all are there or it is to stop."""
    errors = list(known)
    while len(errors) < trial.plan.seeds and not stop.is_set():
        errors.append(peak_to_peak(variant, len(errors)))
        tally.add(f"{cell.truth}, {cell.condition}, {cell.variant}")
    keep(store, cell.file, source, errors)
    trial.errors[cell] = np.array(errors)


def _unfitted(trial: Trial, store: Growing) -> dict[tuple[str, str], dict[str, str]]:
    """Return what each compensator that is missing is to be made from, by truth and family; the others are taken up."""
    missing = {}
    log = read_experiment(LOG).origins["experiment"][0].checksum
    for truth in trial.plan.truths:
        for family in trial.plan.compensators:
            source = {"bristle": version("bristle"), "friction": digest(truth.friction), "log": log, "file": truth.origin.checksum}
            present = part_of(store, f"fit-{truth.name}-{family}", source)
            if present is None:
                missing[truth.name, family] = source
            elif "reason" in present:
                trial.fits[truth.name, family] = Fitted(None, present["reason"])
            else:
                trial.fits[truth.name, family] = Fitted(find(present["model"])(kind=present["kind"], **present["values"]))
    return missing


def _fit(
    trial: Trial,
    store: Growing,
    tally: Tally,
    logs: Mapping[str, tuple[Log, Axis]],
    truth: str,
    family: str,
    source: Mapping[str, str],
    stop: threading.Event,
) -> None:
    """Identify one compensator, unless all is to stop."""
    if stop.is_set():
        return
    friction, reason = outcome = fitted(family, *logs[truth])
    content: dict[str, Any] = {"reason": reason}
    if friction is not None:
        values = {name: np.asarray(value).tolist() for name, value in friction.values.items()}
        content = {"model": friction.name, "kind": friction.kind, "values": values}
    keep(store, f"fit-{truth}-{family}", source, content)
    trial.fits[truth, family] = outcome
    tally.tell(f"{truth}: {family} identified")


def _spare(trial: Trial, store: Growing, tally: Tally, truth: Truth, stop: threading.Event) -> None:
    """Measure few and more branches of a truth, unless all is to stop."""
    if stop.is_set():
        return
    seeds = min(trial.plan.seeds, ECONOMY_SEEDS)
    source = {"bristle": version("bristle"), "friction": digest(truth.friction), "branches": list(COUNTS), "seeds": seeds}
    present = part_of(store, f"economy-{truth.name}", source)
    if present is None:
        tally.tell(f"{truth.name}: branches")
        cost = economy_on(truth, seeds)
        errors = {way: errors.tolist() for way, errors in cost.errors.items()}
        present = {"errors": errors, "floor": cost.floor, "duration": cost.duration}
        keep(store, f"economy-{truth.name}", source, present)
    errors = {way: np.array(values) for way, values in present["errors"].items()}
    trial.economy[truth.name] = Economy(list(COUNTS), errors, present["floor"], present["duration"])


def _abreast(tasks: Iterable[Task]) -> None:
    """Do tasks on all cores; an error or Ctrl-C ends them once what each simulates at that moment is there."""
    stop, pool = threading.Event(), Abreast()
    try:
        pending: set[Future[None]] = {pool.submit(task, stop) for task in tasks}
        while pending:
            ready, pending = wait(pending, PATIENCE, FIRST_COMPLETED)
            for future in ready:
                future.result()
    finally:
        stop.set()
        pool.shutdown(cancel_futures=True)


class Tally:
    """How many runs are there, and how long the rest takes."""

    def __init__(self, progress: Progress | None) -> None:
        self.progress, self.share, self.ran, self.missing = progress, 0.0, 0, 0
        self.begin, self.lock = time.monotonic(), threading.Lock()

    def expect(self, plan: Plan, trial: Trial) -> None:
        """Take note of how many runs are missing."""
        self.total = len(plan.cells) * plan.seeds
        self.missing = self.total - sum(errors.size for errors in trial.errors.values())
        self.begin, self.ran = time.monotonic(), 0

    def tell(self, text: str) -> None:
        """Report what is being done besides runs."""
        if self.progress is not None:
            self.progress(self.share, text)

    def add(self, text: str) -> None:
        """Count a run, and report."""
        with self.lock:
            self.ran += 1
            missing = self.missing - self.ran
            left = in_words((time.monotonic() - self.begin) * missing / self.ran)
            self.share = 1.0 - missing / self.total
        self.tell(f"{text}, {left} left")
