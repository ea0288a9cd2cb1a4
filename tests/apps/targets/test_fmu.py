"""FMUs, stepped and integrated by an importer: models, and laws of control."""

import ctypes
import importlib
import importlib.util
import sys
import zipfile
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from tests.exports.importing import (
    PLANT,
    STEP,
    WRITTEN,
    Importer,
    described_by,
    example,
    needs_compiler,
    needs_fmpy,
)
from tests.exports.native import FLAGS, WARNINGS, compiled, differing, example_with, library_of_laws
from tests.exports.test_laws import CHANGED, DT, RUN_CHANGED, replayed, told, variant_of

import bristle as br
from bristle.apps.targets import fmu
from bristle.apps.targets.fmu_exchange import why_not
from bristle.cli.main import main
from bristle.contract import example_of
from bristle.exports.c import law_files
from bristle.exports.described import Source, hash_of_model
from bristle.exports.law import hash_of_law, law_of, law_walk
from bristle.models.friction.resting import with_rest
from bristle.models.friction.slots import SLOTS

pytestmark = [pytest.mark.slow, needs_compiler, needs_fmpy]

needs_ecos = pytest.mark.skipif(importlib.util.find_spec("ecospy") is None, reason="needs ecospy")
COUNT = 1000


@pytest.fixture(scope="module")
def ecos():
    """Return Ecos, which looks for a library that the environment has, and the system may not."""
    beside = Path(sys.prefix) / "lib" / "libtbb.so.12"
    if beside.exists():
        ctypes.CDLL(str(beside), mode=ctypes.RTLD_GLOBAL)
    return importlib.import_module("ecospy")


