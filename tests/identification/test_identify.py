"""Shared data of all fits, and reports of progress."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from tests.identification.known_logs import STATED, log_of, sines, sliding_effort

from bristle.core.axis import Cogging
from bristle.identification.identify import TURNS, _context, _share, _turn
from bristle.identification.parameters import PriorKnowledge
from bristle.identification.settings import DEFAULT
from bristle.plants import inertia

MOTION = sines(6.0, dt=2e-3, amplitudes=(0.03, 0.008), frequencies=(0.25, 0.7), phases=(0.0, 1.0))
TURN = 0.01


@pytest.mark.parametrize("harmonics", [None, (6,)])
def test_harmonics_are_sought_in_the_log_if_the_axis_omits_them(harmonics):
    effort = sliding_effort(MOTION, noise=0.05) + 2.0 * np.sin(4.0 * np.pi * MOTION.position / TURN)
    axis = replace(STATED, cogging=(Cogging("motor", TURN, harmonics),))
    context = _context([(log_of(MOTION, effort), axis)], PriorKnowledge(plant=inertia), DEFAULT, partial(_share, None, 1), None, 100.0, 4)
    assert context.prior.plant.orders == (("motor", 2),) if harmonics is None else context.prior.plant is inertia


def test_progress_of_fits_with_slots_is_a_share_of_all_turns():
    shares = []
    for turn in range(TURNS):
        for number in range(2):
            report = _turn(lambda share, remark: shares.append((share, remark)), turn, 2, number, "")
            report(0.0)
            report(0.5, "so far")
    assert [share for share, _ in shares] == pytest.approx((np.arange(4 * TURNS) / (4.0 * TURNS)).tolist())
    assert [remark for _, remark in shares[:2]] == ["", "so far"]


def test_progress_has_a_task_and_a_remark():
    messages = []
    _share(lambda *message: messages.append(message), 4, 1, "fitting")(0.5, "start 2")
    _share(lambda *message: messages.append(message), 4, 3, "fitting")(1.0)
    assert messages == [(0.375, "fitting, start 2"), (1.0, "fitting")]
    _share(None, 4, 1, "fitting")(0.5)
