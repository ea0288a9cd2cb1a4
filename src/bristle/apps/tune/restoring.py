"""The way out of a run: restore the machine from its backup, read it back, and only then write of it."""

import json
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from bristle.apps.tune.machine import Machine, MachineRefusedError, MachineStoppedError, State
from bristle.core import BristleError, error_text

# Of a restoration; before the second one [s], twice as long before the third.
ATTEMPTS, PAUSE = (3, 0.1)


@dataclass(frozen=True)
class Restoration:
    """How a machine reads back after its restoration.

    Parameters
    ----------
    different : mapping
        Each entry of the backup that reads back differently: before and now.
    fault : str
        Why the last attempt failed; empty if the machine was restored and read.
    """

    different: State = field(default_factory=dict)
    fault: str = ""

    @property
    def is_identical(self) -> bool:
        """Whether the machine was read, and reads as before."""
        return not self.fault and not self.different

    def as_data(self) -> State:
        """Return the facts for the journal."""
        return {"identical": self.is_identical, "different": dict(self.different)} | (
            {"fault": self.fault} if self.fault else {}
        )


def restored(machine: Machine, backup: State) -> Restoration:
    """Restore a machine and read it back, in up to three attempts; a signal ends an attempt, and not the restoration."""
    result = Restoration()
    for attempt in range(ATTEMPTS):
        try:
            time.sleep(attempt * PAUSE)
            machine.restore(backup)
            result = Restoration(differences(plain(backup), plain(machine.state())))
        except BaseException as error:  # noqa: BLE001  (whatever happens, the machine comes first)
            result = Restoration(fault=named(error)[1])
        if result.is_identical:
            break
    return result


def plain(state: State) -> State:
    """Return a state as the journal reads it back."""
    return json.loads(json.dumps(dict(state)))


def differences(state: State, present: State, path: str = "") -> State:
    """Return each entry that differs, before and now."""
    different = {}
    for name in [*state, *(name for name in present if name not in state)]:
        old, new = state.get(name), present.get(name)
        if isinstance(old, dict) and isinstance(new, dict):
            different |= differences(old, new, f"{path}{name}: ")
        elif old != new:
            different[f"{path}{name}"] = [old, new]
    return different


def named(error: BaseException) -> tuple[str, str]:
    """Return the code of what ended a run, and its reason."""
    if isinstance(error, MachineRefusedError):
        return error.code, str(error)
    if isinstance(error, MachineStoppedError):
        return error.reason, str(error)
    if isinstance(error, BristleError):
        return "input", str(error)
    kind = type(error).__name__
    if not isinstance(error, Exception):  # a signal
        return kind, error_text(error) or kind
    place = traceback.extract_tb(error.__traceback__)[-1]
    message = f"{kind}: {error_text(error)}".rstrip(": ")
    return "failed", f"{message} ({Path(place.filename).name}, line {place.lineno})"


@contextmanager
def answering() -> Iterator[None]:
    """Turn what the code of a machine raises, or the disk, into a refusal that names it."""
    try:
        yield
    except BristleError:
        raise
    except Exception as error:
        raise MachineRefusedError(
            "failed", named(error)[1], "Mend the cause, and repeat the command"
        ) from error
