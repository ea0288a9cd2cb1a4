"""The trial: every truth under every condition in the loops of both sets, with compensators that know none of it."""

import json
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
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
from bristle.paper.robust.loops import CHOSEN, FAMILIES, LOG, SETS, VARIANTS, Fitted, fitted, log_of, loop, peak_to_peak, setting
from bristle.paper.robust.truths import CONDITIONS, NOMINAL, Truth, under
from bristle.study.run import in_words

PARTS = "parts"


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
Task = Callable[[], None]


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


def run_trial(plan: Plan, store: Growing, progress: Progress | None = None) -> Trial:
    """Make what is missing of a trial, and keep each part as soon as it is there."""
    work = _Work(plan, store, progress)
    with cores_for_simulations():
        fits = work.missing_fits()
        work.abreast(partial(work.record, truth) for truth in plan.truths if truth.name in {name for name, _ in fits})
        # Fits keep a core busy with Python itself, loops do not: side by side they use both.
        turns = zip_longest([partial(work.fit, *key, source) for key, source in fits.items()], work.missing_runs(fed=False))
        work.abreast(task for turn in turns for task in turn if task is not None)
        work.abreast(work.missing_runs(fed=True))
    return work.trial


class _Work:
    """A trial while it is made: what is done is kept in a folder, and told with the time that is left."""

    def __init__(self, plan: Plan, store: Growing, progress: Progress | None) -> None:
        self.trial, self.plan, self.store, self.progress = Trial(plan), plan, store, progress
        self.logs: dict[str, tuple[Log, Axis]] = {}
        self.total, self.missing, self.ran, self.begin = len(plan.cells) * plan.seeds, 0, 0, 0.0
        self.stop, self.lock = threading.Event(), threading.Lock()

    def abreast(self, tasks: Iterable[Task]) -> None:
        """Do tasks on all cores; an error or Ctrl-C ends them once what each simulates at that moment is there."""
        pool = Abreast()
        try:
            pending: set[Future[None]] = {pool.submit(task) for task in tasks}
            while pending:
                ready, pending = wait(pending, 0.2, FIRST_COMPLETED)  # so often [s] signals are looked for
                for future in ready:
                    future.result()
        except BaseException:
            self.stop.set()
            raise
        finally:
            pool.shutdown(cancel_futures=True)

    def part(self, name: str, source: Mapping[str, str]) -> Any:
        """Return what a part of the trial holds; None where it is not there or was made from something else."""
        content = self.store.read(f"{PARTS}/{name}.json")
        part = None if content is None else json.loads(content)
        return part["content"] if part and part["made_from"] == source else None

    def keep(self, name: str, source: Mapping[str, str], content: Any) -> None:
        """Write a part of the trial."""
        self.store.write(f"{PARTS}/{name}.json", json.dumps({"made_from": source, "content": content}) + "\n")

    def tell(self, text: str) -> None:
        """Report what is being done, and the share of the runs that are done."""
        if self.progress is not None:
            self.progress(1.0 - (self.missing - self.ran) / self.total if self.missing else 0.0, text)

    def record(self, truth: Truth) -> None:
        """Make the log that compensators for a truth are identified from."""
        self.tell(f"{truth.name}: its log")
        self.logs[truth.name] = log_of(truth)

    def missing_fits(self) -> dict[tuple[str, str], dict[str, str]]:
        """Take up the compensators that are there; return what each other one is to be made from, by truth and family."""
        missing, log = {}, read_experiment(LOG).origins["experiment"][0].checksum
        for truth in self.plan.truths:
            source = {"bristle": version("bristle"), "friction": digest(truth.friction), "log": log, "file": truth.origin.checksum}
            for family in self.plan.compensators:
                present = self.part(f"fit-{truth.name}-{family}", source)
                if present is None:
                    missing[truth.name, family] = source
                else:
                    friction = find(present["model"])(kind=present["kind"], **present["values"]) if "model" in present else None
                    self.trial.fits[truth.name, family] = Fitted(friction, present.get("reason", ""))
        return missing

    def fit(self, truth: str, family: str, source: Mapping[str, str]) -> None:
        """Identify one compensator, unless all is to stop."""
        if self.stop.is_set():
            return
        friction, reason = self.trial.fits[truth, family] = fitted(family, *self.logs[truth])
        content: dict[str, Any] = {"reason": reason}
        if friction is not None:
            values = {name: np.asarray(value).tolist() for name, value in friction.values.items()}
            content = {"model": friction.name, "kind": friction.kind, "values": values}
        self.keep(f"fit-{truth}-{family}", source, content)
        self.tell(f"{truth}: {family} identified")

    def missing_runs(self, *, fed: bool) -> list[Task]:
        """Return what simulates the runs that are missing: of loops that feed friction forward, or of the others."""
        settings, truths = {name: setting(name) for name in self.plan.sets}, {truth.name: truth for truth in self.plan.truths}
        tasks, seeds = [], self.plan.seeds
        for cell in self.plan.cells:
            friction = self.trial.fits.get((cell.truth, cell.family), Fitted(None)).friction
            if bool(cell.family) != fed or (fed and friction is None):
                continue
            truth = truths[cell.truth]
            variant = loop(settings[cell.set][cell.variant], truth, under(cell.condition, truth), friction)
            source = {
                "bristle": version("bristle"),
                "friction": digest(variant.friction),
                "compensator": "" if friction is None else digest(friction),
                "loop": "-".join(map(digest, (variant.plant, variant.controller, variant.sensor, variant.reference))),
                "run": repr(variant.run),
            }
            present = [float(error) for error in self.part(cell.file, source) or []]
            self.trial.errors[cell] = np.array(present[:seeds])
            if len(present) < seeds:
                tasks.append(partial(self.simulate, cell, variant, source, present))
        self.missing = self.total - sum(errors.size for errors in self.trial.errors.values())
        self.begin, self.ran = time.monotonic(), 0
        return tasks

    def simulate(self, cell: Cell, variant: Variant, source: Mapping[str, str], errors: list[float]) -> None:
        """Simulate the runs of a cell that are missing, until all are there or it is to stop."""
        while len(errors) < self.plan.seeds and not self.stop.is_set():
            errors.append(peak_to_peak(variant, len(errors)))
            with self.lock:
                self.ran += 1
                left = in_words((time.monotonic() - self.begin) * (self.missing - self.ran) / self.ran)
            self.tell(f"{cell.truth}, {cell.condition}, {cell.variant}, {left} left")
        self.keep(cell.file, source, errors)
        self.trial.errors[cell] = np.array(errors)
