"""Numbers so small that their inverse is none are refused where they are asked for, with what is allowed."""

import pytest

from bristle.core import InputError, Variable
from bristle.core.edge import amount


@pytest.mark.parametrize("text", ["1e-320 Hz", "1e-310", "-1e-320"])
def test_a_number_without_an_inverse_is_refused(text):
    with pytest.raises(InputError, match=r"--cutoff: is out of any range.*allowed 0, or 1e-300"):
        amount(Variable("frequency", "cut-off"))(text, "--cutoff", None)


def test_zero_and_small_numbers_pass():
    assert amount(Variable("frequency", "cut-off"))("1e-290 Hz", "--cutoff", None) == 1e-290
    assert amount(Variable("frequency", "cut-off"))("0 Hz", "--cutoff", None) == 0.0
