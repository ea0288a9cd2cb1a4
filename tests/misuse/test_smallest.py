"""Numbers so small that their inverse is none are refused where they are asked for, with what is allowed."""

import pytest

import bristle as br
from bristle.core import InputError, Variable
from bristle.core.edge import amount


@pytest.mark.parametrize("text", ["1e-320 Hz", "1e-310", "-1e-320"])
def test_a_number_without_an_inverse_is_refused(text):
    with pytest.raises(InputError, match=r"--cutoff: is too close to 0.*allowed 0, or 1e-300"):
        amount(Variable("frequency", "cut-off"))(text, "--cutoff", None)


def test_zero_and_small_numbers_pass():
    assert amount(Variable("frequency", "cut-off"))("1e-290 Hz", "--cutoff", None) == 1e-290
    assert amount(Variable("frequency", "cut-off"))("0 Hz", "--cutoff", None) == 0.0


@pytest.mark.parametrize("stroke", ['["0 m", "1e90 m"]', '["1e15 m", "1.1e15 m"]'])
def test_a_stroke_below_the_resolution_of_floats_is_refused(stroke):
    axis = br.Axis(
        stroke=tuple(float(end.split()[0].strip('["')) for end in stroke.split(",")),
        velocity_limit=0.1,
    )
    with pytest.raises(InputError, match=r"limits\.stroke: is so far from zero"):
        br.excite(axis, duration="10 s", rehearsed=False)


def test_the_harmonics_of_a_cogging_are_named_as_in_the_file(tmp_path):
    path = tmp_path / "axis.toml"
    path.write_text(
        'schema = 1\nkind = "translational"\ncolumns.position = { column = "x", unit = "m" }\n'
        'cogging = [{ turn = "motor", harmonics = [0] }]\n'
    )
    with pytest.raises(InputError, match=r"cogging\[0\]\.harmonics\[0\]: is not valid"):
        br.read_axis(path)
