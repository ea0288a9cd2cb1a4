"""The fingerprint of code sees what the dispatch would call."""

from typing import NamedTuple

from bristle.core.dispatch import everett, register
from bristle.core.fingerprint import fingerprint


def measured(value):
    """The fingerprint of a function that builds a measure whose Everett function is `value`."""

    class Measure(NamedTuple):
        s: float

    register("everett", Measure, {"value": value})

    def operator(alpha, beta):
        return everett(alpha, beta, Measure(2.0))

    return fingerprint(operator), operator(3.0, 1.0)


def flat(alpha, beta, q):
    return q.s * (alpha - beta)


def steep(alpha, beta, q):
    return q.s * (alpha - beta) * (alpha - beta)


def test_a_change_behind_the_dispatch_is_a_change():
    (first, one), (again, same), (other, another) = measured(flat), measured(flat), measured(steep)
    assert (one, same, another) == (4.0, 4.0, 8.0)
    assert first == again
    assert first != other
