"""Variables of an FMU, and its functions in continuous time, run as they stand."""

import math
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from tests.exports.native import example_with
from tests.exports.test_laws import variant

import bristle as br
from bristle.apps.targets.fmu import header_text
from bristle.apps.targets.fmu_content import (
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
from bristle.apps.targets.fmu_description import build_text, description_text
from bristle.apps.targets.fmu_exchange import BEYOND, exchange_of, why_not
from bristle.contract import example_of
from bristle.engine.screwed import through_screw
from bristle.engine.translation.build import Builder
from bristle.engine.translation.tree import REAL, Return, Store, struct_type
from bristle.exports.cycle import LARGEST, SOLVER, core_of, loaded, stored
from bristle.exports.described import Source
from bristle.exports.law import law_of
from bristle.exports.subject import subject_of

LUGRE = br.friction.lugre(F_C=22.0, F_S=29.0, v_S=3e-3, sigma_0=2e6, sigma_1=1e3, sigma_2=40.0)
GMS = br.friction.gms(F_C=4.0, F_S=5.0, v_S=1e-2, nu_i=[0.25, 0.75], k_i=[1e5, 2e5], C=30.0)
MASS = br.plants.inertia(M=2.5)
UNSURE = Source(
    {"model": "model.toml"},
    {"F_C": {"interval": (21.0, 23.0)}, "F_S": {"status": "unidentifiable"}},
    model_hash="ab" * 32,
)


def core(model=LUGRE, plant=None):
    return core_of(subject_of(model), plant, Builder())


def described(model=LUGRE, plant=MASS, source=UNSURE, fmi=3):
    """Return the content of an FMU and its description."""
    content = content_of(subject_of(model), plant, source)
    return content, ElementTree.fromstring(
        description_text(content, Setting("axis_x", source, 1e-4, fmi), "token")
    )


TOLD = {
    "F_C": {"causality": "parameter", "start": "22.0", "unit": "N", "min": "1e-12"},
    "effort": {"causality": "input"},
    "time": {},
    "der(x)": {},
    "der(v)": {},
    "der(z)": {},
}


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_description_names_each_variable_with_unit_range_and_start(fmi):
    _, root = described(fmi=fmi)
    listed = root.find("ModelVariables")
    variables = {
        item.attrib["name"]: item.attrib | (item.find("Real").attrib if fmi == 2 else {})
        for item in listed
    }
    assert [item.attrib["valueReference"] for item in listed] == [
        str(place) for place in range(len(listed))
    ]
    assert all(told.items() <= variables[name].items() for name, told in TOLD.items())
    assert "start" not in variables["time"]
    for name, ending in (("F_C", "(95 % interval 21 to 23)"), ("F_S", "(unidentifiable)")):
        assert variables[name]["description"].endswith(ending)
    derivatives = {
        name: int(told["derivative"]) - (fmi == 2)
        for name, told in variables.items()
        if name.startswith("der(")
    }
    assert derivatives == {f"der({name})": list(variables).index(name) for name in ("x", "v", "z")}


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_description_has_its_version_author_units_and_default_experiment(fmi):
    _, root = described(fmi=fmi)
    assert root.attrib["fmiVersion"] == f"{fmi}.0"
    assert root.attrib["author"].endswith(", from model.toml")
    assert root.attrib["guid" if fmi == 2 else "instantiationToken"] == "token"
    assert root.find("DefaultExperiment").attrib == {
        "startTime": "0",
        "stepSize": "0.0001",
        "tolerance": "1e-06",
    }
    assert ("fixedInternalStepSize" in root.find("CoSimulation").attrib) == (fmi == 3)


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_force_depends_on_states_and_rates_also_on_inputs(fmi):
    _, root = described(fmi=fmi)
    names = ["", *(item.attrib["name"] for item in root.find("ModelVariables"))][fmi == 3 :]
    rates, outputs = (
        ("Derivatives/Unknown", "Outputs/Unknown")
        if fmi == 2
        else ("ContinuousStateDerivative", "Output")
    )

    def dependencies(rows):
        return {
            names[int(row.attrib["index" if fmi == 2 else "valueReference"])]: {
                names[int(k)] for k in row.attrib["dependencies"].split()
            }
            for row in root.findall(f"ModelStructure/{rows}")
        }

    assert dependencies(outputs) == {"x": {"x"}, "v": {"v"}, "force": {"x", "v", "z"}}
    assert dependencies(rates) == {
        key: {"effort", "x", "v", "z"} for key in ("der(x)", "der(v)", "der(z)")
    }


def test_a_model_without_continuous_time_supports_co_simulation_only_with_reason():
    content, root = described(br.friction.coulomb(F_C=2.0), None, fmi=2)
    (guidance, reason) = content.notes
    assert "exchange force and velocity in very short steps" in guidance
    assert reason == (
        "co-simulation alone: the force of coulomb jumps at reversals, and sticking is not a differential equation"
    )
    assert root.find("ModelExchange") is None
    assert "tolerance" not in root.find("DefaultExperiment").attrib
    assert why_not(LUGRE) == why_not(LUGRE, MASS) == ""
    screw = br.plants.ball_screw
    moved = example_of(screw)
    assert why_not(LUGRE, moved) == (
        ""
        if screw.rate
        else f"{moved.name} has kernels for time steps only, not for continuous time"
    )


def test_outputs_are_finite_and_parameters_have_their_ranges():
    assert Port("x", INPUT, br.core.Variable("length", "x"), 0.0).range == (-LARGEST, LARGEST)
    assert Port("x", OUTPUT, br.core.Variable("length", "x", min=-1.0, max=2.0), 0.0).range == (
        -1.0,
        2.0,
    )
    for role in (PARAMETER, CONSTANT, MARGIN):
        assert Port("x", role, br.core.Variable("length", "x"), 0.0).range == (-math.inf, math.inf)


def test_each_array_element_is_a_variable_and_choices_are_not():
    variables = {
        "k": br.core.Variable("force/length", "stiffness"),
        "n": br.core.Variable("1", "number"),
    }
    ports = parameter_ports(
        variables, {"k": np.array([1.0, 2.0]), "n": math.nan}, PARAMETER, Source()
    )
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
        assert [names[place] for place in ports.in_role(RATE)] == [
            f"der({names[place]})" for place in ports.states
        ]
        assert {names[place] for place in ports.in_role(MARGIN)} <= {"margin", "reversal"}
        assert all(ports.listed[place].variable.nominal > 0.0 for place in ports.states)


def test_the_state_of_a_step_on_a_mass_is_body_contact_and_solver():
    alone, moved = core(), core(plant=MASS)
    assert (alone.begin.size, list(alone.parameters)) == (1, ["p"])
    assert (moved.begin.size, list(moved.parameters)) == (2 + 1 + SOLVER, ["q", "p"])
    assert moved.most == [0] * 7
    deep = core(br.contract.example_of(br.friction.MODELS["preisach_lugre"]))
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


def test_headers_of_the_standard_are_found():
    assert "fmi3Instance" in header_text("fmi3FunctionTypes.h")


def test_states_are_local_to_an_fmu_without_a_mass():
    content, _ = described(plant=None)
    (state,) = (port for port in content.ports.listed if port.role == STATE)
    assert state.name == "z"
    assert [port.name for port in content.ports.listed[:4]] == ["time", "v", "x", "force"]


def test_the_step_of_a_law_stores_its_state_and_returns_its_effort():
    law = law_of(variant(br.core.Feedforward(friction=LUGRE)), tunable=True)
    content = content_of_law(law, "axis_x", Source())
    assert isinstance(content.entry.body[-1], Return)
    assert content.entry.body[-1].value.type == REAL
    stored_at = [
        statement.at.value for statement in content.entry.body if isinstance(statement, Store)
    ]
    assert stored_at == list(range(1 + len(law.leaves)))
    assert (content.begin.size, content.begin[0], content.most[0]) == (len(stored_at), 0.0, 2)


def test_variables_of_a_law_are_its_inputs_its_effort_and_its_parameters():
    content = content_of_law(
        law_of(variant(br.core.Feedforward(friction=LUGRE)), tunable=True), "axis_x", Source()
    )
    roles = {port.name: port.role for port in content.ports.listed}
    assert list(roles)[:6] == [
        "time",
        "position",
        "velocity",
        "acceleration",
        "measured",
        "place_ahead[1]",
    ]
    assert {"controller_k_p", "friction_sigma_0"} <= set(roles)
    assert (content.output, roles["effort"]) == ("effort", OUTPUT)
    (note,) = content.notes
    assert note.startswith("step the law before the plant")


@pytest.mark.parametrize(
    ("kind", "units"),
    [
        (
            "translational",
            {
                "s": "s1",
                "m": "m1",
                "m/s": "m1 s-1",
                "N": "kg1 m1 s-2",
                "N/m": "kg1 s-2",
                "N*s/m": "kg1 s-1",
                "kg": "kg1",
            },
        ),
        (
            "rotational",
            {
                "s": "s1",
                "rad": "rad1",
                "rad/s": "rad1 s-1",
                "N*m": "kg1 m2 s-2",
                "N*m*s/rad": "kg1 m2 rad-1 s-1",
            },
        ),
    ],
)
def test_units_are_described_in_base_units(kind, units):
    model = br.friction.lugre(kind=kind, F_C=22.0, F_S=29.0, v_S=3e-3, sigma_0=2e6, sigma_1=1e3)
    _, root = described(model, br.plants.inertia(kind=kind, M=2.5))
    reported = {
        unit.attrib["name"]: unit.find("BaseUnit").attrib
        for unit in root.findall("UnitDefinitions/Unit")
    }
    assert {
        name: " ".join(f"{base}{power}" for base, power in sorted(reported[name].items()))
        for name in units
    } == units
    _, root = described(br.friction.with_slots(br.friction.coulomb, ["temperature"])(F_C=2.0), None)
    assert root.find("UnitDefinitions/Unit[@name='K']/BaseUnit").attrib == {"K": "1"}


LUGRE = br.friction.lugre(F_C=22.0, F_S=29.0, v_S=3e-3, sigma_0=2e6, sigma_1=1e3, sigma_2=40.0)
BOUC_WEN, NESTED = example_with("bouc_wen"), example_with("preisach_lugre")
MASS = br.plants.inertia(M=2.5)


@pytest.fixture(autouse=True)
def in_plain_python():
    with br.engine.interpreted():
        yield


class Importer:
    """What an importer keeps of an FMU, and how it calls its functions."""

    def __init__(self, model, plant=None):
        builder = Builder()
        self.core = core_of(subject_of(model), plant, builder)
        self.exchange = exchange_of(self.core, builder)
        self.values = {
            "lasting": np.array(self.core.begin, dtype=float),
            "memory": np.array(model.component.new_memory(model.parameters), dtype=float),
            "varying": np.zeros(len(self.exchange.varying)),
            "held": np.zeros(len(self.exchange.held)),
            "slope": np.full(len(self.exchange.varying) + 2, np.nan),
            "p": model.parameters,
        } | ({} if plant is None else {"q": plant.parameters})

    @classmethod
    def moving(cls, model, v=1e-3, plant=None):
        """Return an importer behind the start of a motion."""
        importer = cls(model, plant)
        importer.call("begun", v=v, x=0.0)
        return importer

    def __getitem__(self, name):
        return self.values[name]

    def call(self, name, **inputs):
        function, values = getattr(self.exchange, name), self.values | inputs
        return function.source(*(values[parameter.name] for parameter in function.parameters))


@pytest.mark.parametrize(("z", "v"), [(0.0, 1e-3), (1e-6, 2e-3), (-3e-6, -1e-3)])
def test_a_model_with_rates_only_gives_force_and_rates(z, v):
    importer = Importer(BOUC_WEN)
    assert importer.exchange.held == ()
    component, p = BOUC_WEN.component, BOUC_WEN.parameters
    importer["varying"][0] = z
    force, rates = component.rate(component.State(z), br.core.Motion(v, 0.3), p)
    assert importer.call("flowing", v=v, x=0.3) == force
    assert importer["slope"][0] == rates[0]
    assert np.isnan(importer["slope"][1:]).all()  # no event is looked for


def test_a_mass_moves_with_its_velocity_and_friction_brakes_it():
    importer = Importer(BOUC_WEN, MASS)
    assert list(importer.exchange.varying)[:2] == ["x", "v"]
    importer["varying"][:] = [0.3, 2e-3, 1e-6]
    force = importer.call("flowing", effort=7.0)
    component = BOUC_WEN.component
    expected, rates = component.rate(
        component.State(1e-6), br.core.Motion(2e-3, 0.3), BOUC_WEN.parameters
    )
    assert force == expected
    assert importer["slope"][:3].tolist() == [2e-3, pytest.approx((7.0 - force) / 2.5), rates[0]]


def test_the_states_of_a_mass_are_copied_at_the_start_and_at_events():
    importer = Importer(BOUC_WEN, MASS)
    importer["lasting"][:3] = [0.3, 2e-3, 1e-6]
    importer.call("begun")
    assert importer["varying"].tolist() == [0.3, 2e-3, 1e-6]
    importer["varying"][:] = [0.4, 3e-3, 2e-6]
    importer.call("arrived")
    assert importer["lasting"][:3].tolist() == [0.4, 3e-3, 2e-6]


@pytest.mark.parametrize("v", [1e-3, -1e-3])
def test_a_piece_begins_in_the_direction_of_the_motion_with_its_contact(v):
    importer = Importer(LUGRE)
    importer["lasting"][0] = 1e-6
    importer.call("begun", v=v, x=0.0)
    side, contact = importer["held"]
    assert (side, contact, importer["varying"].tolist()) == (math.copysign(1.0, v), 1e-6, [1e-6])


def test_after_a_reversal_a_piece_continues_and_its_indicator_is_negative():
    importer = Importer.moving(LUGRE)
    importer["varying"][0] = 1e-6  # far from the event
    importer.call("flowing", v=1e-3, x=0.0)
    rate, margin, reversal = importer["slope"]
    assert (rate > 0.0, margin > 0.0) == (True, True)
    assert reversal == 1e-3
    force = importer.call("flowing", v=-1e-3, x=0.0)
    assert importer["slope"][2] == -1e-3
    assert math.isfinite(force)
    still = importer.call("flowing", v=0.0, x=0.0)
    assert importer["slope"][0] == pytest.approx(0.0, abs=1e-12)
    assert still == pytest.approx(2e6 * 1e-6)


def test_within_a_window_around_an_event_only_a_fast_motion_reverses():
    importer = Importer.moving(LUGRE)
    distance = importer.exchange.varying["z"].nominal
    lifted = []
    for moved in (0.0, 0.5e-6, 1e-6, 2e-6):  # of the distance before sliding
        importer["varying"][0] = moved * distance
        importer.call("flowing", v=-1e-3, x=0.0)
        lifted.append(importer["slope"][2] + 1e-3)
    assert lifted == pytest.approx([1e3 * distance, 0.5e3 * distance, 0.0, 0.0], abs=1e-9)


def test_margins_have_a_small_offset_beyond_their_events():
    importer = Importer.moving(NESTED)
    component = NESTED.component
    piece = component.piece(
        component.State(), importer["memory"], br.core.Motion(1e-3, 0.0), NESTED.parameters
    )
    _, _, margin = component.flow(*piece, br.core.Motion(1e-3, 0.0), NESTED.parameters)
    importer.call("flowing", v=1e-3, x=0.0)
    assert importer["slope"][-2] == pytest.approx(margin + BEYOND, rel=1e-15)
    assert 0.0 < BEYOND < 1e-6


def test_constant_whole_numbers_have_one_value_more_than_storable_turns():
    importer = Importer(NESTED)
    fields = [
        name
        for name, _ in zip(
            importer.exchange.flowing.source.__globals__["Piece"]._fields,
            importer.exchange.held,
            strict=False,
        )
    ]
    counts = {
        name: most for name, most in zip(fields, importer.exchange.held, strict=False) if most
    }
    assert list(counts.values()) == [importer["memory"].size // 2 + 1]
    # The contact as it was at the event, a real number.
    assert len(importer.exchange.held) == len(fields) + 1
    assert importer.exchange.held[-1] == 0


def test_an_event_commits_the_present_state_of_the_contact():
    importer = Importer.moving(NESTED)
    importer["varying"][0] = 2e-6
    importer.call("arrived")
    component, p = NESTED.component, NESTED.parameters
    memory = np.array(component.new_memory(p), dtype=float)
    contact, _ = component.piece(component.State(), memory, br.core.Motion(1e-3, 0.0), p)
    move = component.arrival(component.State(), memory, contact._replace(z=2e-6), p)
    after = component.commit(component.State(), memory, move, p)
    assert importer["lasting"].tolist() == [float(number) for number in after]
    assert importer["memory"].tolist() == memory.tolist()


@pytest.mark.parametrize("model", [LUGRE, NESTED], ids=lambda model: model.name)
def test_nominal_values_follow_from_half_the_largest_force_and_its_energy(model):
    varying = Importer(model, MASS).exchange.varying
    length, speed, largest = varying["x"].nominal, varying["v"].nominal, model.values["F_S"]
    force = br.response(model, np.linspace(0.0, 100.0 * length, 10_001), 1e6)  # slowly
    assert 0.5 * largest < force[100] < largest
    assert force[-1] == pytest.approx(largest, rel=1e-3)
    assert 2.5 * speed**2 == pytest.approx(largest * length, rel=1e-3)
    assert varying["z"].nominal == length


BALL_SCREW = br.plants.ball_screw(
    kind="rotational", J=5e-4, M=150.0, lead=10e-3, k=3e6, d=1500.0, backlash=2e-5
)
MOTOR = br.friction.lugre(
    kind="rotational", F_C=0.05, F_S=0.06, v_S=0.1, sigma_0=100.0, sigma_1=1e-2, sigma_2=1e-4
)
TURNS = br.friction.preisach_contact(
    kind="rotational", kernel="reformed_dahl_exact", s=100.0, f_p=0.05
)
SLIDES = br.friction.preisach_contact(kernel="reformed_dahl_exact", s=1e7, f_p=200.0)


def test_parameters_of_both_sides_have_their_units():
    component = through_screw(BALL_SCREW, MOTOR, LUGRE, exported=True).component
    units = {name: variable.unit("rotational") for name, variable in component.variables.items()}
    assert (units["motor_F_C"], units["table_F_C"]) == ("N*m", "N")
    assert (units["motor_sigma_0"], units["table_sigma_0"]) == ("N*m/rad", "N/m")
    assert (units["motor_v_S"], units["table_v_S"]) == ("rad/s", "m/s")


def test_memories_of_both_sides_are_apart_with_the_bounds_of_each():
    motor, table = TURNS.with_values(capacity=20), SLIDES.with_values(capacity=50)
    content = content_of(
        subject_of(through_screw(BALL_SCREW, motor, table, exported=True)), BALL_SCREW, Source()
    )
    sizes = [model.component.memory_size(model.parameters) for model in (motor, table)]
    assert sizes[0] != sizes[1]
    assert content.memory_at == {"motor_memory": 0, "table_memory": sizes[0]}
    assert content.memory.size == sum(sizes)
    assert [bound for bound in content.most if 0 < bound < 2**31] == [size // 2 for size in sizes]
