"""Plays, stops and their sums: what the definitions say."""

import numpy as np
from hypothesis import given, settings, strategies as st
from tests.models.hysteresis.paths import along, walk

from bristle import friction, hysteresis, response

inputs = st.lists(st.floats(-5.0, 5.0), min_size=1, max_size=20)
STOPS = hysteresis.prandtl_ishlinskii(
    thresholds=[0.3, 1.0, 2.0], weights=[2.0, 1.0, 0.5], spring=0.1
)


@settings(max_examples=50, deadline=None)
@given(path=inputs, r=st.floats(0.0, 3.0))
def test_play_and_stop_share_the_input(path, r):
    play, stop = response(hysteresis.play(r=r), path), response(hysteresis.stop(r=r), path)
    assert np.max(np.abs(play + stop - path)) <= 1e-15 * (5.0 + r)
    assert np.max(np.abs(stop)) <= r + 1e-15


def test_a_gap_is_crossed_before_the_output_moves():
    path = np.array([0.5, 1.0, 1.5, 0.5, -0.5, -1.0])
    assert response(hysteresis.play(r=1.0), path).tolist() == [0.0, 0.0, 0.5, 0.5, 0.5, 0.0]
    assert response(hysteresis.stop(r=1.0), path).tolist() == [0.5, 1.0, 1.0, 0.0, -1.0, -1.0]


@settings(max_examples=50, deadline=None)
@given(path=inputs)
def test_stops_in_parallel_are_the_sum_of_stops(path):
    parts = [0.1 * np.array(path)]
    parts += [
        w * response(hysteresis.stop(r=r), path) for r, w in ((0.3, 2.0), (1.0, 1.0), (2.0, 0.5))
    ]
    assert np.max(np.abs(response(STOPS, path) - sum(parts))) <= 1e-14


def test_stops_are_the_maxwell_slip_model():
    path = walk(2, 500, 5.0)
    slip = friction.maxwell_slip(
        F_C=2.6, k_i=[2.0, 1.0, 0.5], nu_i=[0.6 / 2.6, 1.0 / 2.6, 1.0 / 2.6]
    )
    force = response(STOPS, path) - 0.1 * path
    # Its force is the mean of a step: a step of no length tells the force at its end.
    ends = response(slip, np.concatenate([[0.0], np.repeat(path, 2)]), 1.0)[2::2]
    assert np.max(np.abs(force - ends)) <= 1e-13


@settings(max_examples=50, deadline=None)
@given(bias=st.floats(-3.0, 3.0), tip=st.floats(0.1, 4.0))
def test_stops_are_congruent_everywhere_and_obey_masing(bias, tip):
    loop = along([-0.5 * tip, 0.5 * tip, -0.5 * tip], 5)
    here, present = (response(STOPS, loop + b, history=[-20.0])[5:] for b in (0.0, bias))
    assert np.max(np.abs((here - here[0]) - (present - present[0]))) <= 1e-13
    virgin = response(STOPS, [0.5 * tip])[0]
    assert abs((here[0] - here[-1]) - 2.0 * virgin) <= 1e-13


def test_no_error_accumulates_over_many_small_moves():
    fine = np.linspace(0.0, 0.1, 100_001)
    there_and_back = np.concatenate([fine, fine[::-1]])
    assert abs(response(hysteresis.stop(r=1.0), there_and_back)[-1]) == 0.0
