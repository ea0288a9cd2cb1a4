"""A slot of a person's own is one file: identified, saved and predicted with, and the package is not touched."""

from pathlib import Path

import pytest
from tests.files.own_slot import AXIS, SLOT, TRUTH, write_bench

pytestmark = pytest.mark.usefixtures("undrawn")


@pytest.mark.slow
def test_from_the_log_to_the_prediction(bristle, here, monkeypatch):
    write_bench(here)
    models = "coulomb_viscous+oiled.py,coulomb_viscous"
    requested = ("identify", "log.csv", "--axis", "axis.toml", "--model", models, "--draws", "50")
    result = bristle(*requested, "--out", "results", "--json")
    assert result.code == 0, result.err
    assert result.data["models"][0]["name"] == "coulomb_viscous+oiled"
    fall = result.data["parameters"]["a"]
    low, high = fall["interval"]
    assert fall["status"] == "identified"
    assert low < TRUTH["a"] < high
    assert high - low < 0.1 * TRUTH["a"]
    assert result.data["parameters"]["b_0"]["status"] == "held"
    errors = [item["metrics"]["force_error_percent"] for item in result.data["models"]]
    assert errors[0] < 0.2 * errors[1]
    assert 'model = "coulomb_viscous+oiled.py"' in Path("results/model.toml").read_text()
    assert Path("results/oiled.py").read_text() == SLOT
    assert result.data["provenance"]["code"] == "oiled.py"

    message = bristle("predict", "results/model.toml", "log.csv", "--axis", "axis.toml", "--json")
    assert message.code == 0, message.err
    assert message.data["metrics"]["force_error_percent"] == pytest.approx(errors[0], rel=0.1)
    Path("dry.toml").write_text("\n".join(line for line in AXIS.splitlines() if "pressure" not in line))
    for command in (("predict", "results/model.toml", "log.csv"), ("identify", "log.csv", "--model", "lugre+oiled.py")):
        refused = bristle(*command, "--axis", "dry.toml")
        assert refused.code != 0
        assert "has no pressure, needed by +oiled" in refused.err
        assert 'pressure = { column = "...", unit = "N/m^2" }' in refused.err

    monkeypatch.setenv("BRISTLE_STATE_DIR", str(here / "another person"))
    refused = bristle("predict", "results/model.toml", "log.csv", "--axis", "axis.toml")
    assert refused.code != 0
    assert "oiled.py (SHA-256" in refused.err
    assert "needs permission to run" in refused.err
    assert bristle("predict", "results/model.toml", "log.csv", "--axis", "axis.toml", "--allow-code").code == 0


def test_it_is_shown_with_its_channel(bristle, here):
    Path("oiled.py").write_text(SLOT)
    shown = bristle("models", "lugre+oiled.py", "--json").data["models"][0]
    assert shown["name"] == "lugre+oiled"
    assert {"F_S", "a", "b_0"} <= set(shown["parameters"])
    assert shown["channels"] == ["pressure"]
    alone = bristle("models", "oiled.py")
    assert "e^" in alone.out or "exp" in alone.out
    assert "Needs channel pressure of the log: pressure of the oil, >= 0 N/m^2" in alone.out


@pytest.mark.slow
def test_it_is_checked(bristle, here):
    Path("oiled.py").write_text(SLOT)
    checked = bristle("check", "oiled.py", "--json")
    assert checked.code == 0
    assert checked.data["model"] == "oiled"
    assert {"neutral defaults", "same bits along its channel", "same bits exported"} <= set(checked.data["certificates"])
    Path("oiled.py").write_text(SLOT.replace('nominal=1e-5, excitation="channel")] = 0.0', 'excitation="channel")] = 1e-6'))
    drifted = bristle("check", "oiled.py", "--json")
    assert drifted.code == 1
    assert drifted.data["certificates"]["neutral defaults"]["passed"] is False
