"""HAL of LinuxCNC through its programs: halcmd, halstreamer, halsampler and halcompile."""

import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

from bristle.apps.tune.machine import MachineRefusedError
from bristle.core import InputError

PATIENCE = 60.0  # [s]
NOBODY = "65534"
# Names whose values a component or a running program changes.
COMPUTED = (".tmax", ".time", "-deriv", ".alive")
TRUTH = {"TRUE": 1.0, "FALSE": 0.0}
CHATTER = "Note: Using POSIX non-realtime"


class HalError(MachineRefusedError):
    """HAL refused a command."""

    def __init__(self, message: str) -> None:
        super().__init__("hal", f"halcmd: {message}")


class Hal:
    """The HAL that runs on this computer."""

    def __init__(self) -> None:
        if shutil.which("halcmd") is None:
            raise InputError(
                "needs halcmd of LinuxCNC, which is not installed",
                path="machine",
                value="linuxcnc",
                mend="Install LinuxCNC 2.9 (Debian: linuxcnc-uspace, and linuxcnc-uspace-dev for halcompile)",
            )
        # As root, the real-time program takes another identity.
        self.environment = os.environ | (
            {"RTAPI_UID": os.environ.get("RTAPI_UID", NOBODY)} if os.geteuid() == 0 else {}
        )

    def run(self, *lines: str, keep_going: bool = False) -> list[str]:
        """Run commands in one batch and return the lines that HAL prints; `keep_going` ignores failures, as a restoration must."""
        program = ["halcmd", *(["-k"] if keep_going else []), "-f"]
        # Files instead of pipes: the program that the first loadrt starts inherits them, and would hold a pipe open.
        with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as faults:
            text = "\n".join(lines) + "\n"
            process = subprocess.run(
                program,
                input=text,
                text=True,
                stdout=out,
                stderr=faults,
                timeout=PATIENCE,
                env=self.environment,
                check=False,
            )
            out.seek(0)
            faults.seek(0)
            output = [
                line
                for line in out.read().splitlines()
                if line.strip() and not line.startswith(CHATTER)
            ]
            if process.returncode and not keep_going:
                raise HalError((faults.read() + " ".join(output)).strip()[:400])
        return output

    def get(self, *pins: str) -> list[float]:
        """Return the values of pins."""
        output = self.run(*(f"getp {pin}" for pin in pins))
        if len(output) != len(pins):
            raise HalError(f"getp {' '.join(pins)}: {' '.join(output)}")
        return [TRUTH[value] if value in TRUTH else float(value) for value in output]

    def components(self) -> list[str]:
        """Return the names of the loaded components, without those of halcmd."""
        rows = [line.split() for line in self.run("show comp")]
        return sorted(
            row[2]
            for row in rows
            if len(row) > 3 and row[0].isdigit() and not row[2].startswith("halcmd")
        )

    def links(self) -> dict[str, list[str]]:
        """Return the pins of each signal."""
        linked: dict[str, list[str]] = {}
        for pin, signal in re.findall(
            r"(\S+)\s+(?:==>|<==|<=>)\s+(\S+)", "\n".join(self.run("show pin"))
        ):
            linked.setdefault(signal, []).append(pin)
        return {signal: sorted(pins) for signal, pins in sorted(linked.items())}

    def functions(self, thread: str) -> list[str]:
        """Return the functions of a thread, in order."""
        listed, inside = [], False
        for line in self.run("show thread"):
            words = line.split()
            if len(words) >= 3 and words[1] in ("YES", "NO"):
                inside = words[2] == thread
            elif inside and len(words) == 2 and words[0].isdigit():
                listed.append(words[1])
        return listed

    def value_of_parameters(self, components: Sequence[str]) -> dict[str, str]:
        """Return the parameters and unlinked input pins of components, by name."""
        rows = [line.split() for line in self.run("show param", "show pin")]
        prefixes = tuple(f"{component}." for component in components)
        values = {}
        for row in rows:
            name = next(
                (word for word in row if word.startswith(prefixes) and not word.endswith(COMPUTED)),
                None,
            )
            if name is not None and not {"==>", "<=="} & set(row) and row[2] in ("RW", "IN"):
                values[name] = row[row.index(name) - 1]
        return values

    def play(self, path: Path) -> subprocess.Popen[str]:
        """Start to fill the ring of the streamer from a file."""
        return subprocess.Popen(
            ["halstreamer", str(path)],
            stderr=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            text=True,
            env=self.environment,
        )

    def sampled(self, count: int) -> list[str]:
        """Return rows of the sampler."""
        with tempfile.TemporaryFile("w+") as out:
            subprocess.run(
                ["halsampler", "-n", str(count)],
                stdout=out,
                timeout=2 * PATIENCE,
                env=self.environment,
                check=True,
            )
            out.seek(0)
            return out.read().splitlines()

    def install(self, name: str, source: str) -> None:
        """Compile and install a component."""
        with tempfile.TemporaryDirectory() as folder:
            component = Path(folder) / f"{name}.comp"
            component.write_text(source, encoding="utf-8")
            command = ["halcompile", "--install", component.name]
            process = subprocess.run(
                command, cwd=folder, capture_output=True, text=True, check=False
            )
        if process.returncode:
            output = (process.stdout + process.stderr).strip()[-400:]
            raise MachineRefusedError(
                "not_compiled",
                f"halcompile refused {component.name}: {output}",
                "Run it as root, or allow this user to write the modules of LinuxCNC",
            )
