"""The numbers that the pages tell of the source paper are those that come out."""

import re
from pathlib import Path

import numpy as np
import pytest

from bristle.files import read_experiment
from bristle.paper import EXPERIMENTS, write_experiments
from bristle.paper.setting import SECTIONS, read_setting

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/theory/the-source-paper.md").read_text(encoding="utf-8").replace("−", "-")


def test_the_experiment_in_the_docs_is_one(tmp_path):
    page = (ROOT / "docs/how-to/contact-experiment.md").read_text(encoding="utf-8")
    text = re.search(r"```toml contact\n(.*?)```", page, re.DOTALL)[1]
    own = write_experiments(tmp_path / "mine")[0].with_name("own.toml")
    own.write_text(text, encoding="utf-8")
    found = read_setting(own)
    assert list(found.contacts) == ["LuGre", "virtual rig"]
    assert found.contacts["virtual rig"].values["scatter"] == 0.0
    told = set(re.findall(r"^\| `\[(\w+)", page, re.MULTILINE))
    assert told == {"contact", "operator", "plant", *SECTIONS}
    for keys in SECTIONS.values():
        assert all(f"`{key}`" in page for key in keys)


def row(first):
    """The numbers of the row of a table that begins so, its first cell left out."""
    cells = next(line for line in PAGE.splitlines() if line.startswith(f"| {first} |")).split("|")[2:-1]
    return [float(one) for cell in cells for one in re.findall(r"(?<![\w(])-?\d+(?:\.\d+)?", cell)]


@pytest.mark.parametrize(
    ("first", "key", "place"),
    [
        ("1", "error_percent", 0),
        ("10", "error_percent", 3),
        ("100", "error_percent", 4),
        ("1, no scatter", "error_percent_without_scatter", 0),
        ("100, no scatter", "error_percent_without_scatter", 4),
    ],
)
def test_the_errors_over_branches(first, key, place, paper):
    lines = [line for line in PAGE.splitlines() if line.startswith(f"| {first} |")]
    told = [cell.strip() for cell in lines[-1].split("|")[2:-1]]
    found = [float(one[place]) for one in paper[6].numbers[key].values()]
    for text, value in zip(told, found, strict=True):
        assert np.isnan(value) if text == "–" else float(text) == pytest.approx(value, abs=0.06)
    assert paper[6].numbers["scatter_percent"] == pytest.approx(2.3, abs=0.05)


def test_the_loops_that_stay_open(paper):
    missing = paper[1].numbers["missing_at_return"]
    lugre, printed, rig = row("1")[:3]
    found = [-100.0 * missing[name] for name in ("LuGre", "equations (5)–(7)", "virtual rig")]
    assert (lugre, printed, rig) == pytest.approx(found, abs=0.5)


def test_the_drift(paper):
    drift = paper[2].numbers["drift_per_cycle"]
    step, more = row("2")[:2]
    assert 1e6 * drift["LuGre"] == pytest.approx(step, abs=0.005)
    assert 100.0 * (drift["equations (5)–(7)"] / drift["LuGre"] - 1.0) == pytest.approx(more, abs=0.5)


def test_the_other_figures(paper):
    rests, width = row("3")[:2]
    assert 1e9 * abs(paper[3].numbers["drift_per_cycle"]["virtual rig"]) == pytest.approx(rests, abs=0.5)
    drift, share = (paper[3].numbers[key]["virtual rig"] for key in ("drift_per_cycle", "share_of_the_orbit"))
    assert 1e6 * abs(drift) / share == pytest.approx(width, abs=0.006)
    bottom, top, tip = row("5")[:3]
    assert 1e3 * np.array(paper[5].numbers["largest_loop"]) == pytest.approx((bottom, top), abs=0.6)
    assert 1e3 * np.ptp(paper[5].numbers["forward_tips"]) == pytest.approx(tip, abs=0.5)
    assert f"{row('8')[1]:.0f} % of it after" not in " ".join(paper[8].found)
    assert f"of which it has {row('8')[1]:.0f} % after {row('8')[2]:.1f} µm" in " ".join(paper[8].found)
    printed = paper[10].numbers["missing_at_return"]["equations (5)–(7)"]["B"]
    assert -100.0 * printed == pytest.approx(row("9, 10")[-1], abs=0.5)


def test_the_tracking(paper):
    peaks, worse = paper[12].numbers["peak_to_peak"], paper[12].numbers["forward_over_backward"]
    _, before, after, less, forward = row("11, 12")
    assert (1e6 * peaks["none"], 1e6 * peaks["paper"]) == pytest.approx((before, after), abs=0.006)
    assert 100.0 * (1.0 - peaks["paper"] / peaks["none"]) == pytest.approx(less, abs=0.6)
    assert worse["paper"] == pytest.approx(forward, abs=0.05)
    means = [1e6 * paper[13].numbers[name][key] for key in ("mean", "std") for name in ("none", "paper")]
    assert row("13") == pytest.approx(means, abs=0.006)
    rms = paper[14].numbers["rms"]
    assert 100.0 * (rms["paper"] / rms["none"] - 1.0) == pytest.approx(row("14")[0], abs=0.06)
    told = (ROOT / "README.md").read_text(encoding="utf-8")
    assert f"{before:.2f} → {after:.2f} µm" in told
    assert f"{1e6 * peaks['observer_feedforward']:.2f} µm" in told


def test_the_switching_gain_is_a_sixteenth_of_what_sliding_needs():
    variant = next(one for one in read_experiment(EXPERIMENTS / "set_a.toml").variants if one.name == "none")
    needed = 0.5 * (variant.friction.values["F_S_pos"] + variant.friction.values["F_S_neg"]) / variant.plant.values["M"]
    assert needed / variant.controller.values["K_2"] == pytest.approx(16.0, abs=0.5)
