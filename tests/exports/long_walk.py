"""A million steps of every model with every set of slots, in C at several levels of optimisation, to the bit.

And a tenth of it in Structured Text, with its self-test, where the reader of that language is installed.

``python -m tests.exports.long_walk``: tells each model that differs; exit code 1 if there is one. Minutes, not seconds.
"""

import shutil
import sys
import tempfile
from itertools import product
from pathlib import Path

import numpy as np
from tests.exports.native import COMPILER, Native, differing, example_with, walk

import bristle as br
from bristle.core.contracts import NOMINAL_LOAD, NOMINAL_TEMPERATURE, NOTHING_TRANSMITTED

STEPS, ST_STEPS, DT = 1_000_000, 100_000, 5e-4
SLOTS = {
    "plain": (),
    "sided": ("asymmetry",),
    "varied": ("position", "periodic", "load", "temperature", "asymmetry"),
}
LEVELS = (("-O0",), ("-O2",), ("-O3", "-march=native"))
COMPILERS = tuple(
    fromkey for fromkey in dict.fromkeys((COMPILER, shutil.which("clang"))) if fromkey is not None
)


def main() -> int:
    """Compare, and tell."""
    if COMPILER is None:
        print("no C compiler here: nothing compared")
        return 0
    models = {
        f"{kind}_{name}": example_with(name, slots)
        for kind, slots in SLOTS.items()
        for name in br.friction.MODELS
    }
    x, wrong = walk(STEPS), 0
    with tempfile.TemporaryDirectory() as place:
        built = {}
        for number, (compiler, (level, *more)) in enumerate(product(COMPILERS, LEVELS)):
            built[" ".join((Path(compiler).name, level, *more))] = Native(
                models, Path(place) / str(number), optimise=level, more=more, compiler=compiler
            )
        for name, model in models.items():
            expected = br.response(model, x, DT, rest="held")
            for level, native in built.items():
                count = differing(native.forces(name, x, DT), expected)
                wrong += count > 0
                if count:
                    print(f"{name} {level}: {count} of {STEPS} forces differ")
    print(
        f"{len(models)} models, {len(built)} ways of compiling, {STEPS} steps each; wrong: {wrong or 'none'}"
    )
    wrong += structured_text(models)
    return 1 if wrong else 0


def structured_text(models):
    """Compare what is written in Structured Text, and return how many models are wrong."""
    try:
        from tests.apps.targets.structured_text import StandardError, StructuredText
    except ImportError:
        print("no reader of Structured Text here: that is not compared")
        return 0
    x, wrong = walk(ST_STEPS), 0
    for name, model in models.items():
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            br.export(model, "st", folder / "out", name=name)
            texts = [(folder / "out" / f"{name}{end}.st").read_text() for end in ("", "_selftest")]
            signals = {
                "load": NOMINAL_LOAD,
                "temperature": NOMINAL_TEMPERATURE,
                "transmitted": NOTHING_TRANSMITTED,
            }
            expected = br.response(model, x, DT, rest="held")
            for rounded in ("nearbyint", "trunc"):
                try:
                    block = StructuredText({name: texts}, folder / rounded, rounded=rounded)
                    force, flags = block.run(name, x, DT, **signals)
                    # At rest from below the velocity is -2^-1000 there, for that language has no -0.0: viscous friction shows it.
                    tiny = (np.abs(force) < 2.0**-900) & (np.abs(expected) < 2.0**-900)
                    force = np.where(tiny, expected, force)
                    count, passed = (
                        differing(force, expected) + np.count_nonzero(flags),
                        block.selftest(name)[1],
                    )
                except StandardError as stopped:
                    count, passed = str(stopped), False
                if count or not passed:
                    wrong += 1
                    print(
                        f"{name}, {rounded}: {count} of {ST_STEPS} differ; self-test passed: {passed}"
                    )
    print(f"Structured Text: {len(models)} models, {ST_STEPS} steps each; wrong: {wrong or 'none'}")
    return wrong


if __name__ == "__main__":
    sys.exit(main())
