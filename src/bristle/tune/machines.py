"""The machines: built-in ones by name, and Python files of the user."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bristle.core import InputError, did_you_mean
from bristle.files import MachineFile, declared_in
from bristle.tune.machine import Machine


def _experiment(file: MachineFile) -> Machine:
    from bristle.tune.experiment import ExperimentMachine

    return ExperimentMachine.of(file)


def _linuxcnc(file: MachineFile) -> Machine:
    from bristle.tune.linuxcnc import LinuxCNC

    return LinuxCNC.of(file)


BUILT_IN: dict[str, Callable[[MachineFile], Machine]] = {"experiment": _experiment, "linuxcnc": _linuxcnc}


def connected(file: MachineFile) -> Machine:
    """Return the machine of a machine file, connected."""
    if file.machine in BUILT_IN:
        return BUILT_IN[file.machine](file)
    if not file.machine.endswith(".py"):
        known = f"{', '.join(BUILT_IN)}, or a Python file"
        raise InputError("is not a machine", path="machine", value=file.machine, allowed=known, mend=did_you_mean(file.machine, BUILT_IN))
    own: Any = declared_in(
        file.source.parent / file.machine, "MACHINE", type, title="machine", mend="End the file with MACHINE = MyMachine"
    )
    return own(**file.settings)
