"""The fingerprint of code sees what the dispatch would call."""

import sys
from typing import NamedTuple

from bristle.contract import example_of
from bristle.core.dispatch import everett, functions_of, register
from bristle.core.fingerprint import fingerprint
from bristle.models.hysteresis import OPERATORS


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
    (first, item), (again, same), (other, another) = measured(flat), measured(flat), measured(steep)
    assert (item, same, another) == (4.0, 4.0, 8.0)
    assert first == again
    assert first != other


def defined(level):
    """A function that reads a global, and one that only asks its argument for something of that name."""
    scope = {"level": level}
    exec("def reads(q):\n    return q.s * level\n\ndef asks(q):\n    return q.s * q.level\n", scope)
    return fingerprint(scope["reads"]), fingerprint(scope["asks"])


def test_attributes_with_names_of_globals_are_not_followed():
    (reads, asks), (reads_other, asks_other) = defined(1.0), defined(2.0)
    assert reads != reads_other
    assert asks == asks_other


def test_further_components_keep_existing_fingerprints(monkeypatch):
    # What a kernel asks of its parameters may be called as the decorator is, which knows every kernel there is.
    functions = functions_of(type(example_of(OPERATORS["preisach"]).parameters))
    before = [fingerprint(function) for function in functions]
    monkeypatch.setattr(sys.modules["bristle.core.kernel"], "_kernels", [(flat, True)])
    assert functions
    assert [fingerprint(function) for function in functions] == before
