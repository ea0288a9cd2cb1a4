"""The libraries of an FMU: one with the C compiler of this machine, those of other platforms with zig."""

from __future__ import annotations

import importlib.util
import platform
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from bristle.exports.fmu_description import FLAGS
from bristle.exports.proof import compiler

__all__ = ["Library", "libraries", "zig"]

PATIENCE = 600.0  # [s]; zig builds the library of a platform once


@dataclass(frozen=True)
class Platform:
    """A platform: its folder in FMI 2.0, empty where that has none, and in 3.0; its name for zig; its library."""

    fmi_2: str
    fmi_3: str
    triple: str
    suffix: str


PLATFORMS = {
    ("linux", "x86_64"): Platform("linux64", "x86_64-linux", "x86_64-linux-gnu.2.17", ".so"),
    ("linux", "aarch64"): Platform("", "aarch64-linux", "aarch64-linux-gnu.2.17", ".so"),
    ("win32", "amd64"): Platform("win64", "x86_64-windows", "x86_64-windows-gnu", ".dll"),
    ("darwin", "x86_64"): Platform("darwin64", "x86_64-darwin", "x86_64-macos", ".dylib"),
    ("darwin", "arm64"): Platform("", "aarch64-darwin", "aarch64-macos", ".dylib"),
}


@dataclass(frozen=True)
class Library:
    """A library of an FMU: where it lies inside, and its bytes; or why there is none."""

    place: str
    content: bytes
    problem: str = ""


def zig() -> list[str]:
    """Return the command of the compiler for other platforms; empty where it is not installed."""
    return [sys.executable, "-m", "ziglang", "cc"] if importlib.util.find_spec("ziglang") else []


def libraries(name: str, sources: Mapping[str, str], fmi: int) -> list[Library]:
    """Return the libraries that can be built here."""
    local, own, across = (sys.platform, platform.machine().lower()), compiler(), zig()
    built = []
    for machine, target in PLATFORMS.items():
        folder = target.fmi_2 if fmi == 2 else target.fmi_3
        if not folder:
            continue
        if machine == local and own:
            command = [own, "-fPIC", "-fvisibility=hidden"]
        elif across:
            command = [*across, "-g0", "-target", target.triple, *([] if machine[0] == "win32" else ["-fPIC"])]
        else:
            continue
        built.append(_library(command, name, sources, f"binaries/{folder}/{name}{target.suffix}"))
    return built


def _library(command: list[str], name: str, sources: Mapping[str, str], place: str) -> Library:
    with tempfile.TemporaryDirectory(prefix="bristle-fmu-") as folder:
        for file, text in sources.items():
            (Path(folder) / file).write_text(text, encoding="utf-8")
        output = Path(folder) / Path(place).name
        line = [*command, "-O2", *FLAGS.split(), "-shared", f"{name}.c", "-o", output.name]
        line += [] if output.suffix == ".dll" else ["-lm"]
        try:
            ran = subprocess.run(line, cwd=folder, capture_output=True, text=True, timeout=PATIENCE, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            return Library(place, b"", type(error).__name__)
        if ran.returncode or not output.is_file():
            return Library(place, b"", (ran.stderr.strip().splitlines() or ["no reason given"])[0])
        return Library(place, output.read_bytes())
