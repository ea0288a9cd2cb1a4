import pytest

from bristle.identification.words import with_unit


@pytest.mark.parametrize(
    ("value", "quantity", "kind", "said"),
    [
        (0.02, "length/time", "translational", "20 mm/s"),
        (7e-6, "length", "translational", "7 um"),
        (1e-3, "length", "translational", "1 mm"),
        (1500.0, "length", "translational", "1.5e+03 m"),
        (-3.1648, "force", "translational", "-3.16 N"),
        (34e-3, "force", "rotational", "34 mN*m"),
        (5e6, "force/length", "translational", "5 MN/m"),
        (95.1, "mass", "translational", "95.1 kg"),
        (0.0, "force", "translational", "0 N"),
        (2.0, "1", "translational", "2"),
    ],
)
def test_values_are_said_in_three_digits(value, quantity, kind, said):
    assert with_unit(value, quantity, kind) == said
