"""Loops as a page computes them: what they begin with, what pushes them, and which it cannot."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import bristle as br
from bristle.core.experiment import Feedforward, Run, Start, Variant
from bristle.exports.page import loop, rows, switches
from bristle.exports.page.packing import as_json, differences, packed, packed_numbers, plain, unpacked
from bristle.friction import lugre
from bristle.lab.page import paper_experiment

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
    return np.split(np.where(folded % 2 == 0, folded // 2, -(folded + 1) // 2), [count] * (parts - 1))


def described(**changes):
    facts, reason = loop.loop_described(variant(**changes), FRICTION)
    assert reason == ""
    return facts


def test_a_page_has_the_numbers_of_the_loop():
    facts = described()
    expected = {"M": 2.0, "mass": 1.5, "count": 400, "all": 400, "settle": 100, "substeps": 5, "delay": 1, "limit": 90.0, "sampleTime": DT}
    expected |= {"effortBefore": 0.0, "body": None, "lag": {"inMean": 0.0, "atEnd": 0.0}}
    expected |= {"begin": [(0, pytest.approx(0.02)), (1, pytest.approx(0.01 * 2.0 * np.pi, rel=1e-3))]}
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
    np.testing.assert_allclose(facts["pushed"] * np.cumsum(pushed), force, atol=0.51 * facts["pushed"])
    assert described()["pushed"] == 1.0


def test_a_loop_that_continues_a_motion_starts_with_its_contact():
    facts = described(start=Start(0.02, 0.05, 0.0, effort=6.0))
    assert (facts["effortBefore"], facts["begin"][:2]) == (6.0, [(0, 0.02), (1, 0.05)])
    places = [place for place, _ in facts["begin"]]
    assert places == sorted(set(places))
    bristle_bent = [number for _, number in facts["begin"][2:] if number]
    assert any(0.5 < number / (5.0 / 1e5) < 1.5 for number in bristle_bent)
    assert len(described(start=Start(0.02))["begin"]) == 2


def test_different_friction_of_the_axis_is_included():
    other = br.friction.coulomb(F_C=4.0)
    facts = described(friction=other)
    assert facts["body"]["values"] == facts["bodyValues"] == {"F_C": [4.0]}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"plant": br.plants.oscillator(M=2.0, c=1.0, k=1e3)}, "more than one mass"),
        ({"friction": br.friction.find("coulomb+transmitted")(F_C=5.0, c_T=0.2)}, "rises with the effort"),
        ({"feedforward": Feedforward(friction=FRICTION, gain=0.5)}, "the feedforward contains more than this friction"),
        ({"feedforward": Feedforward(friction=FRICTION, along="measured")}, "the feedforward contains more than this friction"),
        ({"feedforward": Feedforward(friction=br.friction.coulomb(F_C=5.0))}, "the feedforward contains more than this friction"),
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
    np.testing.assert_allclose(trace["step"] * np.cumsum(values), error[samples], atol=0.51 * trace["step"])
    assert loop.trace_described("error", time, 0.0 * error, samples)["step"] == 1.0


def test_the_loop_of_the_page_has_the_numbers_of_the_experiment():
    plain, observing = ({variant.name: variant for variant in paper_experiment().variants}[name] for name in ("none", "observer"))
    data = loop.tracking_described(plain, observing)
    assert (data["sampleTime"], data["delay"]) == (plain.run.sample_time, plain.run.delay)
    assert data["paper"] == {
        "K_2": plain.controller.values["K_2"],
        "g": observing.controller.values["g"],
        "frequency": plain.reference.values["frequency"],
    }
    assert set(data["parts"]) >= {"sliding", "observer"}


@pytest.mark.parametrize(("first", "place"), [("dahl", 1), (lugre(**lugre.example), 0)])
def test_a_page_begins_with_a_model_by_name_or_with_values(monkeypatch, first, place):
    monkeypatch.setattr(switches, "MODELS", ("coulomb", "dahl"))
    monkeypatch.setattr(switches, "example_described", lambda name: {"name": name, "kind": "translational"})
    monkeypatch.setattr(switches, "switched", lambda model, **options: {"name": model.name, "kind": "rotational"} | options)
    monkeypatch.setattr(switches, "common_described", dict)
    monkeypatch.setattr(switches, "slots_described", lambda kind: kind)
    data = json.loads(unpacked(switches.lab_described(first, {"moved": 1}, named="a file")["code"]))
    names = [row["name"] for row in data["models"]]
    assert (data["first"], data["loop"]) == (place, {"moved": 1})
    assert names == (["coulomb", "dahl"] if isinstance(first, str) else ["lugre", "coulomb", "dahl"])
    assert list(data["slots"]) == (["translational"] if isinstance(first, str) else ["rotational", "translational"])


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
