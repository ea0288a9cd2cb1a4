"""The machine `ads`, against pyads' own server: the Structured Text runs in C behind it."""

import os
import socket
import struct
import time
from pathlib import Path

import numpy as np
import pytest
from tests.apps.tune.machine import AXIS, MACHINE
from tests.apps.tune.plc import PERSISTENT, WIDE, Plc, Task, compiled, examples, stroke
from tests.exports.native import COMPILER

from bristle.apps.tune import (
    FrictionFeedforward,
    MachineRefusedError,
    MachineStoppedError,
    Options,
    tune,
    undo,
)
from bristle.apps.tune.ads import Ads
from bristle.apps.tune.contract import check_machine
from bristle.models.friction import coulomb
from bristle.models.plants import inertia

pyads = pytest.importorskip("pyads", reason="pyads is not installed")
testserver = pytest.importorskip("pyads.testserver", reason="pyads has no test server")
pytestmark = pytest.mark.skipif(
    COMPILER is None, reason="the Structured Text runs as C, and there is no compiler"
)
ADDRESS = f"127.{1 + (os.getpid() >> 16 & 63)}.{os.getpid() >> 8 & 255}.{os.getpid() & 255}"  # pyads fixes the port
PREFIX = "MAIN.tune."
ADVANCE = 100  # cycles of the controller at each request


class Controller(testserver.AdvancedHandler):
    """The handler of pyads, with the variables of a controller that advances at each request."""

    def __init__(self, plc: Plc) -> None:
        super().__init__()
        self.plc, self.advance = plc, ADVANCE
        for name in plc.variables:
            self.add_variable(Variable(plc, name))

    def handle_request(self, request):
        try:
            return super().handle_request(request)
        except KeyError:  # the server of pyads ends here; a controller answers "symbol not found"
            return testserver.handler.AmsResponseData(
                struct.pack("<H", 5), request.ams_header.error_code, struct.pack("<II", 0x710, 0)
            )
        finally:
            self.plc.cycles(self.advance)


class Variable(testserver.PLCVariable):
    """A variable of the function block."""

    def __init__(self, plc: Plc, name: str) -> None:
        self._plc, self._variable = plc, name
        super().__init__(f"{PREFIX}{name}", plc.content(name), pyads.constants.ADST_VOID, "ANY")

    value = property(lambda self: self._plc.content(self._variable), lambda self, content: None)

    def write(self, value, request=None):
        self._plc.put(self._variable, value)


def _listens(port):
    with socket.socket() as probe:
        return probe.connect_ex((ADDRESS, port)) == 0


@pytest.fixture(scope="module")
def controller(tmp_path_factory):
    handler = Controller(Plc(compiled(tmp_path_factory.mktemp("plc"))))
    with testserver.AdsTestServer(handler, ADDRESS, logging=False) as server:
        end = time.monotonic() + 5.0
        while not _listens(server.port) and time.monotonic() < end:
            time.sleep(0.01)  # the server listens from its own thread
        yield handler


@pytest.fixture
def kind(controller):
    """Return the class of machines on the controller, which starts anew."""

    def restart(*, as_new):
        (controller.plc.restart if as_new else controller.plc.reboot)()
        controller.advance = ADVANCE

    with examples(
        Ads, restart, net_id=f"{ADDRESS}.1.1", address=ADDRESS, prefix=PREFIX, patience=1e3
    ) as example:
        yield example


@pytest.mark.slow
def test_the_machine_meets_the_contract(kind):
    assert [
        (check.name, check.detail) for check in check_machine(kind, move=True) if not check.passed
    ] == []


def test_each_row_is_that_of_the_axis(armed, controller):
    recording = armed.record(stroke(6000), lambda: None)
    np.testing.assert_allclose(recording.reference, stroke(6000), atol=1e-15)
    assert recording.position[-1] == pytest.approx(
        1e-3 * controller.plc.value("position"), abs=2e-6
    )
    assert np.max(np.abs(recording.error)) < 5e-4


