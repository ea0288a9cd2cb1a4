"""The contract of a machine: what `bristle tune` relies on before it moves an axis."""

import json
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any

import numpy as np

from bristle.apps.tune.machine import FrictionFeedforward, Limits, MachineStoppedError
from bristle.contract import Check, Fact, UnmetError, outcomes
from bristle.models.friction import coulomb
from bristle.models.plants import inertia

METHODS = (
    "identity",
    "writes",
    "state",
    "arm",
    "load",
    "set",
    "record",
    "keep",
    "restore",
    "close",
)
WIDE = Limits(1.0, 1e6, (-1.0, 1.0))
FEEDFORWARD = FrictionFeedforward(Path(), "bristle_contract", inertia(M=1.0), coulomb(F_C=1.0), 0.0)
SMALL = 1e-4  # amplitude of the motion of the contract [m or rad]
SAVING = ("save", "saved", "unsave", "restarted")
STATE = "Return the same plain data while nothing is written"
ADVICE = "See the methods of bristle.apps.tune.Machine"


def check_machine(machine: Any, *, move: bool = False) -> list[Check]:
    """Return the outcome of each demand on a class of machines; only the machine of its class method ``example`` moves.

    Parameters
    ----------
    machine : type
        The class; ``example()`` returns a machine at rest at the position 0, which should be one without hardware. A class with the
        method ``save`` also has a class method ``restarted(machine)``: it restarts the controller of this machine, and returns a new
        connection.
    move : bool
        Whether this machine may move and be written. Without it, methods and two readings of the state are checked. With it, the
        machine is restored as it was found, at gain 0, behind each demand.
    """
    moving = (every_sample, guard_trips, gain_of_feedforward, restores, saves)
    demands = [all_methods, plain_state, *(guarded(demand, move=move) for demand in moving)]
    return outcomes(demands, machine, (all_methods,), ADVICE)


def guarded(demand: Callable[[Any], Fact], *, move: bool) -> Callable[[Any], Fact]:
    """Return a demand behind which the machine is as it was found; without `move` it is not tried."""

    @wraps(demand)
    def tried(machine: Any) -> Fact:
        if not move:
            return Fact("not tried: it moves the machine of example(). Add --move", applies=False)
        found = _plain(machine.example())
        try:
            return demand(machine)
        finally:
            instance = machine.example()
            if _plain(instance) != found:
                instance.set()
                instance.restore(found)

    return tried


def all_methods(machine: Any) -> Fact:
    """Check that all methods exist, and a class method for a machine without hardware."""
    needed = (*METHODS, "example", *(SAVING if hasattr(machine, "save") else ()))
    missing = [name for name in needed if not callable(getattr(machine, name, None))]
    if missing:
        raise UnmetError(f"methods are missing: {', '.join(missing)}", ADVICE)
    return Fact("present")


def plain_state(machine: Any) -> Fact:
    """Check that state and identity are plain data, and equal in two readings."""
    instance = machine.example()
    if _plain(instance) != _plain(instance) or dict(instance.identity()) != dict(
        instance.identity()
    ):
        raise UnmetError("two readings of state or identity differ", STATE)
    if not instance.writes():
        raise UnmetError(
            "the allow list is empty", "Return the names of everything that a run may write"
        )
    return Fact(f"{len(instance.state())} entries, read twice")


def every_sample(machine: Any) -> Fact:
    """Check that a record contains each sample of the motion."""
    instance = _armed(machine, WIDE)
    time = np.linspace(0.0, 1.0, max(round(1.0 / instance.sample_time), 100))
    played = np.concatenate(
        [_rest(instance), SMALL * (1.0 - np.cos(2.0 * np.pi * time)), _rest(instance)]
    )
    recording = instance.record(played, lambda: None)
    for name in ("reference", "position", "effort"):
        signal = getattr(recording, name)
        if np.shape(signal) != played.shape or not np.all(np.isfinite(signal)):
            raise UnmetError(
                f"{name} has {np.size(signal)} samples, the motion {played.size}",
                "Refuse a record with lost samples",
            )
    if not np.allclose(recording.reference, played, rtol=0.0, atol=1e-2 * SMALL):
        raise UnmetError(
            "the recorded reference is not the motion", "Check the scale, and the first sample"
        )
    if np.ptp(recording.position) < 0.1 * SMALL:
        raise UnmetError(
            "the position does not follow the motion", "Return the measured position [m or rad]"
        )
    return Fact(f"{played.size} samples")


