"""Batches: every trajectory is that of a run on its own, to the bit, however many run together."""

import numpy as np
import pytest
from tests.contract.models import with_fast

import bristle.engine.batch
from bristle import friction
from bristle.contract import example_of
from bristle.core.errors import InputError
from bristle.core.packing import flattener, lane_constants, structure_of
from bristle.core.status import Status
from bristle.engine import interpreted, run_batch, run_open_loop
from bristle.models.plants import inertia

FIELDS = ("position", "velocity", "friction")


def mechanisms(name, count):
    """Models of which each has a force of its own, and one effort for each."""
    generator = np.random.default_rng(3)
    base = example_of(friction.MODELS[name])
    changed = next((key for key in ("F_C", "F_v", "A", "f_p") if key in base.values), None)
    factors = generator.uniform(0.9, 1.0, count)
    models = (
        [base.with_values(**{changed: f * base.values[changed]}) for f in factors]
        if changed
        else [base] * count
    )
    t = 1e-4 * np.arange(60)
    effort = 40.0 * np.sin(200.0 * t + generator.uniform(0.0, 3.0, (count, 1))) + generator.normal(
        0.0, 5.0, (count, 1)
    )
    return models, effort


@pytest.mark.parametrize("name", with_fast("lugre", "preisach_lugre"))
def test_every_model_in_a_batch_is_identical_to_a_serial_run(name):
    models, effort = mechanisms(name, 37)
    plant = inertia(M=2.0)
    options = {"steps": 3, "hold": "linear", "v": 0.01}
    batch = run_batch(plant, models, effort, 1e-4, **options)
    for i in (0, 5, 31, 32, 36):
        alone = run_open_loop(plant, models[i], effort[i], 1e-4, **options)
        for field in FIELDS:
            assert np.array_equal(getattr(batch, field)[i], getattr(alone, field)), (field, i)
    with interpreted():
        plain = run_batch(plant, models[:2], effort[:2], 1e-4, **options)
    for field in FIELDS:
        assert np.array_equal(getattr(batch, field)[:2], getattr(plain, field)), field


WITHOUT_MEMORY = [
    name
    for name in friction.MODELS
    if not (model := example_of(friction.MODELS[name])).component.new_memory(model.parameters).size
]


@pytest.fixture
def lanes(monkeypatch):
    """Let the implicit step run in lanes however short the work is, and count how often it does."""
    counted, original = [], bristle.engine.batch._Batch.in_lanes
    monkeypatch.setattr("bristle.engine.batch.WORTH_LANES", 0)
    monkeypatch.setattr(
        bristle.engine.batch._Batch, "in_lanes", lambda *a: counted.append(a) or original(*a)
    )
    return counted


@pytest.mark.parametrize(
    "name",
    [
        name if name == "lugre" else pytest.param(name, marks=pytest.mark.slow)
        for name in WITHOUT_MEMORY
    ],
)
def test_the_implicit_step_in_lanes_is_identical_to_a_serial_run(name, lanes):
    models, effort = mechanisms(name, 37)
    effort[:, 20:] *= -3.0  # turns most of them around
    effort[7] = 0.0  # rests
    plant = inertia(M=2.0)
    starts = np.where(np.arange(37) % 3, 0.01, 0.0)
    options = {"steps": 3, "hold": "linear"}
    batch = run_batch(plant, models, effort, 1e-4, v=starts, **options)
    for i in range(37):
        alone = run_open_loop(plant, models[i], effort[i], 1e-4, v=starts[i], **options)
        for field in FIELDS:
            assert np.array_equal(getattr(batch, field)[i], getattr(alone, field)), (field, i)
    if name == "lugre":
        with interpreted():
            plain = run_batch(plant, models[:32], effort[:32, :12], 1e-4, v=starts[:32], **options)
        for field in FIELDS:
            assert np.array_equal(getattr(batch, field)[:32, :11], getattr(plain, field)[:, :11]), (
                field
            )
    assert len(lanes) == 1 + (name == "lugre")
    assert np.sum(np.diff(np.sign(batch.velocity[1:]), axis=1) != 0) > 30  # they reverse
    v = batch.velocity[1:]
    assert np.sum((v.min(axis=1) < 0.0) & (v.max(axis=1) > 0.0)) > 12  # many of them


