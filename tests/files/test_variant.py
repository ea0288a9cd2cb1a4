"""Variants: what an override replaces, which path is told, what a recorded signal and a run become."""

import copy
import math
from types import SimpleNamespace

import numpy as np
import pytest

from bristle.core.axis import Axis
from bristle.core.errors import InputError
from bristle.core.experiment import Run
from bristle.files import read_experiment, variant
from bristle.files.variant import (
    Tables,
    effort_from,
    effort_variables,
    merged,
    run_from,
    variables_of_section,
)
from bristle.models.references import recorded, sine

SINE = sine(amplitude=1e-3, frequency=1.0)


OF_LUGRE = {"model": "lugre", "F_C": 3.0, "feedforward": {"gain": 0.5}}


@pytest.mark.parametrize(
    ("base", "override", "result"),
    [
        (
            {"run": {"duration": 1.0, "delay": 2}, "friction": 1},
            {"run": {"delay": 0}},
            {"run": {"duration": 1.0, "delay": 0}, "friction": 1},
        ),
        (
            {"run": {"duration": 1.0, "delay": 2}, "friction": 1},
            {"run": 3},
            {"run": 3, "friction": 1},
        ),
        # Parameters belong to the model that was named with them.
        *(
            (OF_LUGRE, {key: "other"}, {key: "other", "feedforward": {"gain": 0.5}})
            for key in ("model", "file", "identified")
        ),
        (OF_LUGRE, {"F_C": 4.0}, {**OF_LUGRE, "F_C": 4.0}),
    ],
)
def test_an_override_replaces_the_keys_that_it_names(base, override, result):
    before = copy.deepcopy(base)
    assert merged(base, override) == result
    assert base == before


def test_the_path_of_an_overridden_key_is_in_the_override():
    tables = Tables({"run": {"delay": 1}}, {"run": {"delay": 1}, "sensor": 3}, "compare.fast")
    keys = (("run",), ("run", "delay"), ("run", "seeds"), ("sensor", "noise"), ("plant",))
    paths = ["compare.fast.run", "compare.fast.run.delay", "run.seeds", "sensor.noise", "plant"]
    assert [tables.path(*key) for key in keys] == paths
    assert (tables.table("run"), tables.table("plant")) == ({"delay": 1}, {})


@pytest.mark.parametrize(
    ("duration", "sample_time", "samples"),
    [
        (0.03, 0.005, [1.0, 1.0, 2.0, 2.0, 3.0, 3.0]),
        (0.04, 0.02, [1.0, 3.0]),
        (0.04, 0.01, [1.0, 2.0, 3.0, 4.0]),
    ],
)
def test_a_recorded_signal_is_constant_over_finer_samples_and_cut_at_the_end(
    duration, sample_time, samples
):
    values = np.array([1.0, 2.0, 3.0, 4.0])
    assert (
        variant._repeated(
            values, 0.01, Run(duration, sample_time), "it", "run.duration", "x"
        ).tolist()
        == samples
    )
    with pytest.raises(
        InputError, match=r"run\.duration.*is longer than the log, 0\.04 s.*Remove duration"
    ):
        variant._repeated(
            values, 0.01, Run(0.05, 0.01), "the log", "run.duration", "Remove duration"
        )


AXIS = Axis(kind="translational", effort_limit=200.0, lag=3e-4, sample_time=5e-4)
RECORDED = recorded(position=np.zeros(50), sample_time=0.01)


@pytest.mark.parametrize(
    ("table", "axis", "reference", "expected"),
    [
        ({"duration": "2 s"}, AXIS, SINE, (2.0, 5e-4, 200.0, 3e-4)),
        (
            {"duration": 2, "sample_time": "1 ms", "effort_limit": "50 N", "current_lag": 0},
            AXIS,
            SINE,
            (2.0, 1e-3, 50.0, 0.0),
        ),
        ({"duration": 2, "sample_time": "1 ms"}, None, SINE, (2.0, 1e-3, math.inf, 0.0)),
        ({}, None, RECORDED, (0.5, 0.01, math.inf, 0.0)),
        ({"duration": 0.2}, None, RECORDED, (0.2, 0.01, math.inf, 0.0)),
        ({"duration": 3e-3, "sample_time": 1e-3}, None, SINE, (3e-3, 1e-3, math.inf, 0.0)),
    ],
)
def test_a_run_gets_missing_values_from_its_axis_or_its_recorded_reference(
    table, axis, reference, expected
):
    result = run_from(table, axis, reference, "translational", "run")
    assert (
        result.duration,
        result.sample_time,
        result.effort_limit,
        result.current_lag,
    ) == expected


RUN = Run(0.04, 0.01)


LOG = SimpleNamespace(effort=SimpleNamespace(values=np.arange(4.0)), sample_time=0.01)


@pytest.mark.parametrize(
    ("table", "values", "description"),
    [
        ({"model": "constant", "level": "3 N"}, [3.0] * 4, "constant, level = 3 N"),
        ({"model": "constant"}, [0.0] * 4, "none"),
        (
            {"model": "sine", "amplitude": "2 N", "frequency": "25 Hz"},
            pytest.approx([0.0, 2.0, 0.0, -2.0], abs=1e-12),
            "sine, amplitude = 2 N, frequency = 25 Hz",
        ),
        ({"model": "recorded", "file": "log.csv"}, [0.0, 1.0, 2.0, 3.0], "effort of log.csv"),
    ],
)
def test_an_open_loop_is_driven_by_a_level_a_function_or_a_log(table, values, description):
    log = LOG if table["model"] == "recorded" else None
    result = effort_from(table, log, RUN, "translational", "effort")
    assert (result.values.tolist(), result.description) == (values, description)


