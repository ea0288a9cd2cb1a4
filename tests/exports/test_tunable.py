"""Parameters that may be changed at run time: which they are, where they go, what they are compared with."""

import math

import numpy as np
import pytest

import bristle as br
from bristle.core.errors import InputError
from bristle.exports.tunable import CONSTANTS, bounds_of, checkpoints, refuse_beyond_single, single_note, tunable_of

LUGRE = br.friction.lugre(F_C=22.0, F_S=29.0, v_S=3e-3, sigma_0=2e6)
SLIP = br.friction.maxwell_slip(F_C=4.0, nu_i=[0.25, 0.75], k_i=[1e5, 2e5])


def test_real_numbers_are_variable_by_name_and_index():
    tuned = tunable_of(SLIP)
    numbers = [("F_C", None, 4.0), ("nu_i", 0, 0.25), ("nu_i", 1, 0.75), ("k_i", 0, 1e5), ("k_i", 1, 2e5), ("sigma_2", None, 0.0)]
    assert sorted(tuned.numbers(), key=str) == sorted(numbers, key=str)
    assert tunable_of(SLIP, ("F_C",)).values.keys() == {"nu_i", "k_i", "sigma_2"}
    assert set(tuned.places.values()) == {"F_C", "nu_i", "k_i", "sigma_2"}


def test_a_number_is_limited_by_its_bounds_or_by_the_largest_number():
    bounds = {(name, place): compared for name, place, compared in bounds_of(tunable_of(SLIP))}
    assert bounds["F_C", None] == [(">=", SLIP.component.variables["F_C"].min)]
    share = SLIP.component.variables["nu_i"]
    assert bounds["nu_i", 1] == [(">=", share.min)] * math.isfinite(share.min) + [("<=", share.max)] * math.isfinite(share.max)
    offset = br.friction.with_slots(br.friction.coulomb, [])(F_C=1.0, offset=0.5)
    assert {name: compared for name, _, compared in bounds_of(tunable_of(offset))}["offset"] == [(">=", -math.inf), ("<=", math.inf)]


def test_a_value_beyond_single_precision_is_refused_by_its_path():
    refuse_beyond_single({"a": 1e38, "b": math.inf, "c": "text", "d": np.array([1.0, np.nan])})
    with pytest.raises(InputError) as reported:
        refuse_beyond_single({"a": LUGRE.parameters._replace(sigma_0=1e39)})
    assert (reported.value.path, reported.value.value) == ("a.sigma_0", 1e39)
    with pytest.raises(InputError, match="k: is too large"):
        refuse_beyond_single({"k": np.array([1.0, -4e38])})


def test_single_precision_is_compared_at_checkpoints():
    outputs = np.linspace(-3.0, 1.0, 101)
    near = checkpoints(outputs, single=True)
    assert [float(number) for number in near["checkpoints"]] == pytest.approx([-3.0, -2.0, -1.0, 0.0, 1.0])
    assert (near["largest"], near["every"], near["tolerance"]) == ("3.0", 25, "0.001")
    assert checkpoints(outputs, single=False)["tolerance"] == ""
    assert single_note("force").endswith("the self-test allows 0.001 of the largest force")


SINGLE, INFO = {name: number for (name, _), number in CONSTANTS.items()}, np.finfo(np.float32)


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        (SINGLE["NORMAL_MIN"], float(INFO.tiny)),
        (SINGLE["LARGEST"], float(INFO.max)),
        (SINGLE["LOG_OF_MIN"], pytest.approx(math.log(float(INFO.tiny)), rel=1e-12)),
        # The largest exponents whose exponential is a normal number, and its size there.
        (SINGLE["EXP_OF_MAX"], pytest.approx(math.exp(SINGLE["EXP_MAX"]), rel=1e-12)),
        (SINGLE["EXP_MAX"], math.floor(math.log(float(INFO.max)))),
        (SINGLE["EXP_MIN"], math.ceil(math.log(float(INFO.tiny)))),
        # A number plus one and a half times 2^23 is whole; a tangent is 1 to the last place from there on.
        (np.float32(SINGLE["ROUNDER"]) + np.float32(0.7) - np.float32(SINGLE["ROUNDER"]), 1.0),
        (SINGLE["ROUNDER"], 1.5 * 2.0**23),
        (np.float32(math.tanh(SINGLE["TANH_MAX"])), 1.0),
        (np.float32(math.tanh(0.5 * SINGLE["TANH_MAX"])) < 1.0, True),
        # Parts of a few bits whose products with whole numbers are exact, and what is left.
        (SINGLE["LN2_HIGH"] + SINGLE["LN2_LOW"], pytest.approx(math.log(2.0), abs=1e-14)),
        (SINGLE["LN2_HIGH"] * 2.0**9 % 1.0, 0.0),
        (sum(SINGLE[f"HALF_PI_{part}"] for part in (1, 2, 3, 4)), pytest.approx(math.pi / 2.0, abs=1e-15)),
        (SINGLE["HALF_PI_1"] * 2.0**7 % 1.0, 0.0),
        (SINGLE["HALF_PI_2"] * 2.0**23 % 1.0, 0.0),
    ],
)
def test_constants_of_single_precision_follow_from_the_format(found, expected):
    assert found == expected
