"""``bristle design``: margins, budget and gains from an experiment file."""

import json
import math
from pathlib import Path

import pytest
from tests.cli.conftest import written_in

pytestmark = pytest.mark.usefixtures("undrawn")


def test_results_are_a_report_and_numbers(bristle, place):
    result = bristle("design", "experiment.toml", "--variant", "none", "--bandwidth", "10 Hz", "--out", "design")
    assert result.code == 0
    assert "Poles and margins of the sampled loop" in result.out
    assert "none: the sampled loop is stable" in result.out
    assert written_in("design") == {"summary.json", "report.html"}
    assert json.loads(Path("design/summary.json").read_text())["variant"] == "none"
    proposed = json.loads(Path("design/summary.json").read_text())["proposals"]["tuned"]
    assert proposed["bandwidth"] == pytest.approx(20.0 * math.pi)
    assert proposed["parameters"]["k_p"] == pytest.approx(5.0 * math.pi)
    page = Path("design/report.html").read_text()
    for name in ("margins", "circles"):
        assert f'<figure id="figure-{name}">' in page


@pytest.mark.slow
def test_an_unstable_loop_exits_with_1_its_pole_and_stable_gains(bristle, place):
    text = Path("experiment.toml").read_text()
    Path("experiment.toml").write_text(text.replace("[run]", "[run]\ndelay = 12"))
    ended = bristle("design", "experiment.toml", "--json", "--out", "design")
    assert ended.code == 1
    assert ended.data["stable"] is False
    assert "the sampled loop has a pole at" in ended.data["loops"]["base"]["sentence"]
    assert "samples of delay" in ended.data["loops"]["base"]["sentence"]
    assert ended.data["budget"] is None
    assert ended.data["proposals"]["tuned"]["following_error"]["peak_to_peak"] > 0.0
    assert (Path("design") / "report.html").is_file()
