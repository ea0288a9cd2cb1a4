"""A user model with a new quantity is identified like any other model."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from tests.identification.known_logs import Motion, log_of, sines

from bristle.core import Variable
from bristle.core.dimensions import exponents_of
from bristle.files import load_code
from bristle.identification import identify
from bristle.identification.least_squares import Search, Sliding
from bristle.identification.parameter_space import Transform
from bristle.identification.parameters import Scales

pytestmark = pytest.mark.usefixtures("of_one_mass")

OWN = load_code(Path(__file__).parents[2] / "examples" / "quadratic_drag.py")
TRUTH = {"M": 12.0, "F_C": 8.0, "F_q": 40.0}


@pytest.mark.parametrize(
    ("length", "force", "kind"), [(1.0, 1.0, "translational"), (2.0**-20, 2.0**9, "translational"), (2.0**11, 2.0**-12, "rotational")]
)
def test_a_drag_coefficient_is_found_for_any_magnitude(length, force, kind):
    moved = sines(5.0)
    drag = TRUTH["F_q"] * moved.velocity * np.abs(moved.velocity)
    effort = TRUTH["M"] * moved.acceleration + TRUTH["F_C"] * np.sign(moved.velocity) + drag
    effort += np.random.default_rng(3).normal(0.0, 0.1, effort.size)
    motion = Motion(moved.time, length * moved.position, length * moved.velocity, length * moved.acceleration)
    best = identify(log_of(motion, force * effort, kind=kind), OWN, blocks=0, draws=0).best
    result = best.parameters["F_q"]
    assert result.status == "identified"
    assert result.value == pytest.approx(TRUTH["F_q"] * force / length**2, rel=0.02)
    assert result.unit == {"translational": "N*s^2/m^2", "rotational": "N*m*s^2/rad^2"}[kind]


SCALES = Scales(
    force=8.0, peak=20.0, speed=0.2, slowest=1e-3, acceleration=3.0, stroke=0.05, shortest=1e-6, duration=10.0, sample_time=1e-3
)
DIMENSIONS = Scales(
    force="force",
    peak="force",
    speed="length/time",
    slowest="length/time",
    acceleration="length/time^2",
    stroke="length",
    shortest="length",
    duration="time",
    sample_time="time",
)


def ratio(quantity, force, length, time):
    """Factor of a quantity if forces, lengths and times are multiplied by these factors."""
    by = {"force": force, "length": length, "time": time}
    return np.prod([by[name] ** power for name, power in exponents_of(quantity).items()])


@pytest.mark.parametrize(
    "quantity",
    [
        "force",
        "length",
        "time",
        "1/time",
        "1/length",
        "length/time",
        "length/time^2",
        "length/time^3",
        "force/length",
        "force*time/length",
        "force*time^2/length^2",
        "force/length/time",
        "mass",
        "force/time",
        "force^0.5*time^1.5",
        "frequency",
    ],
)
def test_typical_values_of_a_search_have_the_dimension_of_the_parameter(quantity):
    by = (3.0, 7.0, 11.0)
    other = Scales(*(value * ratio(of, *by) for value, of in zip(SCALES, DIMENSIONS, strict=True)))
    for excitation in ("", "speed", "presliding"):
        variable = Variable(quantity, "a parameter", excitation=excitation)
        expected = pytest.approx(ratio(quantity, *by), rel=1e-12)
        assert other.magnitude(variable) / SCALES.magnitude(variable) == expected
        ends = zip(other.range(variable), SCALES.range(variable), strict=True)
        assert [item / before for item, before in ends] == [expected, expected]
        starts = []
        for scales in (other, SCALES):
            sliding = Sliding({}, scales.force, scales.force / scales.speed)
            search, coordinate = (SimpleNamespace(sliding=sliding, scales=scales), Transform("p", "plain", 1.0, *4 * (0.0,)))
            starts.append(Search._draw(search, coordinate, variable, np.random.default_rng(1)))
        assert starts[0] / starts[1] == expected