@pytest.mark.parametrize(
    ("name", "dt"),
    [pytest.param("coulomb", 1e-4, marks=pytest.mark.slow), ("lugre", 1e-4), ("lugre", 1e-2)],
)
def test_lanes_near_rest_are_identical_to_serial_runs(name, dt):
    models, _ = mechanisms(name, 1024)
    generator = np.random.default_rng(8)
    effort, v = generator.normal(0.0, 20.0, (1024, 12)), generator.normal(0.0, 1e-3, 1024)
    both = [
        run_batch(inertia(M=2.0), models, effort, dt, v=v, in_lanes=in_lanes)
        for in_lanes in (True, False)
    ]
    for field in FIELDS:
        assert np.array_equal(*(getattr(batch, field) for batch in both)), field


@pytest.mark.parametrize("in_lanes", [True, False])
def test_a_diverging_trajectory_ends_like_a_serial_run_and_does_not_affect_others(in_lanes):
    models, effort = mechanisms("lugre", 34)
    effort[4] = 1e300
    batch = run_batch(inertia(M=1e-6), models, effort, 1e-2, in_lanes=in_lanes, threads=2)
    assert batch.status[4] == Status.NOT_FINITE
    for i in (4, 5):
        alone = run_open_loop(inertia(M=1e-6), models[i], effort[i], 1e-2)
        assert np.array_equal(
            batch.position[i][: alone.position.size], alone.position, equal_nan=True
        )
        assert np.all(np.isnan(batch.position[i][alone.position.size :]))
        assert batch.status[i] is alone.status


@pytest.mark.parametrize(
    ("factors", "alike"), [((1.0, 1.0), True), ((1.0, 1.1), False), ((1.1, 1.1), False)]
)
def test_lanes_merge_directions_only_if_they_are_equal_in_every_lane(factors, alike):
    base = example_of(friction.find("lugre+asymmetry"))
    both = base.with_values(
        **{name: base.values[f"{name[:-4]}_pos"] for name in base.values if name.endswith("_neg")}
    )
    models = [both.with_values(F_C_neg=factor * both.values["F_C_neg"]) for factor in factors]
    structure = structure_of(both.parameters)
    rows = np.array([flattener(structure)(model.parameters) for model in models])
    twins = dict(lane_constants(structure, rows).twins)
    count = len(both.parameters.forward)
    assert twins == ({count + place: place for place in range(count)} if alike else {})


def test_a_common_model_or_effort_is_shared():
    models, effort = mechanisms("lugre", 3)
    plants = [inertia(M=m) for m in (1.0, 2.0, 4.0)]
    batch = run_batch(plants, models[0], effort[0], 1e-4, x=[0.0, 1.0, 2.0])
    assert batch.position.shape == (3, effort.shape[1])
    assert batch.position[:, 0].tolist() == [0.0, 1.0, 2.0]
    alone = run_open_loop(plants[2], models[0], effort[0], 1e-4, x=2.0)
    assert np.array_equal(batch.position[2], alone.position)
    assert np.array_equal(batch.time, alone.time)


@pytest.mark.parametrize(
    ("models", "options", "words"),
    [
        (("lugre", "lugre"), {"v": [0.0, 1.0, 2.0]}, "3 velocities"),
        (("lugre", "coulomb"), {}, r"friction\[1\]"),
        (("lugre", "lugre"), {"hold": "cubic"}, "hold"),
    ],
)
def test_bad_batches_are_refused_with_their_path(models, options, words):
    with pytest.raises(InputError, match=words):
        run_batch(
            inertia(M=1.0),
            [example_of(friction.MODELS[name]) for name in models],
            np.zeros(5),
            1e-4,
            **options,
        )
