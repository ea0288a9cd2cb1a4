"""What the page says of bristle, asked again; and that the answers known beforehand are answers."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from benchmarks.sticking import BREAKS_AWAY, DT, F_C, PULLED, K, M, exact, ours, spring
from scipy.integrate import solve_ivp

TOLD = json.loads(
    (Path(__file__).parents[2] / "docs" / "theory" / "sticking.json").read_text(encoding="utf-8")
)


QUESTIONS = ("slope", "axis", "stop", "still", "pulled")


def assert_told(answers):
    """The page has these answers of bristle."""
    message = {
        row["setting"]: [row[question] for question in QUESTIONS]
        for row in TOLD
        if row["simulator"].startswith("bristle ")
    }
    for answer in answers:
        numbers = [getattr(answer, question) for question in QUESTIONS]
        assert numbers == pytest.approx(message[answer.setting], rel=0.02, abs=1e-12), (
            answer.setting
        )


def test_coulomb_friction_rests():
    rests = next(ours())
    assert_told([rests])
    assert (rests.setting, rests.slope, rests.axis, rests.still) == ("coulomb", 0.0, 0.0, 0.0)
    assert rests.stop < 1e-12


@pytest.mark.slow
def test_the_page_has_the_numbers_of_bristle_and_preisach_gives_way_by_nanometres():
    answers = {answer.setting: answer for answer in ours()}
    assert_told(answers.values())
    assert answers.keys() == {
        row["setting"] for row in TOLD if row["simulator"].startswith("bristle ")
    }
    assert 9.0 * answers["preisach_lugre"].axis < 1e-8
    assert 1e-6 < 9.0 * answers["lugre"].axis < 2e-6


def test_the_pulled_axis_follows_its_equation():
    later = np.arange(BREAKS_AWAY, PULLED, DT)
    moved = solve_ivp(
        lambda t, y: (y[1], (spring(t, y[0]) - F_C) / M),
        (BREAKS_AWAY, PULLED),
        [0.0, 0.0],
        t_eval=later,
        rtol=1e-10,
        atol=1e-14,
    )
    assert np.all(moved.y[1] > -1e-9)  # it never turns, so that friction keeps its sign
    assert exact(later) == pytest.approx(moved.y[0], abs=1e-10)
    assert math.isclose(spring(BREAKS_AWAY, 0.0), F_C)
    assert spring(0.0, 1.0) == -K
