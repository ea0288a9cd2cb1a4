"""Loops as a page computes them: what they begin with, what pushes them, and which it cannot."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from tests.apps.lab.scripts import needs_node, node

import bristle as br
from bristle.apps.lab.page import paper_experiment, paper_loop
from bristle.apps.targets.page import loop, rows, switches
from bristle.apps.targets.page.described import example_named, model_described
from bristle.apps.targets.page.packing import (
    as_json,
    differences,
    packed,
    packed_numbers,
    plain,
    unpacked,
)
from bristle.core import Feedforward, Reference, Run, Variant, experiment
from bristle.engine.mechanism import Mechanism, mechanism
from bristle.exports.subject import presliding_distance, subject_of
from bristle.models.controllers.law import law
from bristle.simulation.compensation import feedforward_effort

DT = 1e-3
FRICTION = br.friction.lugre(F_C=5.0, F_S=6.0, v_S=1e-2, sigma_0=1e5)
POSITION = 0.02 + 0.01 * np.sin(2.0 * np.pi * DT * np.arange(400))
PLANT = br.plants.inertia(M=2.0)


def variant(**changes):
    parts = {
        "name": "loop",
        "plant": PLANT,
        "friction": FRICTION,
        "controller": br.controllers.cascade(k_p=20.0, k_v=300.0, k_i=100.0),
        "sensor": br.sensors.encoder(resolution=1e-6),
        "reference": br.references.recorded(position=POSITION, sample_time=DT),
        "feedforward": Feedforward(mass=1.5, friction=FRICTION),
        "run": Run(0.4, DT, substeps=5, delay=1, effort_limit=90.0, settle=0.1),
    }
    return Variant(**parts | changes)


def whole(message, count, parts):
    """Return the whole numbers that a page unpacks."""
    planes = np.frombuffer(unpacked(message["code"]), dtype=np.uint8).reshape(4, message["count"])
    folded = sum(planes[place].astype(np.int64) << (8 * place) for place in range(4))
    return np.split(
        np.where(folded % 2 == 0, folded // 2, -(folded + 1) // 2), [count] * (parts - 1)
    )


def described(**changes):
    facts, reason = loop.loop_described(variant(**changes), FRICTION)
    assert reason == ""
    return facts


def test_a_page_has_the_numbers_of_the_loop():
    facts = described()
    expected = {
        "M": 2.0,
        "mass": 1.5,
        "count": 400,
        "all": 400,
        "settle": 100,
        "substeps": 5,
        "delay": 1,
        "limit": 90.0,
        "sampleTime": DT,
    }
    expected |= {"effortBefore": 0.0, "body": None, "lag": {"inMean": 0.0, "atEnd": 0.0}}
    expected |= {
        "begin": [(0, pytest.approx(0.02)), (1, pytest.approx(0.01 * 2.0 * np.pi, rel=1e-3))]
    }
    assert {name: facts[name] for name in expected} == expected
    lagging = described(run=replace(variant().run, current_lag=1e-3))["lag"]
    assert lagging == pytest.approx({"atEnd": np.exp(-0.2), "inMean": (1.0 - np.exp(-0.2)) / 0.2})


def test_the_reference_is_written_in_steps_far_below_those_of_the_encoder():
    facts = described()
    assert facts["step"] == pytest.approx(1e-6 / 4096)
    moved, _ = whole(facts["numbers"], 400, 2)
    x = facts["origin"] + facts["step"] * np.cumsum(np.cumsum(moved))
    np.testing.assert_allclose(x, POSITION, atol=facts["step"])
    perfect = described(sensor=br.sensors.encoder(resolution=0.0))
    assert perfect["step"] == pytest.approx(np.max(np.abs(np.diff(POSITION))) / 4096)


def test_the_push_is_the_disturbance_minus_the_known_input():
    disturbance, injected = np.sin(np.arange(400.0)), 0.5 * np.cos(np.arange(400.0))
    facts = described(disturbance=disturbance, injected=injected)
    force = disturbance - injected
    assert facts["pushed"] == pytest.approx(float(np.sqrt(np.mean(force**2))) / 16.0)
    _, pushed = whole(facts["numbers"], 400, 2)
    np.testing.assert_allclose(
        facts["pushed"] * np.cumsum(pushed), force, atol=0.51 * facts["pushed"]
    )
    assert described()["pushed"] == 1.0


def test_a_loop_that_continues_a_motion_starts_with_its_contact():
    facts = described(start=experiment.Start(0.02, 0.05, 0.0, effort=6.0))
    assert (facts["effortBefore"], facts["begin"][:2]) == (6.0, [(0, 0.02), (1, 0.05)])
    places = [place for place, _ in facts["begin"]]
    assert places == sorted(set(places))
    bristle_bent = [number for _, number in facts["begin"][2:] if number]
    assert any(0.5 < number / (5.0 / 1e5) < 1.5 for number in bristle_bent)
    assert len(described(start=experiment.Start(0.02))["begin"]) == 2


def test_different_friction_of_the_axis_is_included():
    other = br.friction.coulomb(F_C=4.0)
    facts = described(friction=other)
    assert facts["body"]["values"] == facts["bodyValues"] == {"F_C": [4.0]}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"plant": br.plants.oscillator(M=2.0, c=1.0, k=1e3)}, "more than one mass"),
        (
            {"friction": br.friction.find("coulomb+transmitted")(F_C=5.0, c_T=0.2)},
            "rises with the effort",
        ),
        (
            {"feedforward": Feedforward(friction=FRICTION, gain=0.5)},
            "the feedforward contains more than this friction",
        ),
        (
            {"feedforward": Feedforward(friction=FRICTION, along="measured")},
            "the feedforward contains more than this friction",
        ),
        (
            {"feedforward": Feedforward(friction=br.friction.coulomb(F_C=5.0))},
            "the feedforward contains more than this friction",
        ),
    ],
)
def test_uncomputable_loops_are_reported(changes, words):
    facts, reason = loop.loop_described(variant(**changes), FRICTION)
    assert facts is None
    assert words in reason


def test_a_following_error_is_some_of_its_samples():
    time = 2.0 + DT * np.arange(100)
    error = 1e-6 * np.sin(np.arange(100.0))
    samples = np.array([0, 3, 7, 50, 99])
    trace = loop.trace_described("error", time, error, samples)
    assert (trace["count"], trace["time"], trace["sampleTime"]) == (5, 2.0, pytest.approx(DT))
    assert trace["step"] == pytest.approx(np.max(np.abs(error)) / 4096)
    places, values = whole(trace["numbers"], 5, 2)
    assert np.cumsum(np.cumsum(places)).tolist() == samples.tolist()
    np.testing.assert_allclose(
        trace["step"] * np.cumsum(values), error[samples], atol=0.51 * trace["step"]
    )
    assert loop.trace_described("error", time, 0.0 * error, samples)["step"] == 1.0


def test_the_loop_of_the_page_has_the_numbers_of_the_experiment():
    plain, observing = (
        {variant.name: variant for variant in paper_experiment().variants}[name]
        for name in ("none", "observer")
    )
    data = loop.tracking_described(plain, observing)
    assert (data["sampleTime"], data["delay"]) == (plain.run.sample_time, plain.run.delay)
    assert data["paper"] == {
        "K_2": plain.controller.values["K_2"],
        "g": observing.controller.values["g"],
        "frequency": plain.reference.values["frequency"],
    }
    assert set(data["parts"]) >= {"sliding", "observer"}


@pytest.mark.parametrize(
    ("first", "place"), [("dahl", 1), (br.friction.lugre(**br.friction.lugre.example), 0)]
)
def test_a_page_begins_with_a_model_by_name_or_with_values(monkeypatch, first, place):
    monkeypatch.setattr(switches, "MODELS", ("coulomb", "dahl"))
    monkeypatch.setattr(
        switches, "example_described", lambda name: {"name": name, "kind": "translational"}
    )
    monkeypatch.setattr(
        switches,
        "switched",
        lambda model, **options: {"name": model.name, "kind": "rotational"} | options,
    )
    monkeypatch.setattr(switches, "common_described", dict)
    monkeypatch.setattr(switches, "slots_described", lambda kind: kind)
    data = json.loads(unpacked(switches.lab_described(first, {"moved": 1}, named="a file")["code"]))
    names = [row["name"] for row in data["models"]]
    assert (data["first"], data["loop"]) == (place, {"moved": 1})
    assert names == (
        ["coulomb", "dahl"] if isinstance(first, str) else ["lugre", "coulomb", "dahl"]
    )
    assert list(data["slots"]) == (
        ["translational"] if isinstance(first, str) else ["rotational", "translational"]
    )


# --- Numbers and data on their way to a page


def test_bytes_are_restored_and_may_refer_to_earlier_bytes():
    content = bytes(range(256)) * 8
    assert unpacked(packed(content)) == content
    assert len(packed(content, content)) < len(packed(content))


@pytest.mark.parametrize("times", [0, 1, 2])
def test_differences_are_summed_up_again(times):
    numbers = np.array([3.0, 5.0, 4.0, 4.0, -7.0])
    back = differences(numbers, times)
    for _ in range(times):
        back = np.cumsum(back)
    assert back.tolist() == numbers.tolist()
    assert differences(np.arange(1.0, 9.0), 2)[1:].tolist() == [0.0] * 7


def test_small_numbers_of_either_sign_have_small_bytes():
    parts = [np.array([0.0, -1.0, 1.0, -2.0]), np.array([127.0, -128.0, 40_000.0, -(2.0**31)])]
    message = packed_numbers(parts)
    (back,) = whole(message, 8, 1)
    assert back.tolist() == np.concatenate(parts).tolist()
    planes = np.frombuffer(unpacked(message["code"]), dtype=np.uint8).reshape(4, 8)
    assert planes[1:, :6].tolist() == [[0] * 6] * 3
    assert packed_numbers([])["count"] == 0


def test_data_of_a_page_end_no_element_and_have_words_for_infinity():
    assert as_json({"a": "</script>", "b": (1, math.inf), "c": [-math.inf, 0.5]}) == (
        '{"a":"\\u003c/script>","b":[1,"Infinity"],"c":["-Infinity",0.5]}'
    )
    assert plain({"a": None}) == {"a": None}


# --- Rows along which a model is led on a page: the turns between them


FORTH_AND_BACK = [0.0, 1.0, 3.0, 2.9, 4.0, 4.0, 1.0, 1.5, 0.0]


@pytest.mark.parametrize(
    ("x", "depth", "turns"),
    [
        (FORTH_AND_BACK, 0.0, [0, 2, 3, 5, 6, 7, 8]),
        (FORTH_AND_BACK, 0.3, [0, 5, 6, 7, 8]),
        (FORTH_AND_BACK, 1.0, [0, 5, 8]),
        ([0.0] * 5, 0.0, [0, 4]),
    ],
)
def test_turns_are_reversals_deeper_than_the_depth(x, depth, turns):
    assert rows.turns_of(np.array(x), depth).tolist() == turns


# --- The tracking loop of the page: laws, encoder and mass have the bits of the kernels, and go as a simulation does


COUNT, SAMPLE, DELAY, SUBSTEPS = 200, 5e-4, 1, 2
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
    t = SAMPLE * np.arange(COUNT + DELAY + 1)
    w = 2.0 * math.pi / (COUNT * SAMPLE)
    x = np.where(t < 0.02, 0.0, 3.0 * reach * (1.0 - np.cos(w * (t - 0.02))))
    v = np.where(t < 0.02, 0.0, 3.0 * reach * w * np.sin(w * (t - 0.02)))
    return {"x": x, "v": v, "a": np.gradient(v, SAMPLE)}


def controllers():
    variants = {variant.name: variant for variant in paper_experiment().variants}
    return {"sliding": variants["none"].controller, "observer": variants["observer"].controller}


def stepped(model, mass, controller, sensor, desired, message):
    """Return where the mass is and is read to be, by the kernels as they stand."""
    plant = br.plants.pulled_inertia(M=mass, k=0.0, v_e=0.0)
    q, p, c, s = plant.parameters, model.parameters, controller.parameters, sensor.parameters
    state, reading = model.component.initial_state(p), sensor.component.initial_state(s)
    now = Mechanism(plant.component.initial_state(q), state, 0.0, 0.0, 0.0, 0.0, 0.0)
    memory, commands, kept = model.component.new_memory(p), [], None
    x, read = [], []
    for k in range(COUNT):
        x.append(now.plant.x)
        measured, reading = sensor.component.step(reading, now.plant.x, SAMPLE, s)
        read.append(measured)
        at = [float(desired[name][k]) for name in "xva"]
        kept = (
            controller.component.start(measured, at[1], at[2], SAMPLE, c) if kept is None else kept
        )
        effort, kept = law(kept, Reference(*at, float(message[k])), measured, 0.0, 1e300, SAMPLE, c)
        commands.append(effort)
        applied = commands[k - DELAY] if k >= DELAY else 0.0
        for _ in range(SUBSTEPS):
            after = mechanism(now, memory, applied, applied, 0.0, 0.0, SAMPLE / SUBSTEPS, 1, q, p)
            now = Mechanism(
                after.plant, after.friction, after.effort, after.slope, after.acceleration, 0.0, 0.0
            )
    return np.array(x), np.array(read)


@pytest.mark.fast_cases(1)
@needs_node
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
        "DT": SAMPLE,
        "DELAY": DELAY,
        "FEEDS": json.dumps(feeds),
        "DESIRED": json.dumps({key: column.tolist() for key, column in desired.items()}),
        "VALUES": json.dumps(values | {key: sensor.values[key] for key in ("resolution", "noise")}),
    }
    script = "\n".join([*(f"const {word} = {text};" for word, text in argument.items()), RUN])
    message, x, read = node(tmp_path, [plain(model_described(model, named="m"))], script)
    controller = controller.with_values(**values)
    # What is fed forward has the bits of the engine, rests too.
    wanted = feedforward_effort(Feedforward(friction=model), desired["x"], desired["a"], SAMPLE)
    assert message == wanted[:-1].tolist()
    fed = wanted[DELAY:] if feeds else np.zeros(COUNT)
    custom, own_read = stepped(model, mass, controller, sensor, desired, fed)
    assert x == custom.tolist()
    assert read == own_read.tolist()
    # And all of it is the course of a simulation.
    reference = np.stack((*(desired[key][:COUNT] for key in "xva"), fed[:COUNT]))
    trace = br.engine.run_closed_loop(
        br.plants.inertia(M=mass),
        model,
        controller,
        sensor,
        reference,
        SAMPLE,
        steps=SUBSTEPS,
        delay=DELAY,
    )
    assert np.max(np.abs(x)) > 1e-6
    # Solves end within their tolerance, and a count of the encoder may fall the other way.
    assert np.max(np.abs(trace.position - x)) < 0.02 * np.ptp(x)


@pytest.mark.slow
@needs_node
def test_the_rig_of_the_paper_has_the_same_error_on_the_page(tmp_path):
    variants = {variant.name: variant for variant in paper_experiment().variants}
    plain_loop, observing = variants["none"], variants["observer"]
    law_values, motion = plain_loop.controller.values, plain_loop.reference.values
    settings = {
        "M": plain_loop.plant.values["M"],
        "gain": law_values["lambda_"],
        "K_2": law_values["K_2"],
    }
    settings |= {
        "g": observing.controller.values["g"],
        "resolution": plain_loop.sensor.values["resolution"],
    }
    settings |= {"A": max(motion["amplitudes"]), "f": motion["frequency"]}
    script = f"""
    const loop = {json.dumps(plain(paper_loop()))}, body = loop.rig, settings = {json.dumps(settings)};
    const values = Object.fromEntries(models[0].variables.map(({{ name, values }}) => [name, numbersOf(values)]));
    const {{ errors, period }} = await tracked(
      {{ loop, model: models[0], values, body, bodyValues: body.values, settings }});
    const width = (values) => Math.max(...values) - Math.min(...values);
    say([period, ...["none", "observer"].map((way) => width(errors[way]))]);
    """
    period, none, observer = node(
        tmp_path, [plain(model_described(example_named("lugre"), named="m"))], script
    )
    assert period == 8000
    # Six runs of the experiment, of amplitudes up to this one: 1.47 and 0.2 um peak to peak.
    assert none == pytest.approx(1.47e-6, rel=0.15)
    assert observer < 0.3 * none


# --- Lines as they are drawn: of few corners, and close to each point


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
    "there and back, further out each time": np.column_stack(
        (TURN * 30.0 * np.sin(6.0 * TURN), np.zeros(TURN.size))
    ),
    "a corner at each point": np.column_stack((np.arange(200.0), 40.0 * (np.arange(200) % 2))),
    "a spiral into a point": np.column_stack((np.cos(9.0 * TURN), np.sin(9.0 * TURN)))
    * (80.0 - 12.7 * TURN)[:, None],
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
    return np.min(
        np.linalg.norm(points[:, None] - (start + part[..., None] * along), axis=2), axis=1
    )


@needs_node
@pytest.mark.slow
@pytest.mark.parametrize("name", LINES)
def test_no_point_is_further_from_the_line_than_a_fifth_of_a_pixel(name, tmp_path):
    points = LINES[name]
    line = corners(points, tmp_path)
    assert np.array_equal(line[[0, -1]], points[[0, -1]])
    assert np.max(off(points[::7], line)) <= 1.05 * NEAR
    # Nor does the line lead where no point is.
    assert np.max(off(line, points[:1].repeat(2, axis=0) if len(points) == 1 else points)) <= 1e-9


@pytest.mark.slow
@needs_node
def test_a_loop_of_20_000_samples_has_few_corners(tmp_path):
    assert len(corners(LINES["a loop"], tmp_path)) < 250
    assert len(corners(LINES["there and back, further out each time"], tmp_path)) < 30
