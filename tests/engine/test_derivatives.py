"""Derivatives of friction along a motion: those of complex steps through the plain kernels, beside a force whose bits stay."""

from functools import cache

import numpy as np
import pytest
from tests.engine.translation.complex_step import directions_of, force_by_complex_steps

from bristle.contract import example_of
from bristle.core.errors import InputError, InputWarning
from bristle.core.packing import pack
from bristle.core.tangent import DIRECTIONS
from bristle.engine.compilation import interpreted
from bristle.engine.derivatives import TangentRun, force_with_derivatives
from bristle.engine.motion import along
from bristle.models.friction import MODELS, with_slots

SLOTS = ("position", "periodic", "load", "temperature", "asymmetry")
CASES = [(name, slots) for name in MODELS for slots in ((), SLOTS)]
NAMES = ["-".join([name, *("slots" for _ in slots[:1])]) for name, slots in CASES]
# Slots are the same around every model: around these three among the fast tests.
SLOTTED = ("coulomb_viscous", "lugre", "maxwell_slip")
FEW = [
    pytest.param(*case, marks=[pytest.mark.slow] * (case[1] != () and case[0] not in SLOTTED))
    for case in CASES
]
DT = 1e-3
EXPONENTS = ("exponent", "delta_S", "n", "nu")
# Where `bristle.core.mathematics.power` takes a shortcut, complex steps see none of the exponent: 1.1 times it takes none.
OFF = 1.1


def off_shortcuts(value):
    """Return parameters whose exponents, those of parts included, take no shortcut."""
    changed = {}
    for name, field in value._asdict().items():
        if hasattr(field, "_fields"):
            changed[name] = off_shortcuts(field)
        elif name in EXPONENTS:
            changed[name] = OFF * field
    return value._replace(**changed)


@cache
def model_of(name, slots=(), is_off=True):
    model = example_of(with_slots(MODELS[name], slots) if slots else MODELS[name])
    return (
        type(model)(model.component, off_shortcuts(model.parameters), model.kind)
        if is_off
        else model
    )


def nasty(seed=1, count=64):
    """Return velocities of a random walk over five decades, with rests on both sides, tiny and exact returns, long slides."""
    random = np.random.default_rng(seed)
    v = 10.0 ** random.uniform(-6.0, -0.5, count) * random.choice([-1.0, 1.0], count)
    v[[20, 21, 40, 60, -1]] = 0.0, -0.0, -0.0, 0.0, 0.0
    v[5:8], v[30:36], v[50:58] = 0.03, -0.2, 1e-4 * random.standard_normal(8)
    v[10], v[12], v[36] = -v[9], -v[11] * (1.0 - 1e-9), 1e-9
    return v


def around_of(count):
    turn = np.linspace(0.0, 6.0, count)
    return {
        "load": 1.0 + 0.4 * np.sin(turn),
        "temperature": 300.0 + 15.0 * np.cos(turn),
        "transmitted": 10.0 * np.sin(3.0 * turn),
    }


def in_python(model, tangents, v, **beside):
    """Return force and derivatives as plain Python gives them."""
    # A branch without end has an infinite one, and 0 times that is no number; nothing that is looked at hangs on it.
    with interpreted(), np.errstate(invalid="ignore"):
        return force_with_derivatives(model, tangents, v, DT, np.cumsum(v) * DT, **beside)


def path_of(name):
    """Return velocities for a model; a step of a contact with turning points takes long."""
    return nasty()[: 42 if name in ("preisach_lugre", "leuven") else None]


@cache
def both(name, slots):
    """Return force and derivatives to all parameters, and what complex steps give."""
    model, v = model_of(name, slots), path_of(name)
    arguments, around = (model, directions_of(model), v), around_of(v.size)
    return in_python(*arguments, around=around), force_by_complex_steps(
        *arguments, DT, np.cumsum(v) * DT, around=around
    )


def agrees(derivatives, expected, tolerance=1e-8):
    """Hold derivatives against others, each direction as exact as the largest of it."""
    assert derivatives.shape == expected.shape
    largest = np.abs(expected).max(axis=0)
    assert np.all(np.abs(derivatives - expected) <= tolerance * largest)


