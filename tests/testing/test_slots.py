"""What a slot is tried with: a path of its own, its channel from end to end, and both ends for an export."""

from types import SimpleNamespace

import numpy as np
import pytest

from bristle.friction import CHANNEL_SLOTS
from bristle.testing import slot as module
from bristle.testing.check import UnmetError
from bristle.testing.slot import range_of

SLOT = CHANNEL_SLOTS["pressure"]


def compared(monkeypatch, slot):
    """The motion and the channel along which plain Python and compiled code are compared."""
    seen = []
    monkeypatch.setattr(module, "force_along", lambda model, v, dt, x, **signals: seen.append((v, dt, x, signals)) or np.zeros(v.size))
    monkeypatch.setattr(module, "compiled_as_plain", lambda run, kind: run())
    module.same_bits_along_its_channel(slot)
    return seen[0]


def test_bits_are_compared_along_a_walk_while_the_channel_goes_from_end_to_end(monkeypatch):
    v, dt, x, signals = compared(monkeypatch, SLOT)
    assert dt == 1e-3
    assert v.size == x.size == 399
    assert np.diff(x) == pytest.approx(dt * v[1:], abs=1e-18)
    assert {np.sign(speed) for speed in v} == {1.0, -1.0}
    assert 1e-7 < np.std(np.diff(x)) < 1e-5
    pressure = signals["pressure"]
    assert (pressure[0], pressure[-1]) == tuple(range_of(SLOT))
    assert np.all(np.diff(pressure) > 0.0)
    again = compared(monkeypatch, SLOT)
    assert again[0].tolist() == v.tolist()  # the same walk each time


def exported(monkeypatch, messages, command="cc"):
    """The fact of an export whose self-tests of 100 steps end with messages, and the usual values that it was tried with."""
    left, usual = iter(messages), []
    monkeypatch.setattr(module, "compiler", lambda: command)
    monkeypatch.setattr(module, "proved", lambda model, command: (100, next(left)))

    def with_slot(slot, inner):
        usual.append(slot.channel.usual)
        return SimpleNamespace(inner=inner)

    monkeypatch.setattr(module, "model_with", with_slot)
    return module.same_bits_exported(SLOT), usual


def test_an_export_is_proved_at_both_ends_of_the_channel(monkeypatch):
    fact, usual = exported(monkeypatch, ["", ""])
    assert fact.detail == "200 steps compiled by cc"
    assert usual == [SLOT.channel.usual] * 2 if not SLOT.channel.is_own else list(range_of(SLOT))


def test_an_export_with_an_error_at_one_end_is_reported(monkeypatch):
    with pytest.raises(UnmetError, match="the last bit differs"):
        exported(monkeypatch, ["", "the last bit differs"])


def test_without_a_compiler_no_export_is_judged(monkeypatch):
    fact, usual = exported(monkeypatch, [], command=None)
    assert (fact.applies, usual) == (False, [])


def test_a_demand_on_a_model_is_met_by_a_model_of_bristle_with_the_slot():
    assert SLOT.name in module.on_a_model(lambda model: model)(SLOT).name.split("+")
