"""The tracking loop of the page: laws, encoder and mass have the bits of the kernels, and go as a simulation does."""

import json
import math

import numpy as np
import pytest
from tests.lab.scripts import needs_node, node

from bristle.controllers.law import law
from bristle.core import Feedforward, Reference
from bristle.engine import run_closed_loop
from bristle.engine.mechanism import Mechanism, mechanism
from bristle.exports.page.described import example_named, model_described
from bristle.exports.page.packing import plain
from bristle.exports.subject import presliding_distance, subject_of
from bristle.lab.page import paper_experiment, paper_loop
from bristle.plants import inertia, pulled_inertia
from bristle.simulation.compensation import feedforward_effort

pytestmark = needs_node
COUNT, DT, DELAY, SUBSTEPS = 200, 5e-4, 1, 2
RUN = """
const parts = await loadedParts(LOOP), contact = await loaded(models[0]), mass = await loaded(models[0]);
for (const [name, value] of Object.entries({ M: MASS, k: 0, v_e: 0 })) mass.set(name, [value]);
const desired = Object.fromEntries(Object.entries(DESIRED).map(([name, list]) => [name, Float64Array.from(list)]));
const setup = { dt: DT, delay: DELAY, count: COUNT, values: VALUES };
const told = fedForward(contact, desired.x, DT);
const { x, read } = followed(parts, mass, LAW, desired, FEEDS ? told.subarray(DELAY) : null, setup);
say([[...told], [...x], [...read]]);
"""


def desired_for(model):
    """Return a motion with a rest in it, from 0."""
    reach = presliding_distance(subject_of(model))
    t = DT * np.arange(COUNT + DELAY + 1)
    w = 2.0 * math.pi / (COUNT * DT)
    x = np.where(t < 0.02, 0.0, 3.0 * reach * (1.0 - np.cos(w * (t - 0.02))))
    v = np.where(t < 0.02, 0.0, 3.0 * reach * w * np.sin(w * (t - 0.02)))
    return {"x": x, "v": v, "a": np.gradient(v, DT)}


def controllers():
    variants = {variant.name: variant for variant in paper_experiment().variants}
    return {"sliding": variants["none"].controller, "observer": variants["observer"].controller}


def stepped(model, mass, controller, sensor, desired, message):
    """Return where the mass is and is read to be, by the kernels as they stand."""
    plant = pulled_inertia(M=mass, k=0.0, v_e=0.0)
    q, p, c, s = plant.parameters, model.parameters, controller.parameters, sensor.parameters
    state, reading = model.component.initial_state(p), sensor.component.initial_state(s)
    now = Mechanism(plant.component.initial_state(q), state, 0.0, 0.0, 0.0, 0.0, 0.0)
    memory, commands, kept = model.component.new_memory(p), [], None
    x, read = [], []
    for k in range(COUNT):
        x.append(now.plant.x)
        measured, reading = sensor.component.step(reading, now.plant.x, DT, s)
        read.append(measured)
        at = [float(desired[name][k]) for name in "xva"]
        kept = controller.component.start(measured, at[1], at[2], DT, c) if kept is None else kept
        effort, kept = law(kept, Reference(*at, float(message[k])), measured, 0.0, 1e300, DT, c)
        commands.append(effort)
        applied = commands[k - DELAY] if k >= DELAY else 0.0
        for _ in range(SUBSTEPS):
            after = mechanism(now, memory, applied, applied, 0.0, 0.0, DT / SUBSTEPS, 1, q, p)
            now = Mechanism(after.plant, after.friction, after.effort, after.slope, after.acceleration, 0.0, 0.0)
    return np.array(x), np.array(read)


@pytest.mark.parametrize(
    ("name", "law_name", "feeds"),
    [
        ("lugre", "sliding", False),
        ("lugre", "observer", True),
        ("coulomb_viscous", "sliding", True),
        pytest.param("preisach_lugre", "sliding", True, marks=pytest.mark.slow),
    ],
)
def test_the_loop_of_the_page_is_that_of_python(name, law_name, feeds, tmp_path):
    model, mass = example_named(name), 200.0
    desired, controller = desired_for(model), controllers()[law_name]
    values = {"J": mass, "lambda_": 150.0, "K_1": 150.0, "cutoff": 400.0}
    values |= {"K_2": 1e-3, "phi": 2e-5} if law_name == "sliding" else {"g": 60.0}
    sensor = paper_experiment().variants[0].sensor
    argument = {
        "LOOP": json.dumps(plain(paper_loop())),
        "MASS": mass,
        "LAW": json.dumps(law_name),
        "COUNT": COUNT,
        "DT": DT,
        "DELAY": DELAY,
        "FEEDS": json.dumps(feeds),
        "DESIRED": json.dumps({key: column.tolist() for key, column in desired.items()}),
        "VALUES": json.dumps(values | {key: sensor.values[key] for key in ("resolution", "noise")}),
    }
    script = "\n".join([*(f"const {word} = {text};" for word, text in argument.items()), RUN])
    message, x, read = node(tmp_path, [plain(model_described(model, named="m"))], script)
    controller = controller.with_values(**values)
    # What is fed forward has the bits of the engine, rests too.
    wanted = feedforward_effort(Feedforward(friction=model), desired["x"], desired["a"], DT)
    assert message == wanted[:-1].tolist()
    fed = wanted[DELAY:] if feeds else np.zeros(COUNT)
    custom, own_read = stepped(model, mass, controller, sensor, desired, fed)
    assert x == custom.tolist()
    assert read == own_read.tolist()
    # And all of it is the course of a simulation.
    reference = np.stack((*(desired[key][:COUNT] for key in "xva"), fed[:COUNT]))
    trace = run_closed_loop(inertia(M=mass), model, controller, sensor, reference, DT, steps=SUBSTEPS, delay=DELAY)
    assert np.max(np.abs(x)) > 1e-6
    # Solves end within their tolerance, and a count of the encoder may fall the other way.
    assert np.max(np.abs(trace.position - x)) < 0.02 * np.ptp(x)


