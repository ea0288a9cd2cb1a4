"""The machines: built-in ones by name, and Python files of the user."""

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from bristle.apps.tune.machine import Machine
from bristle.core import InputError, Kind, Readable, did_you_mean
from bristle.files import code_named, declared_in

BUILT_IN = ("experiment", "linuxcnc", "ads", "opcua")


class Connection(NamedTuple):
    """What connects a machine: its name, its settings, and its machine file, beside which its code is; and the kind of its axis."""

    machine: str
    settings: dict[str, Any]
    source: Path
    kind: Kind = "translational"

    def as_data(self) -> dict[str, Any]:
        """Return the entry for the journal, from which a later process connects the machine."""
        return json.loads(
            json.dumps(
                {"machine": self.machine, "settings": self.settings, "kind": self.kind}, default=str
            )
        )


def code_of(link: Connection) -> str:
    """Return the SHA-256 of the code of a machine; empty if it has none, or none that can be read."""
    file = link.source.parent / link.machine
    if link.machine in BUILT_IN or not file.is_file():
        return ""
    return hashlib.sha256(file.read_bytes()).hexdigest()


def _built_in(name: str) -> Any:
    """Return the class of a built-in machine; its libraries are loaded only then."""
    if name == "experiment":
        from bristle.apps.tune.experiment import ExperimentMachine

        return ExperimentMachine
    if name == "linuxcnc":
        from bristle.apps.tune.linuxcnc import LinuxCNC

        return LinuxCNC
    if name == "ads":
        from bristle.apps.tune.ads import Ads

        return Ads
    from bristle.apps.tune.opcua import OpcUa

    return OpcUa


def connected(file: Connection, *, allow_code: bool = False) -> Machine:
    """Return a machine, connected; code of the user needs permission."""
    if file.machine in BUILT_IN:
        kind, settings = _built_in(file.machine), dict(file.settings)
        for key, (meaning, example) in kind.REQUIRED.items():
            if not isinstance(settings.get(key), str):
                raise InputError(
                    f"is missing{meaning}",
                    path=f"settings.{key}",
                    mend=f'Write {key} = "{example}" under [settings]',
                )
        for key in {"file", "save"} & settings.keys():
            settings[key] = str(file.source.parent.absolute() / str(settings[key]))
        try:
            return kind(**settings)
        except TypeError as error:
            raise InputError(f"is not valid ({error})", path="settings") from None
    if not file.machine.endswith(".py"):
        raise InputError(
            "is not a machine",
            path="machine",
            value=file.machine,
            allowed=f"{', '.join(BUILT_IN)}, or a Python file",
            mend=did_you_mean(file.machine, BUILT_IN),
        )
    content = code_named(file.machine, "machine", folder=file.source.parent, allow_code=allow_code)
    try:
        return load_machine_file(content)(**file.settings)
    except TypeError as error:
        raise InputError(f"does not fit the machine ({error})", path="settings") from None


def load_machine_file(path: Readable) -> Callable[..., Machine]:
    """Return the class of machines that a Python file defines as ``MACHINE``."""
    return declared_in(
        path, "MACHINE", type, title="machine", mend="End the file with MACHINE = MyMachine"
    )
