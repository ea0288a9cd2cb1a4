"""External functions of CasADi: along 200 steps of a graph, the force and derivatives of bristle."""

import numpy as np
import pytest
from tests.exports.native import COMPILER, FLAGS, WARNINGS, compiled, walk
from tests.exports.test_c_derivatives import DT, SLOTS, example, in_python

import bristle as br
from bristle.engine.translation.tree import INTEGER
from bristle.exports.subject import subject_of
from bristle.exports.tunable import tunable_of

casadi = pytest.importorskip("casadi")
pytestmark = pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")
STEPS = 200


def functions(model, folder, name="axis_x"):
    """Return the functions of a step and of the initial state."""
    br.export(model, "casadi", folder, name=name)
    compiled(
        folder,
        "-O0",
        *FLAGS,
        *WARNINGS,
        "-shared",
        "-fPIC",
        f"{name}.c",
        f"{name}_casadi.c",
        "-o",
        f"{name}.so",
        "-lm",
    )
    return [
        casadi.external(f"{name}_{part}", str(folder / f"{name}.so"))
        for part in ("step", "initial")
    ]


def forces(step, initial, x, p, count, *around):
    """Return the forces along positions as a graph."""
    state, _ = initial.call([])
    state, out = casadi.vertcat(x[0], state[1:]), []
    for k in range(1, count):
        state, force = step(state, x[k], DT, p, *around)
        out.append(force)
    return casadi.vertcat(*out)


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    "case",
    [
        ("lugre", ()),
        ("maxwell_slip", ("load",)),
        ("elastoplastic", ()),
        ("maxwell_stribeck", SLOTS),
    ],
    ids=str,
)
def test_jacobian_and_gradient_through_steps_are_those_of_bristle(tmp_path, case):
    model, places = example(*case), walk(STEPS + 1, seed=12)
    step, initial = functions(model, tmp_path / "out")
    usual = [1.0 if line.field == "load" else 300.0 for line in model.component.surroundings]
    x, p = casadi.MX.sym("x", STEPS + 1), casadi.MX.sym("p", *initial.size_out(1))
    force = forces(step, initial, x, p, STEPS + 1, *usual)
    exported = np.array(initial.call([])[1]).ravel()
    assert exported.tolist() == [value for *_, value in tunable_of(model).numbers()]
    values, by_p, by_x, gradient = casadi.Function(
        "all",
        [x, p],
        [
            force,
            casadi.jacobian(force, p),
            casadi.jacobian(force, x)[:, 50],
            casadi.gradient(casadi.sumsqr(force), p),
        ],
    )(places, exported)
    count, moved = exported.size, np.zeros((STEPS + 1, exported.size + 1))
    moved[50, -1] = 1.0
    around = {
        line.field: np.full(STEPS + 1, value)
        for line, value in zip(model.component.surroundings, usual, strict=True)
    }
    with br.engine.interpreted():
        expected_force, expected = in_python(
            model, places, np.eye(count + 1, count), moved, around=around
        )
    assert np.array(values).ravel().tolist() == expected_force.tolist()
    found = np.hstack([np.array(by_p), np.array(by_x)])
    assert np.all(np.abs(found - expected) <= 1e-10 * np.abs(expected).max(axis=0))
    expected_gradient = 2.0 * expected[:, :count].T @ expected_force
    np.testing.assert_allclose(
        np.array(gradient).ravel(),
        expected_gradient,
        rtol=1e-9,
        atol=1e-10 * np.abs(expected_gradient).max(),
    )


@pytest.mark.slow
def test_a_model_with_stored_turning_points_has_finite_derivatives(tmp_path):
    model, places = example("preisach_lugre", ()).with_values(capacity=8), walk(20, seed=12)
    step, initial = functions(model, tmp_path / "out", name="knee")
    p = casadi.MX.sym("p", *initial.size_out(1))
    force = forces(step, initial, casadi.MX(places), p, 20)
    gradient = casadi.Function("gradient", [p], [casadi.gradient(casadi.sumsqr(force), p)])
    jacobian = casadi.Function("jacobian", [p], [2.0 * casadi.jacobian(force, p).T @ force])
    exported = initial.call([])[1]
    np.testing.assert_allclose(
        np.array(gradient(exported)), np.array(jacobian(exported)), rtol=1e-10
    )
    assert np.isfinite(np.array(gradient(exported))).all()


def test_an_invalid_input_stops_the_evaluation(tmp_path):
    step, initial = functions(example("dahl", ()), tmp_path / "out")
    state, p = initial.call([])
    with pytest.raises(RuntimeError):
        step(state, 1e-6, -1e-3, p)


def test_a_state_that_is_not_of_the_model_is_refused(tmp_path):
    model = example("preisach_lugre", ())
    step, initial = functions(model, tmp_path / "out")
    state, exported = initial.call([])
    ended = step.call([state, 1e-6, DT, exported])
    place = next(
        1 + k for k, (_, kind) in enumerate(subject_of(model).state.fields) if kind == INTEGER
    )
    for value in (-1.0, 1e9, float("nan")):
        wrong = casadi.DM(state)
        wrong[place] = value
        with pytest.raises(RuntimeError):
            step.call([wrong, 1e-6, DT, exported])
        with pytest.raises(RuntimeError):
            step.forward(1).call(
                [wrong, 1e-6, DT, exported, *ended, 0.0 * state, 1.0, 0.0, 0.0 * exported]
            )
