"""Every figure of the gallery looks as it was frozen: its panels, each line and mark with its numbers, and what stands at the axes."""

import inspect

import pytest
from tests.figures.gallery import gallery
from tests.figures.looks import differences, frozen, look_of

from bristle.figures import (
    comparison,
    fit,
    following_error,
    loop_design,
    loop_rows,
    many_runs,
    motion,
    preisach,
    recorded,
    rig_layout,
    small_multiples,
)

DRAWS, FROZEN = gallery(), frozen()
MODULES = (comparison, fit, inspect.getmodule(following_error), loop_design, loop_rows, many_runs, motion, preisach, recorded)
MODULES += (rig_layout, small_multiples)


@pytest.mark.parametrize("name", DRAWS)
def test_a_figure_looks_as_frozen(name):
    assert list(differences(FROZEN[name], look_of(DRAWS[name]()))) == []


def test_a_look_that_changed_is_reported_by_the_place():
    was = {"panels": [{"box": [1.0, 2.0], "titles": ["a"]}]}
    assert list(differences(was, {"panels": [{"box": [1.0, 2.00001], "titles": ["a"]}]})) == []
    assert list(differences(was, {"panels": [{"box": [1.0, 2.1], "titles": ["a"]}]})) == ["/panels/0/box: [1.0, 2.0] became [1.0, 2.1]"]
    assert list(differences(was, {"panels": [{"box": [1.0], "titles": ["b"]}]})) == [
        "/panels/0/box: [1.0, 2.0] became [1.0]",
        "/panels/0/titles/0: a became b",
    ]


def test_the_gallery_draws_every_figure():
    styled = {
        name
        for module in MODULES
        for name, function in vars(module).items()
        if getattr(function, "__module__", "") == module.__name__ and hasattr(function, "__wrapped__")
    }
    assert len(styled) > 25
    assert {name for name in styled if f"{name}(" not in inspect.getsource(gallery)} == set()
