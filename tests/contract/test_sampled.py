"""What is demanded of a law or a sensor: each fault is told by the demand that it misses."""

from pathlib import Path

import pytest

from bristle.contract import check_model
from bristle.core import InputError
from bristle.core.contracts import Controller, Sensor
from bristle.files.user_model import load_component_file
from bristle.models.controllers import CONTROLLERS
from bristle.models.plants import inertia
from bristle.models.sensors import SENSORS

FOLDER = Path(__file__).parents[2] / "examples" / "own_loop"
EFFORT = """effort = p.K_P * e + p.K_I * total + p.K_D * (e - state.e) / dt + reference.effort
    return effort, State(e, total)"""
READS = "return x + p.a * sin(FOUR_PI * x / p.L), state"


def unmet(folder: Path, name: str, old: str, new: str) -> tuple[str, str, str]:
    text = (FOLDER / name).read_text(encoding="utf-8")
    assert old in text
    (folder / name).write_text(text.replace(old, new), encoding="utf-8")
    (failed,) = [
        item
        for item in check_model(load_component_file(folder / name, Controller, Sensor))
        if not item.passed
    ]
    return failed.name, failed.detail, failed.advice


@pytest.mark.parametrize(
    "component", [*CONTROLLERS.values(), *SENSORS.values()], ids=lambda one: one.name
)
def test_built_in_laws_and_sensors_meet_the_contract(component):
    assert [item.name for item in check_model(component) if not item.passed] == []


@pytest.mark.parametrize(
    ("name", "old", "new", "demand", "said"),
    [
        (
            "pid.py",
            EFFORT,
            "return 0.0, p",
            "law results",
            "step returned a Parameters as its state",
        ),
        (
            "pid.py",
            EFFORT,
            "return dt / (dt - dt), state",
            "law results",
            "stops with ZeroDivisionError",
        ),
        ("pid.py", "return State()", "return dt", "law kernels", ""),
        (
            "pid.py",
            EFFORT,
            'return float("1.0"), state',
            "law kernels",
            "pid.py, line 28: '1.0' is not a number, an argument",
        ),
        ("pid.py", "@kernel\ndef start", "def start", "law kernels", "start is not a kernel"),
        ("pid.py", '"K_P": 4e6, ', '"K_P": "4e6 kg", ', "example", "has the wrong unit"),
        ("resolver.py", READS, "return float('nan') * x, state", "sensor kernels", ""),
        (
            "resolver.py",
            READS,
            "return x, p",
            "sensor results",
            "step returned a Parameters as its state",
        ),
        (
            "resolver.py",
            READS,
            "return x * 1e308 * 1e308, state",
            "sensor results",
            "the position is float inf",
        ),
        ("resolver.py", "@kernel\ndef step", "def step", "sensor kernels", "step is not a kernel"),
    ],
)
def test_each_fault_is_reported(tmp_path, name, old, new, demand, said):
    failed, detail, _ = unmet(tmp_path, name, old, new)
    assert failed == demand
    assert said in detail


def test_a_law_with_memory_outside_its_state_is_reported(tmp_path):
    remembered = (
        "state = state if state.total != 0.0 else State(state.e, LAST.pop() if LAST else 1.0)\n    "
        + EFFORT
    )
    text = (FOLDER / "pid.py").read_text(encoding="utf-8").replace(EFFORT, remembered)
    (tmp_path / "pid.py").write_text(
        text.replace("@kernel\ndef step", "LAST = [2.0]\n\n\n@kernel\ndef step")
    )
    failed = [
        item
        for item in check_model(load_component_file(tmp_path / "pid.py", Controller))
        if not item.passed
    ]
    assert failed
    assert failed[0].name in ("law kernels", "law results")


def test_an_object_without_a_contract_is_refused():
    with pytest.raises(InputError, match="is not a friction model, slot, control law or sensor"):
        check_model(inertia(M=1.0))
