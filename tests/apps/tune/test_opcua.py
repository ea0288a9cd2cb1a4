"""The machine `opcua`, against a server of asyncua: the Structured Text runs in C behind it."""

import asyncio
import datetime
import socket
import threading
import time

import numpy as np
import pytest
from tests.apps.tune.plc import Plc, compiled, examples, stroke
from tests.exports.native import COMPILER

from bristle.apps.tune import MachineRefusedError, MachineStoppedError
from bristle.apps.tune.contract import check_machine, saves
from bristle.apps.tune.opcua import OpcUa

asyncua = pytest.importorskip("asyncua", reason="asyncua is not installed")
pytestmark = pytest.mark.skipif(
    COMPILER is None, reason="the Structured Text runs as C, and there is no compiler"
)
PREFIX = "ns=2;s=MAIN.tune."
WRITTEN = (
    "armed keep clear start save saved max_error max_effort low high gain offset ramp patience alive model rows "
    "block block_first block_rows"
)
TYPES = {"c_bool": "Boolean", "c_int": "Int32", "c_long": "Int64", "c_double": "Double"}
BEGIN = datetime.datetime(2026, 1, 1, tzinfo=datetime.UTC)


class Server:
    """A server in a thread of its own, whose controller advances in steps; each row is a value with its source time stamp."""

    def __init__(self, plc: Plc) -> None:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.url = f"opc.tcp://127.0.0.1:{probe.getsockname()[1]}/"
        self.plc, self.clock, self._start = plc, 5.0, plc.restart
        self.step, self.lost, self.longest = 1e-3, 0, 10_000
        self._fresh = threading.Event()
        self._end, self._ready = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=lambda: asyncio.run(self._serve()), daemon=True)

    def __enter__(self) -> "Server":
        self._thread.start()
        assert self._ready.wait(20.0)
        return self

    def __exit__(self, *_: object) -> None:
        self._end.set()
        self._thread.join()

    def restart(self, *, as_new: bool = True) -> None:
        """Restart the controller, as a new controller or with what it stored."""
        self._start = self.plc.restart if as_new else self.plc.reboot
        self.clock, self.step, self.lost, self.longest = 5.0, 1e-3, 0, 10_000
        self._fresh.clear()
        assert self._fresh.wait(20.0)

    async def _serve(self) -> None:
        server = asyncua.Server()
        await server.init()
        server.set_endpoint(self.url)
        server.set_security_policy([asyncua.ua.SecurityPolicyType.NoSecurity])
        await server.register_namespace("urn:plc")
        self._space, self._nodes = server.iserver.aspace, {}
        for name in self.plc.variables:
            if name not in ("motion", "ring"):
                node = asyncua.ua.NodeId.from_string(f"{PREFIX}{name}")
                variable = await server.nodes.objects.add_variable(
                    node, name, self.plc.value(name), self._type(name)
                )
                await variable.set_writable()
                self._nodes[name] = node
        async with server:
            self._server = server
            self._ready.set()
            begin = time.monotonic()
            count = 0
            while not self._end.is_set():
                await asyncio.sleep(5e-3)
                server.iserver.max_monitored_item_queue_size = self.longest
                if not self._fresh.is_set():
                    self._start()
                    for name in self._nodes:
                        await self._set(name, self.plc.value(name))
                    begin, count = time.monotonic(), 0
                    self._fresh.set()
                due = int(1e3 * self.clock * (time.monotonic() - begin)) - count
                count += due
                await self._advance(min(due, 500))

    def _type(self, name):
        kind = self.plc.variables[name]
        kind = getattr(kind, "_type_", kind) if hasattr(kind, "_length_") else kind
        return getattr(asyncua.ua.VariantType, TYPES[kind.__name__])

    async def _advance(self, cycles: int) -> None:
        read, value = self._space.read_attribute_value, asyncua.ua.AttributeIds.Value
        values = {name: read(node, value).Value.Value for name, node in self._nodes.items()}
        for name in WRITTEN.split():
            place = self.plc.variables[name]
            self.plc.put(
                name, bytes(place(*values[name]) if name == "block" else place(values[name]))
            )
        for _ in range(cycles):
            self.plc.cycles(1)
            row = self.plc.value("row")
            if row[0] == values["row"][0]:
                continue
            values["row"] = row
            if 50 <= row[0] % 100 < 50 + self.lost:
                continue
            await self._set(
                "row", row, BEGIN + datetime.timedelta(seconds=self.step * row[0] / self.clock)
            )
        for name in self._nodes:
            now = self.plc.value(name)
            if name != "row" and now != values[name]:
                await self._set(name, now)

    async def _set(self, name, value, stamp=None) -> None:
        data = asyncua.ua.DataValue(
            asyncua.ua.Variant(value, self._type(name)), SourceTimestamp=stamp
        )
        await self._server.write_attribute_value(self._nodes[name], data)


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    with Server(Plc(compiled(tmp_path_factory.mktemp("plc")))) as running:
        yield running


@pytest.fixture
def kind(server):
    """Return the class of machines on the server, whose controller starts anew."""
    with examples(
        OpcUa,
        server.restart,
        url=server.url,
        prefix=PREFIX,
        patience=100.0,
        clock=5.0,
        publish=0.05,
    ) as example:
        yield example


@pytest.mark.slow
def test_the_machine_meets_the_contract(kind):
    assert [
        (check.name, check.detail) for check in check_machine(kind, move=True) if not check.passed
    ] == []


@pytest.mark.slow
def test_each_row_is_that_of_the_axis(armed, server):
    recording = armed.record(stroke(2000), lambda: None)
    np.testing.assert_allclose(recording.reference, stroke(2000), atol=1e-15)
    assert recording.position[-1] == pytest.approx(1e-3 * server.plc.value("position"), abs=2e-6)


def test_lost_rows_are_refused_with_their_number(armed, server):
    server.lost = 3  # of 100
    with pytest.raises(MachineStoppedError, match=r"lost samples: 30 of 1000 rows"):
        armed.record(stroke(900), lambda: None)


def test_a_saved_feedforward_is_in_force_after_a_restart_until_it_is_removed(kind):
    assert saves(kind).applies


def test_a_short_queue_is_refused_before_the_axis_moves(armed, server):
    server.longest = 10
    time.sleep(0.05)
    with pytest.raises(MachineRefusedError, match="a queue of 10 values, and 500 are needed"):
        armed.record(stroke(), lambda: None)
    assert server.plc.value("count") == 0


def test_other_time_stamps_than_the_sample_time_are_refused(armed, server):
    server.step = 2e-3
    with pytest.raises(
        MachineRefusedError, match=r"0\.002 s apart, and the sample time is 0\.001 s"
    ):
        armed.record(stroke(), lambda: None)


def test_a_wrong_node_is_refused_by_name(server):
    machine = OpcUa(
        url=server.url, prefix=PREFIX, names={"armed": "ns=2;s=absent"}, sample_time=1e-3
    )
    with pytest.raises(MachineRefusedError, match="ns=2;s=absent"):
        machine.state()
    machine.close()
