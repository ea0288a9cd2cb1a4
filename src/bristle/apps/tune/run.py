"""The state of a run of `bristle tune`: machine, journal, records; every write is in the journal before it is done."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.apps.tune.journal import Journal
from bristle.apps.tune.machine import (
    FrictionFeedforward,
    Limits,
    Machine,
    MachineRefusedError,
    MachineStoppedError,
    Recording,
    State,
)
from bristle.apps.tune.restoring import Restoration
from bristle.core import Axis, Kind, Progress, Variable, amount, cached_property, guarded, whole
from bristle.files import Growing, MachineFile, log_text
from bristle.logs import Log, read_log

if TYPE_CHECKING:
    from bristle.report.compared import Compared

MODELS = "lugre,dahl,maxwell_slip"
REST = 1.0  # before and after each motion [s]
RECORDS, RESULTS, REFINED, MODEL = "records", "results", "refined", "model.toml"


@guarded(
    duration=amount(Variable("time", "duration of the excitation", min=1.0)),
    draws=whole(20, none=True),
)
@dataclass(frozen=True)
class Options:
    """Choices of a run: models to identify, duration of the excitation [s], number of simulated logs for intervals."""

    models: str = MODELS
    duration: float = 40.0
    draws: int = 20


@dataclass
class Run:
    """A run on a machine, with its folder, the played and planned time of the present step, and that of all records [s]."""

    file: MachineFile
    machine: Machine
    grown: Growing
    journal: Journal
    options: Options = field(default_factory=Options)
    progress: Progress | None = None
    step: str = ""
    facts: dict[str, dict[str, Any]] = field(default_factory=dict)
    feedforward: FrictionFeedforward | None = None
    compared: Compared | None = None
    backup: State | None = None
    played: float = 0.0
    planned: float = 1.0
    recorded: float = 0.0

    @property
    def folder(self) -> Path:
        """The folder of the run."""
        return self.grown.path

    @property
    def axis(self) -> Axis:
        """The axis."""
        return self.file.axis

    @property
    def sample_time(self) -> float:
        """Time between two samples [s]."""
        return self.machine.sample_time

    @cached_property
    def limits(self) -> Limits:
        """Limits of the guard."""
        axis = self.axis
        assert axis.stroke is not None
        assert axis.following_error_limit is not None
        assert axis.effort_limit is not None
        return Limits(axis.following_error_limit, axis.effort_limit, axis.stroke)

    def tell(self, text: str, seconds: float = 0.0) -> None:
        """Report the progress of the present step, `seconds` after the begin of a record."""
        if self.progress is not None:
            self.progress(min((self.played + seconds) / self.planned, 1.0), text)

    def write(self, name: str, act: Callable[[], None], **facts: Any) -> None:
        """Do a write on the machine, which the journal contains before it happens."""
        self.journal.write(self.step, "write", what=name, **facts)
        act()

    def arm(self, limits: Limits | None = None) -> None:
        """Insert the guard."""
        chosen = limits or self.limits
        self.write("arm", lambda: self.machine.arm(chosen), **vars(chosen))

    def set(self, *, gain: float = 0.0, offset: float = 0.0) -> None:
        """Set gain and test effort."""
        self.write(
            "set", lambda: self.machine.set(gain=gain, offset=offset), gain=gain, offset=offset
        )

    def load(self, feedforward: FrictionFeedforward) -> None:
        """Load a feedforward at gain 0."""
        self.write(
            "load",
            lambda: self.machine.load(feedforward),
            model=feedforward.name,
            lead=feedforward.lead,
        )
        self.feedforward = feedforward

    def rest(self, seconds: float) -> np.ndarray:
        """Return the reference of a rest at the start of the motion."""
        return np.full(max(round(seconds / self.sample_time), 4), self.file.cycle[0])

    def motion(self, cycles: int) -> np.ndarray:
        """Return the reference of some cycles of the user's motion, between two rests."""
        rest = self.rest(REST)
        return np.concatenate([rest, np.tile(self.file.cycle, cycles), rest])

    def record(self, name: str, reference: np.ndarray, *, skip: int | None = None) -> Recording:
        """Play a reference, keep the record as a file, and return it; with `skip`, the file has only the cycles behind the first ones."""
        seconds = reference.size * self.sample_time
        text, begin = f"recording {name.replace('_', ' ')}, {seconds:.0f} s", time.monotonic()
        self.tell(text)
        recording = self.machine.record(
            reference, lambda: self.tell(text, min(time.monotonic() - begin, seconds))
        )
        self.played += seconds
        if not all(
            isinstance(getattr(recording, name, None), np.ndarray)
            for name in ("reference", "position", "effort")
        ):
            raise MachineRefusedError(
                "no_record",
                f"the machine returned no record of {name.replace('_', ' ')}, but {type(recording).__name__}",
                "Return a Recording of three arrays. Test the machine: bristle check",
            )
        lengths = {recording.reference.size, recording.position.size, recording.effort.size}
        if lengths != {reference.size}:
            raise MachineStoppedError(
                "lost_samples",
                f"{reference.size - min(lengths)} of {reference.size} samples of {name.replace('_', ' ')} are missing",
            )
        if not all(
            np.all(np.isfinite(signal)) for signal in (recording.position, recording.effort)
        ):
            raise MachineStoppedError(
                "lost_samples", f"{name.replace('_', ' ')} contains values that are not finite"
            )
        if not np.allclose(
            recording.reference, reference, rtol=0.0, atol=self.axis.resolution or 1e-6
        ):
            worst = float(np.max(np.abs(recording.reference - reference)))
            raise MachineRefusedError(
                "other_motion",
                f"the machine played another motion: it differs by up to {worst:.3g} in SI",
                "Check the scale of the reference",
            )
        signals = {
            "position": recording.position,
            "effort": recording.effort,
            "reference": recording.reference,
        }
        if skip is not None:
            signals = {
                channel: cycles_of(self, signal, skip).ravel()
                for channel, signal in signals.items()
            }
        # The times of the records state their order.
        signals["time"] = self.recorded + np.arange(signals["position"].size) * self.sample_time
        self.recorded += seconds
        self.grown.write(f"{RECORDS}/{name}.csv", log_text(self.axis, signals))
        self.note(f"{RECORDS}/{name}.csv")
        return recording

    def log(self, name: str) -> Log:
        """Return a record as a log."""
        return read_log(noted(self.journal, f"{RECORDS}/{name}.csv"), self.axis)

    def note(self, name: str) -> None:
        """Note the hash of a file that this run wrote."""
        self.journal.write(
            self.step,
            "file",
            name=name,
            sha256=hashlib.sha256((self.folder / name).read_bytes()).hexdigest(),
        )

    def finish(self, **facts: Any) -> dict[str, Any]:
        """Note the end of the present step with its facts."""
        self.facts[self.step] = facts
        return self.journal.write(self.step, "done", facts=facts)