def test_lost_rows_are_refused_with_their_number(armed, controller):
    motion = stroke(6000)

    def late():
        if controller.plc.value("count") > 1000:
            controller.advance = 3000  # more than the ring of 4000 rows between two readings

    with pytest.raises(MachineStoppedError, match=r"lost samples: \d+ of 6100 rows") as stopped:
        armed.record(motion, late)
    assert stopped.value.reason == "lost_samples"
    assert 0 < int(stopped.value.detail.split()[0]) < 6100
    assert controller.plc.value("rows") == 6100


@pytest.mark.slow
def test_the_feedforward_is_added_in_a_ramp_and_fades(armed, controller):
    armed.load(FrictionFeedforward(Path(), "bristle_x", inertia(M=1.0), coulomb(F_C=10.0), 0.0))
    recordings = []
    for gain in (0.0, 1.0):
        armed.set(gain=gain)
        recordings.append(armed.record(stroke(3000), lambda: None))
    errors = [np.mean(np.abs(recording.error[1000:])) for recording in recordings]
    assert errors[1] < 0.7 * errors[0]
    for _ in range(40):
        armed.state()
    assert controller.plc.value("gain_now") == 0.0


def test_a_silent_program_loses_the_axis(armed, controller):
    armed.set(offset=2.0)
    controller.plc.put("patience", (100).to_bytes(4, "little"))
    controller.plc.cycles(101)
    assert (controller.plc.value("ok"), controller.plc.value("cause")) == (False, 4)
    assert controller.plc.value("effort") == controller.plc.value("controller")


def test_an_operator_stops_the_motion(armed, controller):

    def alive():
        if controller.plc.value("count") > 100:
            raise MachineStoppedError("operator")

    with pytest.raises(MachineStoppedError, match="operator"):
        armed.record(stroke(6000), alive)
    armed.state()
    assert not controller.plc.value("playing")
    assert controller.plc.value("count") < 3000


def kept_one(kind):
    """Return a machine with a kept feedforward, and its state before."""
    machine = kind.example()
    before = machine.state()
    machine.arm(WIDE)
    machine.load(FrictionFeedforward(Path(), "bristle_x", inertia(M=1.0), coulomb(F_C=10.0), 0.0))
    machine.set(gain=0.5)
    machine.record(stroke(), lambda: None)
    machine.keep()
    return machine, before


def test_a_guard_that_tripped_while_the_program_computed_is_cleared_or_named_when_it_keeps(
    kind, controller
):
    machine, _ = kept_one(kind)
    controller.plc.put("keep", b"\0")
    controller.plc.put("patience", (100).to_bytes(4, "little"))
    controller.plc.cycles(101)
    assert (controller.plc.value("ok"), controller.plc.value("cause")) == (False, 4)
    machine.keep()
    assert controller.plc.value("ok")
    machine._write("max_effort", 0.0)
    with pytest.raises(MachineStoppedError) as stopped:
        machine.keep()
    assert stopped.value.reason == "effort"


def test_a_kept_feedforward_is_gone_after_a_restart(kind, controller):
    machine, _ = kept_one(kind)
    for name in PERSISTENT:  # a controller that stores at any time, without a command
        controller.plc.stored[name] = controller.plc.content(name)
    state = kind.restarted(machine).state()
    assert (state["armed"], state["keep"]) == (False, False)
    controller.advance = 0
    controller.plc.put("again", b"\1")
    controller.plc.cycles(400)
    controller.plc.put("again", b"\0")
    assert (controller.plc.value("playing"), controller.plc.value("gain_now")) == (False, 0.0)


def test_a_saved_feedforward_plays_after_a_restart_as_before(kind, controller):
    machine, before = kept_one(kind)
    kept, motion = machine.state(), controller.plc.content("motion")
    written = machine.save(Path())
    machine = kind.restarted(machine)
    assert (machine.state(), machine.saved()) == (kept, written)
    assert controller.plc.content("motion") == motion
    for keep in (b"\0", b"\1"):
        controller.plc.put("keep", keep)
        with pytest.raises(MachineRefusedError, match="keeps the feedforward"):
            machine.arm(WIDE)
    controller.plc.put("again", b"\1")
    controller.advance = 0
    controller.plc.cycles(400)
    controller.plc.put("again", b"\0")
    controller.advance = ADVANCE
    assert (controller.plc.value("ok"), controller.plc.value("gain_now")) == (True, 0.5)
    machine.restore(before)
    machine.unsave()
    machine = kind.restarted(machine)
    assert (machine.state(), set(machine.saved().values())) == (before, {""})


