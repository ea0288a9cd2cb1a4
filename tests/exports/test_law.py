"""Laws of control in samples: what they are told, what is fed forward, and what they say of it."""

import math
from collections.abc import Mapping

import numpy as np
import pytest

import bristle as br
from bristle.core.errors import InputError
from bristle.core.experiment import Effort, Feedforward, Learning, Run, Variant
from bristle.exports.c import law_files
from bristle.exports.described import Source
from bristle.exports.fmu_content import content_of_law
from bristle.exports.law import Inputs, law_facts, law_of, law_walk
from bristle.exports.law_text import Gravity, Load, loads_of
from bristle.exports.st import st_law_files
from bristle.exports.tunable import settled_law

M, DT = 2.0, 1e-3
COULOMB = br.friction.with_slots(br.friction.coulomb, [])(F_C=5.0, offset=0.5)
RISEN = br.friction.find("coulomb+transmitted")(F_C=5.0, c_T=0.2)
LINK = br.plants.find("inertia+gravity")(M=3.0, g_sin=4.0, g_cos=1.0)
LUGRE = br.friction.lugre(F_C=5.0, F_S=6.0, v_S=1e-2, sigma_0=1e5)


def variant(feedforward=None, delay=0, limit=math.inf, **changes):
    parts = {
        "name": "loop",
        "plant": br.plants.inertia(M=M),
        "friction": COULOMB,
        "controller": br.controllers.cascade(k_p=20.0, k_v=30.0),
        "sensor": br.sensors.encoder(resolution=0.0),
        "reference": br.references.recorded(position=np.zeros(100), sample_time=DT),
        "feedforward": feedforward or Feedforward(),
        "run": Run(0.1, DT, delay=delay, effort_limit=limit),
    }
    return Variant(**parts | changes)


def fed(reported, delay=0, **feedforward):
    """Return the inputs of a law, and what its feedforward adds at each sample."""
    law, plain = (law_of(variant(each, delay=delay)) for each in (Feedforward(**feedforward), None))
    return law.inputs, law.efforts(reported) - plain.efforts(reported)


def at_rest(ahead, a=0.0, a_ahead=0.0, measured=0.0):
    """A sample at 0, with the positions and accelerations of the next ones."""
    return Inputs(0.0, 0.0, a, measured, np.array(ahead), np.full(len(ahead), a_ahead))


def test_inertia_is_fed_forward_as_the_mean_of_two_samples():
    inputs, efforts = fed([at_rest([0.0], a, a + 1.0) for a in (0.0, 1.0, 2.0)], mass=M)
    assert inputs == ("position", "velocity", "acceleration", "measured", "acceleration_ahead")
    assert efforts == pytest.approx([1.0, 3.0, 5.0])


@pytest.mark.parametrize("delay", [0, 2])
def test_friction_along_the_desired_motion_leads_by_the_delay(delay):
    x = np.array([0.0, 0.0, 0.0, 0.0, 1e-4, 2e-4, 1e-4, 0.0, -1e-4, -2e-4])
    _, efforts = fed([at_rest(x[k + 1 : k + 2 + delay]) for k in range(6)], delay, friction=COULOMB)
    ways = np.sign(np.diff(x))[delay : delay + 6]
    assert efforts[ways != 0.0] == pytest.approx(5.0 * ways[ways != 0.0] + 0.5)


def test_friction_along_the_measured_motion_needs_no_samples_ahead():
    reported = [at_rest(np.zeros(3), measured=x) for x in (0.0, 1e-4, 2e-4, 1e-4)]
    inputs, efforts = fed(reported, 2, friction=COULOMB, along="measured")
    assert inputs == ("position", "velocity", "acceleration", "measured")
    assert efforts[1:] == pytest.approx([5.5, 5.5, -4.5])


@pytest.mark.parametrize(
    ("way", "shape", "force"),
    [
        (1.0, {}, 5.5),
        (1.0, {"gain": 0.5}, 2.75),
        (1.0, {"gain": 0.5, "offset": 1.0}, 3.75),
        (1.0, {"limit": 3.0}, 3.0),
        (-1.0, {"limit": 3.0}, -3.0),
        (1.0, {"asymmetry": 0.2}, 5.5 * 1.2),
        (-1.0, {"asymmetry": 0.2}, -4.5 * 0.8),
    ],
)
def test_gain_asymmetry_and_limit_shape_the_feedforward(way, shape, force):
    x = way * 1e-4 * np.arange(7)
    reported = [Inputs(x[k], way * 0.1, 0.0, x[k], x[k + 1 : k + 2], np.zeros(1)) for k in range(5)]
    assert fed(reported, friction=COULOMB, **shape)[1][-1] == pytest.approx(force)


def test_a_drive_limits_the_effort():
    far = [Inputs(1.0, 0.0, 0.0, 0.0, np.ones(1), np.zeros(1))] * 3
    assert law_of(variant(limit=7.0)).efforts(far) == pytest.approx([7.0] * 3)
    assert law_of(variant()).efforts(far)[-1] > 100.0


def test_gravity_acts_at_the_middle_of_two_samples():
    load, carried = loads_of(Feedforward(plant=LINK))
    assert load is carried
    assert (load.place, load.numbers) == (Gravity(4.0, 1.0), (0.0, 4.0, 1.0))
    _, gravity = fed([Inputs(0.2, 0.0, 0.0, 0.2, np.array([0.4]), np.zeros(1))], plant=LINK)
    assert gravity == pytest.approx([4.0 * math.sin(0.3) + math.cos(0.3)])


