"""Slots put on and taken off on the page: what it makes of them is what Python has, facts and bits."""

import json
from functools import cache

import numpy as np
import pytest
from tests.lab.scripts import data_of, needs_node, node
from tests.lab.test_certificates import CLOSE, of_python

import bristle as br
from bristle.exports.page.described import example_named, model_described
from bristle.exports.page.packing import plain
from bristle.exports.page.sliders import Scales
from bristle.exports.page.switches import begun, combinations, offered, plain_of, slots_of
from bristle.friction import MODELS, with_slots
from bristle.lab import lab_page
from bristle.testing import example_of

pytestmark = [pytest.mark.slow, needs_node]
FACTS = ("model", "description", "shares", "varies", "units", "elements", "head")
ROWS = ("name", "key", "symbol", "values", "unit", "description", "min", "max", "choices", "array", "whole", "fixed")
# What the page does before it shows a model.
BEGUN = """
const data = DATA;
for (const model of data.models) {
  const { code, size } = model, before = [data.common];
  Object.assign(model, { before });
  Object.assign(model.wide, { before: [data.common, { code, size, before }] });
}
const offers = (model) => data.slots[model.kind];
"""


@cache
def page_data(name=None):
    if name is None:
        return data_of(lab_page())
    base, *slots = name.split("+")
    return data_of(lab_page(example_of(with_slots(MODELS[base], slots)), source="model.toml"))


def run(folder, script, data):
    return node(folder, [], BEGUN.replace("DATA", json.dumps(data)) + script)


def only(*names):
    data = page_data()
    return data | {"models": [model for model in data["models"] if model["name"] in names]}


def begun_named(name, slots):
    model = example_named(name)
    facts = next(row for row in page_data()["models"] if row["name"] == name)
    return begun(model, slots, Scales(**facts["scales"]))


def test_every_model_walks_as_in_python_with_every_set_of_slots(tmp_path):
    script = """
    const counts = [];
    for (const model of data.models) {
      const { differ, of } = await walkedWithSlots(model, offers(model));
      counts.push([model.name, differ, of]);
    }
    say(counts);
    """
    counts = run(tmp_path, script, page_data())
    assert [row[:2] for row in counts] == [[name, 0] for name in MODELS]
    for name, _, blocks in counts:
        assert blocks == 21 + 2 ** len(offered(example_named(name))) // 16 + 1


def test_a_single_different_bit_with_slots_is_detected(tmp_path):
    script = """
    const [model] = data.models;
    const spoilt = { ...offers(model), ripple: structuredClone(offers(model).ripple) };
    spoilt.ripple.rows.find(({ name }) => name === "h_s2").values = [1e-12];
    say([(await walkedWithSlots(model, offers(model))).differ, (await walkedWithSlots(model, spoilt)).differ]);
    """
    whole, spoilt = run(tmp_path, script, only("lugre"))
    assert whole == 0
    assert spoilt > 0


@pytest.mark.parametrize(
    "name",
    [
        "preisach_lugre+position+asymmetry",
        "lugre+transmitted+ripple+position+load",
        *(pytest.param(name, marks=pytest.mark.slow) for name in ("gms+asymmetry", "gap_slider+asymmetry")),
    ],
)
def test_a_given_model_walks_as_in_python(name, tmp_path):
    data = page_data(name)
    data = data | {"models": data["models"][:1]}
    assert data["models"][0]["own"]["slots"] == name.split("+")[1:]
    script = "say((await walkedWithSlots(data.models[0], offers(data.models[0]))));"
    assert run(tmp_path, script, data) == {"differ": 0, "of": 7}


def test_a_slot_over_a_channel_is_refused_by_its_name():
    with pytest.raises(br.core.InputError, match=r"has a slot that needs a channel of the log, but a page has no log.*pressure"):
        lab_page(example_of(with_slots(MODELS["lugre"], ["pressure"])))


@pytest.mark.parametrize(
    "name",
    [
        "lugre",
        "preisach_lugre",
        "viscous",
        *(pytest.param(name, marks=pytest.mark.slow) for name in ("gms", "maxwell_slip", "bouc_wen", "elastoplastic")),
    ],
)
def test_the_page_describes_a_model_with_slots_like_python(name, tmp_path):
    slots = offered(example_named(name))
    sets = [(), *((slot,) for slot in slots[::3]), ("periodic", "asymmetry"), slots]
    script = f"""
    const [model] = data.models;
    say({json.dumps(sets)}.map((slots) => {{
      const {{ plain, wide, before, code, walks, ...facts }} = withSlots(model, slots, offers(model));
      return facts;
    }}));
    """
    for slots, facts in zip(sets, run(tmp_path, script, only(name)), strict=True):
        model = begun_named(name, slots)
        wanted = plain(model_described(model, proven=False, named="m"))
        assert {key: facts[key] for key in FACTS} == {key: wanted[key] for key in FACTS}
        assert [[row[key] for key in ROWS] for row in facts["variables"]] == [[row[key] for key in ROWS] for row in wanted["variables"]]
        assert [row for row in facts["conditions"] if "least" not in row] == wanted["conditions"]
        assert facts["slots"] == list(slots_of(model))


