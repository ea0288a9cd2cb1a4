"""What is kept of a block of runs, and which runs can be made many at once."""

from types import SimpleNamespace as Some

import numpy as np
import pytest
from tests.study.test_runs import LOOPS

from bristle import friction
from bristle.core import Status
from bristle.core.errors import InputError
from bristle.study import block as blocks
from bristle.study.block import FAILED, Simulator, Varied, _overridden, fits_a_batch, row_of
from bristle.study.plan import Block


def test_a_run_is_made_with_plain_numbers():
    values = {"a": np.array([1.0, 2.0]), "b": np.array(["x", "y"]), "c": np.array([[1, 2], [3, 4]])}
    row = row_of(values, 1)
    assert row == {"a": 2.0, "b": "y", "c": [3, 4]}
    assert [type(row["a"]), type(row["b"]), type(row["c"][0])] == [float, str, int]


@pytest.mark.parametrize(
    ("override", "keys", "own"),
    [
        ({}, ("friction", "F_C"), False),
        ({"friction": {"F_C": 1.0}}, ("friction", "F_C"), True),
        ({"friction": {"F_v": 1.0}}, ("friction", "F_C"), False),
        ({"friction": {"model": "dahl"}}, ("friction", "F_C"), True),
        ({"friction": {"file": "a.toml"}}, ("friction", "F_C"), True),
        ({"friction": "none"}, ("friction", "F_C"), False),
        ({"friction": {"model": "dahl"}}, ("plant", "M"), False),
    ],
)
def test_a_variant_keeps_values_under_keys_of_the_variant(override, keys, own):
    assert _overridden(override, keys) is own


def test_runs_that_failed_have_no_numbers():
    assert FAILED == ("not_finite", "refused", "raised")


def variant(**changes):
    run = Some(tolerance=0.0, delay=0, current_lag=0.0)
    known = {
        "run": run,
        "friction": friction.lugre(F_C=1.0, F_S=1.5, v_S=1e-3, sigma_0=1e5),
        "effort": 1,
        "disturbance": None,
        "start": None,
    }
    known |= {"plant": Some(component=Some(screw=None))}
    return Some(**known | changes)


@pytest.mark.parametrize(
    ("changes", "fits"),
    [
        ({}, True),
        ({"effort": None}, False),
        ({"plant": Some(component=Some(screw=1))}, False),
        ({"disturbance": 1}, False),
        ({"start": 1}, False),
        ({"run": Some(tolerance=1e-9, delay=0, current_lag=0.0)}, False),
        ({"run": Some(tolerance=0.0, delay=1, current_lag=0.0)}, False),
        ({"run": Some(tolerance=0.0, delay=0, current_lag=1e-3)}, False),
        ({"friction": friction.maxwell_slip(F_C=1.0, k_i=[1e5, 2e5], nu_i=[0.4, 0.6])}, False),
    ],
)
def test_runs_in_a_batch_have_a_single_mass_under_a_given_effort(changes, fits):
    assert fits_a_batch(Some(variants=[variant(**changes)])) is fits
    assert fits_a_batch(Some(variants=[variant(), variant(**changes)])) is fits


def test_a_block_has_a_row_for_each_of_the_runs(bench):
    columns = Simulator(bench.study()).columns(Block(4, 7))
    assert columns["run"].tolist() == [4, 5, 6]
    assert list(columns["seed"]) == bench.study().seeds(Block(4, 7))
    assert columns["status"] == ["ok"] * 3
    assert columns["reason"] == [""] * 3
    assert {len(column) for column in columns.values()} == {3}


def test_a_list_that_was_drawn_is_a_column_for_each_element(bench, monkeypatch):
    simulator = Simulator(bench.study())
    drawn = {"friction.K": np.arange(4.0).reshape(2, 2)}
    study = Some(values=lambda block: drawn, seeds=lambda block: [0, 0], metrics=())
    simulator.study, simulator.in_batches = study, False
    monkeypatch.setattr(simulator, "_serial", lambda *a: ("refused", "why"))
    columns = simulator.columns(Block(0, 2))
    assert columns["friction.K[0]"].tolist() == [0.0, 2.0]
    assert columns["friction.K[1]"].tolist() == [1.0, 3.0]
    assert "friction.K" not in columns
    assert (columns["status"], columns["reason"]) == (["refused"] * 2, ["why"] * 2)


@pytest.mark.parametrize(
    ("error", "status", "reason"), [(InputError("is wrong"), "refused", "is wrong"), (ValueError("x" * 400), "raised", "ValueError: xxx")]
)
def test_a_run_that_fails_is_reported_with_the_reason_in_short(bench, monkeypatch, error, status, reason):
    simulator = Simulator(bench.study(), batches=False)

    def fails(experiment):
        raise error

    monkeypatch.setattr(blocks, "simulate", fails)
    columns = simulator.columns(Block(0, 1))
    assert columns["status"] == [status]
    assert reason in columns["reason"][0]
    assert len(columns["reason"][0]) <= 300
    assert np.isnan(columns["effort.rms"][0])


def test_no_memory_is_no_reason_of_a_run(bench, monkeypatch):
    simulator = Simulator(bench.study(), batches=False)

    def fails(experiment):
        raise MemoryError

    monkeypatch.setattr(blocks, "simulate", fails)
    with pytest.raises(MemoryError):
        simulator.columns(Block(0, 1))


def test_the_worst_variant_sets_the_status_of_a_run(bench, monkeypatch):
    study = bench.study(LOOPS)
    simulator, ends = Simulator(study), {"plain": Status.OK, "stiff": Status.TOLERANCE_MISSED}
    result = Some(variants={name: Some(name=name, status=status) for name, status in ends.items()})
    monkeypatch.setattr(blocks, "simulate", lambda experiment: result)
    simulator.study = Some(metrics=())
    row = row_of(study.values(Block(0, 1)), 0)
    assert simulator._serial(0, row, 1, {}) == ("tolerance_missed", f"stiff: {Status.TOLERANCE_MISSED.sentence}")
    del result.variants["plain"]
    assert simulator._serial(0, row, 1, {}) == ("tolerance_missed", Status.TOLERANCE_MISSED.sentence)
    result.variants["stiff"].status = Status.OK
    assert simulator._serial(0, row, 1, {}) == ("ok", "")


def test_a_fed_forward_model_and_another_variant_are_placed_apart(bench):
    (sections,) = blocks._placed(bench.study())
    assert sections == {"friction": {"friction.F_C": "F_C"}, "plant": {"plant.M": "M"}}
    plain, stiff = blocks._placed(bench.study(LOOPS.replace('"friction.F_C"', '"compare.stiff.friction.F_C"')))
    assert "friction" not in plain
    assert stiff["friction"] == {"compare.stiff.friction.F_C": "F_C"}
    assert "controller" not in stiff  # whose gain is its own


@pytest.mark.parametrize(("number", "is_direct"), [(0, False), (5, True), (11, False)])
def test_the_first_and_the_last_run_decide_whether_values_are_set_directly(bench, monkeypatch, number, is_direct):
    study = bench.study()
    changed = row_of(study.values(Block(number, number + 1)), 0)
    models = Varied.models

    def heavier(self, values, *further):
        return models(self, values | {"plant.M": 2.0 * values["plant.M"]} if values == changed else values, *further)

    monkeypatch.setattr(Varied, "models", heavier)
    assert Varied(study).is_direct is is_direct
