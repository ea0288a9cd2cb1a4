"""A stiffness blurred by a coarse encoder: an observer does not report the apparent stiffness."""

import numpy as np
import pytest
from benchmarks.strangers import make
from tests.identification.known_logs import log_of

from bristle.core import Axis
from bristle.identification import identify


@pytest.mark.slow
def test_a_stiffness_blurred_by_the_encoder_is_not_identified():
    # Friction builds up over half a step of the encoder; along what the encoder shows a fit finds nine.
    truth, record = make(40009, "lugre", "multisine")
    assert truth.friction.F_C[1] / truth.friction.sigma_0 < 0.6 * truth.encoder.resolution
    motion = type("Recorded", (), {"time": np.asarray(record.t), "position": np.asarray(record.position)})
    effort = record.effort * truth.recording.force_per_effort
    axis = Axis(kind="rotational", seeks_delay=False, cutoff=100.0)
    fit = identify(log_of(motion, effort, kind="rotational"), "lugre", axis=axis, blocks=0, draws=20).best
    for name in ("sigma_0", "sigma_1"):
        assert (fit.parameters[name].status, fit.parameters[name].reason.code) == ("unidentifiable", "coarse_position")
