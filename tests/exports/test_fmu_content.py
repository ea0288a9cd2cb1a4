"""Variables of an FMU: their places, ranges, sizes and dependencies."""

import math
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from tests.exports.test_law import variant

import bristle as br
from bristle.core.experiment import Feedforward
from bristle.core.variable import Variable
from bristle.exports.cycle import LARGEST, SOLVER, core_of, loaded, stored
from bristle.exports.described import Source
from bristle.exports.fmu_content import (
    CONSTANT,
    INPUT,
    MARGIN,
    OUTPUT,
    PARAMETER,
    RATE,
    START,
    STATE,
    Port,
    Setting,
    content_of,
    content_of_law,
    parameter_ports,
    ports_of,
)
from bristle.exports.fmu_description import build_text, description_text
from bristle.exports.fmu_exchange import exchange_of, why_not
from bristle.exports.law import law_of
from bristle.exports.subject import subject_of
from bristle.translation.build import Builder
from bristle.translation.tree import REAL, Return, Store, struct_type

LUGRE = br.friction.lugre(F_C=22.0, F_S=29.0, v_S=3e-3, sigma_0=2e6, sigma_1=1e3, sigma_2=40.0)
GMS = br.friction.gms(F_C=4.0, F_S=5.0, v_S=1e-2, nu_i=[0.25, 0.75], k_i=[1e5, 2e5], C=30.0)
MASS = br.plants.inertia(M=2.5)
UNSURE = Source({"model": "model.toml"}, {"F_C": {"interval": (21.0, 23.0)}, "F_S": {"status": "unidentifiable"}}, model_hash="ab" * 32)


def core(model=LUGRE, plant=None):
    return core_of(subject_of(model), plant, Builder())


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_description_names_each_variable_with_unit_range_and_start(fmi):
    content = content_of(subject_of(LUGRE), MASS, UNSURE)
    root = ElementTree.fromstring(description_text(content, Setting("axis_x", UNSURE, 1e-4, fmi), "token"))
    assert root.attrib["fmiVersion"] == f"{fmi}.0"
    assert root.attrib["author"].endswith(", from model.toml")
    assert root.attrib["guid" if fmi == 2 else "instantiationToken"] == "token"
    assert root.find("DefaultExperiment").attrib == {"startTime": "0", "stepSize": "0.0001", "tolerance": "1e-06"}
    assert root.find("ModelExchange") is not None
    assert ("fixedInternalStepSize" in root.find("CoSimulation").attrib) == (fmi == 3)
    listed = root.find("ModelVariables")
    described = {item.attrib["name"]: item for item in listed}
    assert [item.attrib["valueReference"] for item in listed] == [str(place) for place in range(len(listed))]

    def number(name):
        return described[name].find("Real").attrib if fmi == 2 else described[name].attrib

    assert described["F_C"].attrib["description"].endswith("(95 % interval 21 to 23)")
    assert described["F_S"].attrib["description"].endswith("(unidentifiable)")
    assert (number("F_C")["start"], number("F_C")["unit"], number("F_C")["min"]) == ("22.0", "N", "1e-12")
    assert "start" not in described["time"].attrib
    assert described["F_C"].attrib["causality"] == "parameter"
    assert described["effort"].attrib["causality"] == "input"
    states = [place for place, item in enumerate(listed) if item.attrib["name"] in ("x", "v", "z")]
    derivatives = {name: number(name)["derivative"] for name in described if name.startswith("der(")}
    offset = 1 if fmi == 2 else 0
    assert derivatives.keys() == {"der(x)", "der(v)", "der(z)"}
    assert sorted(int(place) - offset for place in derivatives.values()) == states
    base = root.find("UnitDefinitions/Unit[@name='N']/BaseUnit").attrib
    assert base == {"kg": "1", "m": "1", "s": "-2"}


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_force_depends_on_states_and_rates_also_on_inputs(fmi):
    content = content_of(subject_of(LUGRE), MASS, Source())
    root = ElementTree.fromstring(description_text(content, Setting("axis_x", Source(), 1e-4, fmi), "token"))
    names = [item.attrib["name"] for item in root.find("ModelVariables")]
    offset = 1 if fmi == 2 else 0
    key = "index" if fmi == 2 else "valueReference"
    rates = f"ModelStructure/{'Derivatives/Unknown' if fmi == 2 else 'ContinuousStateDerivative'}"
    for unknown in root.findall(rates):
        assert names[int(unknown.attrib[key]) - offset].startswith("der(")
        known = [names[int(place) - offset] for place in unknown.attrib["dependencies"].split()]
        assert sorted(known) == sorted(["effort", "x", "v", "z"])
    outputs = root.findall("ModelStructure/Outputs/Unknown" if fmi == 2 else "ModelStructure/Output")

    def depends(row):
        return {names[int(place) - offset] for place in row.attrib["dependencies"].split()}

    on = {names[int(row.attrib[key]) - offset]: depends(row) for row in outputs}
    assert on == {"x": {"x"}, "v": {"v"}, "force": {"x", "v", "z"}}


