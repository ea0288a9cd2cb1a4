"""CUDA of friction models: its text, and its bits on a graphics processor."""

import ctypes
import re
import shutil
import subprocess
from functools import cache

import numpy as np
import pytest
from tests.contract.models import with_fast
from tests.exports.native import differing, example_with, walk

import bristle as br
from bristle.apps.targets import cuda
from bristle.apps.targets.cuda import write
from bristle.contract import example_of
from bristle.engine.path import output_along
from bristle.exports.described import Request

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
MODELS_OF = {
    name: br.friction.with_slots(component, SLOTS.get(name, ()))
    for name, component in br.friction.MODELS.items()
}
COMPONENTS = MODELS_OF | {
    f"op_{name}": br.hysteresis.OPERATORS[name] for name in ("prandtl_ishlinskii", "preisach")
}
COMPARED = [
    *with_fast("lugre", "gms", "preisach_lugre"),
    pytest.param("op_prandtl_ishlinskii", marks=pytest.mark.slow),
    "op_preisach",
]


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
    flags = (
        "-O1",
        "-std=c++17",
        "-ffp-contract=off",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-shared",
        "-fPIC",
    )
    built = subprocess.run(
        [COMPILER, *flags, f"{name}.cpp", "-o", "model.so"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
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
        columns.append(
            np.concatenate([np.ravel(np.asarray(values[name], float)) for name in variables])
        )
    return models, np.ascontiguousarray(np.transpose(columns))


def expected(name):
    """Return positions, values and what bristle makes of them in each lane."""
    x = np.ascontiguousarray(np.transpose([walk(SAMPLES, seed=lane) for lane in range(LANES)]))
    models, values = lanes_of(example_of(COMPONENTS[name]))
    if name.startswith("op_"):
        x /= np.max(np.abs(x))
        return (
            x,
            values,
            np.transpose([output_along(model, x[:, lane]) for lane, model in enumerate(models)]),
        )
    return (
        x,
        values,
        np.transpose([br.response(model, x[:, lane], DT) for lane, model in enumerate(models)]),
    )


@pytest.mark.slow
@pytest.mark.skipif(COMPILER is None, reason="needs a C++ compiler")
@pytest.mark.parametrize("name", COMPARED)
def test_every_lane_is_identical_to_bristle_with_separate_values(written, tmp_path, name):
    x, values, forces = expected(name)
    computed, pointer = np.empty_like(x), ctypes.POINTER(ctypes.c_double)
    handed = [array.ctypes.data_as(pointer) for array in (x, values, computed)]
    native(name, written(name), tmp_path)(LANES, SAMPLES, ctypes.c_double(DT), *handed)
    assert np.ptp(forces) > 0.0
    assert differing(computed, forces) == 0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["lugre", "preisach_lugre", "op_preisach"])
def test_nvrtc_compiles_it_and_rounds_every_operation(written, name):
    ptx = ptx_of(written(name))
    used = set(re.findall(r"\b(add|sub|mul|div|sqrt|fma|mad)\.([a-z.]*f(?:64|32))\b", ptx))
    assert {how for _, how in used} == {"rn.f64"}
    assert {"add", "mul"} <= {name for name, _ in used} <= {"add", "sub", "mul", "div", "sqrt"}
    assert f".entry {name}_start_lanes" in ptx


@pytest.mark.slow
def test_fused_multiply_add_is_detected(written):
    assert "fma.rn.f64" in ptx_of(written("lugre"), "--fmad=true", "--std=c++17")


@pytest.mark.slow
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
    device.launch(
        f"{name}_{kernel}_lanes", LANES, axes, LANES, SAMPLES, *step, device.memory(x), output
    )
    assert differing(device.array(output, x.shape), forces) == 0


FLAGS = ("--fmad=false", "--std=c++17")


def ptx_of(text, *flags, architecture="compute_80"):
    """Return what NVRTC makes of a text, for the virtual machine of a family of processors."""
    nvrtc = pytest.importorskip(
        "cuda.bindings.nvrtc", reason="needs NVRTC: pip install bristle[gpu]"
    )
    try:
        _, program = nvrtc.nvrtcCreateProgram(text.encode(), b"axis.cu", 0, [], [])
    except RuntimeError as error:
        pytest.skip(f"needs the library of NVRTC: {error}")
    options = [
        f"--gpu-architecture={architecture}".encode(),
        *(flag.encode() for flag in flags or FLAGS),
    ]
    (status,) = nvrtc.nvrtcCompileProgram(program, len(options), options)
    log = _room(nvrtc.nvrtcGetProgramLogSize(program)[1])
    nvrtc.nvrtcGetProgramLog(program, log)
    assert int(status) == 0, log.decode()[:4000]
    assert log.strip(b"\0") == b""
    ptx = _room(nvrtc.nvrtcGetPTXSize(program)[1])
    nvrtc.nvrtcGetPTX(program, ptx)
    return ptx.rstrip(b"\0").decode()


def _room(size):
    """Return bytes to be written over: never one alone, as CPython keeps a single object for each of these."""
    return b"\0" * (size + 2)


class Device:
    """A graphics processor with the kernels of a text."""

    def __init__(self, text):
        driver = pytest.importorskip("cuda.bindings.driver")
        self._driver = driver
        try:
            self._of(driver.cuInit(0))
            device = self._of(driver.cuDeviceGet(0))
        except Exception as error:  # noqa: BLE001  (no driver, no device: each library says it in its own way)
            pytest.skip(f"needs a graphics processor: {error}")
        major, minor = [
            self._of(driver.cuDeviceGetAttribute(attribute, device))
            for attribute in (
                driver.CUdevice_attribute.CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR,
                driver.CUdevice_attribute.CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR,
            )
        ]
        self._of(driver.cuCtxSetCurrent(self._of(driver.cuDevicePrimaryCtxRetain(device))))
        ptx = ptx_of(text, architecture=f"compute_{major}{minor}")
        self._module = self._of(driver.cuModuleLoadData(ptx.encode()))

    def _of(self, answer):
        status, *values = answer
        assert int(status) == 0, status
        return values[0] if values else None

    def memory(self, content):
        """Return the address of a copy of an array, or of so many bytes, on the device."""
        size = content if isinstance(content, int) else content.nbytes
        address = self._of(self._driver.cuMemAlloc(size))
        if not isinstance(content, int):
            self._of(self._driver.cuMemcpyHtoD(address, content.ctypes.data, size))
        return address

    def launch(self, kernel, lanes, *arguments):
        """Run a kernel in so many lanes."""
        function = self._of(self._driver.cuModuleGetFunction(self._module, kernel.encode()))
        kinds = tuple(
            {int: ctypes.c_int, float: ctypes.c_double}.get(type(a), ctypes.c_void_p)
            for a in arguments
        )
        values = tuple(a if isinstance(a, (int, float)) else int(a) for a in arguments)
        blocks = (lanes + 127) // 128
        self._of(
            self._driver.cuLaunchKernel(function, blocks, 1, 1, 128, 1, 1, 0, 0, (values, kinds), 0)
        )
        self._of(self._driver.cuCtxSynchronize())

    def array(self, address, shape):
        """Return the numbers at an address."""
        content = np.empty(shape)
        self._of(self._driver.cuMemcpyDtoH(content.ctypes.data, address, content.nbytes))
        return content


# --- text ------------------------------------------------------------------------------------------------------------


LUGRE = br.friction.lugre(F_C=22.0, F_S=29.0, v_S=3e-3, sigma_0=2e6, sigma_1=1e3, sigma_2=40.0)
SIZES = {"double": 8, "int32_t": 4, "int64_t": 8, "bool": 1}


def texts(model, **options):
    product = write(Request(model, "axis_x", 1e-3, **options))
    assert list(product.files) == ["axis_x.cu", "README.md"]
    return product.files["axis_x.cu"], product.files["README.md"], product.notes


def size_of(body):
    """The bytes of a structure of C, each number at a multiple of its own size, the whole of eight."""
    at = 0
    for kind, count in re.findall(
        r"^\s*(double|int32_t|int64_t|bool) \w+(?:\[(\d+)\])?;", body, re.MULTILINE
    ):
        at = -(-at // SIZES[kind]) * SIZES[kind] + SIZES[kind] * int(count or 1)
    return -(-at // 8) * 8


@pytest.mark.parametrize(
    "model",
    [
        LUGRE,
        br.friction.coulomb(F_C=2.0),
        example_with("preisach_lugre"),
        example_of(br.hysteresis.OPERATORS["prandtl_ishlinskii"]),
    ],
    ids=lambda model: model.name,
)
def test_a_lane_is_as_large_as_its_structure(model):
    source, readme, _ = texts(model)
    told = re.findall(r"(\d+) bytes", readme)
    assert len(set(told)) == 1
    parameters = re.search(r"typedef struct \{\n([^}]*)\} axis_x_parameters;", source)[1]
    lane = re.search(r"typedef struct axis_x \{\n(.*?)\} axis_x;", source, re.DOTALL)[1]
    state = re.search(r"struct \{\n(.*?)\} state;", lane, re.DOTALL)
    own = re.sub(r"struct \{\n.*?\} state;", "", lane, flags=re.DOTALL)
    head, memory = own.partition("double memory")[::2]
    sizes = [
        size_of(head),
        size_of("    double memory" + memory) if memory else 0,
        size_of(parameters),
    ]
    assert int(told[0]) == sum(sizes) + (size_of(state[1]) if state else 0)


OPERATOR = example_of(br.hysteresis.OPERATORS["prandtl_ishlinskii"])
ROWS = "`F_C`, `F_S`, `v_S`, `sigma_0`, `sigma_1`, `sigma_2`, `v_d`"


@pytest.mark.parametrize(
    ("model", "words"),
    [
        (
            LUGRE,
            ["one axis with 96 bytes", "double values[7][lanes]", ROWS, "force[samples][lanes]"],
        ),
        (OPERATOR, ["`thresholds[0]`, `thresholds[1]`, `thresholds[2]`", "output[samples][lanes]"]),
    ],
)
def test_rows_of_values_are_the_parameters_in_order_with_each_array_element(model, words):
    _, readme, _ = texts(model)
    assert [word for word in words if word not in readme] == []


def test_functions_are_device_functions_and_structures_are_constructed_by_name():
    source, _, _ = texts(LUGRE)
    assert "__device__ double axis_x_force(" in source
    assert "static __device__ inline double lugre_stribeck_force(" in source
    assert re.search(r"\((State|Move|Motion|Parameters)\)\{", source) is None  # which is C
    assert re.search(r"\b(State|Move|Motion|Parameters)\{", source)
    assert (
        re.search(r"^static __device__ const \w+", source, re.MULTILINE)
        or "static const" not in source
    )


def test_the_option_tunable_does_not_change_the_text():
    assert texts(LUGRE)[0] == texts(LUGRE, tunable=True)[0]


def test_constant_parameters_are_shared_by_all_lanes(monkeypatch):
    _, _, notes = texts(LUGRE)
    assert len(notes) == 1
    assert "--fmad=false" in notes[0]

    def refuses(model, fixed=()):
        raise br.core.InputError("converts these parameters at the start", path="model")

    monkeypatch.setattr(cuda, "tunable_of", refuses)
    source, readme, notes = texts(LUGRE)
    assert notes[1] == "all lanes share the parameters of the model"
    assert "values[" not in readme
    assert "one axis with 40 bytes" in readme
    assert "_set_lanes" not in source