def test_lengths_of_a_function_of_time_are_forces_of_an_effort():
    quantities = {name: item.quantity for name, item in effort_variables("sine").items()}
    assert (quantities["amplitude"], quantities["frequency"]) == ("force", "frequency")
    assert [list(effort_variables(model)) for model in ("constant", "recorded", 3)] == [
        ["level"],
        [],
        [],
    ]


CLOSED, LEARNING = (
    SimpleNamespace(effort=None, learning=None),
    SimpleNamespace(effort=None, learning=object()),
)
DRIVEN = SimpleNamespace(effort=object(), learning=None)


@pytest.mark.parametrize(
    ("section", "of", "key"),
    [
        ("effort", DRIVEN, "amplitude"),
        ("effort", CLOSED, None),
        ("run", DRIVEN, "duration"),
        ("controller.feedforward", CLOSED, "gain"),
        ("controller.feedforward", DRIVEN, None),
        ("controller.learning", LEARNING, "trials"),
        ("controller.learning", CLOSED, None),
        ("plant", CLOSED, None),
    ],
)
def test_sections_of_a_variant_have_their_own_values(section, of, key):
    variables = variables_of_section(section, of, {"effort": {"model": "sine"}})
    assert variables is None if key is None else key in variables


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


FED = {"mass": 20.0, "friction": {"model": "coulomb", "F_C": 2.0}, "gain": 0.5, "along": "measured"}


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        (FED, (20.0, 0.5, "measured", {"F_C": 2.0}, None)),
        ({"plant": "own"}, (0.0, 1.0, "desired", None, {"M": 20.0})),
        ({"friction": "none", "offset": 1.0}, (0.0, 1.0, "desired", None, None)),
    ],
)
def test_a_compensator_has_the_given_options(table, expected):
    fed = loop(controller=LOOP["controller"] | {"feedforward": table}).feedforward
    models = [
        model and {name: model.values[name] for name in ("F_C", "M") if name in model.values}
        for model in (fed.friction, fed.plant)
    ]
    assert (fed.mass, fed.gain, fed.along, *models) == expected


@pytest.mark.parametrize(
    ("read", "table", "words"),
    [
        *(
            (lambda table: run_from(table, None, SINE, "translational", "run"), *row)
            for row in (
                (
                    {"duration": 2e-3, "sample_time": 1e-3},
                    r"run\.duration.*gives 2 samples at a sample time of 0\.001 s.*3 to",
                ),
                ({"duration": 1e9, "sample_time": 1e-3}, r"gives 1e\+12 samples"),
                (
                    {"duration": 1.0, "sample_time": 1e-3, "settle": 1.0},
                    r"run\.settle.*is not shorter than the run.*less than the duration, 1 s",
                ),
                ({"duration": 1.0, "sample_time": 1e-3, "delay": 1.5}, r"run\.delay"),
                ({"duration": 1.0}, "run: needs sample_time"),
                ({"duration": 1.0, "sample_time": 1e-3, "steps": 3}, r"run\.steps"),
            )
        ),
        *(
            (lambda table: effort_from(table, None, RUN, "translational", "effort"), *row)
            for row in (
                ({}, "effort: names no model"),
                ({"model": "sinus"}, r"effort\.model.*sine"),
                ({"model": "constant", "amplitude": 1.0}, r"effort\.amplitude"),
                ({"model": "sine", "level": 1.0}, r"effort\.level"),
                ({"model": "sine", "amplitude": "2 mm"}, r"effort\.amplitude"),
            )
        ),
        *(
            (lambda table: loop(**table), *row)
            for row in (
                (
                    {"controller": LOOP["controller"] | {"learning": LEARNED | {"k_f": 1.0}}},
                    r"controller\.learning\.k_f: unknown key",
                ),
                ({"start": {"position": 0.0, "jerk": 1.0}}, r"start\.jerk: unknown key"),
                ({"start": {"velocity": 0.0}}, "start: needs position"),
                (
                    {"controller": LOOP["controller"] | {"feedforward": {"masses": 1.0}}},
                    r"controller\.feedforward\.masses: unknown key",
                ),
                (
                    {"controller": LOOP["controller"] | {"feedforward": {"friction": "coulomb"}}},
                    r"feedforward\.friction: must be a table",
                ),
                (
                    {"controller": LOOP["controller"] | {"feedforward": {"along": "there"}}},
                    r"feedforward\.along",
                ),
                (
                    {"controller": LOOP["controller"] | {"feedforward": {"plant": "other"}}},
                    r"feedforward\.plant",
                ),
                ({"effort": {"model": "constant"}}, "controller: needs a closed loop"),
                (
                    {"table_friction": {"model": "coulomb", "F_C": 1.0}},
                    "table_friction: needs a plant with a screw that moves a table",
                ),
                ({"plant": {}}, r"plant: is missing.*model = .inertia. and M"),
                ({"sensor": {"side": "left"}}, r"sensor\.side: no such side"),
                ({"disturbance": {"fil": 1}}, r"disturbance\.fil: unknown key"),
                ({"axis": {"file": "a.toml", "fil": 1}}, r"axis\.fil: unknown key"),
            )
        ),
    ],
)
def test_a_section_that_cannot_be_is_refused_with_its_place(read, table, words):
    with pytest.raises(InputError, match=words):
        read(table)
