"""Experiments as they are described: defaults, ranges, and what does not go together."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from bristle import controllers, friction, plants, references, sensors
from bristle.core.errors import InputError
from bristle.core.experiment import (
    Effort,
    Experiment,
    Feedforward,
    Learning,
    Run,
    Start,
    Variant,
    substeps_for,
)


def variant(**changes):
    parts = {
        "name": "loop",
        "plant": plants.inertia(M=2.0),
        "friction": friction.coulomb(F_C=1.0),
        "controller": controllers.cascade(k_p=80.0, k_v=500.0),
        "sensor": sensors.encoder(resolution=0.0),
        "reference": references.recorded(position=np.zeros(100), sample_time=1e-3),
        "feedforward": Feedforward(),
        "run": Run(0.1, 1e-3),
    } | changes
    of_axis = {
        part: replace(parts[part], kind=parts["plant"].kind)
        for part in ("friction", "controller", "sensor", "reference")
    }
    return Variant(**parts | of_axis)


PLAIN = {
    "settle": 0.0,
    "delay": 0,
    "current_lag": 0.0,
    "seeds": 1,
    "tolerance": 0.0,
    "effort_limit": math.inf,
}
FED = {
    "mass": 0.0,
    "gain": 1.0,
    "offset": 0.0,
    "asymmetry": 0.0,
    "limit": math.inf,
    "rate_limit": math.inf,
    "conditioning": 0.0,
}


@pytest.mark.parametrize(
    ("described", "values"),
    [
        (
            Run(2.0, 1e-3),
            {
                "settle": 0.0,
                "delay": 0,
                "current_lag": 0.0,
                "seeds": 1,
                "tolerance": 0.0,
                "effort_limit": math.inf,
                "substeps": 4,
            },
        ),
        (Run(2.0, 1e-3, tolerance=1e-9), {"substeps": 0}),
        (Feedforward(), FED | {"along": "desired", "rest": "held", "friction": None}),
        (Start(0.5), {"velocity": 0.0, "acceleration": 0.0, "effort": None}),
    ],
)
def test_by_default_a_run_counts_from_its_first_sample_once_without_lag_limit_or_feedforward(
    described, values
):
    assert {name: getattr(described, name) for name in values} == values


EFFORT, LOOSE = Effort(np.zeros(100)), Run(0.1, 1e-3, tolerance=1e-9)
SCREW = plants.ball_screw(J=1e-4, M=20.0, lead=5e-3, k=1e8, kind="rotational")


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: Run(0.1, 1e-3, tolerance=1e-9, substeps=4), "determines the steps"),
        (lambda: variant(run=LOOSE), "is only for open loops"),
        (lambda: variant(run=replace(LOOSE, delay=1), effort=EFFORT), "cannot include the drive"),
        (
            lambda: variant(run=replace(LOOSE, current_lag=1e-3), effort=EFFORT),
            "cannot include the drive",
        ),
        (
            lambda: variant(run=LOOSE, effort=EFFORT, plant=SCREW),
            r"run\.tolerance: needs a plant with one mass, but ball_screw",
        ),
        (
            lambda: Experiment("e", "translational", (variant(), variant())),
            "has two variants with the same name",
        ),
        (lambda: Run(1.001e4, 1e-3), "up to 10000000 samples"),
        (lambda: Run(0.9e-3, 1e-3), "is shorter than a sample"),
        (lambda: Run(0.1, 1e-3, settle=0.1), "leaves nothing of the run"),
        (
            lambda: replace(variant(), plant=SCREW),
            "friction: is not of the kind of plant; found 'coulomb, translational'",
        ),
        (
            lambda: Experiment("e", "rotational", (variant(),)),
            "kind: is not the kind of the variant loop",
        ),
    ],
)
def test_what_does_not_go_together_is_refused(call, words):
    with pytest.raises(InputError, match=words):
        call()


def test_a_tolerance_is_for_an_open_loop_of_one_mass_without_a_drive():
    assert variant(run=LOOSE, effort=EFFORT).run is LOOSE
    assert variant(plant=SCREW).plant is SCREW


def test_the_first_samples_of_a_loop_have_the_disturbances_of_these():
    loop = variant(
        disturbance=np.arange(100.0), injected=-np.arange(100.0), run=Run(0.1, 1e-3, settle=0.05)
    )
    first = loop.first(40)
    assert (first.run.duration, first.run.settle) == pytest.approx((0.04, 0.039))
    assert (first.disturbance.tolist(), first.injected.tolist()) == (
        list(range(40)),
        [-k for k in range(40)],
    )
    assert variant().first(40).disturbance is None


TWIN = {"effort": Effort(np.arange(3.0)), "disturbance": np.arange(5.0)}


@pytest.mark.parametrize(
    ("changes", "others", "alike"),
    [
        (TWIN, {"effort": Effort(np.arange(3.0), "again"), "disturbance": np.arange(5.0)}, True),
        (TWIN, TWIN | {"effort": Effort(np.arange(3.0) + 1.0)}, False),
        (TWIN, TWIN | {"disturbance": np.arange(6.0)}, False),
        (TWIN, TWIN | {"effort": None}, False),
        ({}, {"plant": plants.inertia(M=3.0)}, False),
        ({}, {"sensor_at": "motor"}, False),
        # A run does not depend on them.
        ({"draws": {"F_C": np.arange(3.0)}}, {"draws": {"F_C": np.arange(4.0)}}, True),
    ],
)
def test_loops_are_equal_if_all_samples_are_equal(changes, others, alike):
    assert variant(**changes).is_like(variant(**others)) is alike


def test_variants_of_an_experiment_have_names_of_their_own():
    loop, other = variant(), variant(name="other")
    assert Experiment("e", "translational", (loop, other)).variants == (loop, other)


RUN_OF = partial(Run, duration=1.0, sample_time=1e-3)
LEARNING_OF = partial(Learning, trials=1, k_e=1.0, k_d=0.0, cutoff=20.0)


@pytest.mark.parametrize(
    ("dt", "steps"),
    [(1e-4, 4), (1e-3, 4), (1.0001e-3, 5), (2e-3, 8), (2.1e-3, 9), (1e-3 * (1.0 + 1e-9), 4)],
)
def test_steps_of_the_integration_are_a_quarter_of_a_millisecond_at_most_and_four_at_least(
    dt, steps
):
    assert substeps_for(dt) == steps


@pytest.mark.parametrize(
    ("made", "name", "ends", "beyond"),
    [
        (Feedforward, "asymmetry", (-1.0, 1.0), (-1.001, 1.001)),
        *(
            (Feedforward, name, (0.0,), (-1e-9,))
            for name in ("mass", "limit", "rate_limit", "conditioning")
        ),
        *((RUN_OF, name, (0.0,), (-1e-9,)) for name in ("settle", "effort_limit", "current_lag")),
        (RUN_OF, "tolerance", (0.0,), (-1e-9,)),
        (RUN_OF, "duration", (1e4,), (0.0, 1.001e4)),
        (RUN_OF, "sample_time", (1e-4,), (0.0,)),
        (RUN_OF, "delay", (0, 64), (-1, 65)),
        (RUN_OF, "seeds", (1, 1000), (0, 1001)),
        (RUN_OF, "substeps", (1, 10_000), (-1, 10_001)),
        (LEARNING_OF, "cutoff", (1e-3,), (0.9e-3,)),
        (LEARNING_OF, "trials", (1, 1000), (0, 1001)),
        *((LEARNING_OF, name, (0.0,), (-1e-9,)) for name in ("k_e", "k_d")),
    ],
)
def test_a_number_of_a_loop_is_taken_at_its_ends_and_refused_beyond(made, name, ends, beyond):
    assert [getattr(made(**{name: value}), name) for value in ends] == list(ends)
    for value in beyond:
        with pytest.raises(InputError, match=name):
            made(**{name: value})
