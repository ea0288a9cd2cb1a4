"""Examples with MuJoCo, CasADi and JAX: a fit by derivatives, a planned reversal, and a designed motion."""

import re
import shutil

import pytest
from tests.examples.data import printed

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler"),
]


@pytest.mark.timeout(1000)
def test_derivatives_need_a_fifth_of_the_simulations():
    for module in ("mujoco", "jax"):
        pytest.importorskip(module)
    fits = {}
    for name, count, rms, values in re.findall(
        r"(\w+): (\d+) simulations, \d+ s, rms ([\d.]+) urad\n(.+)", printed("fit_in_mujoco.py")
    ):
        fits[name] = (
            int(count),
            float(rms),
            {key: float(value) for key, value in re.findall(r"(\w+) ([\d.]+)", values)},
        )
    (exact, rms, parameters), (differences, other_rms, others) = (
        fits["derivatives"],
        fits["differences"],
    )
    assert exact <= differences / 5
    assert rms == pytest.approx(other_rms, rel=1e-3)
    assert parameters == pytest.approx(others, rel=1e-3)
    # Friction and stiffness of the joint that was measured; the fit started 30 % below.
    assert parameters["F_C"] == pytest.approx(0.50, rel=0.02)
    assert parameters["sigma_0"] == pytest.approx(120.0, rel=0.05)


@pytest.mark.timeout(600)
def test_a_plan_begins_before_the_reversal():
    pytest.importorskip("casadi")
    free, limited = printed("reverse_with_casadi.py").split("feedforward that changes by at most")[
        1:
    ]
    errors = [
        dict(re.findall(r"  ([\w, ]+): ([\d.]+) um at the reversal", part))
        for part in (free, limited)
    ]
    errors = [{name: float(error) for name, error in part.items()} for part in errors]
    assert all(part["planned"] < 0.3 * part["mass only"] for part in errors)
    assert all(part["planned"] < 0.5 * part["force along the path"] for part in errors)
    # Without a limit, the inverse of the filter is sufficient; with a limit, it begins too late.
    assert errors[1]["planned"] < 0.5 * errors[1]["the same, filter inverted"]


@pytest.mark.timeout(600)
def test_a_designed_motion_gives_smaller_errors():
    pytest.importorskip("jax")
    lines = re.findall(
        r"(\w+).*: information ([\d.]+), errors ([\d.]+) %", printed("design_with_jax.py")
    )
    (_, least, error), (_, most_of_random, _), (_, information, error_of_design) = lines
    assert [name for name, *_ in lines] == ["random", "best", "designed"]
    assert float(least) < float(most_of_random) < float(information)
    assert float(error_of_design) < 0.75 * float(error)
