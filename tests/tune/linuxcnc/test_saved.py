"""A feedforward saved beside the configuration of LinuxCNC, and the version of the guard, on a HAL in memory."""

import re
import zlib

import pytest
from tests.tune.linuxcnc import double

from bristle.core import BristleError
from bristle.files import write_model
from bristle.friction import coulomb
from bristle.plants import inertia
from bristle.tune import FrictionFeedforward, Limits, MachineRefusedError
from bristle.tune.linuxcnc import LinuxCNC
from bristle.tune.linuxcnc.saved import guard_source

WIDE = Limits(6e-3, 1e4, (-1.0 / 3.0, 1.0))
SIGNALS = {"reference": "ref", "position": "pos", "effort": "eff", "motor": "rplant.0.effort", "thread": "servo"}
NAME = "bristle_1f2e3d4c"


@pytest.fixture
def hal(monkeypatch):
    """Return a HAL, in which the next machines run."""
    hals = [double.Hal()]
    monkeypatch.setattr("bristle.tune.linuxcnc.machine.Hal", lambda: hals[-1])
    hals[0].restarted = lambda: hals.append(double.Hal(hals[0].installed)) or hals[-1]
    return hals[0]


@pytest.fixture
def kept(hal, tmp_path):
    """Return a machine with a kept feedforward, its file, the folder of the model, and the state before."""
    machine = LinuxCNC(sample_time=1e-3, save=str(tmp_path / "bristle.hal"), **SIGNALS)
    before = machine.state()
    results = tmp_path / "results"
    results.mkdir()
    plant, friction = inertia(M=1.0), coulomb(F_C=1.0)
    write_model(results / "model.toml", plant, friction)
    machine.arm(WIDE)
    machine.load(FrictionFeedforward(results, NAME, plant, friction, 1.23456789e-3))
    machine.set(gain=2.0 / 3.0)
    machine.keep()
    return machine, tmp_path / "bristle.hal", results, before


def test_the_saved_file_rebuilds_the_kept_state_in_a_new_session(hal, kept):
    machine, file, results, before = kept
    written = machine.save(results)
    new = hal.restarted()
    machine = LinuxCNC(sample_time=1e-3, save=str(file), **SIGNALS)
    assert machine.state() == before
    new.run(*file.read_text().splitlines())
    assert machine.state() == kept[0].state()
    assert (new.values, new.linked, new.order) == (hal.values | {"bristle-guard.alive": 0.0}, hal.linked, hal.order)
    assert new.values["bristle-guard.gain"] == pytest.approx(2.0 / 3.0, rel=1e-6)
    assert (new.values["sampler.0.enable"], new.values["bristle-guard.keep"]) == (0.0, 1.0)
    assert machine.saved() == written
    assert f"HALFILE = {file}" in machine.loads
    machine.restore(before)
    machine.unsave()
    assert machine.state() == before
    assert set(machine.saved().values()) == {""}
    assert [path.name for path in file.parent.iterdir()] == ["results"]


def test_the_saved_sources_are_those_of_the_installed_components(hal, kept):
    _, file, results, _ = kept
    kept[0].save(results)
    sources = {path.stem: path.read_text().partition("\n")[2] for path in file.parent.glob("*.comp")}
    assert sources == hal.installed


@pytest.mark.parametrize("name", ["bristle.hal", f"{NAME}.comp"])
@pytest.mark.parametrize("is_edited", [False, True])
def test_a_file_of_the_user_is_neither_overwritten_nor_removed(kept, name, is_edited):
    machine, file, results, _ = kept
    if is_edited:
        machine.save(results)
    path = file.with_name(name)
    own = path.read_text() + "setp pid.0.Pgain 3\n" if is_edited else "loadrt siggen\n"
    path.write_text(own)
    for act in (lambda: machine.save(results), machine.unsave):
        if is_edited or act != machine.unsave:
            with pytest.raises(MachineRefusedError, match=f"{path} is not a file of bristle"):
                act()
        assert path.read_text() == own
    assert len(list(file.parent.glob("bristle*"))) == (3 if is_edited else 1)


def test_a_machine_file_without_the_key_is_refused_by_name(hal):
    machine = LinuxCNC(sample_time=1e-3, **SIGNALS)
    with pytest.raises(MachineRefusedError, match=r'save = "bristle\.hal" under \[settings\]') as refused:
        machine.saved()
    assert refused.value.code == "no_memory"


def test_the_version_of_the_guard_is_the_hash_of_its_source():
    version = re.search(r"version = (\d+) ", guard_source())[1]
    assert int(version) == zlib.crc32(guard_source().replace(version, "0").encode()) // 2


OLD = {"without a version": "pin in float gain\n;;\n", "of another version": guard_source().replace("version = ", "version = 1")}


@pytest.mark.parametrize("old", OLD)
def test_the_guard_of_another_version_is_replaced(hal, old):
    hal.installed["bristle_guard"] = OLD[old]
    machine = LinuxCNC(sample_time=1e-3, **SIGNALS)
    machine.arm(WIDE)
    assert hal.installed["bristle_guard"] == guard_source()
    assert hal.values["bristle-guard.low"] == -333.3333


def test_the_guard_of_this_version_is_not_compiled_again(hal, monkeypatch):
    hal.installed["bristle_guard"] = guard_source()
    monkeypatch.setattr(hal, "install", None)
    LinuxCNC(sample_time=1e-3, **SIGNALS).arm(WIDE)


@pytest.mark.parametrize(("old", "code"), [(OLD["of another version"], "old_guard"), (None, "not_compiled")])
def test_a_guard_that_cannot_be_installed_is_refused_by_name(hal, monkeypatch, old, code):
    def refused(name, source):
        raise MachineRefusedError("not_compiled", "halcompile refused it", "Run it as root")

    monkeypatch.setattr(hal, "install", refused)
    hal.installed |= {} if old is None else {"bristle_guard": old}
    machine = LinuxCNC(sample_time=1e-3, **SIGNALS)
    before = machine.state()
    with pytest.raises(BristleError, match=r"Run it as root") as error:
        machine.arm(WIDE)
    assert error.value.code == code
    machine.restore(before)
    assert machine.state() == before


def test_a_guard_that_stays_old_is_refused_by_name(hal, monkeypatch):
    hal.installed["bristle_guard"] = OLD["of another version"]
    monkeypatch.setattr(hal, "install", lambda name, source: None)
    with pytest.raises(MachineRefusedError, match="still loads the guard of another version"):
        LinuxCNC(sample_time=1e-3, **SIGNALS).arm(WIDE)
