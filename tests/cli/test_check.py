"""``bristle check``: the contract suite from the command line."""

from pathlib import Path


def test_a_sound_model_of_a_users_own_passes(bristle, place):
    found = bristle("check", "own.py", "--json")
    assert found.code == 0
    assert found.data["passed"] is True
    assert all(one["passed"] for one in found.data["certificates"].values())
    measured = {name: one for name, one in found.data["certificates"].items() if one["value"] is not None}
    assert {"finite everywhere", "one sided limits", "dissipates", "refines", "same bits compiled"} <= set(measured)
    assert all(one["unit"] for one in measured.values())
    assert measured["dissipates"]["value"] > measured["dissipates"]["threshold"]
    assert measured["refines"]["value"] <= measured["refines"]["threshold"]
    assert found.data["certificates"]["rate agrees"]["applies"] is False  # it has no rate
    keys = {"applies", "value", "unit", "threshold", "passed", "advice"}
    assert all(keys <= set(one) for one in found.data["certificates"].values())


def test_a_model_that_pushes_fails_with_advice(bristle, place):
    Path("own.py").write_text(Path("own.py").read_text().replace("return p.F_0 *", "return -p.F_0 *"))
    found = bristle("check", "own.py", "--json")
    assert found.code == 1
    failed = {name for name, one in found.data["certificates"].items() if not one["passed"]}
    assert "dissipates" in failed
    assert all(name in found.err for name in failed)
    worst = found.data["certificates"]["dissipates"]
    assert worst["value"] < worst["threshold"] < 0.0
    shown = bristle("check", "own.py")
    assert shown.code == 1
    assert "NOT MET" in shown.out


def test_a_model_file_is_checked_with_its_values(bristle, place):
    assert bristle("check", "model.toml").code == 0