@pytest.mark.parametrize(("name", "slots"), FEW, ids=NAMES)
def test_parameter_derivatives_agree_with_complex_steps(name, slots):
    (force, derivatives), (complex_force, expected) = both(name, slots)
    assert np.isfinite(derivatives).all()
    assert np.abs(expected).max() > 0.0
    agrees(derivatives, expected, 1e-11)
    # The force beside them has the bits of the force alone.
    v = path_of(name)
    with interpreted():
        alone = along(model_of(name, slots), v, DT, np.cumsum(v) * DT, **around_of(v.size))
    assert force.tobytes() == complex_force.tobytes() == alone.tobytes()


@pytest.mark.parametrize(
    "name",
    [
        "lugre",
        *(
            pytest.param(name, marks=pytest.mark.slow)
            for name in ("maxwell_slip", "preisach_lugre")
        ),
    ],
)
def test_compiled_derivatives_agree_with_plain_python(name):
    model, v = model_of(name), path_of(name)
    (force, expected), _ = both(name, ())
    compiled_force, derivatives = force_with_derivatives(
        model, directions_of(model), v, DT, np.cumsum(v) * DT, around=around_of(v.size)
    )
    assert compiled_force.tobytes() == force.tobytes()
    agrees(derivatives, expected, 1e-14)


@pytest.mark.parametrize(
    ("name", "field"),
    [
        ("stribeck", "delta_S"),
        ("stribeck_free", "delta_S"),
        ("dahl", "exponent"),
        ("bouc_wen", "exponent"),
        ("gap_slider", "n"),
        ("leuven", "n"),
    ],
)
def test_derivatives_are_continuous_at_shortcuts_of_a_power(name, field):
    model, v = model_of(name, is_off=False), nasty()
    near = model.parameters._replace(**{field: getattr(model.parameters, field) * (1.0 + 1e-9)})
    _, derivatives = in_python(model, directions_of(model), v)
    _, expected = in_python(type(model)(model.component, near, model.kind), directions_of(model), v)
    agrees(derivatives, expected, 1e-6)


# Laws that ask nothing about rest.
CONTINUED = ["stribeck", "dahl", "lugre", "bouc_wen", "elastoplastic", "maxwell_stribeck"]
# That take a branch of its own there.
BRANCHING = ["maxwell_slip", "gms", "gap_slider", "reformed_dahl", "preisach_lugre", "leuven"]
LONGEST = ["bouc_wen", "elastoplastic", "leuven"]


def moving(model, v):
    """Return tangents of parameters, velocities and positions: a path that swings, one that bends little, one that is shifted."""
    random = np.random.default_rng(3)
    dv = random.uniform(-1.0, 1.0, (v.size, 3)) * np.array([1.0, 1e-3, 0.0])
    dx = np.cumsum(dv, axis=0) * DT + np.array([0.0, 0.0, 1.0])
    directions = directions_of(model)
    return directions @ random.uniform(-1e-3, 1e-3, (directions.shape[1], 3)), (dv, dx)


def without_rest(v, least):
    """Return velocities of which none is less than this."""
    return np.where(v == 0.0, np.copysign(least, v), v)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow] * (name in LONGEST))
        for name in CONTINUED + BRANCHING
    ],
)
def test_motion_derivatives_agree_with_complex_steps(name):
    # At rest a relaxation is clamped so that no number is divided by 0: the complex step is that of the clamp.
    model, v = (
        model_of(name, SLOTS),
        nasty(2) if name in BRANCHING else without_rest(nasty(2), 1e-6),
    )
    tangents, moved = moving(model, v)
    for mixed in (tangents, 0.0 * tangents):
        force, derivatives = in_python(model, mixed, v, motion_tangents=moved)
        complex_force, expected = force_by_complex_steps(
            model, mixed, v, DT, np.cumsum(v) * DT, motion_tangents=moved
        )
        assert force.tobytes() == complex_force.tobytes()
        assert np.isfinite(derivatives).all()
        agrees(derivatives, expected)


@pytest.mark.parametrize("name", CONTINUED)
def test_motion_derivatives_at_rest_are_the_one_sided_limits(name):
    model, v = model_of(name, SLOTS), nasty(2)
    tangents, moved = moving(model, v)
    _, derivatives = in_python(model, tangents, v, motion_tangents=moved)
    _, expected = in_python(model, tangents, without_rest(v, 1e-14), motion_tangents=moved)
    agrees(derivatives, expected, 1e-6)


