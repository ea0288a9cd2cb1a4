"""What a log does not see is named, with what takes its place."""

import numpy as np
from tests.identification.known_logs import TRUTH, log_of, sines, sliding_effort

from bristle.identification import identify
from bristle.identification.resampling.whiteness import is_white


def test_everything_is_seen_in_a_log_that_shows_everything():
    motion = sines(8.0)
    fit = identify(log_of(motion, sliding_effort(motion)), blocks=0, draws=20).best
    assert {one.status for one in fit.estimates} == {"identified"}
    for one in fit.estimates:
        assert one.interval is not None
        assert one.interval[0] < one.value < one.interval[1]
        assert one.interval[0] - one.larger_std < TRUTH[one.name] < one.interval[1] + one.larger_std


def test_an_inertia_that_hardly_matters_is_not_seen():
    motion = sines(20.0, amplitudes=(0.02,), frequencies=(0.1,), phases=(0.3,))
    effort = sliding_effort(motion, noise=0.3, M=0.4)
    fit = identify(log_of(motion, effort), blocks=0, draws=20).best
    assert fit.parameters["M"].status == "unidentifiable"
    assert fit.parameters["F_C"].status == "identified"
    assert any("M cannot be identified" in one for one in fit.warnings)


def test_only_independent_residuals_are_white():
    white = np.random.default_rng(4).normal(size=3000)
    assert is_white(white)
    assert not is_white(np.convolve(white, np.ones(3), "valid"))
    assert not is_white(np.zeros(100))
    assert not is_white(white[:10])
