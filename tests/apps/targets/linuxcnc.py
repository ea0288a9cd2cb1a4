"""HAL of LinuxCNC for tests, and a component without HAL: one session of a machine at a time, components removed again."""

import ctypes
import fcntl
import os
import re
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest
from tests.exports.native import WARNINGS, library

LOCK = Path(tempfile.gettempdir()) / "linuxcnc-hal.lock"
MODULES = Path("/usr/lib/linuxcnc/modules")
REALTIME = "/usr/lib/linuxcnc/realtime"
NOBODY = "65534"
PATIENCE = 60.0  # [s]
PERIOD = 1_000_000  # [ns]
# What HAL gives a component: volatile pins and parameters, and the period of the thread. It calls the function by its address.
HAL = """
#include <stddef.h>
struct instance {{ {fields} }};
{macros}
#define FUNCTION(name) static __attribute__((noinline)) void step(struct instance *self, long period)
"""
RUN = """
void start(struct instance *self) {{ begun = 0; {defaults} }}
size_t size(void) {{ return sizeof(struct instance); }}
void run(struct instance *self, const double *inputs, int count, long period, double *fed)
{{
    for (int i = 0; i < count; ++i) {{
        {played}
        step(self, period);
        fed[i] = self->{output};
    }}
}}
"""
DECLARED = re.compile(r"^(pin in|pin out|param rw) (float|bit) (\w+)(?: = (\S+))? \"", re.MULTILINE)


def _lacking():
    if shutil.which("halcompile") is None or shutil.which("halrun") is None:
        return "needs halcompile of LinuxCNC (packages linuxcnc-uspace and linuxcnc-uspace-dev)"
    return "" if os.access(MODULES, os.W_OK) else f"cannot install a component into {MODULES}"


LACKING = _lacking()
"""Reason for which HAL cannot be run here; empty if it can."""


def in_hal(files, folder, started):
    """Return the output of a session of HAL, and the files that it wrote, by name; the component is compiled without a warning."""
    for name, content in files.items():
        (folder / name).write_text(content, encoding="ascii")
    before, installed = set(files), []
    with LOCK.open("w") as lock, tempfile.TemporaryDirectory(prefix="hal") as socket:
        fcntl.flock(lock, fcntl.LOCK_EX)
        os.chmod(socket, 0o777)
        # rtapi_app does not run as root, and is found by its socket. It inherits the outputs: files, for a pipe would stay open.
        environment = os.environ | {"RTAPI_UID": NOBODY, "RTAPI_FIFO_PATH": f"{socket}/fifo"}
        end = time.monotonic() + PATIENCE
        while (
            subprocess.run(
                [REALTIME, "status"], env=environment, capture_output=True, check=False
            ).returncode
            == 0
        ):
            if time.monotonic() > end:
                pytest.skip("HAL is in use on this machine")
            time.sleep(0.2)
        try:
            for name in before:
                if name.endswith(".comp"):
                    said = "".join(_ran(["halcompile", "--compile", name], folder, environment))
                    assert "warning" not in said.lower(), said
                    installed.append(MODULES / name.replace(".comp", ".so"))
                    shutil.copy(folder / installed[-1].name, installed[-1])
            said, faults = _ran(["halrun", "-f", started], folder, environment)
        finally:
            for module in installed:
                module.unlink()
    found = {
        path.name: path.read_text(encoding="ascii")
        for path in folder.glob("*.txt")
        if path.name not in before
    }
    return found | {
        "stdout": said.replace("Note: Using POSIX non-realtime\n", ""),
        "stderr": faults,
    }


def _ran(command, folder, environment):
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        ran = subprocess.run(
            command,
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=err,
            timeout=PATIENCE,
            check=False,
        )
        out.seek(0)
        err.seek(0)
        texts = out.read(), err.read()
    assert ran.returncode == 0, f"{command}: {texts}"
    return texts


def text_of(files, end):
    return next(text for name, text in files.items() if name.endswith(end))


class Component:
    """A component, compiled with macros in place of HAL, as halcompile writes them."""

    def __init__(self, files, folder, *, more=()):
        text = text_of(files, ".comp")
        self._pins = DECLARED.findall(text)
        types = {"float": "volatile double", "bit": "volatile unsigned char"}
        fields = " ".join(f"{types[kind]} {name};" for _, kind, name, _ in self._pins)
        # A pin without parentheses or with an operator in front is no name of C, as with halcompile.
        macros = "\n".join(
            f"#define {name} ({'0+' * (way == 'pin in')}self->{name})"
            for way, _, name, _ in self._pins
        )
        defaults = " ".join(f"self->{name} = {value or 0};" for _, _, name, value in self._pins)
        undone = "\n".join(f"#undef {name}" for _, _, name, _ in self._pins)
        inputs = [
            name
            for way, kind, name, _ in self._pins
            if (way, kind) == ("pin in", "float") and name != "gain"
        ]
        output = next(
            name for way, kind, name, _ in self._pins if (way, kind) == ("pin out", "float")
        )
        facts = {
            "defaults": defaults,
            "played": " ".join(f"self->{name} = *inputs++;" for name in inputs),
            "output": output,
        }
        source = (
            HAL.format(fields=fields, macros=macros)
            + text.partition("\n;;\n")[2]
            + undone
            + RUN.format(**facts)
        )
        (folder / "component.c").write_text(source, encoding="ascii")
        flags = (*WARNINGS, "-Wno-unused-function", "-Wno-overlength-strings", "-std=gnu11")
        self._library = library(folder, "-Os", *more, *flags, "component.c")
        kinds = {"float": ctypes.c_double, "bit": ctypes.c_ubyte}
        self.pins = type(
            "Instance",
            (ctypes.Structure,),
            {"_fields_": [(name, kinds[kind]) for _, kind, name, _ in self._pins]},
        )()
        assert ctypes.sizeof(self.pins) == self._library.size()
        self.fresh()

    def fresh(self):
        """Return the component as it is before its first cycle."""
        self._library.start(ctypes.byref(self.pins))
        return self

    def feed(self, references, period=PERIOD, **pins):
        """Return the feed along some references."""
        for name, value in pins.items():
            setattr(self.pins, name, value)
        references, fed = np.ascontiguousarray(references, dtype=float), np.empty(len(references))
        pointer = ctypes.POINTER(ctypes.c_double)
        place = [array.ctypes.data_as(pointer) for array in (references, fed)]
        self._library.run(
            ctypes.byref(self.pins), place[0], len(references), ctypes.c_long(period), place[1]
        )
        return fed