def test_friction_transmits_the_feedforward_or_the_carried_plant():
    fed, carried = loads_of(Feedforward(mass=M, friction=RISEN, carries=LINK))
    assert (fed.prefix, fed.mass, carried.prefix, carried.mass) == ("", M, "carried_", 3.0)
    with pytest.raises(InputError, match="has forces besides inertia, gravity, cogging and a spring"):
        loads_of(Feedforward(friction=RISEN, carries=br.testing.example_of(br.plants.oscillator)))
    assert Load("", 0.0, None).text("", "0") == "0.0"


SAME = br.plants.inertia(M=M)


@pytest.mark.parametrize(
    ("feedforward", "apart", "prefix"),
    [
        ({"mass": M, "friction": RISEN}, False, ""),
        ({"mass": M, "friction": RISEN, "carries": SAME}, False, ""),
        ({"mass": M, "friction": RISEN, "carries": SAME}, True, "carried_"),
        ({"mass": M, "friction": COULOMB, "carries": LINK}, False, ""),
    ],
)
def test_a_carried_plant_is_that_of_the_feedforward_if_they_are_equal(feedforward, apart, prefix):
    fed, carried = loads_of(Feedforward(**feedforward), apart=apart)
    assert carried.prefix == prefix
    assert (carried is fed) == (prefix == "")


def test_a_compensator_with_a_past_starts_with_the_memory_of_a_sweep():
    fresh, worn = (law_of(variant(Feedforward(friction=LUGRE, conditioning=size))) for size in (0.0, 1e-3))
    assert float(fresh.lasting.fed.state.z) == 0.0
    assert worn.lasting.fed.state == br.engine.conditioned(LUGRE, 1e-3)[0]


def test_leaves_are_all_numbers_of_the_state_in_order():
    law = law_of(variant(Feedforward(friction=LUGRE)))
    paths = [".".join(path) for path, _ in law.leaves]
    assert paths[-3:] == ["fed.state.z", "fed.place", "fed.effort"]
    assert all(path.startswith(("controller.", "fed.")) for path in paths)
    assert law.memory_size == law.memory.size
    assert law.dt == DT


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"effort": Effort(np.zeros(100))}, "drives an open loop"),
        ({"learning": Learning(2, 1.0, 0.0, 20.0)}, "needs repetitions of the whole motion"),
    ],
)
def test_variants_without_a_law_are_refused(changes, words):
    with pytest.raises(InputError, match=words):
        law_of(variant(**changes))


def test_facts_of_a_law_list_feedforward_and_samples_ahead():
    facts = law_facts(law_of(variant(Feedforward(mass=M, friction=COULOMB, gain=0.5), delay=2, limit=9.0)), "axis_x", Source())
    assert facts["fed"] == ["inertia along the desired motion: 2 kg", "friction along the desired motion by coulomb, gain 0.5"]
    assert (facts["ahead"], facts["delay"], facts["limit"], facts["rate"]) == (3, 2, "9", "1000")
    assert [(entry["declared"], entry["unit"], entry["several"]) for entry in facts["inputs"]] == [
        ("position", "m", False),
        ("velocity", "m/s", False),
        ("acceleration", "m/s^2", False),
        ("measured", "m", False),
        ("place_ahead[3]", "m", True),
        ("acceleration_ahead[3]", "m/s^2", True),
    ]


@pytest.mark.parametrize(
    ("feedforward", "first", "last"),
    [
        ({}, "nothing", "nothing"),
        (
            {"friction": RISEN, "plant": LINK, "carries": LINK},
            "position-dependent effort of inertia+gravity",
            "that inertia+gravity transmits along the desired motion",
        ),
        ({"mass": M, "friction": RISEN}, "inertia", "that the rest of the feedforward transmits along the desired motion"),
    ],
)
def test_facts_of_a_law_state_what_is_transmitted(feedforward, first, last):
    lines = law_facts(law_of(variant(Feedforward(**feedforward))), "axis_x", Source())["fed"]
    assert lines[0].startswith(first)
    assert lines[-1].endswith(last)


def test_the_self_test_measures_each_position_one_sample_late():
    law = law_of(variant(Feedforward(mass=M, friction=COULOMB)))
    walk, reported, efforts = law_walk(law, 40)
    assert reported == 40 + law.samples_ahead + 1
    assert efforts.shape == (40,)
    x = walk.positions(reported)
    v = np.diff(x) / DT
    first = Inputs(x[0], v[0], 100.0 * v[0], x[0], x[1:2], 100.0 * v[1:2])
    second = Inputs(x[1], v[1], 100.0 * v[1], x[0], x[2:3], 100.0 * v[2:3])
    assert law.efforts([first, second]) == pytest.approx(efforts[:2])


LAW, TUNABLE = (law_of(variant(Feedforward(mass=2.0)), tunable=tunable) for tunable in (False, True))


def length(text) -> int:
    return sum(map(len, text.values())) if isinstance(text, Mapping) else len(text)


@pytest.mark.parametrize("write", [law_files, st_law_files], ids=["c", "st"])
def test_folding_earlier_or_later_gives_the_same_law(write):
    assert write(LAW, "axis_x", Source()) == write(settled_law(LAW), "axis_x", Source())


@pytest.mark.parametrize("write", [law_files, st_law_files], ids=["c", "st"])
def test_a_law_with_variable_parameters_is_longer(write):
    assert length(write(TUNABLE, "axis_x", Source())) > length(write(LAW, "axis_x", Source()))


def test_folding_earlier_or_later_gives_the_same_fmu_of_a_law():
    texts = [printed(content_of_law(law, "axis_x", Source()).unit) for law in (TUNABLE, settled_law(TUNABLE))]
    assert texts[0] == texts[1]


def printed(unit) -> str:
    """Every function of a unit, as its tree has it."""
    return "\n".join(repr((function.name, function.parameters, function.body)) for function in unit.functions)