def test_a_model_without_continuous_time_supports_co_simulation_only_with_reason():
    content = content_of(subject_of(br.friction.coulomb(F_C=2.0)), None, Source())
    assert content.exchange is None
    (guidance, reason) = content.notes
    assert "exchange force and velocity in very short steps" in guidance
    assert reason == ("co-simulation alone: the force of coulomb jumps at reversals, and sticking is not a differential equation")
    root = ElementTree.fromstring(description_text(content, Setting("axis_x", Source(), 1e-4, 2), "token"))
    assert root.find("ModelExchange") is None
    assert "tolerance" not in root.find("DefaultExperiment").attrib
    assert why_not(LUGRE) == why_not(LUGRE, MASS) == ""
    screw = br.plants.ball_screw
    moved = br.testing.example_of(screw)
    assert why_not(LUGRE, moved) == ("" if screw.rate else f"{moved.name} has kernels for time steps only, not for continuous time")


def test_outputs_are_finite_and_parameters_have_their_ranges():
    assert Port("x", INPUT, Variable("length", "x"), 0.0).range == (-LARGEST, LARGEST)
    assert Port("x", OUTPUT, Variable("length", "x", min=-1.0, max=2.0), 0.0).range == (-1.0, 2.0)
    for role in (PARAMETER, CONSTANT, MARGIN):
        assert Port("x", role, Variable("length", "x"), 0.0).range == (-math.inf, math.inf)


def test_each_array_element_is_a_variable_and_choices_are_not():
    variables = {"k": Variable("force/length", "stiffness"), "n": Variable("1", "number")}
    ports = parameter_ports(variables, {"k": np.array([1.0, 2.0]), "n": math.nan}, PARAMETER, Source())
    assert [(port.name, port.value) for port in ports] == [("k[1]", 1.0), ("k[2]", 2.0)]


def test_states_rates_and_margins_come_last():
    builder = Builder()
    core = core_of(subject_of(GMS), MASS, builder)
    ports = ports_of(core, Source(), exchange_of(core, builder) if not why_not(GMS, MASS) else None)
    names = [port.name for port in ports.listed]
    assert names[:5] == ["time", "effort", "x", "v", "force"]
    assert ports.place("force") == 4
    assert [names[place] for place in ports.in_role(START)] == ["x", "v"]
    if ports.states:
        assert [names[place] for place in ports.in_role(RATE)] == [f"der({names[place]})" for place in ports.states]
        assert {names[place] for place in ports.in_role(MARGIN)} <= {"margin", "reversal"}
        assert all(ports.listed[place].variable.nominal > 0.0 for place in ports.states)


def test_nominal_values_are_the_scales_of_presliding():
    builder = Builder()
    core = core_of(subject_of(LUGRE), MASS, builder)
    varying = exchange_of(core, builder).varying
    assert list(varying) == ["x", "v", "z"]
    length = varying["x"].nominal
    # Half of the largest force of a bristle that slips exponentially, on a grid of factors.
    assert 0.3 < length / (math.log(2.0) * 29.0 / 2e6) < 3.0
    force = subject_of(LUGRE).forces(np.array([0.0, 1.0]), 1e3)[1]
    assert varying["v"].nominal == pytest.approx(math.sqrt(force / 2.5 * length), rel=0.4)
    assert varying["z"].nominal == length