def test_a_saved_feedforward_does_not_trip_where_the_axis_starts(kind, controller):
    machine, _ = kept_one(kind)
    machine.save(Path())
    controller.plc.reboot(position=5e-3)
    assert [controller.plc.value(name) for name in ("armed", "ok", "setpoint")] == [True, True, 5.0]


def test_a_program_that_stores_nothing_is_refused(kind, controller, monkeypatch):
    monkeypatch.setattr("bristle.apps.tune.function_block.STORING", 0.2)
    machine, _ = kept_one(kind)
    controller.plc.stores = False
    with pytest.raises(
        MachineRefusedError, match=r"not report .* stored\. Connect store and stored"
    ):
        machine.save(Path())
    assert (controller.plc.value("save"), controller.plc.value("saved")) == (False, False)


@pytest.mark.parametrize(("keep", "ok"), [(b"\1", True), (b"\0", False)])
def test_the_program_clears_a_trip_of_a_kept_feedforward_only(kind, controller, keep, ok):
    plc = kept_one(kind)[0] and controller.plc
    plc.put("ok", b"\0")
    plc.put("keep", keep)
    plc.cycles(1)
    assert not plc.value("ok")
    plc.put("reset", b"\1")
    plc.cycles(1)
    assert plc.value("ok") is ok
    plc.put("reset", b"\0")


@pytest.mark.slow
def test_a_stopped_controller_is_named(kind, controller):
    machine = kind.example()
    controller.plc.runs = False
    try:
        with pytest.raises(MachineRefusedError, match="does not run"):
            machine.arm(WIDE)
    finally:
        controller.plc.runs = True


def test_a_wrong_prefix_is_refused_by_name(controller):
    with pytest.raises(MachineRefusedError, match=r"MAIN\.other\.ring_rows"):
        Ads(net_id=f"{ADDRESS}.1.1", address=ADDRESS, prefix="MAIN.other.", sample_time=1e-3)


@pytest.mark.slow
def test_a_minute_in_real_time_loses_no_row(kind, controller):
    machine = kind.example()
    machine._patience = 1e3
    controller.advance = 0
    with Task(controller.plc):
        machine.arm(WIDE)
        motion = np.tile(1e-3 * (1.0 - np.cos(np.linspace(0.0, 2.0 * np.pi, 2000))), 30)
        recording = machine.record(motion, lambda: None)
    np.testing.assert_allclose(recording.reference, motion, atol=1e-15)


@pytest.mark.slow
def test_a_run_keeps_a_feedforward_and_undo_restores_the_controller(kind, controller, tmp_path):
    machine = kind.example()
    before = machine.state()
    (tmp_path / "axis.toml").write_text(AXIS.format(limit=400.0, resolution=1e-8))
    (tmp_path / "machine.toml").write_text(MACHINE.format(cycles=6))
    cycle = 1e3 * (1.0 - np.cos(np.linspace(0.0, 2.0 * np.pi, 1501)))
    table = np.column_stack([1e-3 * np.arange(cycle.size), cycle])
    np.savetxt(
        tmp_path / "motion.csv",
        table,
        fmt="%.9g",
        delimiter=",",
        header="time [s],ref [um]",
        comments="",
    )
    options = Options(models="dahl", duration=20.0)
    result = tune(
        tmp_path / "machine.toml", tmp_path / "out", move=True, machine=machine, options=options
    )
    assert result.outcome == "kept", result.reason
    with pytest.raises(MachineRefusedError, match="closed"):
        machine.state()
    state = kind.again().state()
    assert (state["keep"], state["gain"]) == (True, result.facts["comparison"]["gain"])
    assert undo(tmp_path / "out", machine=kind.again()).outcome == "undone"
    assert kind.again().state() == before
