"""WebAssembly of friction models: written without a compiler, run in node, to the bit."""

import ctypes
import json
import shutil
import subprocess

import numpy as np
import pytest
from tests.contract.models import with_fast
from tests.exports.native import (
    ALL,
    COMPILER,
    differing,
    example_with,
    library,
    selected_cases,
    walk,
)

import bristle as br
from bristle.apps.targets.wasm import ALONE, module_of, write
from bristle.apps.targets.wasm_code import leb, signed_leb
from bristle.exports.described import Request
from bristle.exports.subject import digest_of, subject_of
from bristle.models.friction.resting import rest_rule, with_rest

NODE = shutil.which("node")
DT = 5e-4
MODELS_OF = {f"sided_{name}": (name, ("asymmetry",)) for name in br.friction.MODELS} | {
    f"varied_{name}": (name, ALL) for name in ("lugre", "gms", "preisach_lugre")
}
CHOSEN = [
    *with_fast("coulomb", "lugre", "preisach_contact", form="sided_{}"),
    "varied_lugre",
    *(pytest.param(f"varied_{name}", marks=pytest.mark.slow) for name in ("gms", "preisach_lugre")),
]
RUN = """
import { readFileSync, writeFileSync } from "node:fs";
const x = new Float64Array(new Uint8Array(readFileSync("x.bin")).buffer);
for (const name of process.argv.slice(2)) {
  const { load } = await import("./" + name + "/axis_x.mjs");
  const axis = await load();
  writeFileSync(name + ".bin", new Uint8Array(x.map((at) => axis.force(at, 5e-4)).buffer));
}
"""
needs_node = pytest.mark.skipif(NODE is None, reason="needs node")


def example(name):
    base, slots = MODELS_OF[name]
    return example_with(base, slots)


def node(folder, script, *arguments):
    (folder / "run.mjs").write_text(script)
    ran = subprocess.run(
        [NODE, "run.mjs", *arguments], cwd=folder, capture_output=True, text=True, check=False
    )
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


@pytest.fixture(scope="module")
def forces(request, tmp_path_factory):
    folder, names = (
        tmp_path_factory.mktemp("wasm"),
        [name for (name,) in selected_cases(request, "name")],
    )
    walk(20_000).tofile(folder / "x.bin")
    for name in names:
        br.export(example(name), "wasm", folder / name)
    node(folder, RUN, *names)
    return {name: np.fromfile(folder / f"{name}.bin") for name in names}


@needs_node
@pytest.mark.parametrize("name", CHOSEN)
def test_forces_are_identical_to_bristle(forces, name):
    assert differing(forces[name], br.response(example(name), walk(20_000), DT)) == 0


AROUND = """
import { load } from "./out/axis_x.mjs";
const axis = await load();
const run = () => [0, 1e-5, 3e-5, 2e-5].map((x) => axis.force(x, 5e-4));
const first = run();
axis.start();
const again = run();
axis.force(NaN, 5e-4);
const held = [axis.force(Infinity, 5e-4), axis.refused];
axis.start();
const cleared = axis.refused;
let beyond = "";
try { axis.set("F_S_neg", -1); } catch (error) { beyond = error instanceof RangeError ? error.message : "" }
axis.set("k_i", [5e6, 3e6, 1e6]);
axis.set("F_S_neg", 26);
const changed = run();
const k_i = axis.get("k_i");
console.log(JSON.stringify({ first, again, held, cleared, changed, beyond, k_i, names: axis.parameters }));
"""


@needs_node
def test_it_resets_repeats_the_force_and_accepts_parameters(tmp_path):
    model = example("sided_gms")
    br.export(model, "wasm", tmp_path / "out")
    message, x = json.loads(node(tmp_path, AROUND)), [0.0, 1e-5, 3e-5, 2e-5]
    forces, changed = (
        br.response(each, x, DT).tolist()
        for each in (model, model.with_values(k_i=[5e6, 3e6, 1e6], F_S_neg=26.0))
    )
    assert message.pop("beyond").startswith("F_S_neg: -1 is not allowed; from 1e-12")
    assert sorted(message.pop("names")) == sorted(model.values)
    told = {
        "first": forces,
        "again": forces,
        "held": [forces[-1], True],
        "cleared": False,
        "changed": changed,
    }
    assert message == told | {"k_i": [5e6, 3e6, 1e6]}