def velocities(count=COUNT):
    """Return velocities that turn, creep and stand still with both signs."""
    generator = np.random.default_rng(5)
    v = np.repeat(generator.standard_normal(count // 10), 10) * 10.0 ** generator.uniform(
        -6, -1, count
    )
    v[generator.random(count) < 0.1] = 0.0
    v[generator.random(count) < 0.05] = -0.0
    return v


def efforts(count=COUNT):
    """Return efforts that hold the mass, let it slip, and turn it back."""
    return (
        60.0
        * np.sin(np.arange(count) * 0.02)
        * np.repeat(np.random.default_rng(6).uniform(0, 1, count // 50), 50)
    )


NAMES = tuple(WRITTEN)


@pytest.mark.parametrize("mass", [False, True])
@pytest.mark.parametrize("name", NAMES)
def test_an_importer_finds_no_problem(fmus, name, mass):
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(fmus / name / f"axis_x{'_mass' * mass}.fmu")) == []


@pytest.mark.parametrize("name", NAMES)
def test_friction_along_a_velocity_is_identical_to_bristle(opened, name):
    v, model = velocities(), example(name)
    x = np.cumsum(v) * STEP
    load = {"load": 1.0 + 0.5 * np.sin(np.arange(COUNT) * 0.1)} if "load" in model.name else {}
    inputs = [
        {"v": v[k], "x": x[k]} | {key: values[k] for key, values in load.items()}
        for k in range(COUNT)
    ]
    forces = opened(name).start().along(STEP, inputs, "force")[:, 0]
    with br.engine.interpreted():
        expected = br.engine.force_along(with_rest(model, "middle"), v, STEP, x, **load)
    assert np.ptp(expected) > 0.0
    assert differing(forces, expected) == 0


@pytest.mark.parametrize("name", NAMES)
def test_a_mass_under_an_effort_moves_as_in_bristle(opened, name):
    u = efforts()
    unit = opened(name, mass=True).start(time=0.25, x=1e-3, v=0.02)
    seen = unit.along(
        STEP, [{"effort": value} for value in u], "force", before=("x", "v"), start=0.25
    )
    with br.engine.interpreted():
        trace = br.engine.run_open_loop(PLANT, example(name), u, STEP, x=1e-3, v=0.02)
    assert name != "coulomb_3" or np.count_nonzero(trace.velocity == 0.0) > 10
    assert np.min(trace.velocity) < 0.0 < np.max(trace.velocity)
    assert differing(seen, np.transpose([trace.position, trace.velocity, trace.friction])) == 0


@needs_ecos
@pytest.mark.parametrize("name", NAMES)
def test_a_second_importer_computes_identical_results(ecos, fmus, name):
    u = efforts(200)
    with ecos.EcosSimulationStructure() as structure:
        structure.add_model("axis", fmus / name / "axis_x_mass.fmu")
        structure.add_parameter_set("start", {"axis::x": 1e-3, "axis::v": 0.02})
        with ecos.EcosSimulation(STEP, structure=structure) as simulation:
            simulation.init(parameter_set="start")
            seen = []
            for effort in u:
                before = [simulation.get_real(f"axis::{name}") for name in ("x", "v")]
                simulation.set_real("axis::effort", effort)
                simulation.step()
                seen.append([*before, simulation.get_real("axis::force")])
    with br.engine.interpreted():
        trace = br.engine.run_open_loop(PLANT, example(name), u, STEP, x=1e-3, v=0.02)
    assert differing(seen, np.transpose([trace.position, trace.velocity, trace.friction])) == 0


def test_a_plant_with_constant_parameters_moves_equally_and_is_reported(opened, fmus, monkeypatch):
    monkeypatch.setattr(fmu, "zig", list)
    values = {
        "M": 2.0,
        "g_sin": 1.0,
        "motor_turn": 0.01,
        "motor_2_cos": 3.0,
        "motor_2_sin": 0.2,
        "spring_1": 4.0,
    }
    plant = br.plants.with_terms(
        br.plants.inertia, gravity=True, cogging={"motor": [2]}, spring="linear"
    )(**values)
    result = br.export(example("coulomb_3"), "fmu2", fmus / "termed", step=STEP, plant=plant)
    assert any("cannot change during a simulation" in note for note in result.notes)
    u, unit = efforts()[:300], opened("termed", mass=True).start()
    seen = unit.along(STEP, [{"effort": value} for value in u], "force", before=("x",))[:, 0]
    with br.engine.interpreted():
        trace = br.engine.run_open_loop(plant, example("coulomb_3"), u, STEP)
    assert differing(seen, trace.position) == 0
    with pytest.raises(Exception, match="SetReal failed"):
        unit.set(M=3.0)


def test_long_and_odd_communication_steps_are_internal_steps(opened):
    u = efforts(COUNT)
    item, other = opened("lugre_2", mass=True).start(), opened("lugre_2", mass=True).start()
    for k in range(0, 120, 4):
        for i in range(4):
            item.step((k + i) * STEP, STEP, effort=u[k])
        other.step(k * STEP, 2.7 * STEP, effort=u[k])  # two steps; the third waits for its end
        other.step((k + 2.7) * STEP, 1.3 * STEP)
        assert item.get("x", "v", "force") == other.get("x", "v", "force")
    with pytest.raises(Exception, match="DoStep failed"):
        other.step(10 * STEP, STEP)


@pytest.mark.parametrize("mass", [False, True])
@pytest.mark.parametrize("name", ["preisach_lugre_2", "preisach_lugre_3"])
def test_a_saved_state_continues_identically_and_damaged_bytes_are_refused(opened, name, mass):
    inputs = (
        [{"effort": value} for value in efforts()]
        if mass
        else [{"v": value, "x": 0.0} for value in velocities()]
    )
    generator = np.random.default_rng(20260)
    at = int(generator.integers(300, COUNT - 300))
    unit = opened(name, mass).start()
    first_name = next(port for port in ("sigma_1", "f_p", "s") if port in unit.places)
    unit.set(**{first_name: 1.1 * unit.get(first_name)[0]})
    outputs = ("x", "v", "force") if mass else ("force",)

    def walked(each, first):
        return each.along(STEP, inputs[first : first + 200], *outputs, first=first).tolist()

    unit.along(STEP, inputs[:at], *outputs)
    saved = unit.saved()
    expected = walked(unit, at)
    assert np.ptp(expected) > 0.0
    for each in (unit, opened(name, mass).start()):
        each.restore(saved)
        assert walked(each, at) == expected
    for place in [0, 8, 16, *generator.integers(24, len(saved), 8)]:
        damaged = bytearray(saved)
        damaged[place] ^= 4
        with pytest.raises(Exception, match=r"erialize.* failed"):
            unit.restore(bytes(damaged))
    with pytest.raises(Exception, match=r"erialize.* failed"):
        unit.restore(saved[:-8])


def digest(content):
    from bristle.exports.subject import hash_of

    return hash_of(np.frombuffer(content, dtype="<f8").tolist())


def test_a_depth_beyond_the_memory_is_refused_even_with_a_correct_checksum(opened):
    unit = opened("preisach_lugre_2").start()
    unit.step(0.0, STEP, v=1e-3)
    saved = bytearray(unit.saved())
    lasting = 8 * (4 + len(unit.places))
    depth = lasting + 8 * list(example("preisach_lugre_2").component.State._fields).index("depth")
    for value, fine in ((3.0, True), (1e6, False), (-1.0, False), (1.5, False)):
        saved[depth : depth + 8] = np.array(value).tobytes()
        saved[-8:] = digest(bytes(saved[:-8])).to_bytes(8, "little")
        if fine:
            unit.restore(bytes(saved))
        else:
            with pytest.raises(Exception, match=r"erialize.* failed"):
                unit.restore(bytes(saved))


def test_parameters_are_tunable_within_their_ranges(opened):
    v = velocities(400)
    unit, inputs = opened("gms_2").start(), [{"v": value, "x": 0.0} for value in v]
    inputs[200] |= {"k_i[2]": 2e6, "F_S_neg": 26.5}
    forces = unit.along(STEP, inputs, "force")[:, 0]
    model = example("gms_2")
    with br.engine.interpreted():
        expected = br.engine.force_along(model, v, STEP, np.zeros(400))
    assert forces[:200].tolist() == expected[:200].tolist()
    assert forces[200:].tolist() != expected[200:].tolist()
    for values in ({"F_S_neg": -1.0}, {"v": np.nan}, {"force": 1.0}):
        with pytest.raises(Exception, match="SetReal failed"):
            unit.set(**values)
    described = {variable.name: variable for variable in unit.described.modelVariables}
    assert (described["F_S_neg"].unit, described["F_S_neg"].min) == ("N", "1e-12")
    assert described["k_i[2]"].variability == "tunable"


def test_parameters_set_before_the_start_give_the_changed_model(opened):
    v, unit = velocities(400), opened("lugre_2").start(sigma_0=2e6, F_C=11.0)
    forces = unit.along(STEP, [{"v": value, "x": 0.0} for value in v], "force")[:, 0]
    model = example("lugre_2").with_values(sigma_0=2e6, F_C=11.0)
    with br.engine.interpreted():
        expected = br.engine.force_along(model, v, STEP, np.zeros(400))
    assert differing(forces, expected) == 0


@pytest.fixture
def uncompiled(monkeypatch):
    """No compiler of any platform is found."""
    monkeypatch.setattr(fmu, "zig", list)
    monkeypatch.setattr(fmu, "compiler", lambda: None)


def test_without_a_compiler_the_fmu_has_only_its_source_and_a_note(tmp_path, uncompiled):
    result = br.export(example("coulomb_3"), "fmu3", tmp_path / "out")
    assert any("contains its source only" in note for note in result.notes)
    assert any("the mass is unknown" in note for note in result.notes)
    assert result.files == ("axis_x.fmu",)
    with zipfile.ZipFile(tmp_path / "out" / "axis_x.fmu") as archive:
        names = set(archive.namelist())
        build = ElementTree.fromstring(archive.read("sources/buildDescription.xml"))
    assert {
        "modelDescription.xml",
        "sources/axis_x.c",
        "sources/fmi3Functions.h",
        "sources/LICENSE.txt",
    } <= names
    assert not any(name.startswith("binaries") for name in names)
    files = build.find("BuildConfiguration/SourceFileSet")
    assert "-ffp-contract=off" in files.attrib["compilerOptions"]
    assert files.find("SourceFile").attrib["name"] == "axis_x.c"


def test_the_source_compiles_without_warnings_and_the_archive_is_reproducible(
    fmus, tmp_path, monkeypatch
):
    monkeypatch.setattr(fmu, "zig", list)
    written = [
        (name, "axis_x_mass") for name in ("preisach_lugre_2", "preisach_lugre_3", "lugre_2")
    ]
    for name, unit in (*written, ("coulomb_3", "axis_x")):
        with zipfile.ZipFile(fmus / name / f"{unit}.fmu") as archive:
            archive.extractall(tmp_path / name)
        compiled(
            tmp_path / name / "sources", *FLAGS, "-O1", "-fsyntax-only", *WARNINGS, f"{unit}.c"
        )
    first, second = [
        br.export(example_with("dahl"), "fmu2", tmp_path / name, step=STEP) for name in ("a", "b")
    ]
    content = [(each.folder / "axis_x.fmu").read_bytes() for each in (first, second)]
    assert content[0] == content[1]


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_description_states_title_author_and_licence(tmp_path, uncompiled, fmi):
    model = example("lugre_2")
    source = Source(
        {"model": "a<b.toml", "command": "bristle export"}, {"F_S": {"interval": (24.0, 31.5)}}
    )
    br.export(model, f"fmu{fmi}", tmp_path / "out", source=source, plant=PLANT)
    hashes = [hash_of_model(model)]
    for name in ("axis_x", "axis_x_mass"):
        with zipfile.ZipFile(tmp_path / "out" / f"{name}.fmu") as archive:
            described = ElementTree.fromstring(archive.read("modelDescription.xml"))
            licence = archive.read("documentation/licenses/license.txt").decode()
            text = archive.read(f"sources/{name}.c").decode()
        hashes.append(described.find(".//Model[@sha256]").get("sha256"))
        assert described.get("version") == f"{br.__version__}+{hashes[-1][:12]}"
        assert described.get("license").startswith("BSD-3-Clause")
        assert described.get("copyright") in licence
        assert described.get("generationTool") == f"bristle {br.__version__}"
        assert f"sha256 {hashes[-1]}" in text.splitlines()[3]
    br.export(
        model, f"fmu{fmi}", tmp_path / "heavier", source=source, plant=PLANT.with_values(M=2.5)
    )
    hashes.append(
        described_by(tmp_path / "heavier" / "axis_x_mass.fmu")
        .find(".//Model[@sha256]")
        .get("sha256")
    )
    assert hashes[0] == hashes[1]
    assert len(set(hashes[1:])) == 3


def test_the_command_takes_the_mass_from_the_model_file(tmp_path, uncompiled, capsys):
    br.write_model(tmp_path / "model.toml", PLANT, example("coulomb_3"))
    out = tmp_path / "out"
    assert (
        main(
            [
                "export",
                str(tmp_path / "model.toml"),
                "--to",
                "fmu3",
                "--step",
                "0.2ms",
                "--out",
                str(out),
            ]
        )
        == 0
    )
    assert "contains its source only" in capsys.readouterr().out
    described = described_by(out / "axis_x_mass.fmu")
    assert described.find("CoSimulation").attrib["fixedInternalStepSize"] == "0.0002"
    mass = next(
        variable for variable in described.find("ModelVariables") if variable.attrib["name"] == "M"
    )
    assert (mass.attrib["start"], mass.attrib["unit"]) == ("2.0", "kg")


SCREW = br.plants.ball_screw(
    kind="rotational", J=5e-4, M=150.0, lead=10e-3, k=3e6, d=1500.0, backlash=2e-5
)
LUGRE = br.friction.lugre(
    kind="rotational", F_C=0.05, F_S=0.06, v_S=0.1, sigma_0=100.0, sigma_1=1e-2, sigma_2=1e-4
)
COULOMB = br.friction.coulomb(kind="rotational", F_C=0.05)
SLIPS = br.friction.maxwell_slip(kind="rotational", F_C=0.05, k_i=[60.0], nu_i=[1.0])
TURNS = br.friction.preisach_contact(
    kind="rotational", kernel="reformed_dahl_exact", s=100.0, f_p=0.05
)
TABLES = {
    "preisach": br.friction.preisach_contact(kernel="reformed_dahl_exact", s=1e7, f_p=200.0),
    "lugre": br.friction.lugre(
        F_C=200.0, F_S=260.0, v_S=1e-3, sigma_0=1e7, sigma_1=1e3, sigma_2=10.0
    ),
    "maxwell_slip": br.friction.maxwell_slip(F_C=200.0, k_i=[6e7, 3e7], nu_i=[0.5, 0.5]),
    "coulomb": br.friction.coulomb(F_C=200.0),
}
CASES = [
    ("lugre", 2, LUGRE),
    ("maxwell_slip", 3, LUGRE),
    ("coulomb", 2, COULOMB),
    ("maxwell_slip", 2, SLIPS),
    ("preisach", 3, TURNS),
]
SHORT, SAMPLES = 1e-4, 800


def screwed(folder, table, motor=LUGRE, fmi=2):
    return br.export(motor, f"fmu{fmi}", folder, plant=SCREW, table=table, step=SHORT)


@pytest.mark.parametrize(("name", "fmi", "motor"), CASES)
def test_both_masses_move_as_in_bristle(tmp_path, monkeypatch, name, fmi, motor):
    from fmpy.validation import validate_fmu

    monkeypatch.setattr(fmu, "zig", list)
    table = TABLES[name]
    assert "axis_x_mass.fmu" in screwed(tmp_path / "out", table, motor, fmi).files
    assert validate_fmu(str(tmp_path / "out" / "axis_x_mass.fmu")) == []
    unit = Importer(tmp_path / "out" / "axis_x_mass.fmu", tmp_path / "unpacked").start(
        x=0.02, x_table=0.02
    )
    effort = (
        0.9
        * np.sin(np.arange(SAMPLES) * 0.012)
        * np.repeat(np.random.default_rng(6).uniform(0, 1, SAMPLES // 50), 50)
    )
    seen = unit.along(
        SHORT,
        [{"effort": value} for value in effort],
        "force",
        before=("x", "v", "x_table", "v_table"),
    )
    unit.close()
    with br.engine.interpreted():
        trace = br.engine.run_open_loop(SCREW, motor, effort, SHORT, table=table, x=0.02)
    assert np.min(trace.velocity) < 0.0 < np.max(trace.velocity)
    signals = (
        trace.motor_position,
        trace.motor_velocity,
        trace.position,
        trace.velocity,
        trace.friction,
    )
    assert differing(seen, np.transpose(signals)) == 0


EXCHANGED = ("lugre_2", "preisach_lugre_3")
# Turning points [m]: passing 3 wipes a loop out, coming back to 2 another one, and -4 meets the virgin curve. At the
# Stribeck velocity the gate opens before -4.5.
LOOPS = np.array([0.0, 3.0, 1.5, 4.0, 2.0, 3.5, -4.5, 0.0]) * 1e-6
# The gate opens on the way to 16, to -14 and to 15; a loop is wiped out at 3, one in sliding and the one around it.
SLIDING = np.array([0.0, 3.0, 1.5, 4.0, 16.0, 8.0, 11.0, -14.0, -9.0, 15.0]) * 1e-6
STROKE = 1e-8  # of a step of the reference [m]
FINE = 100_000  # steps of the reference in a sample


def along(turns, speed):
    """Times at the turning points [s], and the velocity [m/s] on the way to each of them."""
    times = np.concatenate(([0.0], np.cumsum(np.abs(np.diff(turns)) / speed)))
    return times, np.sign(np.diff(turns)) * speed


def stays(times, **values):
    """Return inputs that jump at times."""
    columns = {"time": np.repeat(times, 2)[1:-1]} | {
        name: np.repeat(each, 2) for name, each in values.items()
    }
    signals = np.zeros(columns["time"].size, dtype=[(name, float) for name in columns])
    for name, column in columns.items():
        signals[name] = column
    return signals


def integrated(path, signals, tolerance, output, points=1000, **start):
    """Return what FMPy finds with CVODE, and at which times and margins there were events."""
    from fmpy import simulate_fmu

    end = float(signals["time"][-1])
    result = simulate_fmu(
        str(path),
        fmi_type="ModelExchange",
        stop_time=end,
        relative_tolerance=tolerance,
        input=signals,
        output_interval=end / points,
        record_events=True,
        output=output,
        start_values=start,
    )
    events = np.flatnonzero(np.diff(result["time"]) == 0.0)
    return result, events


def state_events(result, events, name):
    """Return at how many events this indicator had fallen below zero."""
    return int(np.count_nonzero(result[name][events] < 0.0))


@pytest.mark.parametrize(
    ("turns", "speed", "wiped", "opened_gates"),
    [(LOOPS, 2e-3, 3, 1), (LOOPS, 1e-9, 3, 0), (SLIDING, 2e-3, 3, 3)],
)
def test_loops_along_a_velocity_close_and_each_is_wiped_out_once(
    fmus, turns, speed, wiped, opened_gates
):
    times, v = along(turns, speed)
    path = fmus / "preisach_lugre_3" / "axis_x.fmu"
    result, events = integrated(path, stays(times, v=v, x=0.0 * v), 1e-8, ["force", "margin", "z"])
    steps = np.round(np.abs(np.diff(turns)) / STROKE).astype(int)
    with br.engine.interpreted():
        force = br.engine.force_along(
            example("preisach_lugre_3"), np.repeat(v, steps), STROKE / speed
        )
    at = STROKE / speed * (np.arange(force.size) + 0.5)
    kinks = np.concatenate((times, result["time"][events]))
    apart = np.min(np.abs(result["time"][:, None] - kinks), axis=1) > STROKE / speed
    error = np.abs(np.interp(result["time"], at, force) - result["force"])[apart]
    assert np.max(error) <= 1e-4 * np.max(np.abs(force))
    assert state_events(result, events, "margin") == wiped + opened_gates


@pytest.mark.parametrize("name", EXCHANGED)
def test_a_resting_body_decays_and_then_has_no_events(fmus, name):
    for tolerance in (1e-4, 1e-6, 1e-8):
        path = fmus / name / "axis_x_mass.fmu"
        result, events = integrated(
            path, stays(np.array([0.0, 2.0]), effort=np.array([10.0])), tolerance, ["v"]
        )
        assert 8 <= events.size <= 50
        assert result["time"][events[-1]] < 0.2
        assert abs(result["v"][-1]) < 1e-15


def test_a_resting_contact_has_no_events(fmus):
    times, v = np.array([0.0, 1.0, 1.001, 2.0]), np.array([0.0, 1e-3, 0.0])
    result, events = integrated(
        fmus / "lugre_2" / "axis_x.fmu", stays(times, v=v, x=0.0 * v), 1e-8, ["z", "reversal"]
    )
    assert events.size == 2  # the input jumps twice
    assert result["z"][-1] == result["z"][result["time"] > 1.001][0] > 0.0


def turn(unit, **values):
    """Let an event happen."""
    unit.unit.enterEventMode()
    unit.set(**values)
    begin(unit)


def begin(unit):
    """End an event, or the start."""
    (unit.unit.newDiscreteStates if unit.fmi == 2 else unit.unit.updateDiscreteStates)()
    unit.unit.enterContinuousTimeMode()


def put(unit, *states):
    """Set the states."""
    vector = np.array(states)
    unit.unit.setContinuousStates(
        vector.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), vector.size
    )


def moved(unit, states, time):
    """Take one step of Euler's method, with the events of it, and return the states."""
    rates = np.zeros(len(states))
    get_rates = (
        unit.unit.getDerivatives if unit.fmi == 2 else unit.unit.getContinuousStateDerivatives
    )
    get_rates(rates.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), rates.size)
    unit.unit.setTime(time)
    put(unit, *(states + 1e-6 * rates))
    if min(unit.get("margin", "reversal")) < 0.0:
        turn(unit)
    return states + 1e-6 * rates


def walked(unit, states, first, last):
    """Take steps under an effort that turns, and return what is seen."""
    seen = []
    for k in range(first, last):
        unit.set(effort=30.0 * np.sin(0.01 * k))
        states = moved(unit, states, 1e-6 * k)
        seen += unit.get("force", "der(v)", "margin", "reversal")
    return states, seen


@pytest.mark.parametrize("name", EXCHANGED)
def test_a_saved_state_continues_identically_in_integration(opened, name):
    unit = opened(name, mass=True, exchanged=True).start(v=0.02)
    begin(unit)
    states, _ = walked(unit, np.array([0.0, 0.02, 0.0]), 0, 1500)
    kept, saved = states.copy(), unit.saved()
    states, expected = walked(unit, states, 1500, 2500)
    assert np.ptp(expected) > 0.0
    unit.restore(saved)
    assert walked(unit, kept.copy(), 1500, 2500)[1] == expected
    other = opened(name, mass=True, exchanged=True).start()
    other.restore(saved)
    assert walked(other, kept.copy(), 1500, 2500)[1] == expected
    stepped = opened(name, mass=True).start()
    with pytest.raises(Exception, match=r"etFMU[sS]tate failed"):
        stepped.restore(saved)


def test_an_event_is_signalled_slightly_late_so_that_it_is_certainly_over(opened):
    unit = opened("preisach_lugre_3", exchanged=True).start(v=1e-4)
    begin(unit)
    put(unit, 3e-6)
    turn(unit, v=-1e-4)
    put(unit, 1.5e-6)
    turn(unit, v=1e-4)
    put(unit, 3e-6)  # where the loop closes, to the bit
    force, before = unit.get("force", "margin")
    assert 0.0 < before < 1e-8
    put(unit, 3e-6 * (1.0 + 1e-8))
    assert unit.get("margin")[0] < 0.0
    turn(unit)
    after, beyond = unit.get("force", "margin")
    assert beyond > 1e-3
    assert abs(after - force) < 1e-6


@pytest.mark.parametrize("name", EXCHANGED)
def test_states_are_visible_in_co_simulation(opened, name):
    unit = opened(name, mass=True).start(v=0.02)
    for k in range(40):
        unit.step(k * 1e-3, 1e-3, effort=25.0)
    v, z, rate, acceleration, force = unit.get("v", "z", "der(x)", "der(v)", "force")
    assert rate == v
    assert abs(acceleration - (25.0 - force) / 2.0) <= 0.05 * abs(25.0 - force)
    assert z > 0.0


PULLED = br.plants.pulled_inertia(M=1.0, k=2e4, v_e=2e-3)
SPRUNG = br.plants.oscillator(M=2.0, k=1e4, c=3.0)


@pytest.mark.parametrize(
    ("name", "slots", "plant", "fmi"),
    [
        ("dahl", (), PLANT, 2),
        ("elastoplastic", (), PLANT, 3),
        ("bouc_wen", (), SPRUNG, 2),
        ("bouc_wen_classic", (), PLANT, 3),
        ("leuven", (), PULLED, 2),
        ("preisach_lugre", (), PULLED, 2),
        ("preisach_lugre", ("asymmetry",), PULLED, 3),
        ("lugre", ("load",), PLANT, 3),
    ],
)
def test_every_model_in_continuous_time_meets_the_tolerance(
    tmp_path, monkeypatch, name, slots, plant, fmi
):
    from fmpy.validation import validate_fmu

    monkeypatch.setattr(fmu, "zig", list)
    model, dt = example_with(name, slots), 0.02
    result = br.export(model, f"fmu{fmi}", tmp_path / "out", plant=plant)
    path = tmp_path / "out" / "axis_x_mass.fmu"
    assert [validate_fmu(str(tmp_path / "out" / file)) for file in result.files] == [[], []]
    levels = np.array([0, 15, -5, 20, 10, 22, -15, -5, -20, 0, 32, 0, -40, 0, 10, 10, 10.0])
    exact = br.engine.run_open_loop(plant, model, levels, dt, steps=FINE)
    times = dt * np.arange(levels.size + 1)
    for tolerance in (1e-4, 1e-6, 1e-8):
        seen, events = integrated(path, stays(times, effort=levels), tolerance, ["x", "v"])
        at = np.searchsorted(seen["time"], times[1:-1] - 1e-9)
        assert np.max(np.abs(seen["x"][at] - exact.position[1:])) <= 50.0 * tolerance * np.max(
            np.abs(exact.position)
        )
        assert events.size <= 300


def test_the_guide_lists_every_model_in_its_group():
    guide = (Path(__file__).parents[3] / "docs" / "how-to" / "export.md").read_text(
        encoding="utf-8"
    )
    section = guide[guide.index("### Model exchange") :]
    section = section[: section.index("\n## ")]
    able, unable = section.split("These models allow only co-simulation")
    for name, component in br.friction.MODELS.items():
        assert (f"`{name}`" in able) == (why_not(example_of(component)) == ""), name
        assert (f"`{name}`" in unable) == (why_not(example_of(component)) != ""), name
    of_all = unable.split("and Preisach–LuGre with")[0]
    for slot in SLOTS:
        lugre, composite = (example_with(name, [slot]) for name in ("lugre", "preisach_lugre"))
        assert (f"`+{slot}`" in of_all) == (why_not(lugre) != ""), slot
        assert (slot == "asymmetry") == (why_not(composite) == ""), slot


@pytest.mark.parametrize("mass", [False, True])
@pytest.mark.parametrize("name", EXCHANGED)
def test_directional_derivatives_are_those_of_differences(opened, name, mass):
    unit = opened(name, mass=mass, exchanged=True)
    unit.start(v=0.012)
    able = unit.described.modelExchange
    assert able.providesDirectionalDerivative if unit.fmi == 2 else able.providesAdjointDerivatives
    begin(unit)
    knowns = ["x", "v", "z", "effort"] if mass else ["z", "v"]
    unknowns = [
        "force",
        *(["der(x)", "der(v)"] if mass else []),
        "der(z)",
        *(["margin"] if "margin" in unit.places else []),
    ]
    of_states = ["x", "v", "z"] if mass else ["z"]
    base = {"x": 1e-6, "v": 0.012, "z": 2e-6, "effort": 3.0}
    sizes = {"x": 1e-6, "v": 1e-3, "z": 1e-7, "effort": 1.0}

    def at(**changed):
        values = base | changed
        put(unit, *(values[state] for state in of_states))
        unit.set(**{known: values[known] for known in knowns if known not in of_states})
        return np.array(unit.get(*unknowns))

    def places(names):
        return [unit.places[each] for each in names]

    jacobian, differences = np.zeros((2, len(knowns), len(unknowns)))
    for k, known in enumerate(knowns):
        nudge = 1e-4 * sizes[known]
        differences[k] = (
            at(**{known: base[known] + nudge}) - at(**{known: base[known] - nudge})
        ) / (2.0 * nudge)
        at()
        jacobian[k] = unit.unit.getDirectionalDerivative(places(unknowns), places([known]), [1.0])
    scale = np.array([[sizes[known]] for known in knowns])
    assert np.all(np.abs(differences).max(axis=0) > 0.0)
    assert np.all(
        np.abs(scale * (jacobian - differences)) <= 1e-6 * np.abs(scale * differences).max(axis=0)
    )
    seed = [0.5 * known for known in range(1, len(knowns) + 1)]
    mixed = unit.unit.getDirectionalDerivative(places(unknowns), places(knowns), seed)
    np.testing.assert_allclose(mixed, np.array(seed) @ jacobian, rtol=1e-12)
    if unit.fmi == 3:
        weights = [1.0 / (k + 1.0) for k in range(len(unknowns))]
        adjoint = unit.unit.getAdjointDerivative(
            places(unknowns), places(knowns), weights, len(knowns)
        )
        np.testing.assert_allclose(adjoint, np.array(jacobian) @ weights, rtol=1e-12)
    with pytest.raises(Exception, match="DirectionalDerivative"):
        unit.unit.getDirectionalDerivative(places(["time"]), places(knowns[:1]), [1.0])


# --- laws ------------------------------------------------------------------------------------------------------------


SAMPLES_OF_A_LAW = 600
# A law without a compensator, one along the measured motion, one led ahead with a past, and one that gravity passes to.
LAWS = {
    "cascade_nothing": ("cascade", "nothing", 2),
    "twisting_measured": ("twisting", "measured", 3),
    "sliding_mode_all": ("sliding_mode", "all", 2),
    "cascade_toothed": ("cascade", "toothed", 3),
}
TUNED = ("cascade", "toothed")


@cache
def law(controller, fed, *, tunable=False):
    return law_of(variant_of(controller, fed), tunable=tunable)


@cache
def inputs_of(controller, fed):
    """Return what a law is told along the walk of its self-test, a row for each sample."""
    message = law(controller, fed)
    walk, count, _ = law_walk(message, 2)
    x = walk.positions(SAMPLES_OF_A_LAW + count)
    v = np.diff(x) / DT
    return told(message, x[:-1], v, 100.0 * v, np.append(x[0], x[:-2]))[:SAMPLES_OF_A_LAW]


@pytest.fixture(scope="module")
def in_c(tmp_path_factory):
    """The same laws in C, as one library; parameters of one of them are changed where that is asked for."""
    texts, callers = {}, {}
    for name, (controller, fed, _) in LAWS.items():
        tuned = (controller, fed) == TUNED
        texts[name] = law_files(law(controller, fed, tunable=tuned), name, Source())
        changes = CHANGED[TUNED][0].items() if tuned else ()
        lines = (
            " ".join(f"axis.parameters.{field} = {value!r};" for field, value in changes)
            or "(void)changed;"
        )
        callers[name] = RUN_CHANGED.format(name=name, lines=lines)
    return library_of_laws(tmp_path_factory.mktemp("in_c"), texts, callers)


@pytest.fixture(scope="module")
def laws(tmp_path_factory):
    folder = tmp_path_factory.mktemp("law_fmus")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fmu, "zig", list)
        for name, (controller, fed, fmi) in LAWS.items():
            message = law(controller, fed)
            source = Source(model_hash=hash_of_law(message))
            written = fmu.write_law(message, name, source, fmi=fmi)
            assert any("sample time of the law, 0.0005 s" in note for note in written.notes)
            assert any(note.startswith("step the law before the plant") for note in written.notes)
            (folder / name).mkdir()
            (folder / name / "axis_x.fmu").write_bytes(written.files[f"{name}.fmu"])
    return folder


def stepped(unit, rows, first=0, dt=DT):
    """Return the effort after each sample; the inputs of an FMU stand in the order of those in C."""
    names = [
        variable.name for variable in unit.described.modelVariables if variable.causality == "input"
    ]
    inputs = [dict(zip(names, row.tolist(), strict=True)) for row in rows]
    return unit.along(dt, inputs, "effort", first=first)[:, 0]


@pytest.mark.parametrize("name", LAWS)
def test_an_importer_finds_no_problem_in_a_law(laws, name):
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(laws / name / "axis_x.fmu")) == []


