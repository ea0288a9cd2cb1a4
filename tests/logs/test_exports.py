"""Files of other programs: each is understood untold, and the same numbers come from all of them."""

import re

import numpy as np
import pytest
from tests.logs.binary_exports import BINARY
from tests.logs.exports import EXPORTS, RATED, motion

from bristle.files.axis import read_axis
from bristle.files.proposal import propose_axis
from bristle.logs import read_log, summarize

ALL = EXPORTS | BINARY
MOTION = motion()


@pytest.mark.parametrize("name", ALL)
def test_a_log_of_another_program_is_read_and_its_axis_file_proposed(tmp_path, name):
    export = ALL[name]
    path = export.write(tmp_path, MOTION)
    proposal = propose_axis(path)
    assert set(proposal.missing) == set(export.filled)
    assert len(proposal.missing) <= 2
    assert summarize(path, proposal.axis)["problems"] == []
    text = proposal.text
    for key, value in export.filled.items():
        last = key.rpartition(".")[2]
        channel = key.split(".")[1] if key.startswith("columns") else ""
        text, count = re.subn(rf'(?m)^({channel}.*?{last} = )"\?"', rf'\1"{value}"', text, count=1)
        assert count == 1
    file = tmp_path / "axis.toml"
    file.write_text(text, encoding="utf-8")
    axis = read_axis(file)
    log = read_log(path, axis)
    assert axis.kind == "translational"
    assert log.sample_time == pytest.approx(1e-3, rel=1e-12)
    at = np.round(log.position.values * 1e6).astype(int)
    first = int(np.flatnonzero(MOTION.position_um == at[0])[0])
    expected = slice(first, first + len(log))
    assert len(log) >= 0.99 * MOTION.time_us.size
    np.testing.assert_allclose(log.position.values, 1e-6 * MOTION.position_um[expected], rtol=1e-12, atol=1e-18)
    truth = 1e-3 * RATED * MOTION.torque[expected]
    if export.exact:
        np.testing.assert_allclose(log.effort.values, truth, rtol=1e-12, atol=1e-12)
    else:
        assert np.sqrt(np.mean((log.effort.values - truth) ** 2)) < 0.1 * np.std(truth)
        assert [found.code for found in log.findings] == ["rates_differ"]
    if log.reference is not None:
        np.testing.assert_allclose(log.reference.values, 1e-6 * MOTION.reference_um[expected], rtol=1e-12, atol=1e-18)
