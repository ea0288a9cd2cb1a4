"""What the page says of bristle, asked again; and that the answers known beforehand are answers."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from benchmarks.sticking import BREAKS_AWAY, DT, F_C, PULLED, K, M, exact, ours, spring
from scipy.integrate import solve_ivp

TOLD = json.loads((Path(__file__).parents[2] / "docs" / "theory" / "sticking.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def answers():
    return {our.setting: our for our in ours()}


def test_the_page_has_the_numbers_of_bristle(answers):
    message = {row["setting"]: row for row in TOLD if row["simulator"].startswith("bristle ")}
    assert message.keys() == answers.keys()
    for name, row in message.items():
        for question in ("slope", "axis", "stop", "still", "pulled"):
            assert getattr(answers[name], question) == pytest.approx(row[question], rel=0.02, abs=1e-12), (name, question)


def test_coulomb_friction_rests_and_preisach_gives_way_by_nanometres(answers):
    rests = answers["coulomb"]
    assert (rests.slope, rests.axis, rests.still) == (0.0, 0.0, 0.0)
    assert rests.stop < 1e-12
    assert 9.0 * answers["preisach_lugre"].axis < 1e-8
    assert 1e-6 < 9.0 * answers["lugre"].axis < 2e-6


def test_the_pulled_axis_follows_its_equation():
    later = np.arange(BREAKS_AWAY, PULLED, DT)
    moved = solve_ivp(
        lambda t, y: (y[1], (spring(t, y[0]) - F_C) / M), (BREAKS_AWAY, PULLED), [0.0, 0.0], t_eval=later, rtol=1e-10, atol=1e-14
    )
    assert np.all(moved.y[1] > -1e-9)  # it never turns, so that friction keeps its sign
    assert exact(later) == pytest.approx(moved.y[0], abs=1e-10)
    assert math.isclose(spring(BREAKS_AWAY, 0.0), F_C)
    assert spring(0.0, 1.0) == -K