def test_copied_text_is_the_model_with_its_slots(tmp_path):
    for name in ("lugre", "gap_slider", "preisach_lugre"):
        for slots in combinations(offered(example_named(name)), complete=False):
            script = f"""
            const model = withSlots(data.models[0], {json.dumps(slots)}, offers(data.models[0]));
            const values = Object.fromEntries(model.variables.map(({{ name, values }}) => [name, numbersOf(values)]));
            say([asToml(model, values), asPython(model, values)]);
            """
            toml, python = run(tmp_path, script, only(name))
            (tmp_path / "model.toml").write_text(toml, encoding="utf-8")
            wanted = begun_named(name, slots)
            assert br.read_model(tmp_path / "model.toml").friction == wanted
            scope = {}
            exec(python, scope)
            assert scope["model"] == wanted


def test_a_removed_slot_leaves_the_mean_of_both_directions(tmp_path):
    data = page_data("gms+asymmetry")
    model = example_of(with_slots(MODELS["gms"], ["asymmetry"]))
    script = """
    const [model] = data.models, own = withSlots(model, ownSlots(model), offers(model));
    const bare = withSlots(model, [], offers(model));
    const first = Object.fromEntries(own.variables.map(({ name, values }) => [name, numbersOf(values)]));
    const off = carried({ ...first, F_C_pos: [30] }, bare.variables), on = carried(off, own.variables);
    say([first, off, on, bare.model, asToml(bare, off).includes("asymmetry")]);
    """
    first, off, on, name, is_named = run(tmp_path, script, data)
    values = [*first["F_C_pos"], *off["F_C"], *off["F_S"], *on["F_C_pos"]]
    mean = 0.5 * (30.0 + model.values["F_C_neg"])
    assert values == pytest.approx([model.values["F_C_pos"], mean, plain_of(model).values["F_S"], 1.1 * mean])
    assert (name, is_named) == ("gms", False)


def test_friction_that_changes_sign_along_the_axis_is_reported(tmp_path):
    random = np.random.default_rng(2)
    cases = [[float(p_1), float(p_2)] for p_1, p_2 in random.uniform(-1.5, 1.5, (60, 2))] + [[0.0, 0.0], [0.99, 0.0]]
    script = f"""
    const model = withSlots(data.models[0], ["position"], offers(data.models[0]));
    const first = Object.fromEntries(model.variables.map(({{ name, values }}) => [name, numbersOf(values)]));
    say({json.dumps(cases)}.map(([p_1, p_2]) => broken(model, {{ ...first, p_1: [p_1], p_2: [p_2] }}).length === 0));
    """
    message = run(tmp_path, script, only("lugre"))
    component, values = begun_named("lugre", ["position"]).component, dict(begun_named("lugre", ["position"]).values)
    relation = component.relations[-1]
    wanted = [bool(relation.holds(component.assemble(values | {"p_1": a, "p_2": b}))) for a, b in cases]
    assert message == wanted
    assert len(set(wanted)) == 2


def test_a_zero_level_has_no_relative_rise(tmp_path):
    script = """
    const model = withSlots(data.models[0], ["ripple"], offers(data.models[0])), contact = await loaded(model);
    contact.hold();
    for (const { name, values } of model.variables) contact.set(name, name === "F_C" ? [0] : numbersOf(values));
    say([...contact.forces(Float64Array.from([0, 1e-3, 2e-3, 1e-3]), 1e-3)]);
    """
    forces = run(tmp_path, script, only("coulomb_viscous"))
    model = begun_named("coulomb_viscous", ["ripple"])
    bare = model.component(**dict(model.values) | {"F_C": 0.0}, validate=False)
    assert forces[1:] == [float(bare.values["F_v"]) * v for v in (1.0, 1.0, -1.0)]


@pytest.mark.parametrize("name", ["lugre", "gms", pytest.param("gap_slider", marks=pytest.mark.slow)])
@pytest.mark.parametrize("slots", [("asymmetry",), ("ripple", "position", "asymmetry")], ids=["sided", "varying"])
def test_verdicts_of_a_model_with_slots_are_those_of_the_certificates(name, slots, tmp_path):
    script = f"""
    const [base] = data.models, model = withSlots(base, {json.dumps(slots)}, offers(base));
    const judge = await loaded(base.leans ? model : base);
    const values = Object.fromEntries(model.variables.map(({{ name, values }}) => [name, numbersOf(values)]));
    for (const [name, each] of Object.entries(values)) judge.set(name, each);
    const {{ drift, closure }} = judged(judge);
    say([drift, closure].map((answer) => answer && [answer.passed, answer.moved ?? answer.missing]));
    """
    for custom, wanted, close in zip(run(tmp_path, script, only(name)), of_python(begun_named(name, slots)), CLOSE, strict=True):
        assert (custom is None) == (wanted is None)
        if custom is not None:
            assert custom[0] == wanted[0]
            assert custom[1] == pytest.approx(wanted[1], **close)
