"""``bristle check``: certificates of a model file, the contract suite for a model of a user's own."""

from pathlib import Path

import pytest
from tests.golden.yard import COMPOSITE, LUGRE

pytestmark = pytest.mark.usefixtures("undrawn")

EXAMPLE = Path(__file__).parents[2] / "examples" / "quadratic_drag.py"
KEYS = {"applies", "value", "unit", "threshold", "passed", "advice"}


@pytest.fixture
def models(tmp_path, monkeypatch):
    """A folder with a model that drifts and one that does not."""
    monkeypatch.chdir(tmp_path)
    Path("lugre.toml").write_text(LUGRE)
    Path("composite.toml").write_text(COMPOSITE)
    return tmp_path


def test_a_model_that_drifts_fails_with_advice(bristle, models):
    shown = bristle("check", "lugre.toml")
    assert shown.code == 1
    assert all(f"{name}: " in shown.err for name in ("passive", "drift", "closure"))
    assert shown.out.count("FAILED") == 3
    assert "30 mN·m·s/rad" in shown.out


def test_a_deflection_without_bound_is_an_answer_not_bad_input(bristle, models):
    Path("short.toml").write_text(COMPOSITE.replace("156 mN*m", "120 mN*m"))
    result = bristle("check", "short.toml", "--json")
    assert result.code == 1
    answer = result.data["certificates"]["well_posed"]
    assert answer["passed"] is False
    assert "raise f_p to at least 136.5 mN·m" in answer["advice"]


def test_a_broken_condition_without_a_certificate_is_bad_input(bristle, models):
    Path("reversed.toml").write_text(COMPOSITE.replace("100 mN*m", "140 mN*m").replace("156", "190"))
    result = bristle("check", "reversed.toml")
    assert result.code == 2
    assert "F_S >= F_C" in result.err


def test_ripple_and_loop_are_taken_with_their_units(bristle, models):
    options = ("--force-ripple", "40 mN*m,80 mN*m", "--loop", "3.77 mrad, 1.885 mrad")
    result = bristle("check", "lugre.toml", "--json", *options).data["certificates"]
    # 0.3895 um on a screw of 5 mm lead, and 30.7 % of break-away.
    assert result["drift"]["value"] == pytest.approx(0.38947 * 1.256637e-3, rel=1e-4)
    assert result["closure"]["value"] == pytest.approx(-0.307, abs=1e-3)


def test_a_sound_model_of_a_users_own_passes(bristle, place):
    result = bristle("check", "own.py", "--json")
    assert result.code == 0
    assert result.data["passed"] is True
    assert all(item["passed"] for item in result.data["certificates"].values())
    measured = {name: item for name, item in result.data["certificates"].items() if item["value"] is not None}
    assert {"finite everywhere", "one sided limits", "dissipates", "refines", "same bits compiled"} <= set(measured)
    assert all(item["unit"] for item in measured.values())
    assert measured["dissipates"]["value"] > measured["dissipates"]["threshold"]
    assert measured["refines"]["value"] <= measured["refines"]["threshold"]
    assert result.data["certificates"]["rate agrees"]["applies"] is False  # it has no rate
    assert all(set(item) >= KEYS for item in result.data["certificates"].values())


def test_a_model_that_pushes_fails_with_advice(bristle, place):
    Path("own.py").write_text(Path("own.py").read_text().replace("return p.F_0 *", "return -p.F_0 *"))
    result = bristle("check", "own.py", "--json")
    assert result.code == 1
    failed = {name for name, item in result.data["certificates"].items() if not item["passed"]}
    assert "dissipates" in failed
    assert all(name in result.err for name in failed)
    worst = result.data["certificates"]["dissipates"]
    assert worst["value"] < worst["threshold"] < 0.0
    shown = bristle("check", "own.py")
    assert shown.code == 1
    assert "NOT MET" in shown.out


def test_a_model_file_of_a_users_own_model_has_its_certificates(bristle, place):
    Path("mine.toml").write_text('schema = 1\n[friction]\nfile = "own.py"\nF_0 = "3 N"\n')
    assert bristle("check", "mine.toml", "--json").code == 2
    assert bristle("check", "own.py").code == 0  # which allows its code
    result = bristle("check", "mine.toml", "--json")
    assert result.code == 0
    verdicts = {name: item["passed"] for name, item in result.data["certificates"].items()}
    assert verdicts == {"well_posed": None, "passive": None, "drift": True, "closure": None, "dissipation": True}


def test_a_model_file_is_checked_with_its_values(bristle, place):
    assert bristle("check", "model.toml").code == 0


@pytest.mark.parametrize("command", [("check",), ("identify", "log.csv", "--axis", "axis.toml", "--model")])
@pytest.mark.parametrize(
    ("old", "new", "line", "place_of", "said"),
    [
        ('"force"', '"forse*time"', 9, "quantity of 'force against the motion'", "Did you mean 'force'?"),
        ('"force"', '"N"', 9, "quantity of 'force against the motion'", "not its unit"),
        ("directional=True", 'excitation="slide"', 9, "excitation of 'force against the motion'", "'sliding'?"),
        ('"""None."""', 'z: Annotated[float, Variable("depth", "depth")] = 0.0', 13, "quantity of 'depth'", "'depth' is unknown"),
    ],
)
def test_an_unknown_quantity_is_bad_input_with_its_line(bristle, place, command, old, new, line, place_of, said):
    text = Path("own.py").read_text().replace(old, new, 1)
    # Annotations that are evaluated late have no line.
    for custom, where in ((text, f"own.py, line {line}"), (f"from __future__ import annotations\n{text}", "own.py")):
        Path("own.py").write_text(custom)
        result = bristle(*command, "own.py")
        assert (result.code, result.out) == (2, "")
        assert result.err.startswith(f"bristle: {where}: {place_of}: is no")
        assert said in result.err
        assert "allowed" in result.err


@pytest.mark.slow
def test_a_product_of_quantities_is_described_checked_and_identified(bristle, place):
    for header in ("", "from __future__ import annotations\n"):
        custom = header + EXAMPLE.read_text()
        Path("drag.py").write_text(custom)
        assert bristle("check", "drag.py").code == 0
    result = bristle("identify", "log.csv", "--axis", "axis.toml", "--model", "drag.py", "--json")
    assert result.code == 0
    assert result.data["parameters"]["F_q"]["unit"] == "N*s^2/m^2"
