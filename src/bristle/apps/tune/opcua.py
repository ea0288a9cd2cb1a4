"""An axis behind an OPC UA server as a machine."""

import math
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, ClassVar

import numpy as np

from bristle.apps.tune.function_block import POLL, TYPES, FunctionBlock, Rows, fill
from bristle.apps.tune.machine import MachineRefusedError
from bristle.core import MissingExtraError

# Numeric node ids of the name and the version of a server.
SERVER = {"product": 2262, "version": 2264}
QUEUE = 2.0  # time that the requested queue lasts: a server that publishes late loses no row [s]
TOLERANCE = 0.05  # relative, of the interval of source time stamps


class OpcUa(FunctionBlock):
    """One axis behind an OPC UA server; a subscription with a queue delivers its rows."""

    REQUIRED: ClassVar = {
        "url": ("", "opc.tcp://192.168.1.10:4840"),
        "prefix": ("", "ns=4;s=MAIN.tune."),
    }

    def __init__(self, *, url: str, publish: float = 0.1, **settings: Any) -> None:
        super().__init__(**settings)
        try:
            from asyncua import sync, ua
        except ImportError as error:
            raise MissingExtraError.of("a machine behind OPC UA", "opcua") from error
        self._ua, self._url, self._publish = ua, url, publish
        self._errors = (ua.UaError, OSError, TimeoutError)
        own = ua.VariantType
        self._types = {
            "bool": own.Boolean,
            "dint": own.Int32,
            "lint": own.Int64,
            "lreal": own.Double,
        }
        self._link = sync.Client(url, timeout=10)
        try:
            with self._named(url):
                self._link.connect()
        except MachineRefusedError:
            self._link.tloop.stop()
            raise

    def _read(self, name: str) -> Any:
        with self._named(self._full(name)):
            return self._link.get_node(self._full(name)).read_value()

    def _write(self, name: str, value: Any) -> None:
        # Without time stamps: many servers refuse those of a client.
        data = self._ua.DataValue(self._ua.Variant(value, self._types[TYPES[name]]))
        with self._named(self._full(name)):
            self._link.get_node(self._full(name)).write_value(data)

    def identity(self) -> Mapping[str, str]:
        """Return address and product of the server, and the function block."""
        with self._named("server"):
            product = {
                key: str(self._link.get_node(f"i={number}").read_value())
                for key, number in SERVER.items()
            }
        return {"machine": "opcua", "url": self._url, **product, "block": self._full("row")}

    @contextmanager
    def _recorded(self) -> Iterator[Rows]:
        """Subscribe to the rows of the function block; check the time between their source time stamps."""
        received: list[Any] = []
        stamps: list[float] = []

        def rows() -> np.ndarray:
            values = [received.pop(0) for _ in range(len(received))]
            stamps.extend(
                value.SourceTimestamp.timestamp()
                for value in values
                if value.SourceTimestamp is not None
            )
            return np.array([value.Value.Value for value in values], float).reshape(-1, 4)

        subscription = self._subscribed(received.append)
        try:
            yield rows
        finally:
            with self._named("subscription"):
                self._link.tloop.post(
                    self._link.aio_obj.uaclient.delete_subscriptions([subscription])
                )
        self._check_time(np.array(stamps[1:]))  # the first value is older than the motion

    def _subscribed(self, receive: Callable[[Any], None]) -> int:
        """Subscribe to the rows; refuse a queue that is shorter than two publishing intervals."""
        ua, client, post = self._ua, self._link.aio_obj.uaclient, self._link.tloop.post
        interval = 1e3 * self.sample_time / self._clock
        size = math.ceil(1e3 * max(2.0 * self._publish, QUEUE) / interval) + 1

        async def publish(result: Any) -> None:
            for notification in result.NotificationMessage.NotificationData or ():
                for item in getattr(notification, "MonitoredItems", ()):
                    receive(item.Value)

        subscription = ua.CreateSubscriptionParameters(
            RequestedPublishingInterval=1e3 * self._publish,
            RequestedLifetimeCount=10_000,
            RequestedMaxKeepAliveCount=100,
            PublishingEnabled=True,
        )
        monitored = ua.MonitoredItemCreateRequest(
            ItemToMonitor=ua.ReadValueId(
                NodeId=ua.NodeId.from_string(self._full("row")), AttributeId=ua.AttributeIds.Value
            ),
            MonitoringMode=ua.MonitoringMode.Reporting,
            RequestedParameters=ua.MonitoringParameters(
                ClientHandle=1, SamplingInterval=interval, QueueSize=size, DiscardOldest=True
            ),
        )
        with self._named(self._full("row")):
            created = post(client.create_subscription(subscription, publish))
            items = ua.CreateMonitoredItemsParameters(
                SubscriptionId=created.SubscriptionId,
                TimestampsToReturn=ua.TimestampsToReturn.Both,
                ItemsToCreate=[monitored],
            )
            result = post(client.create_monitored_items(items))[0]
            result.StatusCode.check()
        needed = math.ceil(2.0 * created.RevisedPublishingInterval / interval)
        if result.RevisedQueueSize < needed:
            post(client.delete_subscriptions([created.SubscriptionId]))
            raise MachineRefusedError(
                "queue_too_short",
                f"the server grants a queue of {result.RevisedQueueSize} values, and {needed} are needed",
                "Lower publish, or allow a longer queue in the server",
            )
        return created.SubscriptionId

    def _check_time(self, stamps: np.ndarray) -> None:
        """Refuse rows whose source time stamps disagree with the sample time."""
        if stamps.size < 3:
            raise MachineRefusedError(
                "no_time", "the rows have no source time stamps", "Enable them in the server"
            )
        interval = float(np.median(np.diff(np.sort(stamps)))) * self._clock
        if abs(interval - self.sample_time) > TOLERANCE * self.sample_time:
            raise MachineRefusedError(
                "sample_time",
                f"the source time stamps are {interval:.4g} s apart, and the sample time is {self.sample_time:.4g} s",
                "Call FB_BristleTune once in each sample",
            )

    def _drain(self, table: np.ndarray, before: int, rows: Rows) -> None:
        """Wait until the last rows arrive, for at most ten publishing intervals."""
        end = time.monotonic() + 10.0 * self._publish + 1.0
        while np.isnan(table[-1, 0]) and time.monotonic() < end:
            time.sleep(POLL)
            fill(table, before, rows())

    def close(self) -> None:
        """Disconnect; the guard removes the feedforward if no run continues."""
        self._link.disconnect()
