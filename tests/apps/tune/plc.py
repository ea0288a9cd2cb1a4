"""A simulated controller that runs ``FB_BristleTune``: the Structured Text in C, and an axis with a PID loop in C."""

import ctypes
import re
import subprocess
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from tests.apps.targets.structured_text import FLAGS, HEAD, Translator
from tests.exports.native import COMPILER

import bristle.apps.tune
from bristle.apps.tune import Limits

# The keyword of the standard, as the head of the file states it for other controllers than TwinCAT.
TEXT = (
    (Path(bristle.apps.tune.__file__).parent / "FB_BristleTune.st")
    .read_text()
    .replace("VAR PERSISTENT", "VAR RETAIN")
)
PERSISTENT = re.findall(
    r"(\w+)(?=[\w, ]* : )",
    re.sub(r"\(\*.*?\*\)", "", TEXT.split("VAR RETAIN")[1].split("END_VAR")[0]),
)
AXIS = """
static t_fb_bristletune tune;
static double x, v, bristle, integral, error_before;
void begin(void) { t_fb_bristletune_virgin(&tune); x = v = bristle = integral = error_before = 0.0; }
void move(double position) { x = position; }
void cycles(int number)
{
    for (int cycle = 0; cycle < number; ++cycle) {
        const double encoder = 1e-8 * ROUNDED(x / 1e-8), error = tune.v_setpoint * 1e-3 - encoder;
        integral += 2e6 * error * 1e-3;
        tune.v_controller = 1.2e5 * error + integral + 1.2e3 * (error - error_before) / 1e-3;
        error_before = error;
        tune.v_position = encoder / 1e-3;
        call_t_fb_bristletune(&tune);
        for (int part = 0; part < 50; ++part) {
            bristle += v * 2e-5;
            if (bristle > 1e-5) { bristle = 1e-5; } else if (bristle < -1e-5) { bristle = -1e-5; }
            v += 2e-5 / 20.0 * (tune.v_effort - 15.0 * bristle / 1e-5 - 100.0 * v);
            x += v * 2e-5;
        }
    }
}
"""
SIZES = {
    "bool": ctypes.c_bool,
    "dint": ctypes.c_int32,
    "lint": ctypes.c_int64,
    "lreal": ctypes.c_double,
}
WARNINGS = (
    "-Wno-unused-function",
    "-Wno-unused-but-set-variable",
    "-Wno-clobbered",
    "-Wno-unused-variable",
)
WIDE = Limits(1e-3, 400.0, (-0.1, 0.1))


def stroke(rows=600, distance=1e-3):
    """Return a motion to and fro between two rests [m]."""
    return np.concatenate(
        [np.zeros(50), distance * (1.0 - np.cos(np.linspace(0.0, 2.0 * np.pi, rows))), np.zeros(50)]
    )


def compiled(folder: Path) -> Path:
    """Translate the function block, and compile it with the axis."""
    translator = Translator(TEXT)
    unit = translator.units["fb_bristletune"]
    access = "".join(f"void *at_{name}(void) {{ return &tune.v_{name}; }}\n" for name in unit.types)
    (folder / "plc.c").write_text(HEAD + translator.text() + AXIS + access)
    command = [
        COMPILER,
        *FLAGS,
        "-DROUNDED=nearbyint",
        *WARNINGS,
        "-shared",
        "-fPIC",
        "plc.c",
        "-o",
        "plc.so",
        "-lm",
    ]
    built = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr[:4000]
    return folder / "plc.so"


class Plc:
    """One controller a process; `lock` keeps a cycle and an access apart. Its program stores the persistent variables on demand."""

    def __init__(self, library: Path) -> None:
        self._library, self.lock = ctypes.CDLL(str(library)), threading.RLock()
        translator = Translator(TEXT)
        self.variables = {}
        for name, kind in translator.units["fb_bristletune"].types.items():
            size, element = translator.arrays.get(kind, (0, kind))
            self.variables[name] = SIZES[element] * size if size else SIZES[element]
        self.restart()

    def restart(self) -> None:
        """Start a new controller."""
        self.stores, self.stored = True, dict[str, bytes]()
        self.reboot()

    def reboot(self, position: float = 0.0) -> None:
        """Start the controller again, at a position [m], with the persistent variables that its program stored."""
        with self.lock:
            self.runs = True
            self._library.begin()
            self._library.move(ctypes.c_double(position))
            self.put("command", bytes(ctypes.c_double(1e3 * position)))
            for name, content in self.stored.items():
                self.put(name, content)
            self._library.cycles(1)

    def cycles(self, number: int) -> None:
        with self.lock:
            if self.runs:
                self._library.cycles(number)
                stores = self.stores and self.value("store")
                if stores:
                    self.stored = {name: self.content(name) for name in PERSISTENT}
                self.put("stored", bytes([stores]))

    def place(self, name: str):
        """Return the memory of a variable."""
        address = getattr(self._library, f"at_{name}")
        address.restype = ctypes.c_void_p
        return self.variables[name].from_address(address())

    def content(self, name: str) -> bytes:
        with self.lock:
            return bytes(self.place(name))

    def value(self, name: str):
        with self.lock:
            place = self.place(name)
            return list(place) if hasattr(place, "__len__") else place.value

    def put(self, name: str, content: bytes) -> None:
        with self.lock:
            place = self.place(name)
            assert len(content) == ctypes.sizeof(place), (name, len(content))
            ctypes.memmove(ctypes.addressof(place), content, len(content))


@contextmanager
def examples(machine, restart, **settings):
    """Give the class of machines on a controller, with examples for the contract; `restart` starts it as new or with what it stored."""
    opened = []

    class Example(machine):
        @classmethod
        def example(cls):
            for each in opened:
                each.close()
            restart(as_new=True)
            return cls.again()

        @classmethod
        def restarted(cls, kept):
            kept.close()
            restart(as_new=False)
            return cls.again()

        @classmethod
        def again(cls):
            opened[:] = [cls(sample_time=1e-3, **settings)]
            return opened[0]

    yield Example
    for each in opened:
        each.close()


class Task:
    """Runs the cycles of a controller in real time, in a thread."""

    def __init__(self, plc: Plc) -> None:
        self._plc, self._end = plc, threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> "Task":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._end.set()
        self._thread.join()

    def _run(self) -> None:
        begin, count = time.monotonic(), 0
        while not self._end.wait(2e-3):
            due = int(1e3 * (time.monotonic() - begin)) - count
            self._plc.cycles(due)
            count += due
