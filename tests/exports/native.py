"""Exported models as one shared library: each compiled once, and called from Python."""

import ctypes
import shutil
import subprocess

import numpy as np

import bristle as br
from bristle.contract import example_of
from bristle.exports.c import builds

COMPILER = next((shutil.which(name) for name in ("cc", "gcc") if builds(name)), None)
WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-pedantic", "-Werror")
ALL = ("position", "periodic", "load", "temperature", "asymmetry")
FLAGS = ("-std=c99", "-ffp-contract=off")
RUN_OPERATOR = """
#include "{name}.h"
void run_{name}(const double *x, int count, double dt, double *output)
{{
    static {name} axis;
    (void)dt;
    {name}_start(&axis);
    for (int i = 0; i < count; ++i) {{
        output[i] = {name}_output(&axis, x[i]);
    }}
}}
"""
RUN = """
#include "{name}.h"
void run_{name}(const double *x, int count, double dt, double *force)
{{
    static {name} axis;
    {name}_start(&axis);
    for (int i = 0; i < count; ++i) {{
        force[i] = {name}_force(&axis, x[i], dt);
    }}
}}
"""

RUN_LAW = """
#include "{name}.h"
void run_{name}(const {name}_inputs *inputs, int count, double *effort)
{{
    static {name} axis;
    {name}_start(&axis);
    for (int i = 0; i < count; ++i) {{
        effort[i] = {name}_effort(&axis, &inputs[i]);
    }}
}}
"""


def example_with(name, slots=None):
    """Return an example of a friction model, with slots if any are named: without one it may still push."""
    component = br.friction.MODELS[name]
    return example_of(component if slots is None else br.friction.with_slots(component, slots))


def compiled(folder, *arguments, compiler=COMPILER):
    """Let a compiler work in a folder, without a warning."""
    made = subprocess.run(
        [compiler, *arguments], cwd=folder, capture_output=True, text=True, check=False
    )
    assert made.returncode == 0, made.stderr[:4000]


def built(folder, main, *flags, compiler=COMPILER, name="axis_x"):
    """Return how a program of an export ran."""
    compiled(
        folder,
        "-O0",
        *FLAGS,
        *WARNINGS,
        *flags,
        f"{name}.c",
        main,
        "-o",
        "program",
        "-lm",
        compiler=compiler,
    )
    return subprocess.run(["./program"], cwd=folder, capture_output=True, text=True, check=False)


def library(folder, *arguments, compiler=COMPILER):
    """Return sources as a library in this process."""
    compiled(
        folder, *FLAGS, *arguments, "-shared", "-fPIC", "-o", "library.so", "-lm", compiler=compiler
    )
    return ctypes.CDLL(str(folder / "library.so"))


def library_of_laws(folder, texts, callers):
    """Return exported laws, by name the text of each file, as one library; the caller of each is C."""
    for name, files in texts.items():
        (folder / name).mkdir(exist_ok=True, parents=True)
        for file, text in {**files, "run.c": callers[name]}.items():
            (folder / name / file).write_text(text, encoding="ascii")
    return library(
        folder, "-O0", *WARNINGS, *(f"{name}/{file}.c" for name in texts for file in (name, "run"))
    )


def selected_cases(request, *keys):
    """Return the values of some parameters that tests of this file run with: what no test asks for is not compiled."""
    items = [
        item
        for item in request.session.items
        if item.path == request.path and hasattr(item, "callspec")
    ]
    return {
        tuple(item.callspec.params[key] for key in keys)
        for item in items
        if all(key in item.callspec.params for key in keys)
    }


def in_structured_text(texts, folder, **options):
    """Return blocks by their names, each the texts of its files."""
    from tests.apps.targets.structured_text import StructuredText

    return StructuredText(texts, folder, **options)


def texts_of(model, folder, name="axis_x", **options):
    """Return a model in Structured Text: its block and its self-test."""
    br.export(model, "st", folder / f"out_{name}", name=name, **options)
    return [
        (folder / f"out_{name}" / f"{name}{end}.st").read_text(encoding="ascii")
        for end in ("", "_selftest")
    ]


class Native:
    """Models, by a name that C can have, compiled into one library."""

    def __init__(self, models, folder, *, optimise="-O0", more=(), compiler=COMPILER, **options):
        folder.mkdir(exist_ok=True)
        for name, model in models.items():
            br.export(model, "c", folder / f"out_{name}", name=name, **options)
            run = RUN_OPERATOR if model.component.family == "hysteresis" else RUN
            (folder / f"run_{name}.c").write_text(run.format(name=name))
        sources = [
            file
            for name in models
            for file in (f"-Iout_{name}", f"out_{name}/{name}.c", f"run_{name}.c")
        ]
        self._library = library(folder, optimise, *WARNINGS, *more, *sources, compiler=compiler)

    def forces(self, name, x, dt):
        """Return what the model of this name gives along some positions."""
        x = np.ascontiguousarray(x, dtype=float)
        force = np.empty(x.size)
        pointer = ctypes.POINTER(ctypes.c_double)
        run = getattr(self._library, f"run_{name}")
        run.restype = None
        run(x.ctypes.data_as(pointer), x.size, ctypes.c_double(dt), force.ctypes.data_as(pointer))
        return force


def walk(count, seed=20260):
    """Return positions [m]: steps of many sizes and both signs, some of length 0, some back to where it was."""
    generator = np.random.default_rng(seed)
    sizes = 10.0 ** np.repeat(generator.uniform(-9, -4, count // 100 + 1), 100)[:count]
    steps = generator.standard_normal(count) * sizes
    steps[generator.random(count) < 0.05] = 0.0
    x = np.cumsum(steps)
    back = np.flatnonzero(generator.random(count) < 0.02)[1:]
    x[back] = x[back - 2]
    return x


def differing(first, second):
    """Return how many numbers have other bits."""
    return int(
        np.count_nonzero(
            np.ascontiguousarray(first).view(np.int64)
            != np.ascontiguousarray(second).view(np.int64)
        )
    )
