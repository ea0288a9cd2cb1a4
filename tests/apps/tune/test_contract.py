"""The contract of machines: the bench and an experiment meet it, and each fault is noticed by the demand that names it."""

import sys
from pathlib import Path

import pytest
from tests.apps.tune.machine import Example, written

from bristle.apps.tune.ads import Ads
from bristle.apps.tune.contract import check_machine
from bristle.apps.tune.experiment import ExperimentMachine
from bristle.apps.tune.machines import connected
from bristle.apps.tune.opcua import OpcUa
from bristle.core import InputError, MissingExtraError
from bristle.files import read_machine

RIG = Path(__file__).parents[3] / "examples/tune/machine.toml"


class Rig(ExperimentMachine):
    """The experiment of the example, as a machine of a user."""

    @classmethod
    def example(cls):
        settings = read_machine(RIG).settings
        return cls(**settings | {"file": str(RIG.with_name(settings["file"]))})


class Saving(Example):
    """The bench with non-volatile memory: what it contains at a restart is in force again."""

    def __init__(self, **settings):
        super().__init__(**settings)
        self.stored = {}

    loads = ""

    def saved(self):
        return {"bench": self.stored.get("model") or ""}

    def save(self, folder):
        self.stored = dict(self._written)
        return self.saved()

    def unsave(self):
        self.stored = {}

    @classmethod
    def restarted(cls, machine):
        again = cls()
        again.stored = machine.stored
        again._write(**machine.stored)
        return again


@pytest.mark.parametrize("machine", [Rig, Saving])
def test_a_machine_meets_the_contract(machine):
    assert [
        (check.name, check.detail)
        for check in check_machine(machine, move=True)
        if not check.passed
    ] == []


class NoGuard(Example):
    def __init__(self, **settings):
        super().__init__(**settings)
        self.faults.guard_fails = True


class LosesSamples(Example):
    def __init__(self, **settings):
        super().__init__(**settings)
        self.faults.lost = {"0": 2}


class StaysArmed(Example):
    def restore(self, state):
        self._write(gain=0.0)


class NoGain(Example):
    def set(self, *, gain=0.0, offset=0.0):
        super().set(offset=offset)


class NoMethods:
    def identity(self):
        return {}


class SavesNothing(Saving):
    def save(self, folder):
        return {"bench": "bristle_contract"}


class SavesWithoutGain(Saving):
    def save(self, folder):
        self.stored = self._written | {"gain": 0.0}
        return self.saved()


class NamesAnother(Saving):
    def save(self, folder):
        super().save(folder)
        return {"bench": "another"}


class KeepsSaved(Saving):
    def unsave(self):
        pass


class KeepsGuard(Saving):
    def unsave(self):
        self.stored = self.stored | {"model": None}


FAULTS = {
    "all methods": NoMethods,
    "every sample": LosesSamples,
    "guard trips": NoGuard,
    "gain of feedforward": NoGain,
    "restores": StaysArmed,
}


@pytest.mark.parametrize(
    "machine", [SavesNothing, SavesWithoutGain, NamesAnother, KeepsSaved, KeepsGuard]
)
def test_a_faulty_memory_is_noticed(machine):
    assert [check.name for check in check_machine(machine, move=True) if not check.passed] == [
        "saves"
    ]


def test_a_machine_that_saves_has_all_methods_of_saving():
    class NoRemoval(Saving):
        unsave = None

    assert (
        next(check.detail for check in check_machine(NoRemoval, move=True) if not check.passed)
        == "methods are missing: unsave"
    )


@pytest.mark.parametrize("demand", FAULTS)
def test_each_fault_is_noticed(demand):
    assert [
        check.name for check in check_machine(FAULTS[demand], move=True) if not check.passed
    ] == [demand]


OPCUA = 'url = "opc.tcp://x"\nprefix = "ns=2;s="\n[settings.names]\nspeed = "i=1"'


@pytest.mark.parametrize(
    ("machine", "settings", "words"),
    [
        ("ads", 'net_id = "1.2.3.4.1.1"', r"settings\.prefix"),
        ("opcua", "", r"settings\.url"),
        ("opcua", OPCUA, "speed"),
    ],
)
def test_a_machine_file_states_the_address_of_the_controller(tmp_path, machine, settings, words):
    file = written(tmp_path, 4)[0]
    file.write_text(
        file.read_text().replace('"bench.py"', f'"{machine}"') + f"[settings]\n{settings}\n"
    )
    with pytest.raises(InputError, match=words):
        connected(read_machine(file))


@pytest.mark.parametrize(
    ("machine", "library", "settings"),
    [
        (Ads, "pyads", {"net_id": "1.2.3.4.1.1"}),
        (OpcUa, "asyncua", {"url": "opc.tcp://127.0.0.1:1"}),
    ],
)
def test_without_the_library_the_extra_is_named(monkeypatch, machine, library, settings):
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(MissingExtraError, match=rf"bristle\[{machine.__name__.lower()}\]"):
        machine(**settings, prefix="MAIN.tune.", sample_time=1e-3)
