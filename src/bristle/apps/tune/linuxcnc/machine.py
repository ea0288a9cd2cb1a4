"""An axis in LinuxCNC's HAL as a machine."""

import math
import tempfile
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import ClassVar

import numpy as np

from bristle.apps.tune.linuxcnc.hal import Hal, HalError
from bristle.apps.tune.linuxcnc.saved import (
    GUARD,
    guard,
    hal_lines,
    places,
    prefix_of,
    source_of,
    write_marked,
)
from bristle.apps.tune.machine import (
    STOPS,
    FrictionFeedforward,
    Limits,
    MachineRefusedError,
    MachineStoppedError,
    Recording,
    State,
)

SAMPLER, STREAMER = "sampler.0", "streamer.0"
DEPTH = 500_000  # rows of the rings: nothing depends on a program being in time
LOAD_SAMPLER = f"loadrt sampler depth={DEPTH} cfg=fffu"
SIGNALS = ("bristle-total", "bristle-feed", "bristle-count")
# halcmd prints seven digits. bristle writes as many, so that a value reads back as it is.
POLL = 0.1  # [s]
SLOWEST = 20.0  # over the whole travel, on the way to the start of a motion [s]
LATEST = 5000  # rows of the sampler before the motion


class LinuxCNC:
    """One axis: the guard stands between the output of the controller and the amplifier."""

    REQUIRED: ClassVar = {
        "reference": (": the signal of the set point", "NAME"),
        "position": (": the signal of the measured position", "NAME"),
        "effort": (": the signal of the output of the controller", "NAME"),
        "motor": (": the pin of the amplifier", "NAME"),
        "thread": (": the thread of the controller", "NAME"),
    }

    def __init__(
        self,
        *,
        sample_time: float,  # time of the axis between two cycles [s]
        reference: str,
        position: str,
        effort: str,
        motor: str,
        thread: str,
        unit: float = 1e-3,  # one machine unit [m or rad]
        effort_unit: float = 1.0,  # one unit of the effort [N or N*m]
        clock: float = 1.0,  # seconds of the axis in a second of the thread, 1 on a real axis
        save: str = "",  # HAL file of a saved feedforward
    ) -> None:
        self.sample_time, self._reference, self._position, self._effort = (
            sample_time,
            reference,
            position,
            effort,
        )
        self._motor, self._thread, self._unit, self._effort_unit, self._clock = (
            motor,
            thread,
            unit,
            effort_unit,
            clock,
        )
        self._save = save
        self._hal, self._alive, self._model = Hal(), 0, ""
        self._is_armed, self._speed = False, 0.0

    def identity(self) -> Mapping[str, str]:
        """Return thread, motor and the controller's links."""
        links = self._hal.links()
        for signal in (self._reference, self._position, self._effort):
            if signal not in links:
                raise MachineRefusedError(
                    "no_signal", f"HAL has no signal {signal}", "halcmd show sig lists the signals"
                )
        if not any(pin.startswith(STREAMER) for pin in links[self._reference]):
            raise MachineRefusedError(
                "no_streamer",
                f"no streamer plays the signal {self._reference}",
                "Load streamer and connect streamer.0.pin.0 to the signal of the set point",
            )
        return {
            "machine": "linuxcnc",
            "motor": self._motor,
            "thread": self._thread,
            "components": " ".join(self._own(self._hal.components())),
        }

    def _own(self, components: list[str]) -> list[str]:
        return [name for name in components if not name.startswith(("bristle_", "sampler"))]

    def writes(self) -> list[str]:
        """Return the pins, signals and components of a run."""
        model = f"{self._model or 'bristle_MODEL'}"
        return [
            self._motor,
            guard(),
            "sampler",
            model,
            *SIGNALS,
            f"functions of {self._thread}",
            f"{STREAMER}.enable",
        ]

    def state(self) -> State:
        """Return all links, parameters of controller, guard and model, functions of the thread and components."""
        components = self._hal.components()
        own = [prefix_of(name) for name in components if name.startswith(("pid", "bristle_"))]
        return {
            "links": self._hal.links(),
            "parameters": self._hal.value_of_parameters(own),
            "functions": self._hal.functions(self._thread),
            "components": components,
        }

    def arm(self, limits: Limits) -> None:
        """Insert guard and sampler, or replace the limits."""
        hal = self._hal
        low, high = limits.travel
        values = {"max-error": limits.following_error, "low": low, "high": high}
        settings = [
            f"setp {GUARD}.{name} {value / self._unit:.7g}" for name, value in values.items()
        ]
        settings += [
            f"setp {GUARD}.max-effort {limits.effort / abs(self._effort_unit):.7g}",
            f"setp {GUARD}.gain 0",
            f"setp {GUARD}.offset 0",
        ]
        self._speed = (high - low) / self._unit / SLOWEST
        if not self._is_armed and any(
            prefix_of(component) == GUARD for component in hal.components()
        ):
            raise MachineRefusedError(
                "kept",
                "HAL contains the guard of an earlier run",
                "Remove it: bristle tune --undo FOLDER",
            )
        if not self._is_armed:
            self._insert()
        hal.run(*settings)
        self._reset()

    def _insert(self) -> None:
        hal, name = self._hal, guard()
        try:
            hal.run(f"loadrt {name} names={GUARD}")
        except HalError:  # not compiled yet
            hal.install(name, source_of(name, Path()))
            hal.run(f"loadrt {name} names={GUARD}")
        patience = int(2.0 / self.sample_time * self._clock)
        hal.run(
            LOAD_SAMPLER,
            f"setp {SAMPLER}.enable 0",
            f"setp {GUARD}.clock {self._clock:.7g}",
            f"setp {GUARD}.patience {patience}",
            f"net {self._reference} => {GUARD}.reference {SAMPLER}.pin.0",
            f"net {self._position} => {GUARD}.feedback {SAMPLER}.pin.1",
            f"net {self._effort} => {GUARD}.loop",
            f"net bristle-count {GUARD}.count => {SAMPLER}.pin.3",
            *self._added(GUARD, SAMPLER),
            f"unlinkp {self._motor}",
            f"net bristle-total {GUARD}.total => {self._motor} {SAMPLER}.pin.2",
        )
        self._is_armed = True

    def _added(self, *functions: str) -> list[str]:
        """Return the lines that add functions to the thread: behind the controller, before the amplifier if it is written behind."""
        present = [name for name in self._hal.functions(self._thread) if name not in functions]
        links = self._hal.links()
        controller = next(
            (
                pin.split(".")[0]
                for pin in links[self._effort]
                if pin != self._motor and pin.endswith("output")
            ),
            "pid",
        )
        places = {
            key: [at for at, name in enumerate(present) if name.split(".")[0] == key]
            for key in (controller, self._motor.split(".")[0])
        }
        behind = max(places[controller], default=len(present))
        writers = [at for at in places[self._motor.split(".")[0]] if at > behind]
        first = 1 + (min(writers) if writers else len(present))
        return [
            f"addf {function} {self._thread} {first + at}" for at, function in enumerate(functions)
        ]

    def _reset(self) -> None:
        """Clear a trip; the reset lasts from one call of halcmd to the next, which is longer than a cycle."""
        self._sign_of_life()
        self._hal.run(f"setp {GUARD}.reset 1")
        self._hal.run(f"setp {GUARD}.reset 0")

    def load(self, feedforward: FrictionFeedforward) -> None:
        """Compile and load the component of the model, at gain 0 of the guard."""
        name, hal = feedforward.name, self._hal
        hal.install(name, source_of(name, feedforward.folder))
        pin, earlier = name.replace("_", "-"), self._model
        if earlier:
            own = earlier.replace("_", "-")
            removal = f"unlinkp {GUARD}.feed", f"delf {own} {self._thread}", f"unloadrt {earlier}"
            hal.run(f"setp {GUARD}.gain 0", *removal, keep_going=True)
        values = {
            "scale": self._unit,
            "effort-scale": self._effort_unit,
            "lead": feedforward.lead,
            "clock": self._clock,
            "gain": 1.0,
        }
        values |= (
            {"limit": feedforward.limit / abs(self._effort_unit)}
            if math.isfinite(feedforward.limit)
            else {}
        )
        hal.run(
            f"setp {GUARD}.gain 0",
            f"loadrt {name}",
            *(f"setp {pin}.{key} {value:.7g}" for key, value in values.items()),
            f"net {self._reference} => {pin}.reference",
            f"net bristle-feed {pin}.feed => {GUARD}.feed",
            *(f"delf {function} {self._thread}" for function in (GUARD, SAMPLER)),
            *self._added(pin, GUARD, SAMPLER),
        )
        self._model = name

    def set(self, *, gain: float = 0.0, offset: float = 0.0) -> None:
        """Set gain and test effort."""
        self._hal.run(
            f"setp {GUARD}.gain {gain:.7g}", f"setp {GUARD}.offset {offset / self._effort_unit:.7g}"
        )

    def record(self, reference: np.ndarray, alive: Callable[[], None]) -> Recording:
        """Play a reference through the streamer and return the rows of the sampler; refuse lost rows."""
        hal = self._hal
        self._empty()
        played = np.concatenate([self._way_to(reference[0] / self._unit), reference / self._unit])
        rows = played.size
        if rows >= DEPTH - 10:
            raise MachineRefusedError(
                "too_long",
                f"a motion of {rows} samples is longer than the ring of the streamer, {DEPTH} rows",
            )
        self._reset()
        overruns = hal.get(f"{SAMPLER}.overruns")[0]
        self._fill(played)
        hal.run(f"setp {SAMPLER}.enable 1", f"setp {STREAMER}.enable 1")
        try:
            self._wait(rows, alive)
        finally:
            hal.run(f"setp {SAMPLER}.enable 0", f"setp {STREAMER}.enable 0")
        table = self._table(played, hal.get(f"{SAMPLER}.overruns")[0] - overruns)[
            rows - reference.size :
        ]
        return Recording(
            table[:, 0] * self._unit, table[:, 1] * self._unit, table[:, 2] * self._effort_unit
        )

    def _empty(self) -> None:
        """Empty the rings of sampler and streamer, in which an interrupted motion leaves rows; the set point stays."""
        hal, pin = self._hal, f"{STREAMER}.pin.0"
        left = int(hal.get(f"{SAMPLER}.curr-depth")[0])
        if left:
            hal.sampled(left)
        hal.run(f"setp {STREAMER}.enable 0")
        # After its ring has wrapped, HAL counts one row too few.
        if hal.get(f"{STREAMER}.curr-depth")[0] <= 1.0:
            return
        hal.run(f"unlinkp {pin}", f"setp {STREAMER}.enable 1")
        while not hal.get(f"{STREAMER}.empty")[0]:
            time.sleep(POLL)
            self._sign_of_life()
        hal.run(f"setp {STREAMER}.enable 0", f"net {self._reference} {pin}")

    def _way_to(self, start: float) -> np.ndarray:
        """Return the set points from the present one to the start of a motion; without rows if the axis is there."""
        present = self._hal.get(f"{GUARD}.reference")[0]
        if abs(start - present) < 1e-9:
            return np.empty(0)
        rows = int(np.ceil(max(abs(start - present) / self._speed, 1.0) / self.sample_time))
        return start + 0.5 * (present - start) * (1.0 + np.cos(np.pi * np.arange(rows) / rows))

    def _fill(self, positions: np.ndarray) -> None:
        """Fill the ring of the streamer with a motion; halstreamer skips a bad line and a last line without an end."""
        with tempfile.NamedTemporaryFile("w", suffix=".txt") as file:
            np.savetxt(file, positions, fmt="%.9f")
            file.flush()
            end = time.monotonic() + 60.0
            with self._hal.play(Path(file.name)) as started:
                while started.poll() is None and time.monotonic() < end:
                    time.sleep(0.02)
                    self._sign_of_life()
                if started.returncode is None:
                    started.kill()
                _, faults = started.communicate()
            if started.returncode or "line" in faults:
                raise MachineRefusedError("streamer", f"halstreamer: {faults.strip()[:200]}")
        # The pin is some cycles behind the file; after its ring has wrapped, HAL counts one row too few.
        for _ in range(40):
            if self._hal.get(f"{STREAMER}.curr-depth")[0] in (positions.size, positions.size - 1):
                return
            time.sleep(0.05)
        held = self._hal.get(f"{STREAMER}.curr-depth")[0]
        raise MachineRefusedError(
            "streamer", f"the streamer contains {held:.0f} of {positions.size} rows"
        )

    def _sign_of_life(self) -> None:
        self._alive += 1
        self._hal.run(f"setp {GUARD}.alive {self._alive}")

    def _wait(self, rows: int, alive: Callable[[], None]) -> None:
        """Wait until the motion has ended."""
        end = time.monotonic() + 3.0 * rows * self.sample_time / self._clock + 10.0
        while time.monotonic() < end:
            time.sleep(POLL)
            self._sign_of_life()
            alive()
            ok, cause, empty = self._hal.get(f"{GUARD}.ok", f"{GUARD}.why", f"{STREAMER}.empty")
            if not ok:
                raise MachineStoppedError(STOPS[int(cause) - 1])
            if empty:
                return
        raise MachineRefusedError("no_end", "the motion did not end in three times its duration")

    def _table(self, played: np.ndarray, overruns: float) -> np.ndarray:
        """Return the rows of the sampler during the motion; refuse missing rows by the counter of the guard."""
        rows = played.size
        count = int(self._hal.get(f"{SAMPLER}.curr-depth")[0])
        lines = self._hal.sampled(count)
        # Each new halsampler prints a first, false line.
        lines = lines[1:] if lines[:1] == ["overrun"] else lines
        if overruns or "overrun" in lines:
            raise MachineStoppedError(
                "lost_samples", f"the sampler lost {max(overruns, 1):.0f} rows"
            )
        table = np.array([line.split() for line in lines], float)
        if len(table) > 1 and table[1, -1] - table[0, -1] != 1:
            table = table[1:]  # a row of an earlier record, by the same wrong count
        jumps = np.diff(table[:, -1]) - 1.0
        if np.any(jumps):
            raise MachineStoppedError(
                "lost_samples", f"{np.sum(np.abs(jumps)):.0f} rows are missing, by the counter"
            )
        if len(table) < rows:
            raise MachineStoppedError(
                "lost_samples", f"{rows - len(table)} of {rows} rows are missing at the end"
            )
        # The sampler begins some cycles before the streamer.
        late = [
            float(np.max(np.abs(table[shift : shift + rows, 0] - played)))
            for shift in range(min(len(table) - rows + 1, LATEST))
        ]
        return table[int(np.argmin(late)) :][:rows]

    def keep(self) -> None:
        """Keep the feedforward when this program ends, also if the guard tripped while this program computed."""
        self._hal.run(f"setp {GUARD}.keep 1")
        self._reset()
        ok, cause = self._hal.get(f"{GUARD}.ok", f"{GUARD}.why")
        if not ok:
            raise MachineStoppedError(STOPS[int(cause) - 1])

    @property
    def loads(self) -> str:
        """The line that loads the saved file."""
        return f"Write this line behind the other lines of its kind under [HAL] in the .ini of LinuxCNC: HALFILE = {self._save}"

    def saved(self) -> Mapping[str, str]:
        """Return the hashes of the saved HAL file and of the sources of its components."""
        if not self._save:
            raise MachineRefusedError(
                "no_memory",
                "HAL has no non-volatile memory, and the machine file names no HAL file for it",
                'Name one: write save = "bristle.hal" under [settings] of the machine file',
            )
        return places(Path(self._save))

    def save(self, folder: Path) -> Mapping[str, str]:
        """Write a HAL file that rebuilds guard, model and sampler as they are, and the sources of the components beside it."""
        path, head = (
            Path(self._save),
            f"# {self.loads}\n# A trip of the guard lasts until {GUARD}.reset is true, for example after homing.\n",
        )
        text = "\n".join(hal_lines(self._hal, self._thread, self._motor, LOAD_SAMPLER))
        names = [name for name in self._hal.components() if name.startswith("bristle_")]
        return write_marked(
            {path: f"{head}{text}\n"}
            | {path.with_name(f"{name}.comp"): source_of(name, folder) for name in names}
        )

    def unsave(self) -> None:
        """Remove these files."""
        for path in self.saved():
            Path(path).unlink(missing_ok=True)

    def restore(self, state: State) -> None:
        """Remove guard, model and sampler, and connect the amplifier to the controller again."""
        hal, thread = self._hal, self._thread
        components = hal.components()
        own = [
            name
            for name in components
            if name.startswith("bristle_") and name not in state["components"]
        ]
        if own:
            hal.run(
                f"setp {STREAMER}.enable 0",
                f"setp {GUARD}.gain 0",
                f"setp {GUARD}.offset 0",
                keep_going=True,
            )
            for _ in range(40):
                try:
                    if hal.get(f"{GUARD}.gain-now")[0] == 0.0:
                        break
                except HalError:
                    break
                time.sleep(0.05)
        added = [
            function for function in hal.functions(thread) if function not in state["functions"]
        ]
        present = hal.links()
        missing = [
            (signal, pin)
            for signal, pins in state["links"].items()
            for pin in pins
            if pin not in present.get(signal, [])
        ]
        back = [
            line for signal, pin in missing for line in (f"unlinkp {pin}", f"net {signal} {pin}")
        ]
        hal.run(
            f"setp {SAMPLER}.enable 0",
            *back,
            *(f"delf {function} {thread}" for function in added),
            keep_going=True,
        )
        loaded = [
            name
            for name in (*own, "sampler")
            if name in components and name not in state["components"]
        ]
        hal.run(
            *(f"unloadrt {name}" for name in loaded),
            *(f"delsig {name}" for name in SIGNALS),
            keep_going=True,
        )
        self._model, self._is_armed = "", False

    def close(self) -> None:
        """Do nothing: the guard fades the feedforward if no run continues."""