@pytest.mark.parametrize("name", LAWS)
def test_efforts_are_identical_to_the_law_in_c(in_c, opened, laws, name):
    controller, fed, _ = LAWS[name]
    rows = inputs_of(controller, fed)
    result = stepped(opened(laws / name).start(), rows)
    assert np.ptp(result) > 20.0
    assert differing(result, replayed(in_c, name, rows, 0)) == 0


def test_changed_parameters_act_as_in_the_law_in_c(in_c, opened, laws):
    rows = inputs_of(*TUNED)
    unit = opened(laws / "cascade_toothed").start()
    unit.set(**CHANGED[TUNED][0])
    result = stepped(unit, rows)
    assert differing(result, replayed(in_c, "cascade_toothed", rows, 1)) == 0
    assert differing(result, replayed(in_c, "cascade_toothed", rows, 0)) > SAMPLES_OF_A_LAW // 2
    for values in ({"controller_k_p": -1.0}, {"measured": np.nan}, {"effort": 1.0}):
        with pytest.raises(Exception, match="SetFloat64 failed"):
            unit.set(**values)


@pytest.mark.parametrize("name", ["sliding_mode_all", "cascade_toothed"])
def test_a_saved_state_of_a_law_continues(opened, laws, name):
    rows = inputs_of(*LAWS[name][:2])
    unit, other = opened(laws / name).start(), opened(laws / name).start()
    virgin = unit.saved()
    first = stepped(unit, rows[:300])
    saved = unit.saved()
    rest = stepped(unit, rows[300:], 300)
    other.restore(saved)
    assert differing(stepped(other, rows[300:], 300), rest) == 0
    other.restore(virgin)
    assert differing(stepped(other, rows[:300]), first) == 0


def test_the_source_compiles_without_warnings(laws, tmp_path):
    for name in LAWS:
        with zipfile.ZipFile(laws / name / "axis_x.fmu") as archive:
            archive.extractall(tmp_path / name)
        compiled(
            tmp_path / name / "sources", *FLAGS, "-O1", "-fsyntax-only", *WARNINGS, f"{name}.c"
        )


def test_the_description_lists_inputs_and_the_order_of_steps(laws):
    described = described_by(laws / "cascade_toothed" / "axis_x.fmu")
    variables = {each.get("name"): each for each in described.find("ModelVariables")}
    assert [name for name, each in variables.items() if each.get("causality") == "input"] == [
        "position",
        "velocity",
        "acceleration",
        "measured",
        "place_ahead[1]",
        "place_ahead[2]",
        "acceleration_ahead[1]",
        "acceleration_ahead[2]",
    ]
    assert (variables["effort"].get("unit"), variables["controller_k_p"].get("variability")) == (
        "N",
        "tunable",
    )
    assert described.find("CoSimulation").get("fixedInternalStepSize") == repr(DT)
    assert described.find("ModelExchange") is None
