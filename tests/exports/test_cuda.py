"""CUDA C++ of models and operators: the bits of bristle in every lane, each with values and positions of its own."""

import ctypes
import re
import shutil
import subprocess
from functools import cache

import numpy as np
import pytest
from tests.contract.models import with_fast
from tests.exports.graphics import Device, ptx_of
from tests.exports.native import differing, walk

import bristle as br
from bristle.engine.path import output_along
from bristle.friction import MODELS, with_slots
from bristle.hysteresis import OPERATORS
from bristle.testing import example_of

pytestmark = pytest.mark.slow

COMPILER = shutil.which("c++") or shutil.which("g++")
DT = 5e-4
LANES, SAMPLES = 3, 2000
RUN = """
extern "C" void run_{name}(int lanes, int samples, double dt, const double *x, const double *values, double *output)
{{
    (void)dt;
    {name} *axes = new {name}[lanes];
    for (int call = 0; call < 2 + {parts}; ++call) {{
        for ({name}_lane = 0; {name}_lane < lanes + 1; ++{name}_lane) {{
            if (call == 0) {{
                {name}_start_lanes(axes, lanes);
            }} else if (call == 1) {{
                {set}
            }} else {{
                const int at = (call - 2) * (samples / {parts}) * lanes;
                {name}_{output}_lanes(axes, lanes, samples / {parts}, {dt}x + at, output + at);
            }}
        }}
    }}
    delete[] axes;
}}
"""


SLOTS = {"lugre": ("periodic",), "gms": ("asymmetry", "load")}
MODELS_OF = {name: with_slots(component, SLOTS.get(name, ())) for name, component in MODELS.items()}
COMPONENTS = MODELS_OF | {f"op_{name}": OPERATORS[name] for name in ("prandtl_ishlinskii", "preisach")}
COMPARED = [*with_fast("lugre", "gms", "preisach_lugre"), pytest.param("op_prandtl_ishlinskii", marks=pytest.mark.slow), "op_preisach"]


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Return the text of a model, by its name."""
    folder = tmp_path_factory.mktemp("written")

    @cache
    def text_of(name):
        br.export(example_of(COMPONENTS[name]), "cuda", folder / name, name=name)
        return (folder / name / f"{name}.cu").read_text()

    return text_of


def native(name, text, folder):
    """Return the function of a text that a compiler of C++ took, for one lane after another."""
    run = RUN.format(
        name=name,
        parts=4,
        output="output" if name.startswith("op_") else "force",
        dt="" if name.startswith("op_") else "dt, ",
        set=f"{name}_set_lanes(axes, lanes, values);" if "set_lanes" in text else "(void)values;",
    )
    (folder / f"{name}.cpp").write_text(text + run)
    flags = ("-O1", "-std=c++17", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC")
    built = subprocess.run([COMPILER, *flags, f"{name}.cpp", "-o", "model.so"], cwd=folder, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr[:4000]
    return getattr(ctypes.CDLL(str(folder / "model.so")), f"run_{name}")


def lanes_of(model):
    """Return models with other values in each lane, and the rows of values that say so."""
    variables = {
        name: np.asarray(value, float)
        for name, value in model.values.items()
        if not model.component.is_integer(name) and not model.component.variables[name].choices
    }
    models, columns = [], []
    for lane in range(LANES):
        models.append(model.with_values(sigma_2=5.0 + lane) if "sigma_2" in variables else model)
        values = models[-1].values
        columns.append(np.concatenate([np.ravel(np.asarray(values[name], float)) for name in variables]))
    return models, np.ascontiguousarray(np.transpose(columns))


def expected(name):
    """Return positions, values and what bristle makes of them in each lane."""
    x = np.ascontiguousarray(np.transpose([walk(SAMPLES, seed=lane) for lane in range(LANES)]))
    models, values = lanes_of(example_of(COMPONENTS[name]))
    if name.startswith("op_"):
        x /= np.max(np.abs(x))
        return x, values, np.transpose([output_along(model, x[:, lane]) for lane, model in enumerate(models)])
    return x, values, np.transpose([br.response(model, x[:, lane], DT) for lane, model in enumerate(models)])


@pytest.mark.skipif(COMPILER is None, reason="needs a C++ compiler")
@pytest.mark.parametrize("name", COMPARED)
def test_every_lane_is_identical_to_bristle_with_separate_values(written, tmp_path, name):
    x, values, forces = expected(name)
    computed, pointer = np.empty_like(x), ctypes.POINTER(ctypes.c_double)
    handed = [array.ctypes.data_as(pointer) for array in (x, values, computed)]
    native(name, written(name), tmp_path)(LANES, SAMPLES, ctypes.c_double(DT), *handed)
    assert np.ptp(forces) > 0.0
    assert differing(computed, forces) == 0


@pytest.mark.parametrize("name", ["lugre", "preisach_lugre", "op_preisach"])
def test_nvrtc_compiles_it_and_rounds_every_operation(written, name):
    ptx = ptx_of(written(name))
    used = set(re.findall(r"\b(add|sub|mul|div|sqrt|fma|mad)\.([a-z.]*f(?:64|32))\b", ptx))
    assert {how for _, how in used} == {"rn.f64"}
    assert {"add", "mul"} <= {name for name, _ in used} <= {"add", "sub", "mul", "div", "sqrt"}
    assert f".entry {name}_start_lanes" in ptx


def test_fused_multiply_add_is_detected(written):
    assert "fma.rn.f64" in ptx_of(written("lugre"), "--fmad=true", "--std=c++17")


@pytest.mark.parametrize("name", COMPARED)
def test_a_graphics_processor_gives_identical_forces(written, name):
    text = written(name)
    device = Device(text)
    x, values, forces = expected(name)
    size = int(re.search(r"static_assert\(sizeof\(\w+\) == (\d+)", text)[1])
    axes, output = device.memory(LANES * size), device.memory(x.nbytes)
    device.launch(f"{name}_start_lanes", LANES, axes, LANES)
    if "set_lanes" in text:
        device.launch(f"{name}_set_lanes", LANES, axes, LANES, device.memory(values))
    kernel, step = ("output", ()) if name.startswith("op_") else ("force", (DT,))
    device.launch(f"{name}_{kernel}_lanes", LANES, axes, LANES, SAMPLES, *step, device.memory(x), output)
    assert differing(device.array(output, x.shape), forces) == 0
