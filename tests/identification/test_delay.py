"""The delay between effort and position, found to a fraction of a sample."""

import numpy as np
import pytest
from tests.identification.known_logs import TRUTH, log_of, sines, sliding_effort

from bristle.core.axis import Axis
from bristle.core.errors import InputError
from bristle.engine import force_along
from bristle.files import read_axis
from bristle.friction import find
from bristle.identification import identify
from bristle.identification.delay import delay_in
from bristle.identification.preprocessing import treat
from bristle.prediction import predict
from bristle.report.messages import assumptions_of

PHASES, DT = (0.3, 1.1, 2.5), 1e-3


def late(delay: float, noise: float = 0.1):
    """A log whose effort was recorded so much later than it acted [s]."""
    motion, fine = sines(phases=PHASES), sines(dt=1e-5, phases=PHASES)
    effort = sliding_effort(fine, noise=0.0)
    recorded = np.interp(motion.time - delay, fine.time, effort)
    return log_of(motion, recorded + np.random.default_rng(5).normal(0.0, noise, recorded.size))


@pytest.mark.parametrize("samples", [-1.7, -0.5, 0.0, 0.3, 2.2])
def test_a_delay_is_found_to_a_fraction_of_a_sample(samples):
    found, std = delay_in(treat(late(samples * DT), None))
    assert found == pytest.approx(samples * DT, abs=0.1 * DT)
    assert 0.0 < std < 0.1 * DT


def test_what_is_late_biases_nothing_once_its_delay_is_known():
    log = late(3.0 * DT)
    plain = identify(log, blocks=0).best
    asked = identify(log, axis=Axis(seeks_delay=True), blocks=0)
    assert asked.treatment["delay"] == pytest.approx(3.0 * DT, abs=0.1 * DT)
    assert asked.best.force_error_percent < 0.7 * plain.force_error_percent
    assert any("lags the position by 3 ms" in one or "samples), found" in one for one in assumptions_of(asked.best))
    for name in ("M", "F_C"):
        assert asked.best.parameters[name].value == pytest.approx(TRUTH[name], rel=0.01)
    known = predict(asked.best.plant, asked.best.friction, log, delay=asked.treatment["delay"])
    unaware = predict(asked.best.plant, asked.best.friction, log)
    assert known.metrics["force_error_percent"] < 0.7 * unaware.metrics["force_error_percent"]


def test_the_axis_file_asks_for_it(tmp_path):
    text = 'schema = 1\nkind = "translational"\n[columns]\nposition = "q"\n[timing]\ndelay = "identify"\n'
    (tmp_path / "axis.toml").write_text(text)
    axis = read_axis(tmp_path / "axis.toml")
    assert (axis.seeks_delay, axis.delay) == (True, 0.0)


def test_friction_before_sliding_is_taken_for_no_delay():
    fine = sines(20.0, 1e-4, (6e-6, 3e-6), (0.5, 1.7), (0.0, 1.0))
    friction = force_along(find("maxwell_slip")(F_C=20.0, k_i=[3e6, 2e6], nu_i=[0.5, 0.5]), fine.velocity, 1e-4)
    log = log_of(type(fine)(*(one[::10] for one in fine)), friction[::10])
    with pytest.raises(InputError, match="slides to and fro at several speeds") as caught:
        delay_in(treat(log, None, cutoff=20.0))
    assert caught.value.path == "timing.delay"