def test_the_rig_of_the_paper_has_the_same_error_on_the_page(tmp_path):
    variants = {variant.name: variant for variant in paper_experiment().variants}
    plain_loop, observing = variants["none"], variants["observer"]
    law_values, motion = plain_loop.controller.values, plain_loop.reference.values
    settings = {"M": plain_loop.plant.values["M"], "gain": law_values["lambda_"], "K_2": law_values["K_2"]}
    settings |= {"g": observing.controller.values["g"], "resolution": plain_loop.sensor.values["resolution"]}
    settings |= {"A": max(motion["amplitudes"]), "f": motion["frequency"]}
    script = f"""
    const loop = {json.dumps(plain(paper_loop()))}, body = loop.rig, settings = {json.dumps(settings)};
    const values = Object.fromEntries(models[0].variables.map(({{ name, values }}) => [name, numbersOf(values)]));
    const {{ errors, period }} = await tracked(
      {{ loop, model: models[0], values, body, bodyValues: body.values, settings }});
    const width = (values) => Math.max(...values) - Math.min(...values);
    say([period, ...["none", "observer"].map((way) => width(errors[way]))]);
    """
    period, none, observer = node(tmp_path, [plain(model_described(example_named("lugre"), named="m"))], script)
    assert period == 8000
    # Six runs of the experiment, of amplitudes up to this one: 1.47 and 0.2 um peak to peak.
    assert none == pytest.approx(1.47e-6, rel=0.15)
    assert observer < 0.3 * none


# --- Lines as they are drawn: of few corners, and close to each point


pytestmark = needs_node
NEAR = 0.2  # [px]
DRAWN = """
const x = POINTS.map(([across]) => across), y = POINTS.map(([, up]) => up), corners = [];
const context = { moveTo: (...point) => corners.push(point), lineTo: (...point) => corners.push(point) };
straightened(context, 0, x.length - 1, (k) => x[k], (k) => y[k]);
say(corners);
"""
TURN = np.linspace(0.0, 2.0 * np.pi, 20_000)
LINES = {
    "a loop": np.column_stack((250.0 * np.sin(TURN), 150.0 * np.tanh(6.0 * np.cos(TURN)))),
    "there and back, further out each time": np.column_stack((TURN * 30.0 * np.sin(6.0 * TURN), np.zeros(TURN.size))),
    "a corner at each point": np.column_stack((np.arange(200.0), 40.0 * (np.arange(200) % 2))),
    "a spiral into a point": np.column_stack((np.cos(9.0 * TURN), np.sin(9.0 * TURN))) * (80.0 - 12.7 * TURN)[:, None],
    "noise": np.random.default_rng(5).normal(0.0, 3.0, (3000, 2)).cumsum(axis=0),
    "one point": np.zeros((1, 2)),
}


def corners(points, folder):
    return np.array(node(folder, [], DRAWN.replace("POINTS", str(points.tolist()))))


def off(points, line):
    """Return how far points are from a line of straight pieces."""
    start, end = line[:-1], line[1:]
    along = end - start
    squares = np.maximum(np.sum(along**2, axis=1), 1e-30)
    part = np.clip(np.sum((points[:, None] - start) * along, axis=2) / squares, 0.0, 1.0)
    return np.min(np.linalg.norm(points[:, None] - (start + part[..., None] * along), axis=2), axis=1)


@pytest.mark.slow
@pytest.mark.parametrize("name", LINES)
def test_no_point_is_further_from_the_line_than_a_fifth_of_a_pixel(name, tmp_path):
    points = LINES[name]
    line = corners(points, tmp_path)
    assert np.array_equal(line[[0, -1]], points[[0, -1]])
    assert np.max(off(points[::7], line)) <= 1.05 * NEAR
    # Nor does the line lead where no point is.
    assert np.max(off(line, points[:1].repeat(2, axis=0) if len(points) == 1 else points)) <= 1e-9


def test_a_loop_of_20_000_samples_has_few_corners(tmp_path):
    assert len(corners(LINES["a loop"], tmp_path)) < 250
    assert len(corners(LINES["there and back, further out each time"], tmp_path)) < 30