@pytest.mark.parametrize(
    "name", ["dahl", "lugre", "bouc_wen", "reformed_dahl", "elastoplastic", "gap_slider"]
)
@pytest.mark.parametrize("slots", [(), SLOTS])
def test_initial_state_derivatives_agree_with_complex_steps(name, slots):
    model, v = model_of(name, slots), nasty(4) * 1e-3
    state = model.component.initial_state(model.parameters)
    size = pack(state).size
    tangents, state_tangents = np.zeros((pack(model.parameters).size, size)), np.eye(size)
    beside = {"state": state, "state_tangents": state_tangents}
    _, derivatives = in_python(model, tangents, v, **beside)
    _, expected = force_by_complex_steps(model, tangents, v, DT, np.cumsum(v) * DT, **beside)
    assert expected[0].any()
    agrees(derivatives, expected)


@pytest.mark.parametrize("count", [0, 1, 8, 9, 17])
def test_many_directions_give_the_columns_of_each_alone(count):
    model, v = model_of("gms"), nasty()
    random = np.random.default_rng(6)
    tangents, state_tangents = (
        random.standard_normal((pack(model.parameters).size, count)),
        random.standard_normal((1, count)),
    )
    state_tangents = np.repeat(
        state_tangents, pack(model.component.initial_state(model.parameters)).size, axis=0
    )
    moved = random.standard_normal((2, v.size, count))
    force, derivatives = in_python(
        model, tangents, v, state_tangents=state_tangents, motion_tangents=(moved[0], moved[1])
    )
    assert derivatives.shape == (v.size, count)
    for k in range(count):
        column = slice(k, k + 1)
        beside = {
            "state_tangents": state_tangents[:, column],
            "motion_tangents": (moved[0][:, column], moved[1][:, column]),
        }
        single_force, single = in_python(model, tangents[:, column], v, **beside)
        assert single_force.tobytes() == force.tobytes()
        assert single[:, 0].tobytes() == derivatives[:, k].tobytes()


@pytest.mark.parametrize(
    ("name", "slots"),
    [("lugre", ()), ("maxwell_stribeck", SLOTS), ("preisach_lugre", ()), ("gms", SLOTS)],
)
def test_a_motion_continues_with_state_memory_and_tangents_of_its_first_half(name, slots):
    model, v = model_of(name, slots), nasty()
    directions = directions_of(model)[:, :DIRECTIONS]
    _, expected = in_python(model, directions, v)
    x, derivatives = np.cumsum(v) * DT, []
    with interpreted(), np.errstate(invalid="ignore"):
        run = TangentRun(model, directions)
        for half in (slice(0, 37), slice(37, v.size)):
            out = np.empty((v[half].size, DIRECTIONS))
            run.along(v[half], DT, x[half], {}, out)
            derivatives.append(out[:, : directions.shape[1]])
    assert np.concatenate(derivatives).tobytes() == expected.tobytes()


def test_compiled_derivatives_with_and_without_motion_coexist():
    model, v = model_of("viscous"), nasty()
    x, still, moved = (
        np.cumsum(v) * DT,
        np.zeros((1, 1)),
        (np.ones((v.size, 1)), np.ones((v.size, 1))),
    )
    _, resting = force_with_derivatives(model, still, v, DT, x)
    _, moving_along = force_with_derivatives(model, still, v, DT, x, motion_tangents=moved)
    assert not resting.any()
    assert moving_along.tolist() == np.full((v.size, 1), pack(model.parameters)[0]).tolist()


def test_a_full_memory_is_reported():
    model = MODELS["preisach_contact"](**{**MODELS["preisach_contact"].example, "capacity": 4})
    v = np.geomspace(1.0, 1e-3, 40) * np.resize([1.0, -1.0], 40) * 0.05
    with pytest.warns(InputWarning, match="memory of turning points was full"):
        in_python(model, directions_of(model), v)


def test_positions_and_velocities_must_have_equal_lengths():
    model, v = model_of("lugre"), nasty()
    with pytest.raises(InputError, match="wrong length"):
        force_with_derivatives(model, directions_of(model), v, DT, np.zeros(v.size - 1))


@pytest.mark.slow
@pytest.mark.parametrize(("name", "slots"), CASES, ids=NAMES)
def test_a_long_motion_has_finite_derivatives_and_an_identical_force(name, slots):
    model = model_of(name, slots, is_off=False)
    v = np.concatenate([nasty(seed, 1000) for seed in range(100)])
    x = np.cumsum(v) * DT
    directions = directions_of(model)
    mixed = directions @ np.random.default_rng(8).standard_normal((directions.shape[1], 8))
    force, derivatives = force_with_derivatives(model, mixed, v, DT, x)
    assert np.isfinite(derivatives).all()
    assert force.tobytes() == along(model, v, DT, x).tobytes()
