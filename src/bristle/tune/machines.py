"""The machines: built-in ones by name, and Python files of the user."""

from __future__ import annotations

from collections.abc import Callable

from bristle.core import InputError, Readable, did_you_mean
from bristle.files import MachineFile, code_named, declared_in
from bristle.tune.machine import Machine


def _experiment(file: MachineFile) -> Machine:
    from bristle.tune.experiment import ExperimentMachine

    return ExperimentMachine.of(file)


def _linuxcnc(file: MachineFile) -> Machine:
    from bristle.tune.linuxcnc import LinuxCNC

    return LinuxCNC.of(file)


def _ads(file: MachineFile) -> Machine:
    from bristle.tune.ads import Ads

    return Ads.of(file)


def _opcua(file: MachineFile) -> Machine:
    from bristle.tune.opcua import OpcUa

    return OpcUa.of(file)


BUILT_IN: dict[str, Callable[[MachineFile], Machine]] = {"experiment": _experiment, "linuxcnc": _linuxcnc, "ads": _ads, "opcua": _opcua}


def connected(file: MachineFile, *, allow_code: bool = False) -> Machine:
    """Return the machine of a machine file, connected; code of the user needs permission."""
    if file.machine in BUILT_IN:
        return BUILT_IN[file.machine](file)
    if not file.machine.endswith(".py"):
        allowed = f"{', '.join(BUILT_IN)}, or a Python file"
        raise InputError("is not a machine", path="machine", value=file.machine, allowed=allowed, mend=did_you_mean(file.machine, BUILT_IN))
    content = code_named(file.machine, "machine", folder=file.source.parent, allow_code=allow_code)
    try:
        return load_machine_file(content)(**file.settings)
    except TypeError as error:
        raise InputError(f"does not fit the machine ({error})", path="settings") from None


def load_machine_file(path: Readable) -> Callable[..., Machine]:
    """Return the class of machines that a Python file defines as ``MACHINE``."""
    return declared_in(path, "MACHINE", type, title="machine", mend="End the file with MACHINE = MyMachine")
