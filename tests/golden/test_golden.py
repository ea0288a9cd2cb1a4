"""Present results equal the frozen results in the fast golden cases. ``python -m tests.golden check`` runs all cases."""

import json
import os

import pytest
import tests.golden.cases
import tests.golden.commands  # noqa: F401  (both register theirs)
from tests.golden.case import CASES, FROZEN, differences_of, tolerance_for
from tests.golden.comparison import ELSEWHERE, RELATIVE, differences, frozen_text

FAST = [
    pytest.param(item, id=item.name, marks=[pytest.mark.measured] if item.measured else [])
    for item in CASES.values()
    if item.fast and not item.name.startswith("json_")
]


@pytest.mark.slow
@pytest.mark.parametrize("case", FAST)
def test_results_match_the_frozen_results(case):
    if case.measured and not os.environ.get("BRISTLE_DATA"):
        pytest.skip("BRISTLE_DATA does not name the folder of the measured logs")
    assert [str(item) for item in differences_of(case, tolerance_for(case))][:20] == []


def test_exactly_the_cases_are_frozen():
    assert {item.stem for item in FROZEN.glob("*.json")} == set(CASES)


ESTIMATE = {
    "value": 1e-3,
    "std": 2.0,
    "robust_std": None,
    "interval": [-4.0, 4.0],
    "status": "identified",
}


@pytest.mark.parametrize(
    ("relative", "was", "now", "paths"),
    [
        (RELATIVE, {"a": 1.0}, {"a": 1.0 + 2e-9}, ["a"]),
        (RELATIVE, {"a": 1.0}, {"a": 1.0 + 5e-10}, []),
        (RELATIVE, {"a": 1.0}, {"a": None}, ["a"]),
        (RELATIVE, {"a": 1}, {"a": 1.0}, []),
        (RELATIVE, {"a": 1}, {"a": True}, ["a"]),
        (RELATIVE, {"a": {"b": "text"}}, {"a": {"b": "texts"}}, ["a.b"]),
        (RELATIVE, {"a": {"b": 1}}, {"a": {}}, ["a.b"]),
        (RELATIVE, {"a": {}}, {"a": {"b": 1}}, []),
        (RELATIVE, {"a": ["x"]}, {"a": ["x", "y"]}, ["a.length"]),
        # Next to nothing beside its neighbour.
        (RELATIVE, {"a": [1e-12, 1.0]}, {"a": [0.0, 1.0]}, []),
        (RELATIVE, {"a": [1e-8, 1.0]}, {"a": [0.0, 1.0]}, ["a[0]"]),
        # Next to nothing beside its interval.
        (RELATIVE, ESTIMATE, ESTIMATE | {"value": 1e-3 + 3e-9}, []),
        (RELATIVE, ESTIMATE, ESTIMATE | {"value": 1e-3 + 5e-9}, ["value"]),
        (RELATIVE, ESTIMATE, ESTIMATE | {"std": 2.0 + 3e-9}, ["std"]),
        (RELATIVE, ESTIMATE, ESTIMATE | {"status": "held"}, ["status"]),
        (RELATIVE, {"below_the_diagonal": [[1e-12]]}, {"below_the_diagonal": [[0.0]]}, []),
        (
            RELATIVE,
            {"below_the_diagonal": [[1e-8]]},
            {"below_the_diagonal": [[0.0]]},
            ["below_the_diagonal[0][0]"],
        ),
        (RELATIVE, [{"n": 0.0}], [{"n": 1e-300}], ["[0].n"]),
        # Elsewhere digits may differ, and no word.
        (ELSEWHERE, {"a": 1.0}, {"a": 1.001}, []),
        (ELSEWHERE, {"a": 1.0}, {"a": 1.003}, ["a"]),
        (ELSEWHERE, {"a": "871 mN, 1.6 %"}, {"a": "-872 mN, 1.61 %"}, []),
        (ELSEWHERE, {"a": "871 mN of ripple"}, {"a": "871 mN of drift"}, ["a"]),
        (ELSEWHERE, ESTIMATE, ESTIMATE | {"status": "at_edge"}, ["status"]),
        (
            ELSEWHERE,
            {"models": ["lugre", "dahl"]},
            {"models": ["dahl", "lugre"]},
            ["models[0]", "models[1]"],
        ),
    ],
)
def test_a_difference_is_reported_with_its_place(relative, was, now, paths):
    assert [difference.path for difference in differences(was, now, relative)] == paths


def test_old_and_new_values_are_reported():
    (item,) = differences({"fits": [{"rank": 1}]}, {"fits": [{"rank": 2}]})
    assert str(item) == "fits[0].rank: was 1, is 2"


def test_numbers_survive_the_file_to_the_last_bit():
    result = {
        "a": [0.1 + 0.2, 5e-324, -1e300],
        "b": {"c": [1, None, True]},
        "µ": ["x", {}],
        "d": [],
        "e": [[1.5], [2.5]],
    }
    assert json.loads(frozen_text(result)) == result
