"""An axis on a TwinCAT PLC as a machine, by ADS."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, ClassVar

import numpy as np

from bristle.apps.tune.function_block import BLOCK, TYPES, FunctionBlock, Rows
from bristle.apps.tune.machine import MachineRefusedError
from bristle.core import MissingExtraError

PORT = 851  # of the first PLC runtime of TwinCAT 3


class Ads(FunctionBlock):
    """One axis on a TwinCAT PLC; its ring of rows is read as a whole."""

    REQUIRED: ClassVar = {"net_id": ("", "192.168.1.10.1.1"), "prefix": ("", "MAIN.tune.")}

    def __init__(
        self, *, net_id: str, prefix: str, address: str = "", port: int = PORT, **settings: Any
    ) -> None:
        super().__init__(prefix=prefix, **settings)
        try:
            import pyads
        except ImportError as error:
            raise MissingExtraError.of("a machine on TwinCAT", "ads") from error
        self._net_id, self._ring, self._errors = net_id, 0, (pyads.ADSError,)
        self._types = {
            "bool": pyads.PLCTYPE_BOOL,
            "dint": pyads.PLCTYPE_DINT,
            "lint": pyads.PLCTYPE_LINT,
            "lreal": pyads.PLCTYPE_LREAL,
        }
        self._link = pyads.Connection(net_id, port, *([address] if address else []))
        with self._named("connection"):
            self._link.open()
            self._ring = int(self._read("ring_rows"))

    def _type(self, name: str) -> Any:
        kind = self._types[TYPES[name]]
        sizes = {"block": 2 * BLOCK, "ring": 4 * self._ring, "row": 4}
        return kind * sizes[name] if name in sizes else kind

    def _call(self, method: str, name: str, *values: Any) -> Any:
        if not self._link.is_open:  # pyads returns None then
            raise MachineRefusedError("connection", f"{name}: the connection is closed")
        with self._named(self._full(name)):
            return getattr(self._link, method)(self._full(name), *values, self._type(name))

    def _read(self, name: str) -> Any:
        return self._call("read_by_name", name)

    def _write(self, name: str, value: Any) -> None:
        self._call("write_by_name", name, value)

    def identity(self) -> Mapping[str, str]:
        """Return net id, runtime and function block."""
        with self._named("device"):
            device, version = self._link.read_device_info() or ("", None)
        release = "" if version is None else f"{version.version}.{version.revision}.{version.build}"
        return {
            "machine": "ads",
            "net_id": self._net_id,
            "device": f"{device} {release}".strip(),
            "block": self._prefix,
        }

    @contextmanager
    def _recorded(self) -> Iterator[Rows]:
        yield lambda: np.array(self._read("ring")).reshape(-1, 4)

    def close(self) -> None:
        """Disconnect; the guard removes the feedforward if no run continues."""
        self._link.close()