SAVED = """
import { readFileSync, writeFileSync } from "node:fs";
import { load } from "./out/axis_x.mjs";
const x = new Float64Array(new Uint8Array(readFileSync("x.bin")).buffer);
const [first, rest] = [x.subarray(0, 1500), x.subarray(1500)];
const axis = await load();
const apart = [...first].map((at) => axis.force(at, 5e-4));
const bytes = axis.save();
writeFileSync("saved.bin", bytes);
const going = axis.forces(rest, 5e-4);
const other = await load();
const batch = other.forces(first, 5e-4);
other.start();
other.load(bytes);
const again = other.forces(rest, 5e-4);
const refused = (changed) => {
  const before = other.save().join();
  try { other.load(changed); } catch (error) { return error instanceof RangeError && other.save().join() === before; }
  return false;
};
const damaged = [...bytes.keys()].filter((at) => {
  const changed = bytes.slice();
  changed[at] ^= 4;
  return refused(changed);
});
const wrong = [bytes.slice(0, -8), new Uint8Array([...bytes, 0]), new Uint8Array(0), "bytes"].every(refused);
for (const name of readFileSync("others.txt", "utf8").split(" ")) {
  if (name && !refused(new Uint8Array(readFileSync(name)))) throw new Error(`${name} was taken`);
}
const same = (one, two) => one.length === two.length && [...one].every((each, at) => Object.is(each, two[at]));
console.log(JSON.stringify({
  batch: same(apart, batch) && batch instanceof Float64Array, again: same(going, again), damaged: damaged.length,
  bytes: bytes.length, wrong, parameters: other.get(other.parameters[0]),
}));
"""
IN_C = """
#include "out_axis_x/axis_x.h"
void saved(const double *x, int count, unsigned char *bytes)
{
    axis_x axis;
    axis_x_start(&axis);
    for (int i = 0; i < count; ++i) {
        (void)axis_x_force(&axis, x[i], 5e-4);
    }
    axis_x_save(&axis, bytes);
}
int size(void) { return AXIS_X_SAVED; }
"""


def saved_by_c(model, folder, x):
    """Return what the export to C saves behind some positions."""
    br.export(
        model,
        "c",
        folder / "out_axis_x",
        rest="middle" if rest_rule(with_rest(model, "middle")) else None,
    )
    (folder / "saved.c").write_text(IN_C)
    in_c = library(folder, "-O0", "saved.c", "out_axis_x/axis_x.c")
    content = ctypes.create_string_buffer(in_c.size())
    in_c.saved(np.ascontiguousarray(x).ctypes.data_as(ctypes.c_void_p), len(x), content)
    return content.raw


@pytest.mark.slow
@needs_node
@pytest.mark.parametrize(
    "saved", ["sided_coulomb", "sided_lugre", "sided_preisach_lugre", "varied_gms"]
)
def test_a_saved_state_continues_and_damaged_bytes_are_refused(tmp_path, saved):
    x = walk(3000, seed=9)
    x.tofile(tmp_path / "x.bin")
    br.export(example(saved), "wasm", tmp_path / "out")
    rest = []
    if COMPILER is not None:
        expected = saved_by_c(example(saved), tmp_path, x[:1500])
        rest = [f"{other}.bin" for other in ("sided_dahl", "sided_maxwell_slip")]
        for other in rest:
            (tmp_path / "of_another").mkdir(exist_ok=True)
            content = saved_by_c(
                example(other.removesuffix(".bin")), tmp_path / "of_another", x[:10]
            )
            (tmp_path / other).write_bytes(content)
            shutil.rmtree(tmp_path / "of_another")
    (tmp_path / "others.txt").write_text(" ".join(rest))
    message = json.loads(node(tmp_path, SAVED))
    assert (message["batch"], message["again"], message["wrong"]) == (True, True, True)
    assert message["damaged"] == message["bytes"]
    if COMPILER is not None:
        assert (tmp_path / "saved.bin").read_bytes() == expected


