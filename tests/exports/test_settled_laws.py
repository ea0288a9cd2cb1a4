"""A law is written without what its parameters decide, in every language."""

from collections.abc import Mapping

import pytest
from tests.exports.test_law import variant

from bristle.core.experiment import Feedforward
from bristle.exports.c import law_files
from bristle.exports.described import Source
from bristle.exports.fmu_content import content_of_law
from bristle.exports.law import law_of
from bristle.exports.st import st_law_files
from bristle.exports.tunable import settled_law

LAW, TUNABLE = (law_of(variant(Feedforward(mass=2.0)), tunable=tunable) for tunable in (False, True))


def length(text) -> int:
    return sum(map(len, text.values())) if isinstance(text, Mapping) else len(text)


@pytest.mark.parametrize("write", [law_files, st_law_files], ids=["c", "st"])
def test_folding_earlier_or_later_gives_the_same_law(write):
    assert write(LAW, "axis_x", Source()) == write(settled_law(LAW), "axis_x", Source())


@pytest.mark.parametrize("write", [law_files, st_law_files], ids=["c", "st"])
def test_a_law_with_variable_parameters_is_longer(write):
    assert length(write(TUNABLE, "axis_x", Source())) > length(write(LAW, "axis_x", Source()))


def test_folding_earlier_or_later_gives_the_same_fmu_of_a_law():
    texts = [printed(content_of_law(law, "axis_x", Source()).unit) for law in (TUNABLE, settled_law(TUNABLE))]
    assert texts[0] == texts[1]


def printed(unit) -> str:
    """Every function of a unit, as its tree has it."""
    return "\n".join(repr((function.name, function.parameters, function.body)) for function in unit.functions)
