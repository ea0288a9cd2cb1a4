"""Variants: what an override replaces, which path is told, what a recorded signal and a run become."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from bristle.core.axis import Axis
from bristle.core.errors import InputError
from bristle.core.experiment import Run
from bristle.files import read_experiment, variant
from bristle.files.sources import Sources
from bristle.files.variant import Tables, effort_from, effort_variables, merged, run_from, variables_of_section
from bristle.references import recorded, sine

SINE = sine(amplitude=1e-3, frequency=1.0)


def test_an_override_replaces_the_keys_that_it_names():
    base = {"run": {"duration": 1.0, "delay": 2}, "friction": {"model": "coulomb", "F_C": 3.0}}
    assert merged(base, {"run": {"delay": 0}}) == {**base, "run": {"duration": 1.0, "delay": 0}}
    assert merged(base, {"run": 3}) == {**base, "run": 3}
    assert base["run"]["delay"] == 2


@pytest.mark.parametrize("key", ["model", "file", "identified"])
def test_parameters_belong_to_the_model_that_was_named_with_them(key):
    base = {"model": "lugre", "F_C": 3.0, "feedforward": {"gain": 0.5}}
    assert merged(base, {key: "other"}) == {key: "other", "feedforward": {"gain": 0.5}}
    assert merged(base, {"F_C": 4.0}) == {**base, "F_C": 4.0}


def test_the_path_of_an_overridden_key_is_in_the_override():
    tables = Tables({"run": {"delay": 1}}, {"run": {"delay": 1}, "sensor": 3}, "compare.fast")
    assert tables.path("run") == "compare.fast.run"
    assert tables.path("run", "delay") == "compare.fast.run.delay"
    assert tables.path("run", "seeds") == "run.seeds"
    assert tables.path("sensor", "noise") == "sensor.noise"
    assert tables.path("plant") == "plant"
    assert (tables.table("run"), tables.table("plant")) == ({"delay": 1}, {})


def run(sample_time, duration):
    return Run(duration, sample_time)


def test_a_recorded_signal_is_constant_over_finer_samples_and_cut_at_the_end():
    values = np.array([1.0, 2.0, 3.0, 4.0])
    assert variant._repeated(values, 0.01, run(0.005, 0.03), "it", "run.duration", "x").tolist() == [1.0, 1.0, 2.0, 2.0, 3.0, 3.0]
    assert variant._repeated(values, 0.01, run(0.02, 0.04), "it", "run.duration", "x").tolist() == [1.0, 3.0]
    assert variant._repeated(values, 0.01, run(0.01, 0.04), "it", "run.duration", "x").tolist() == values.tolist()
    with pytest.raises(InputError, match=r"run\.duration.*is longer than the log, 0\.04 s.*Remove duration"):
        variant._repeated(values, 0.01, run(0.01, 0.05), "the log", "run.duration", "Remove duration")


def test_a_run_gets_missing_values_from_its_axis():
    axis = Axis(kind="translational", effort_limit=200.0, lag=3e-4, sample_time=5e-4)
    result = run_from({"duration": "2 s"}, axis, SINE, "translational", "run")
    assert (result.duration, result.sample_time, result.effort_limit, result.current_lag) == (2.0, 5e-4, 200.0, 3e-4)
    custom = run_from({"duration": 2, "sample_time": "1 ms", "effort_limit": "50 N", "current_lag": 0}, axis, SINE, "translational", "run")
    assert (custom.sample_time, custom.effort_limit, custom.current_lag) == (1e-3, 50.0, 0.0)
    bare = run_from({"duration": 2, "sample_time": "1 ms"}, None, SINE, "translational", "run")
    assert (bare.effort_limit, bare.current_lag) == (math.inf, 0.0)


def test_a_recorded_reference_brings_its_time():
    reference = recorded(position=np.zeros(50), sample_time=0.01)
    result = run_from({}, None, reference, "translational", "run")
    assert (result.duration, result.sample_time) == (0.5, 0.01)
    assert run_from({"duration": 0.2}, None, reference, "translational", "run").duration == 0.2


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"duration": 2e-3, "sample_time": 1e-3}, r"run\.duration.*gives 2 samples at a sample time of 0\.001 s.*3 to"),
        ({"duration": 1e9, "sample_time": 1e-3}, r"gives 1e\+12 samples"),
        ({"duration": 1.0, "sample_time": 1e-3, "settle": 1.0}, r"run\.settle.*is not shorter than the run.*less than the duration, 1 s"),
        ({"duration": 1.0, "sample_time": 1e-3, "delay": 1.5}, r"run\.delay"),
        ({"duration": 1.0}, "run: needs sample_time"),
        ({"duration": 1.0, "sample_time": 1e-3, "steps": 3}, r"run\.steps"),
    ],
)
def test_a_run_that_cannot_be_is_refused_with_its_place(table, words):
    with pytest.raises(InputError, match=words):
        run_from(table, None, SINE, "translational", "run")
    assert run_from({"duration": 3e-3, "sample_time": 1e-3}, None, SINE, "translational", "run").duration == 3e-3


RUN = Run(0.04, 0.01)


def test_an_open_loop_is_driven_by_a_level_a_function_or_a_log():
    level = effort_from({"model": "constant", "level": "3 N"}, None, RUN, "translational", "effort")
    assert (level.values.tolist(), level.description) == ([3.0] * 4, "constant, level = 3 N")
    none = effort_from({"model": "constant"}, None, RUN, "translational", "effort")
    assert (none.values.tolist(), none.description) == ([0.0] * 4, "none")
    wave = effort_from({"model": "sine", "amplitude": "2 N", "frequency": "25 Hz"}, None, RUN, "translational", "effort")
    assert wave.values == pytest.approx([0.0, 2.0, 0.0, -2.0], abs=1e-12)
    assert wave.description == "sine, amplitude = 2 N, frequency = 25 Hz"
    log = SimpleNamespace(effort=SimpleNamespace(values=np.arange(4.0)), sample_time=0.01)
    record = effort_from({"model": "recorded", "file": "log.csv"}, log, RUN, "translational", "effort")
    assert (record.values.tolist(), record.description) == ([0.0, 1.0, 2.0, 3.0], "effort of log.csv")


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({}, "effort: names no model"),
        ({"model": "sinus"}, r"effort\.model.*sine"),
        ({"model": "constant", "amplitude": 1.0}, r"effort\.amplitude"),
        ({"model": "sine", "level": 1.0}, r"effort\.level"),
        ({"model": "sine", "amplitude": "2 mm"}, r"effort\.amplitude"),
    ],
)
def test_an_unknown_effort_is_refused_with_its_place(table, words):
    with pytest.raises(InputError, match=words):
        effort_from(table, None, RUN, "translational", "effort")


def test_lengths_of_a_function_of_time_are_forces_of_an_effort():
    assert {name: item.quantity for name, item in effort_variables("sine").items()}["amplitude"] == "force"
    assert {name: item.quantity for name, item in effort_variables("sine").items()}["frequency"] == "frequency"
    assert list(effort_variables("constant")) == ["level"]
    assert effort_variables("recorded") == effort_variables(3) == {}


def test_sections_of_a_variant_have_their_own_values():
    closed, learning = SimpleNamespace(effort=None, learning=None), SimpleNamespace(effort=None, learning=object())
    driven = SimpleNamespace(effort=object(), learning=None)
    data = {"effort": {"model": "sine"}}
    assert variables_of_section("effort", driven, data) == effort_variables("sine")
    assert variables_of_section("effort", closed, data) is None
    assert "duration" in variables_of_section("run", driven, data)
    assert "gain" in variables_of_section("controller.feedforward", closed, data)
    assert variables_of_section("controller.feedforward", driven, data) is None
    assert "trials" in variables_of_section("controller.learning", learning, data)
    assert variables_of_section("controller.learning", closed, data) is None
    assert variables_of_section("plant", closed, data) is None


def test_the_axis_section_has_only_a_file(tmp_path):
    with pytest.raises(InputError, match=r"axis\.fil: unknown key"):
        variant.variant_from("x", Tables({"axis": {"file": "a.toml", "fil": 1}}), Sources(tmp_path, False))


LOOP = {
    "schema": 1,
    "kind": "translational",
    "plant": {"M": 20.0},
    "friction": {"model": "coulomb", "F_C": 3.0},
    "controller": {"model": "cascade", "k_p": 40.0, "k_v": 900.0},
    "reference": {"model": "sine", "amplitude": 1e-3, "frequency": 1.0},
    "run": {"duration": 1.0, "sample_time": 1e-3},
}
LEARNED = {"trials": 3, "k_e": 10.0, "cutoff": 20.0}


def loop(**changed):
    return read_experiment(LOOP | changed).variants[0]


def test_a_loop_has_the_given_learning_and_start():
    learning = loop(controller=LOOP["controller"] | {"learning": LEARNED}).learning
    assert (learning.trials, learning.k_e, learning.k_d, learning.cutoff) == (3, 10.0, 0.0, 20.0)
    start = loop(start={"position": "1 mm", "effort": "2 N"}).start
    assert (start.position, start.velocity, start.effort) == (1e-3, 0.0, 2.0)
    assert loop().learning is None
    assert loop().start is None


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"controller": LOOP["controller"] | {"learning": LEARNED | {"k_f": 1.0}}}, r"controller\.learning\.k_f: unknown key"),
        ({"start": {"position": 0.0, "jerk": 1.0}}, r"start\.jerk: unknown key"),
        ({"start": {"velocity": 0.0}}, "start: needs position"),
        ({"controller": LOOP["controller"] | {"feedforward": {"masses": 1.0}}}, r"controller\.feedforward\.masses: unknown key"),
        ({"controller": LOOP["controller"] | {"feedforward": {"friction": "coulomb"}}}, r"feedforward\.friction: must be a table"),
        ({"controller": LOOP["controller"] | {"feedforward": {"along": "there"}}}, r"feedforward\.along"),
        ({"controller": LOOP["controller"] | {"feedforward": {"plant": "other"}}}, r"feedforward\.plant"),
        ({"effort": {"model": "constant"}}, "controller: needs a closed loop"),
        ({"table_friction": {"model": "coulomb", "F_C": 1.0}}, "table_friction: needs a plant with a screw that moves a table"),
        ({"plant": {}}, r"plant: is missing.*model = .inertia. and M"),
        ({"sensor": {"side": "left"}}, r"sensor\.side: no such side"),
        ({"disturbance": {"fil": 1}}, r"disturbance\.fil: unknown key"),
    ],
)
def test_a_section_that_cannot_be_is_refused_with_its_place(changed, words):
    with pytest.raises(InputError, match=words):
        loop(**changed)


def test_a_compensator_has_the_given_options():
    fed = {"mass": 20.0, "friction": {"model": "coulomb", "F_C": 2.0}, "gain": 0.5, "along": "measured"}
    feedforward = loop(controller=LOOP["controller"] | {"feedforward": fed}).feedforward
    assert (feedforward.mass, feedforward.gain, feedforward.along, feedforward.friction.values["F_C"]) == (20.0, 0.5, "measured", 2.0)
    assert feedforward.plant is None
    custom = loop(controller=LOOP["controller"] | {"feedforward": {"plant": "own"}}).feedforward
    assert custom.plant.values["M"] == 20.0
    assert loop(controller=LOOP["controller"] | {"feedforward": {"friction": "none", "offset": 1.0}}).feedforward.friction is None
