"""The proof of an export: a C compiler of this machine builds the self-test, and it runs."""

import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path

from bristle.core.contracts import Model
from bristle.exports.c import FLAGS, CFiles
from bristle.exports.described import Source
from bristle.exports.subject import settled_subject, subject_of

STEPS, DT, NAME = 400, 1e-3, "model"
PATIENCE = 120.0  # [s]


def compiler() -> str | None:
    """Return the name of a C compiler that builds and runs a program here; None where none does."""
    return next((name for name in ("cc", "gcc", "clang") if builds(name, *FLAGS.split())), None)


@cache
def builds(command: str, *flags: str) -> bool:
    """Return whether a compiler is installed, takes these flags, and its program runs: a sanitizer may be missing."""
    if shutil.which(command) is None:
        return False
    with tempfile.TemporaryDirectory(prefix="bristle-proof-") as place:
        (Path(place) / "tried.c").write_text("int main(void) { return 0; }\n", encoding="ascii")
        for line in ([command, *flags, "tried.c", "-o", "tried", "-lm"], ["./tried"]):
            if subprocess.run(line, cwd=place, capture_output=True, timeout=PATIENCE, check=False).returncode:
                return False
    return True


def proved(model: Model, command: str) -> tuple[int, str]:
    """Return how many steps the self-test of a model took, compiled, and what it says where it fails."""
    files = CFiles(settled_subject(subject_of(model)), NAME, Source(), DT, steps=STEPS).files()
    with tempfile.TemporaryDirectory(prefix="bristle-proof-") as place:
        for file, text in files.items():
            (Path(place) / file).write_text(text, encoding="ascii")
        line = [command, "-O1", *FLAGS.split(), f"{NAME}.c", f"{NAME}_selftest.c", "-o", "selftest", "-lm"]
        built = subprocess.run(line, cwd=place, capture_output=True, text=True, timeout=PATIENCE, check=False)
        if built.returncode:
            return STEPS, f"{command} says: {built.stderr.strip().splitlines()[0]}"
        ran = subprocess.run(["./selftest"], cwd=place, capture_output=True, text=True, timeout=PATIENCE, check=False)
        return STEPS, ran.stdout.strip().splitlines()[-1] if ran.returncode else ""
