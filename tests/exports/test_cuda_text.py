"""The text of a model in CUDA C++: how large a lane is, which rows its values have, and where C++ is not C."""

import re

import pytest
from tests.exports.native import example_with

import bristle as br
from bristle.core.errors import InputError
from bristle.exports import cuda
from bristle.exports.cuda import write
from bristle.exports.targets import Request
from bristle.hysteresis import OPERATORS
from bristle.testing import example_of

LUGRE = br.friction.lugre(F_C=22.0, F_S=29.0, v_S=3e-3, sigma_0=2e6, sigma_1=1e3, sigma_2=40.0)
SIZES = {"double": 8, "int32_t": 4, "int64_t": 8, "bool": 1}


def texts(model, **options):
    product = write(Request(model, "axis_x", 1e-3, **options))
    assert list(product.files) == ["axis_x.cu", "README.md"]
    return product.files["axis_x.cu"], product.files["README.md"], product.notes


def size_of(body):
    """The bytes of a structure of C, each number at a multiple of its own size, the whole of eight."""
    at = 0
    for kind, count in re.findall(r"^\s*(double|int32_t|int64_t|bool) \w+(?:\[(\d+)\])?;", body, re.MULTILINE):
        at = -(-at // SIZES[kind]) * SIZES[kind] + SIZES[kind] * int(count or 1)
    return -(-at // 8) * 8


@pytest.mark.parametrize(
    "model",
    [LUGRE, br.friction.coulomb(F_C=2.0), example_with("preisach_lugre"), example_of(OPERATORS["prandtl_ishlinskii"])],
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
    sizes = [size_of(head), size_of("    double memory" + memory) if memory else 0, size_of(parameters)]
    assert int(told[0]) == sum(sizes) + (size_of(state[1]) if state else 0)


OPERATOR = example_of(OPERATORS["prandtl_ishlinskii"])
ROWS = "`F_C`, `F_S`, `v_S`, `sigma_0`, `sigma_1`, `sigma_2`, `v_d`"


@pytest.mark.parametrize(
    ("model", "words"),
    [
        (LUGRE, ["one axis with 96 bytes", "double values[7][lanes]", ROWS, "force[samples][lanes]"]),
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
    assert re.search(r"^static __device__ const \w+", source, re.MULTILINE) or "static const" not in source


def test_the_option_tunable_does_not_change_the_text():
    assert texts(LUGRE)[0] == texts(LUGRE, tunable=True)[0]


def test_constant_parameters_are_shared_by_all_lanes(monkeypatch):
    _, _, notes = texts(LUGRE)
    assert len(notes) == 1
    assert "--fmad=false" in notes[0]

    def refuses(model, fixed=()):
        raise InputError("converts these parameters at the start", path="model")

    monkeypatch.setattr(cuda, "tunable_of", refuses)
    source, readme, notes = texts(LUGRE)
    assert notes[1] == "all lanes share the parameters of the model"
    assert "values[" not in readme
    assert "one axis with 40 bytes" in readme
    assert "_set_lanes" not in source
