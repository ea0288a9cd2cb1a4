"""Self-tests of exported models on other targets: built by their compilers, and run by an emulator of each.

``python -m tests.apps.targets.other_targets`` tells each model that has other bits there; exit code 1 where these are not
the ones that are known.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from tests.exports.native import example_with

import bristle as br
from bristle.core.cores import abreast

HERE = Path(__file__).parent / "cortex_m"
FLAGS = ("-O2", "-std=c99", "-ffp-contract=off")
SECONDS = 240
SLOTS = {
    "plain": (),
    "sided": ("asymmetry",),
    "varied": ("position", "periodic", "load", "temperature", "asymmetry"),
}


# A Cortex-M4F has no doubles: libgcc adds them in software, and rounds one sum of these walks to the wrong side.
KNOWN = {"Cortex-M4F": {"sided leuven", "varied leuven"}}


class Target(NamedTuple):
    """A target: its compiler with what it is told, and what runs the program."""

    build: tuple[str, ...]
    run: tuple[str, ...]
    further: tuple[str, ...] = ()

    @property
    def lacking(self) -> str:
        """What is not there to build for it, and to run it."""
        return ", ".join(
            item for item in (self.build[0], *self.run[:1]) if shutil.which(item) is None
        )


def _cortex(core: str, unit: str, board: str) -> Target:
    return Target(
        (
            "arm-none-eabi-gcc",
            f"-mcpu={core}",
            "-mthumb",
            "-mfloat-abi=hard",
            f"-mfpu={unit}",
            "--specs=rdimon.specs",
            "-nostartfiles",
            "-T",
            str(HERE / "mps2.ld"),
        ),
        (
            "qemu-system-arm",
            "-M",
            board,
            "-nographic",
            "-monitor",
            "none",
            "-serial",
            "none",
            "-semihosting-config",
            "enable=on,target=native",
            "-kernel",
        ),
        (str(HERE / "startup.c"),),
    )


TARGETS = {
    "clang": Target(("clang",), ()),
    "aarch64": Target(("aarch64-linux-gnu-gcc", "-static"), ("qemu-aarch64-static",)),
    "Cortex-M7": _cortex("cortex-m7", "fpv5-d16", "mps2-an500"),
    "Cortex-M4F": _cortex("cortex-m4", "fpv4-sp-d16", "mps2-an386"),
}


def answer(target: Target, model: br.core.Model, folder: Path) -> str:
    """Return what the self-test of a model on a target says against it; nothing where its bits are the same."""
    br.export(model, "c", folder, name="axis_x")
    program = folder / "selftest"
    further = target.further
    if further:  # the start of a C program, which the library of the compiler brings
        start = subprocess.run(
            [*target.build[:5], "-print-file-name=rdimon-crt0.o"],
            capture_output=True,
            text=True,
            check=True,
        ).stdout.strip()
        further = (*further, start)
    built = subprocess.run(
        [
            *target.build,
            *FLAGS,
            "axis_x.c",
            "axis_x_selftest.c",
            *further,
            "-o",
            str(program),
            "-lm",
        ],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    if built.returncode != 0:
        return built.stderr[-400:]
    try:
        ran = subprocess.run(
            [*target.run, str(program)],
            capture_output=True,
            text=True,
            timeout=SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"no answer in {SECONDS} s"
    return (
        ""
        if ran.returncode == 0 and "identical to bristle" in ran.stdout
        else (ran.stdout + ran.stderr)[-400:] or "silent"
    )


def examples() -> dict[str, br.core.Model]:
    """Return every model with each set of slots."""
    return {
        f"{kind} {name}": example_with(name, slots)
        for kind, slots in SLOTS.items()
        for name in br.friction.MODELS
    }


def main() -> int:
    """Try all, and tell."""
    models, wrong = examples(), 0
    for name, target in TARGETS.items():
        if target.lacking:
            print(f"{name}: not tried, for {target.lacking} is not here")
            continue
        different = dict(_different(target, models))
        wrong += len(different.keys() ^ KNOWN.get(name, set()))
        print(f"{name}: {len(models) - len(different)} of {len(models)} models have the same bits")
        for model, text in different.items():
            print(f"  {model}: {text.strip()}")
    return 1 if wrong else 0


def _different(target: Target, models: dict[str, br.core.Model]) -> Iterator[tuple[str, str]]:
    with tempfile.TemporaryDirectory() as place:
        try_one = abreast(
            lambda name: answer(target, models[name], Path(place) / name.replace(" ", "_"))
        )
        yield from (
            (name, text) for name, text in zip(models, try_one(list(models)), strict=True) if text
        )


if __name__ == "__main__":
    sys.exit(main())
