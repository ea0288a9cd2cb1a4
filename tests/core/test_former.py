"""Names of earlier releases: each is refused with its successor, from one table."""

import importlib
import importlib.util
import re
from pathlib import Path

import pytest

import bristle
from bristle.core.former import FORMER, SUCCESSORS
from bristle.report.sentences import SENTENCES

ROOT = Path(__file__).parents[2]
MODULES = ("workflow", "stability", "loop_design", "hysteresis_identification")
IN_PYTHON = [
    name
    for name in FORMER
    if name.startswith("bristle.") and not name.endswith("*") and name.split(".")[1] not in MODULES
]


def test_the_table_stays_short():
    assert len(SUCCESSORS) <= 40


@pytest.mark.parametrize(
    ("place", "advice"),
    [
        ("load_model_file", "does not exist. Call bristle.load_code"),
        ("files.load_model_file", "does not exist. Call bristle.load_code"),
        ("apps.targets.AxisEnv", "Copy the environment from examples/gymnasium_environment.py"),
        (
            "simulation.certificates.traced_by_force",
            "does not exist. Call traced(model, Path.to_force, levels)",
        ),
        ("simulation.certificates.traced_by_position", "traced(model, Path.to_position, turns)"),
        (
            "engine.force_in_turns",
            "does not exist. Call bristle.engine.force_along for each trajectory",
        ),
        ("report.figures.drive_table", "A figure of one report is in its module"),
        (
            "report.figures.residuals",
            "does not exist. A figure of one report is in its module, such as bristle.report.figures.fit",
        ),
        ("apps.study.fleet.Fleet", "Look in its modules fleet.plan and run"),
        ("apps.study.fleet.watch", "does not exist. Use bristle identify LOGS --each"),
        ("identification.Traces", "Parts of a result are in bristle.identification.result"),
        ("logs.sign_of_effort", "does not exist. Run bristle log"),
        ("apps.study.repeat_run", "Look in its modules fleet.plan and run"),
    ],
)
def test_a_former_name_is_refused_with_its_successor(place, advice):
    package, _, name = f"bristle.{place}".rpartition(".")
    with pytest.raises(AttributeError, match=re.escape(advice)):
        getattr(importlib.import_module(package), name)
    with pytest.raises(ModuleNotFoundError, match=re.escape(advice)):
        exec(f"from {package} import {name}")


@pytest.mark.parametrize("place", IN_PYTHON)
def test_each_name_of_the_table_is_one_that_bristle_does_not_have(place):
    package, _, name = place.rpartition(".")
    with pytest.raises(AttributeError, match="does not exist"):
        getattr(importlib.import_module(package), name)


@pytest.mark.parametrize(
    ("module", "advice"),
    [
        ("workflow", "Call identify, compare, load and prepare of bristle"),
        ("stability", "Its names are in bristle.apps.design"),
        ("loop_design", "Its names are in bristle.apps.design"),
        ("hysteresis_identification", "Its names are in bristle.identification.hysteresis"),
        ("apps.targets.gymnasium", "Copy the environment from examples/gymnasium_environment.py"),
        ("apps.targets.torch", "Copy the function from examples/torch_friction.py"),
    ],
)
def test_a_former_module_is_refused_with_its_successor(module, advice):
    package, _, name = f"bristle.{module}".rpartition(".")
    for statement in (
        f"import {package}.{name}",
        f"from {package}.{name} import anything",
        f"from {package} import {name}",
    ):
        with pytest.raises(
            ModuleNotFoundError, match=rf"^bristle\.{module} does not exist\. {advice}"
        ):
            exec(statement)


@pytest.mark.parametrize("advice", SUCCESSORS.values())
def test_a_successor_exists(advice):
    for place in re.findall(r"bristle(?:\.\w+)+", advice):
        package, _, name = place.rpartition(".")
        owner = importlib.import_module(package)
        assert hasattr(owner, name) or importlib.util.find_spec(place)
    assert set(re.findall(r"bristle explain (\w+)", advice)) <= set(SENTENCES)
    assert all((ROOT / place).is_file() for place in re.findall(r"examples/\w+\.py", advice))


def test_other_unknown_names_have_the_error_of_python():
    with pytest.raises(
        AttributeError, match=r"^module 'bristle\.engine' has no attribute 'nonsense'$"
    ):
        _ = bristle.engine.nonsense
    with pytest.raises(ModuleNotFoundError, match=r"^No module named 'bristle\.nonsense'$"):
        __import__("bristle.nonsense")
    with pytest.raises(ImportError, match=r"^cannot import name 'nonsense' from 'bristle\.engine'"):
        exec("from bristle.engine import nonsense")


def test_a_module_of_a_package_with_former_names_is_found():
    from bristle.report.figures import comparison

    assert comparison.__name__ == "bristle.report.figures.comparison"
    assert not hasattr(bristle.report.figures, "np")