@pytest.mark.slow
@needs_node
def test_an_impossible_state_is_refused_even_with_a_correct_checksum(tmp_path):
    model = example("sided_preisach_lugre")
    br.export(model, "wasm", tmp_path / "out")
    walk(3000, seed=9).tofile(tmp_path / "x.bin")
    (tmp_path / "others.txt").write_text("")
    node(tmp_path, SAVED)
    saved = (tmp_path / "saved.bin").read_bytes()
    names = subject_of(model).state.fields
    depth = 32 + 8 * next(place for place, (name, _) in enumerate(names) if name.endswith("depth"))
    cases = {
        "as_it_was": (depth, saved[depth : depth + 8]),
        "deep": (depth, (10**6).to_bytes(8, "little")),
        "nan": (8, np.array(np.nan).tobytes()),
        "flags": (28, (4).to_bytes(4, "little")),
    }
    for name, (at, content) in cases.items():
        changed = saved[:at] + content + saved[at + len(content) : -8]
        (tmp_path / name).write_bytes(changed + digest_of(changed).to_bytes(8, "little"))
    script = (
        'import { readFileSync } from "node:fs"; import { load } from "./out/axis_x.mjs"; const axis = await load();'
        "const taken = (name) => { try { axis.load(new Uint8Array(readFileSync(name))); return true; }"
        " catch { return false; } };"
        "console.log(JSON.stringify(process.argv.slice(2).filter(taken)));"
    )
    assert json.loads(node(tmp_path, script, *cases)) == ["as_it_was"]


WRONG = """
import { load } from "./out/axis_x.mjs";
const axis = await load();
const before = axis.parameters.map((name) => axis.get(name));
const tried = [["F_C", 5], ["toString", 1], ["k_i", 1e6], ["k_i", [1e6, 2e6]], ["F_S_neg", [26, 27]],
  ["F_S_neg", NaN], ["F_S_neg", "2"], ["k_i", [1e6, -2e6, 3e6]], ["F_S_neg", "26"]];
const refused = tried.map(([name, value]) => {
  try { axis.set(name, value); } catch (error) { return error instanceof RangeError; }
  return false;
});
const after = axis.parameters.map((name) => axis.get(name));
console.log(JSON.stringify({ refused, same: JSON.stringify(before) === JSON.stringify(after) }));
"""


@needs_node
def test_an_invalid_parameter_is_refused_without_a_change(tmp_path):
    br.export(example("sided_gms"), "wasm", tmp_path / "out")
    message = json.loads(node(tmp_path, WRONG))
    assert message == {"refused": [True] * 9, "same": True}


def test_counts_are_encoded_in_the_format():
    # The examples of the WebAssembly specification and of the format LEB128.
    assert leb(624485) == b"\xe5\x8e\x26"
    assert signed_leb(-123456) == b"\xc0\xbb\x78"
    assert [signed_leb(value) for value in (0, 63, 64, -64, -65)] == [
        b"\x00",
        b"\x3f",
        b"\xc0\x00",
        b"\x40",
        b"\xbf\x7f",
    ]


def test_a_model_is_a_few_kilobytes():
    for name, most in ("sided_lugre", (2_500, 3_500)), ("sided_preisach_lugre", (17_000, 28_000)):
        subject = subject_of(example(name))
        assert len(module_of(subject).binary) < most[0]
        assert len(module_of(subject, added=ALONE).binary) < most[1]


def test_exported_functions_are_inlined():
    model = example("sided_lugre")
    subject = subject_of(model)
    written = write(Request(model, "axis_x", DT)).files["axis_x.wasm"]
    assert written == module_of(subject, added=ALONE).binary != module_of(subject).binary


def test_layers_with_a_common_kernel_are_exported_together():
    model = example_with("lugre", ["ripple", "position"])
    assert len(module_of(subject_of(model)).binary) < 6_000
