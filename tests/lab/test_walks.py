"""The walks that every page repeats are those of the models as they are; write_walks writes them anew."""

import pytest

from bristle.exports.page.described import BLOCK, LONG, PUSHED, example_named, stored, walks_of
from bristle.exports.page.switches import all_walks
from bristle.friction import MODELS


def test_every_model_has_its_walks():
    lacking = " ".join(MODELS.keys() - stored().keys())
    assert list(stored()) == list(MODELS), f"run: python -m tests.lab.write_walks {lacking}"
    for walks in stored().values():
        assert (walks["contact"]["count"], walks["mass"]["count"]) == (LONG, PUSHED)
        assert len(walks["contact"]["hashes"]) == LONG // BLOCK


@pytest.mark.fast_cases(8)
@pytest.mark.parametrize("name", MODELS)
def test_the_walks_are_up_to_date(name):
    fresh, kept = walks_of(example_named(name), BLOCK), stored()[name]
    assert fresh["mass"] == kept["mass"]
    assert fresh["contact"]["hashes"] == kept["contact"]["hashes"][:1]
    assert fresh["contact"]["scales"] == kept["contact"]["scales"]


@pytest.mark.slow
@pytest.mark.parametrize("name", MODELS)
def test_all_of_the_walks_is_up_to_date(name):
    assert all_walks(example_named(name)) == stored()[name]
