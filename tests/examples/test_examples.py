"""Every example runs as a user runs it, and prints the numbers that it is there to show."""

import re
from pathlib import Path

import pytest
from tests.examples.data import EXAMPLES, printed

pytestmark = pytest.mark.slow

SCRIPTS = sorted(EXAMPLES.glob("0*.py"))


def number_after(text, output):
    return float(re.search(re.escape(text) + r"\s*(-?[\d.]+)", output)[1])


def test_every_example_is_short_and_tested():
    asserted = Path(__file__).read_text()
    assert [script.name for script in SCRIPTS if script.name not in asserted] == []
    assert len(SCRIPTS) >= 4
    assert max(len(script.read_text().splitlines()) for script in SCRIPTS) < 40
    assert (
        max(
            len((EXAMPLES / name).read_text().splitlines())
            for name in ("gymnasium_environment.py", "torch_friction.py")
        )
        <= 40
    )


def test_response():
    output = printed("01_response.py")
    largest = number_after("largest force:", output)
    # The bristle force lies between Coulomb and static friction; micro-damping adds less than 0.1 N.
    assert 20.0 < largest < 28.1
    # Half of the force flips over the deflection F/sigma_0 and the exponential tail behind it.
    assert 1.0 < number_after("the force changes sign", output) < 5.0


def test_identify():
    output = printed("02_identify.py")
    assert output.startswith("1. lugre+asymmetry")
    assert number_after("lugre+asymmetry:", output) < 0.5 * number_after("coulomb_viscous:", output)
    # The simulated table weighs 28 kg.
    assert number_after("M =", output) == pytest.approx(28.0, rel=0.01)
    assert number_after("F_C_pos =", output) > number_after("F_C_neg =", output)


def test_compensate():
    output = printed("03_compensate.py")
    none, crude, exact = (number_after(f"{name}:", output) for name in ("none", "crude", "exact"))
    assert exact < 0.05 * none
    assert exact < crude < none


def test_own_model():
    output = printed("04_own_model.py")
    assert "NOT MET" not in output
    assert output.count("met: ") >= 10
    # At 1 m/s the drag is the number of its coefficient.
    assert number_after("force at 1 m/s:", output) == pytest.approx(20.0 + 125.0, rel=1e-6)
    # 100 N carry 80 N of drag.
    assert number_after("speed under 100 N:", output) == pytest.approx(
        (80.0 / 125.0) ** 0.5, rel=1e-3
    )
    assert "under 10 N: friction 10.000 N, speed 0.0 m/s" in output


def test_many_at_once():
    least, most = re.search(
        r"following error of 100 axes: ([\d.]+) to ([\d.]+) um", printed("05_many_at_once.py")
    ).groups()
    # 15 % of the friction is missing at most, on either side, and the loop holds against it with 60 * 6700 N/m.
    stiffness = 60.0 * 6700.0
    assert 0.5 * 2e6 * 0.15 * 20.0 / stiffness < float(most) < 1.2 * 2e6 * 0.15 * 28.0 / stiffness
    assert float(least) < 0.2 * float(most)