def test_the_state_of_a_step_on_a_mass_is_body_contact_and_solver():
    alone, moved = core(), core(plant=MASS)
    assert alone.begin.size == 1
    assert moved.begin.size == 2 + 1 + SOLVER
    assert moved.most == [0] * 7
    assert list(moved.parameters) == ["q", "p"]
    assert list(alone.parameters) == ["p"]
    deep = core(br.testing.example_of(br.friction.MODELS["preisach_lugre"]))
    assert any(most > 0 for most in deep.most)
    assert len(deep.most) == deep.begin.size


def test_fields_of_a_tuple_are_loaded_and_stored_at_their_indices():
    kind = struct_type(br.friction.lugre.initial_state(LUGRE.parameters))
    assert loaded(kind, 3) == "lasting[3]"
    assert stored(kind, "after", 3, "held") == "    held[3] = after.z"
    empty = struct_type(br.friction.coulomb.initial_state(br.friction.coulomb(F_C=1.0).parameters))
    assert (loaded(empty, 0), stored(empty, "after", 0)) == ("", "    pass")


def test_the_source_of_an_fmu_is_built_as_c99():
    root = ElementTree.fromstring(build_text("axis_x"))
    assert root.find("BuildConfiguration").attrib == {"modelIdentifier": "axis_x"}
    assert root.find("BuildConfiguration/SourceFileSet").attrib["language"] == "C99"
    assert root.find("BuildConfiguration/SourceFileSet/SourceFile").attrib["name"] == "axis_x.c"


def test_states_are_local_to_an_fmu_without_a_mass():
    content = content_of(subject_of(LUGRE), None, Source())
    (state,) = (port for port in content.ports.listed if port.role == STATE)
    assert state.name == "z"
    assert [port.name for port in content.ports.listed[:4]] == ["time", "v", "x", "force"]


def test_the_step_of_a_law_stores_its_state_and_returns_its_effort():
    feedforward = Feedforward(friction=LUGRE)
    law = law_of(variant(feedforward), tunable=True)
    content = content_of_law(law, "axis_x", Source())
    *_, last = content.entry.body
    assert isinstance(last, Return)
    assert last.value.type == REAL
    stored_at = [statement.at.value for statement in content.entry.body if isinstance(statement, Store)]
    assert stored_at == list(range(1 + len(law.leaves)))
    assert content.begin.size == 1 + len(law.leaves)
    assert content.begin[0] == 0.0
    assert content.most[0] == 2
    names = [port.name for port in content.ports.listed]
    assert names[:6] == ["time", "position", "velocity", "acceleration", "measured", "place_ahead[1]"]
    assert {"effort", "controller_k_p", "friction_sigma_0"} <= set(names)
    (role,) = {port.role for port in content.ports.listed if port.name == "effort"}
    assert role == OUTPUT
    assert content.output == "effort"
    assert len(content.notes) == 1
    assert content.notes[0].startswith("step the law before the plant")


@pytest.mark.parametrize(
    ("kind", "units"),
    [
        ("translational", {"s": "s1", "m": "m1", "m/s": "m1 s-1", "N": "kg1 m1 s-2", "N/m": "kg1 s-2", "N*s/m": "kg1 s-1", "kg": "kg1"}),
        ("rotational", {"s": "s1", "rad": "rad1", "rad/s": "rad1 s-1", "N*m": "kg1 m2 s-2", "N*m*s/rad": "kg1 m2 rad-1 s-1"}),
    ],
)
def test_units_are_described_in_base_units(kind, units):
    model = br.friction.lugre(kind=kind, F_C=22.0, F_S=29.0, v_S=3e-3, sigma_0=2e6, sigma_1=1e3)
    content = content_of(subject_of(model), br.plants.inertia(kind=kind, M=2.5), Source())
    root = ElementTree.fromstring(description_text(content, Setting("axis_x", Source(), 1e-4, 3), "token"))
    reported = {unit.attrib["name"]: unit.find("BaseUnit").attrib for unit in root.findall("UnitDefinitions/Unit")}
    assert {name: " ".join(f"{base}{power}" for base, power in sorted(reported[name].items())) for name in units} == units
    warm = content_of(subject_of(br.friction.with_slots(br.friction.coulomb, ["temperature"])(F_C=2.0)), None, Source())
    root = ElementTree.fromstring(description_text(warm, Setting("axis_x", Source(), 1e-4, 3), "token"))
    assert root.find("UnitDefinitions/Unit[@name='K']/BaseUnit").attrib == {"K": "1"}