def noted(journal: Journal, name: str) -> Path:
    """Return the path of a file beside a journal; refuse a file that was changed since its hash was noted."""
    path, entries = journal.path.parent / name, journal.with_events("file")
    written = next((entry["sha256"] for entry in entries if entry["name"] == name), None)
    if not path.is_file() or hashlib.sha256(path.read_bytes()).hexdigest() != written:
        raise MachineRefusedError(
            "file_changed",
            f"{name} differs from its hash in the journal: it was changed after the run wrote it",
            "Begin a new run in another folder",
        )
    return path


def cycles_of(run: Run, signal: np.ndarray, skip: int = 0) -> np.ndarray:
    """Return the cycles of a record of `Run.motion`, shape (cycle, sample), without the first `skip`."""
    rest, size = run.rest(REST).size, run.file.cycle.size
    inside = signal[rest : signal.size - rest]
    return inside.reshape(-1, size)[skip:]


def rms(signal: np.ndarray) -> float:
    """Return the root mean square without the mean."""
    return float(np.std(signal))


@dataclass
class Tuning:
    """The result of a run.

    Parameters
    ----------
    folder : Path
        The folder of the run.
    outcome : {"kept", "restored", "planned", "undone", "saved"}
        Whether the feedforward stays in the machine.
    code, reason : str
        Why the machine was restored; empty if it was not.
    facts : mapping
        Facts of each finished step.
    kind : {"translational", "rotational"}
        Kind of axis.
    way_out : Restoration, optional
        How the machine reads back; None if the run wrote nothing on it.
    again : str
        The command that repeats the run.
    remarks : list of str
        What could not be written.
    """

    folder: Path
    outcome: str
    code: str = ""
    reason: str = ""
    facts: dict[str, dict[str, Any]] = field(default_factory=dict)
    kind: Kind = "translational"
    way_out: Restoration | None = None
    again: str = ""
    remarks: list[str] = field(default_factory=list)

    @property
    def restored(self) -> bool:
        """Whether the machine reads back as before the run, if the run wrote on it."""
        return self.way_out is None or self.way_out.is_identical

    @property
    def change_percent(self) -> float | None:
        """Change of the rms following error [%]."""
        change = self.facts.get("comparison", {}).get("changes", {}).get("following_error.rms")
        return None if change is None else change["change_percent"]

    def as_data(self) -> dict[str, Any]:
        """Return the result for JSON."""
        return {
            "outcome": self.outcome,
            "code": self.code,
            "reason": self.reason,
            "steps": self.facts,
        }
