"""Names of release 0.2: those that moved work with a warning, and those that were removed state their successor."""

from importlib import import_module

import pytest

import bristle
from bristle.removed import HOMES, PACKAGES, SUCCESSORS


@pytest.mark.parametrize(
    ("package", "name", "home"),
    [
        ("bristle.stability", "assess", "bristle.loop"),
        ("bristle.loop_design", "error_budget", "bristle.loop"),
        ("bristle.hysteresis_identification", "fit_grid", "bristle.hysteresis.identification.linear"),
        ("bristle.figures", "residuals", "bristle.figures.fit"),
        ("bristle.fleet", "Fleet", "bristle.fleet.plan"),
    ],
)
def test_a_moved_name_is_the_same_object_and_warns(package, name, home):
    with pytest.warns(DeprecationWarning, match=f"{package}.{name} moved to"):
        moved = getattr(import_module(package), name)
    assert moved is getattr(import_module(home), name)


@pytest.mark.parametrize("place", SUCCESSORS)
def test_a_removed_name_states_its_successor(place):
    package, _, name = place.rpartition(".")
    with pytest.raises(AttributeError, match=r"was removed in bristle 0\.3\. \w+"):
        getattr(import_module(package), name)


def test_imports_of_a_module_are_not_its_names(recwarn):
    for name in ("np", "Any", "_own", "__wrapped__"):
        with pytest.raises(AttributeError):
            getattr(bristle.figures, name)
    assert not recwarn.list


def test_an_unknown_name_is_an_attribute_error_as_usual():
    with pytest.raises(AttributeError, match=r"module 'bristle\.engine' has no attribute 'nonsense'"):
        _ = bristle.engine.nonsense
    with pytest.raises(ModuleNotFoundError):
        __import__("bristle.nonsense")


def test_a_submodule_comes_before_a_former_name():
    from bristle.figures import comparison

    assert comparison.__name__ == "bristle.figures.comparison"


def test_packages_that_exist_are_not_shadowed():
    for package in HOMES:
        module = __import__(package, fromlist=["x"])
        assert (module.__spec__.origin is None) == (package in PACKAGES)


def test_the_aliases_of_0_2_end_with_0_4():
    """Delete `bristle.removed` and this file then."""
    assert tuple(map(int, bristle.__version__.split(".")[:2])) < (0, 4)
