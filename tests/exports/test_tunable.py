"""Parameters that may be changed at run time: which they are, where they go, what they are compared with."""

import math

import numpy as np
import pytest

import bristle as br
from bristle.core.errors import InputError
from bristle.exports.tunable import bounds_of, checkpoints, refuse_beyond_single, single_note, tunable_of

LUGRE = br.friction.lugre(F_C=22.0, F_S=29.0, v_S=3e-3, sigma_0=2e6)
SLIP = br.friction.maxwell_slip(F_C=4.0, nu_i=[0.25, 0.75], k_i=[1e5, 2e5])


def test_real_numbers_may_be_changed_each_by_its_name_and_place():
    tuned = tunable_of(SLIP)
    numbers = [("F_C", None, 4.0), ("nu_i", 0, 0.25), ("nu_i", 1, 0.75), ("k_i", 0, 1e5), ("k_i", 1, 2e5), ("sigma_2", None, 0.0)]
    assert sorted(tuned.numbers(), key=str) == sorted(numbers, key=str)
    assert tunable_of(SLIP, ("F_C",)).values.keys() == {"nu_i", "k_i", "sigma_2"}
    assert set(tuned.places.values()) == {"F_C", "nu_i", "k_i", "sigma_2"}


def test_a_number_is_compared_with_its_ends_or_with_the_largest():
    bounds = {(name, place): compared for name, place, compared in bounds_of(tunable_of(SLIP))}
    assert bounds["F_C", None] == [(">=", SLIP.component.variables["F_C"].min)]
    share = SLIP.component.variables["nu_i"]
    assert bounds["nu_i", 1] == [(">=", share.min)] * math.isfinite(share.min) + [("<=", share.max)] * math.isfinite(share.max)
    offset = br.friction.with_slots(br.friction.coulomb, [])(F_C=1.0, offset=0.5)
    assert {name: compared for name, _, compared in bounds_of(tunable_of(offset))}["offset"] == [(">=", -math.inf), ("<=", math.inf)]


def test_a_parameter_that_a_model_makes_something_else_of_stays():
    from bristle.friction import MODELS

    refused = []
    for name in ("preisach_contact", "uneven", "preisach_lugre"):
        if name in MODELS:
            try:
                tunable_of(br.testing.example_of(MODELS[name]))
            except InputError as error:
                refused.append(error.mend)
    assert all(mend == "Leave --tunable out" for mend in refused)


def test_what_single_precision_does_not_hold_is_refused_by_its_place():
    refuse_beyond_single({"a": 1e38, "b": math.inf, "c": "text", "d": np.array([1.0, np.nan])})
    with pytest.raises(InputError) as told:
        refuse_beyond_single({"a": LUGRE.parameters._replace(sigma_0=1e39)})
    assert (told.value.path, told.value.value) == ("a.sigma_0", 1e39)
    with pytest.raises(InputError, match="k: is larger"):
        refuse_beyond_single({"k": np.array([1.0, -4e38])})


def test_single_precision_is_compared_every_so_many_steps():
    outputs = np.linspace(-3.0, 1.0, 101)
    near = checkpoints(outputs, single=True)
    assert [float(number) for number in near["checkpoints"]] == pytest.approx([-3.0, -2.0, -1.0, 0.0, 1.0])
    assert (near["largest"], near["every"], near["tolerance"]) == ("3.0", 25, "0.001")
    assert checkpoints(outputs, single=False)["tolerance"] == ""
    assert single_note("force").endswith("the self-test allows 0.001 of the largest force")
