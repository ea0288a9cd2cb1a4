"""Gravity, a spring and a cable over the angle of a joint: simulated without bristle, identified by their names."""

import numpy as np
import pytest

import bristle as br
from bristle.core.axis import Axis
from bristle.files import read_axis
from bristle.files.axis import axis_from, axis_text
from bristle.logs import Log
from bristle.logs.check import checked

pytestmark = pytest.mark.usefixtures("of_one_mass")

DT, J, F_C, F_V = 2e-3, 0.2, 1.0, 0.5


def joint(force, kind="rotational", scale=1.0, seconds=14.0):
    """Return the log of a joint that moves in three sines: inertia, Coulomb and viscous friction, and a force of the position."""
    t = np.arange(0.0, seconds, DT)
    waves = [(0.9, 0.7, 0.0), (0.5, 1.9, 1.0), (0.15, 4.4, 0.0)]
    q, v, a = (scale * sum(size * rate**n * np.sin(rate * t + phase + 0.5 * np.pi * n) for size, rate, phase in waves) for n in range(3))
    noise = 0.02 * np.random.default_rng(0).normal(size=t.size)
    effort = J * a / scale + F_C * np.sign(v) + F_V * v / scale + force(q / scale) + noise
    return Log.from_columns({"time": t, "position": q, "effort": effort}, kind=kind)


def identified(log, blocks=None, **options):
    axis = Axis(kind=log.kind, **options)
    return br.identify(log, "coulomb_viscous", axis=axis, method="inverse_dynamics", draws=0, blocks=blocks)


def values(result):
    return {name: estimate.value for name, estimate in result.best.parameters.items()}


FORCES = {
    "gravity": lambda q: 20.0 * np.sin(q + 0.3),
    "strong gravity": lambda q: 80.0 * np.sin(q + 0.3),
    "spring": lambda q: 5.0 * (q - 0.4),
    "strong spring": lambda q: 60.0 * (q - 0.4),
    "cable": lambda q: 1.5 * q**2 + 0.8 * q**3,
}


@pytest.mark.parametrize("force", FORCES)
def test_a_force_of_the_position_does_not_count_as_a_stuck_axis(force):
    assert "never_slides" not in {item.code for item in checked(joint(FORCES[force]))}


@pytest.mark.parametrize("force", ["spring", "strong spring"])
def test_the_same_force_over_a_short_stroke_may_be_a_stuck_axis(force):
    codes = {item.code for item in checked(joint(FORCES[force], "translational", 1e-5))}
    assert ("never_slides" in codes) == (force == "strong spring")


@pytest.mark.parametrize(
    ("force", "line", "expected"),
    [
        ("strong gravity", ("gravity", "link"), {"g_sin": 80.0 * np.cos(0.3), "g_cos": 80.0 * np.sin(0.3)}),
        ("spring", ("spring", "cubic"), {"spring_1": 5.0, "offset": -2.0}),
        ("strong spring", ("spring", "cubic"), {"spring_1": 60.0, "offset": -24.0}),
    ],
)
def test_a_force_of_the_position_is_proposed_and_identified(force, line, expected):
    result = identified(joint(FORCES[force]), blocks=2)
    assert [(entry.section, entry.key, entry.value) for entry in result.second_pass.lines] == [("plant", *line)]
    assert result.second_pass.taken
    found = values(result)
    for name, value in (expected | {"M": J}).items():
        assert found[name] == pytest.approx(value, rel=0.02), name
    assert found["F_C"] == pytest.approx(F_C, rel=0.1)


def test_a_stated_spring_or_cable_is_identified_in_the_first_pass():
    found = values(identified(joint(FORCES["spring"]), spring="linear", blocks=0))
    assert found["spring_1"] == pytest.approx(5.0, rel=0.01)
    assert "spring_2" not in found
    found = values(identified(joint(FORCES["cable"], "translational"), spring="cubic", blocks=0))
    assert (found["spring_2"], found["spring_3"]) == (pytest.approx(1.5, rel=0.03), pytest.approx(0.8, rel=0.03))


def test_friction_that_varies_with_the_position_is_no_spring():
    t = np.arange(0.0, 14.0, DT)
    q = 0.9 * np.sin(0.7 * t) + 0.5 * np.sin(1.9 * t + 1.0)
    v, a = np.gradient(q, DT), np.gradient(np.gradient(q, DT), DT)
    effort = J * a + (F_C + 0.8 * q) * np.sign(v) + F_V * v + 0.02 * np.random.default_rng(0).normal(size=t.size)
    result = identified(Log.from_columns({"time": t, "position": q, "effort": effort}, kind="rotational"))
    (missing,) = [item for item in result.best.diagnostics if item.code == "missing_position"]
    assert "alike" not in missing.numbers
    assert result.second_pass is None


def test_a_spring_is_a_line_of_the_axis_file(tmp_path):
    lines = {"schema": 1, "kind": "rotational", "plant": {"spring": "cubic"}}
    columns = {name: {"column": name, "unit": unit} for name, unit in (("time", "s"), ("position", "rad"), ("effort", "N*m"))}
    axis = axis_from(lines | {"columns": columns})
    assert axis.spring == "cubic"
    (tmp_path / "axis.toml").write_bytes(axis_text(axis))
    assert read_axis(tmp_path / "axis.toml").spring == "cubic"
    with pytest.raises(br.core.InputError, match="spring"):
        axis_from(lines | {"columns": columns, "plant": {"spring": "quadratic"}})
