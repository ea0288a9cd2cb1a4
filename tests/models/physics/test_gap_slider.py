"""The slider behind a spring with backlash: its map, its memory, its energy, and where it may begin."""

from itertools import pairwise

import numpy as np
import pytest

from bristle import friction
from bristle.engine import force_along

pytestmark = pytest.mark.usefixtures("in_plain_python")

MODEL = friction.gap_slider(F_C=20.0, give=2e-3, gap=4e-3, n=2.5, share=0.1)
R = 4e-3  # from the middle of the backlash to slip


def along(model, x, count=400):
    """Force at the end of straight moves from one position to the next, all forces, and the velocities."""
    v = np.concatenate([np.full(count, (b - a) / count) for a, b in pairwise([0.0, *x])])
    force = force_along(model, v, 1.0)
    return force[count - 1 :: count], force, v


def test_the_contact_slips_at_its_force_and_is_slack_in_its_backlash():
    ends, _, _ = along(MODEL, [10e-3, 10e-3 - R, -5e-3, 5e-3])
    assert ends[[0, 2, 3]] == pytest.approx([20.0, -20.0, 20.0])
    assert abs(ends[1]) < 0.1 * 20.0 * 0.1  # the middle of the backlash: next to nothing


def test_the_mean_of_a_step_does_not_depend_on_how_it_is_cut():
    # From one stop through the backlash into slip on the other side: exact whatever the step.
    once = force_along(MODEL, np.array([10e-3, -15e-3]), 1.0)
    for cuts in (7, 100, 2000):
        fine = force_along(
            MODEL, np.concatenate([np.full(cuts, 10e-3 / cuts), np.full(cuts, -15e-3 / cuts)]), 1.0
        )
        assert np.mean(fine[:cuts]) == pytest.approx(once[0], rel=1e-6)
        assert np.mean(fine[cuts:]) == pytest.approx(once[1], rel=1e-6)


def test_the_contact_stores_between_its_stops_and_dissipates_only_in_slip():
    _, force, v = along(MODEL, [3e-3, -3e-3, 3e-3, -3e-3], 500)
    cycle = slice(500, 1500)
    assert abs(np.sum(force[cycle] * v[cycle])) < 1e-6 * 20.0 * R
    _, force, v = along(MODEL, [12e-3, -12e-3, 12e-3], 1000)
    work = np.sum((force * v)[1000:])
    assert work == pytest.approx(20.0 * 2.0 * (24e-3 - 2.0 * R), rel=1e-3)


def test_parameters_may_differ_by_side_without_a_jump():
    model = friction.find("gap_slider+asymmetry")(
        F_C_pos=20.0, F_C_neg=12.0, give_pos=2e-3, give_neg=1e-3, gap=4e-3, n=2.0, share=0.1
    )
    ends, force, _ = along(model, [10e-3, -10e-3, 10e-3], 1000)
    assert ends == pytest.approx([20.0, -12.0, 20.0])
    # Back from the forward stop the spring of that side gives its force up: there is no jump at the reversal.
    assert np.max(np.abs(np.diff(force))) < 0.6
