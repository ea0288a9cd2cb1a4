"""``bristle paper``: figures of the source paper, their experiments, the report."""

import json
from pathlib import Path

import pytest
from tests.cli.conftest import written_in
from tests.report.pages import Page


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_one_figure_with_its_report(bristle):
    bristle("paper", "--figure", "4", "--out", "results", code=0, shown=("found in part", "factor 2"))
    assert written_in("results") == {"report.html", "summary.json"}
    page = Page(Path("results/report.html").read_text(encoding="utf-8"))
    assert [item["id"] for item in page.named("figure")] == ["fig-4"]
    summary = json.loads(Path("results/summary.json").read_text())
    assert summary["provenance"]["fig_04"] == "fig_04.toml"
    assert summary["provenance"]["command"] == "bristle paper --figure 4 --out results"


def test_results_go_to_their_usual_place_and_named_results_are_kept_without_force(bristle):
    for _ in range(2):  # the second time it replaces what it wrote unasked
        assert list(bristle("paper", "--figure", "4", "--json").data["figures"]) == ["4"]
    assert Path("bristle-paper/report.html").is_file()
    Path("bristle-paper").rename("results")
    bristle("paper", "--figure", "4", "--out", "results", code=2, said="--force")


def test_experiments_are_written_changed_and_run(bristle):
    assert bristle("paper", "--write", "mine").code == 0
    path = Path("mine/fig_09.toml")
    path.write_text(path.read_text().replace('file = "set_a_rig.toml"\n\n', 'file = "set_a_rig.toml"\nscatter = 0.2\n\n'))
    as_it_is = bristle("paper", "--figure", "9", "--json").data["figures"]["9"]["numbers"]
    changed = bristle("paper", "--figure", "9", "--from", "mine", "--json").data["figures"]["9"]["numbers"]
    before, after = (item["missing_at_return"]["virtual rig"]["B"] for item in (as_it_is, changed))
    assert abs(after) > 2.0 * abs(before)
    assert bristle("paper", "--write", "mine").code == 2
    bristle("paper", "--write", "mine", "--force", code=2, said="were changed: fig_09.toml")
    assert bristle("paper", "--write", "theirs", "--json").data["written"]
    assert bristle("paper", "--write", "theirs", "--force", "--json").data["written"]
