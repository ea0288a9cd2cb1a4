"""Control laws in files: gains in the units of the drive."""

import math

import pytest

from bristle.core import Axis, Column, InputError
from bristle.files.controller import controller_of


def axis(base: str, scale: float, kind="translational", **gains):
    column = Column("u", base, base, scale)
    return Axis(kind=kind, columns={"effort": column}, controller={"model": "cascade", "k_p": 160.18, **gains})


@pytest.mark.parametrize(
    ("found", "k_v", "limit"),
    [
        (axis("V", 35.0, k_v="200 V*s/m", limit="10 V"), 7000.0, 350.0),
        (axis("V", -35.0, k_v="0.2 V*s/mm", limit="10000 mV"), 7000.0, 350.0),
        (axis("V", 35.0, k_v="7 N*s/mm", limit="350 N"), 7000.0, 350.0),
        (axis("V", 35.0, k_v=7000.0), 7000.0, math.inf),
        (axis("A", 0.12, "rotational", k_v="2 A*s/rad", limit="5 A"), 0.24, 0.6),
        (axis("rated", 2.4, "rotational", k_v=0.1, limit="50 %"), 0.1, 1.2),
        (axis("N", 1.0, k_v="7 N*s/mm"), 7000.0, math.inf),
    ],
)
def test_gains_of_the_drive_become_si(found, k_v, limit):
    law = controller_of(found)
    assert law.values["k_v"] == pytest.approx(k_v, rel=1e-12)
    assert law.values["limit"] == pytest.approx(limit, rel=1e-12)
    assert law.values["k_p"] == 160.18
    assert law.kind == found.kind


def test_an_axis_without_a_controller_has_none():
    assert controller_of(Axis()) is None


def test_a_unit_of_neither_is_refused():
    with pytest.raises(InputError, match=r"controller\.k_v.*N\*s/m"):
        controller_of(axis("V", 35.0, k_v="200 A*s/m"))
