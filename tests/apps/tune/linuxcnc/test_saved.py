"""A feedforward saved beside the configuration of LinuxCNC, and the version of the guard, on a HAL in memory."""

from importlib.resources import files
from pathlib import Path

import pytest
from tests.apps.tune.linuxcnc import double

from bristle.apps.tune import FrictionFeedforward, Limits, MachineRefusedError, MachineStoppedError
from bristle.apps.tune.linuxcnc.machine import LinuxCNC
from bristle.apps.tune.linuxcnc.saved import guard, source_of
from bristle.files import write_model
from bristle.models.friction import coulomb
from bristle.models.plants import inertia

WIDE = Limits(6e-3, 1e4, (-1.0 / 3.0, 1.0))
SIGNALS = {
    "reference": "ref",
    "position": "pos",
    "effort": "eff",
    "motor": "rplant.0.effort",
    "thread": "servo",
}
NAME = "bristle_1f2e3d4c"


def guard_text():
    return (files("bristle.apps.tune.linuxcnc") / "bristle_guard.comp").read_text()


@pytest.fixture
def hal(monkeypatch):
    """Return a HAL, in which the next machines run."""
    hals = [double.Hal()]
    monkeypatch.setattr("bristle.apps.tune.linuxcnc.machine.Hal", lambda: hals[-1])
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
    assert (new.values, new.linked, new.order) == (
        hal.values | {"bristle-guard.alive": 0.0},
        hal.linked,
        hal.order,
    )
    assert new.values["bristle-guard.gain"] == pytest.approx(2.0 / 3.0, rel=1e-6)
    assert (new.values["sampler.0.enable"], new.values["bristle-guard.keep"]) == (0.0, 1.0)
    assert machine.saved() == written
    assert new.order[-1] == "rplant.0"
    new.setp("bristle-guard.gain", "0.5")
    assert machine.state() != kept[0].state()
    assert f"HALFILE = {file}" in machine.loads
    machine.restore(before)
    machine.unsave()
    assert machine.state() == before
    assert set(machine.saved().values()) == {""}
    assert [path.name for path in file.parent.iterdir()] == ["results"]


def test_the_saved_sources_are_those_of_the_installed_components(hal, kept):
    _, file, results, _ = kept
    kept[0].save(results)
    sources = {
        path.stem: path.read_text().partition("\n")[2] for path in file.parent.glob("*.comp")
    }
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
    with pytest.raises(
        MachineRefusedError, match=r'save = "bristle\.hal" under \[settings\]'
    ) as refused:
        machine.saved()
    assert refused.value.code == "no_memory"


def changed_guard():
    return guard_text().replace("slew = 2.0", "slew = 3.0")


def test_the_guard_of_another_version_is_not_loaded(hal, monkeypatch):
    old, source = guard(), source_of(guard(), Path())
    hal.installed[old] = source
    machine = LinuxCNC(sample_time=1e-3, **SIGNALS)
    before = machine.state()
    machine.arm(WIDE)
    assert (hal.values["bristle-guard.slew"], list(hal.installed)) == (2.0, [old])
    machine.restore(before)
    monkeypatch.setattr("bristle.apps.tune.linuxcnc.saved._guard_text", changed_guard)
    LinuxCNC(sample_time=1e-3, **SIGNALS).arm(WIDE)
    assert (hal.values["bristle-guard.slew"], hal.values["bristle-guard.low"]) == (3.0, -333.3333)
    assert hal.installed == {old: source, guard(): source_of(guard(), Path())}
    assert guard() != old


def test_the_guard_of_this_version_is_not_compiled_again(hal, monkeypatch):
    hal.installed[guard()] = source_of(guard(), Path())
    monkeypatch.setattr(hal, "install", None)
    LinuxCNC(sample_time=1e-3, **SIGNALS).arm(WIDE)


def test_a_guard_that_cannot_be_installed_is_refused_by_name(hal, monkeypatch):
    def refused(name, source):
        raise MachineRefusedError("not_compiled", f"halcompile refused {name}", "Run it as root")

    monkeypatch.setattr(hal, "install", refused)
    hal.installed["bristle_guard"] = guard_text()  # of a bristle whose guard had no version
    machine = LinuxCNC(sample_time=1e-3, **SIGNALS)
    before = machine.state()
    with pytest.raises(MachineRefusedError, match=f"halcompile refused {guard()}. Run it as root"):
        machine.arm(WIDE)
    machine.restore(before)
    assert machine.state() == before


def test_the_guard_of_another_version_is_not_saved_under_its_name(kept, monkeypatch):
    machine, file, results, _ = kept
    monkeypatch.setattr("bristle.apps.tune.linuxcnc.saved._guard_text", changed_guard)
    with pytest.raises(MachineRefusedError, match="guard of another version of bristle") as refused:
        machine.save(results)
    assert (refused.value.code, list(file.parent.glob("bristle*"))) == ("old_guard", [])


@pytest.mark.parametrize(("cause", "reason"), [(0, ""), (2, "effort")])
def test_a_guard_that_tripped_before_the_feedforward_is_kept_is_cleared_or_named(
    kept, hal, cause, reason
):
    hal.values |= {"bristle-guard.ok": 0.0, "bristle-guard.why": float(cause)}
    if not reason:
        kept[0].keep()
        assert (hal.values["bristle-guard.ok"], hal.values["bristle-guard.reset"]) == (1.0, 0.0)
    else:
        with pytest.raises(MachineStoppedError) as stopped:
            kept[0].keep()
        assert stopped.value.reason == reason
