"""Model exchange: an importer that integrates an FMU finds the forces, the motion and the events of bristle."""

import ctypes
from pathlib import Path

import numpy as np
import pytest
from tests.exports.importing import PLANT, example, needs_compiler, needs_fmpy
from tests.exports.native import example_with

import bristle as br
from bristle.engine import force_along, interpreted, run_open_loop
from bristle.exports import fmu
from bristle.exports.fmu_exchange import why_not
from bristle.friction import MODELS
from bristle.friction.slots import SLOTS
from bristle.testing import example_of

pytestmark = [pytest.mark.slow, needs_compiler, needs_fmpy]
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
    columns = {"time": np.repeat(times, 2)[1:-1]} | {name: np.repeat(each, 2) for name, each in values.items()}
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


@pytest.mark.parametrize(("turns", "speed", "wiped", "opened_gates"), [(LOOPS, 2e-3, 3, 1), (LOOPS, 1e-9, 3, 0), (SLIDING, 2e-3, 3, 3)])
def test_loops_along_a_velocity_close_and_each_is_wiped_out_once(fmus, turns, speed, wiped, opened_gates):
    times, v = along(turns, speed)
    path = fmus / "preisach_lugre_3" / "axis_x.fmu"
    result, events = integrated(path, stays(times, v=v, x=0.0 * v), 1e-8, ["force", "margin", "z"])
    steps = np.round(np.abs(np.diff(turns)) / STROKE).astype(int)
    with interpreted():
        force = force_along(example("preisach_lugre_3"), np.repeat(v, steps), STROKE / speed)
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
        result, events = integrated(path, stays(np.array([0.0, 2.0]), effort=np.array([10.0])), tolerance, ["v"])
        assert 8 <= events.size <= 50
        assert result["time"][events[-1]] < 0.2
        assert abs(result["v"][-1]) < 1e-15


def test_a_resting_contact_has_no_events(fmus):
    times, v = np.array([0.0, 1.0, 1.001, 2.0]), np.array([0.0, 1e-3, 0.0])
    result, events = integrated(fmus / "lugre_2" / "axis_x.fmu", stays(times, v=v, x=0.0 * v), 1e-8, ["z", "reversal"])
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
    unit.unit.setContinuousStates(vector.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), vector.size)


def moved(unit, states, time):
    """Take one step of Euler's method, with the events of it, and return the states."""
    rates = np.zeros(len(states))
    get_rates = unit.unit.getDerivatives if unit.fmi == 2 else unit.unit.getContinuousStateDerivatives
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
def test_every_model_in_continuous_time_meets_the_tolerance(tmp_path, monkeypatch, name, slots, plant, fmi):
    from fmpy.validation import validate_fmu

    monkeypatch.setattr(fmu, "zig", list)
    model, dt = example_with(name, slots), 0.02
    result = br.export(model, f"fmu{fmi}", tmp_path / "out", plant=plant)
    path = tmp_path / "out" / "axis_x_mass.fmu"
    assert [validate_fmu(str(tmp_path / "out" / file)) for file in result.files] == [[], []]
    levels = np.array([0, 15, -5, 20, 10, 22, -15, -5, -20, 0, 32, 0, -40, 0, 10, 10, 10.0])
    exact = run_open_loop(plant, model, levels, dt, steps=FINE)
    times = dt * np.arange(levels.size + 1)
    for tolerance in (1e-4, 1e-6, 1e-8):
        seen, events = integrated(path, stays(times, effort=levels), tolerance, ["x", "v"])
        at = np.searchsorted(seen["time"], times[1:-1] - 1e-9)
        assert np.max(np.abs(seen["x"][at] - exact.position[1:])) <= 50.0 * tolerance * np.max(np.abs(exact.position))
        assert events.size <= 300


def test_the_guide_lists_every_model_in_its_group():
    guide = (Path(__file__).parents[2] / "docs" / "how-to" / "export.md").read_text(encoding="utf-8")
    section = guide[guide.index("### Model exchange") :]
    section = section[: section.index("\n## ")]
    able, unable = section.split("These models allow only co-simulation")
    for name, component in MODELS.items():
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
    unknowns = ["force", *(["der(x)", "der(v)"] if mass else []), "der(z)", *(["margin"] if "margin" in unit.places else [])]
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
        differences[k] = (at(**{known: base[known] + nudge}) - at(**{known: base[known] - nudge})) / (2.0 * nudge)
        at()
        jacobian[k] = unit.unit.getDirectionalDerivative(places(unknowns), places([known]), [1.0])
    scale = np.array([[sizes[known]] for known in knowns])
    assert np.all(np.abs(differences).max(axis=0) > 0.0)
    assert np.all(np.abs(scale * (jacobian - differences)) <= 1e-6 * np.abs(scale * differences).max(axis=0))
    seed = [0.5 * known for known in range(1, len(knowns) + 1)]
    mixed = unit.unit.getDirectionalDerivative(places(unknowns), places(knowns), seed)
    np.testing.assert_allclose(mixed, np.array(seed) @ jacobian, rtol=1e-12)
    if unit.fmi == 3:
        weights = [1.0 / (k + 1.0) for k in range(len(unknowns))]
        adjoint = unit.unit.getAdjointDerivative(places(unknowns), places(knowns), weights, len(knowns))
        np.testing.assert_allclose(adjoint, np.array(jacobian) @ weights, rtol=1e-12)
    with pytest.raises(Exception, match="DirectionalDerivative"):
        unit.unit.getDirectionalDerivative(places(["time"]), places(knowns[:1]), [1.0])