def guard_trips(machine: Any) -> Fact:
    """Check that the guard ends a motion beyond travel and following error, by name."""
    for reason, limits in {
        "travel": Limits(1.0, 1e6, (0.5, 1.0)),
        "following_error": Limits(1e-12, 1e6, (-1.0, 1.0)),
    }.items():
        instance = _armed(machine, limits)
        try:
            instance.record(_ramp(instance), lambda: None)
        except MachineStoppedError as stopped:
            if stopped.reason != reason:
                raise UnmetError(
                    f"the guard names {stopped.reason} instead of {reason}", "Name the limit"
                ) from None
        else:
            raise UnmetError(
                f"the guard does not trip beyond the limit of {reason}", "Raise MachineStoppedError"
            )
    return Fact("travel, following error")


def gain_of_feedforward(machine: Any) -> Fact:
    """Check that a feedforward is loaded at gain 0, and its gain changes the effort."""
    efforts = []
    for gain in (None, 1.0):
        instance = _armed(machine, WIDE)
        instance.load(FEEDFORWARD)
        if gain is not None:
            instance.set(gain=gain)
        efforts.append(instance.record(_ramp(instance), lambda: None).effort)
    difference = float(np.max(np.abs(efforts[1] - efforts[0])))
    if difference < 0.05:
        raise UnmetError(
            "a gain of 1 changes the effort as little as a gain of 0",
            "Add gain times feedforward to the effort of the loop",
        )
    return Fact("changes the effort", difference)


def restores(machine: Any) -> Fact:
    """Check that a restored machine reads back as before, also after a second restoration."""
    instance = machine.example()
    before = _plain(instance)
    instance.arm(WIDE)
    instance.set(gain=0.0)
    if _plain(instance) == before:
        raise UnmetError(
            "the state does not show that the guard was inserted", "Include the guard in the state"
        )
    for _ in range(2):
        instance.restore(before)
        if _plain(instance) != before:
            raise UnmetError(
                "the state after restore differs from that of before",
                "Write back everything on the allow list",
            )
    return Fact("reads back as before")


def saves(machine: Any) -> Fact:
    """Check that a saved feedforward is in force after a restart of the controller, and a removed one is not."""
    if not hasattr(machine, "save"):
        return Fact("no non-volatile memory", applies=False)
    before, instance = _plain(machine.example()), _armed(machine, WIDE)
    instance.load(FEEDFORWARD)
    instance.set(gain=0.5)
    instance.keep()
    kept, empty = _plain(instance), not any(instance.saved().values())
    written = dict(instance.save(Path()))
    instance = machine.restarted(instance)
    if (
        not empty
        or _plain(instance) != kept
        or dict(instance.saved()) != written
        or not all(written.values())
    ):
        raise UnmetError(
            "state or memory after a restart differ from those that were saved",
            "Save all of the state, and read it back",
        )
    instance.restore(before)
    instance.unsave()
    instance = machine.restarted(instance)
    if _plain(instance) != before or any(instance.saved().values()):
        raise UnmetError(
            "a removed feedforward is in force after a restart", "Remove all that save wrote"
        )
    return Fact("in force after a restart, until it is removed")


def _plain(machine: Any) -> Any:
    return json.loads(json.dumps(dict(machine.state())))


def _armed(machine: Any, limits: Limits) -> Any:
    instance = machine.example()
    instance.arm(limits)
    instance.set()
    return instance


def _ramp(machine: Any) -> np.ndarray:
    return 20.0 * SMALL * np.linspace(0.0, 1.0, max(round(1.5 / machine.sample_time), 100))


def _rest(machine: Any) -> np.ndarray:
    return np.zeros(max(round(0.2 / machine.sample_time), 20))
