"""``bristle study`` in this process: what it writes, says and returns."""

import json

import pyarrow.parquet
import pytest
from tests.cli.conftest import progress_in_order
from tests.study.conftest import STUDY, Bench

from bristle.cli.main import main


@pytest.fixture
def bench(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for module in ("options", "study"):
        monkeypatch.setattr(f"bristle.cli.{module}.progress", progress_in_order)
    bench = Bench(tmp_path)
    bench.write(STUDY)
    return bench


def test_a_study_is_run_and_reported(bench, capsys, undrawn):
    assert main(["study", "study.toml", "--out", "out", "--workers", "1"]) == 0
    text = capsys.readouterr()
    assert "90 % of the runs from" in text.out
    assert "rank correlation" in text.out
    assert "open out/report.html" in text.err
    summary = json.loads((bench.folder / "out" / "summary.json").read_text())
    assert (summary["runs"], summary["done"], summary["statuses"]) == (12, 12, {"ok": 12})
    worst = summary["worst"]
    assert [entry["motion.peak_to_peak"] for entry in worst] == sorted((entry["motion.peak_to_peak"] for entry in worst), reverse=True)
    assert worst[0]["command"] == f"bristle study study.toml --run {worst[0]['run']} --out run_{worst[0]['run']}"
    page = (bench.folder / "out" / "report.html").read_text()
    assert worst[0]["command"] in page
    assert summary["provenance"]["command"] == "bristle study study.toml --out out"


def test_the_numbers_are_those_of_the_run_that_is_repeated(bench, capsys, undrawn):
    main(["study", "study.toml", "--out", "out", "--workers", "1", "--json"])
    kept = json.loads(capsys.readouterr().out)["worst"][0]
    assert main(["study", "study.toml", "--run", str(kept["run"]), "--json", "--out", "again"]) == 0
    repeated = json.loads(capsys.readouterr().out)
    assert repeated["variants"]["base"]["motion"]["peak_to_peak"] == kept["motion.peak_to_peak"]
    assert repeated["run"] == kept["run"]
    table = pyarrow.parquet.read_table(bench.folder / "out" / "runs").to_pylist()[kept["run"]]
    assert repeated["seed"] == table["seed"]
    assert repeated["values"]["friction.F_C"] == table["friction.F_C"]
    assert (bench.folder / "again" / "report.html").is_file()
    assert (bench.folder / "again" / "log.csv").is_file()


def test_a_report_of_a_grid_and_of_indices(bench, capsys, undrawn):
    grid = STUDY.replace("[keep]", '[grid]\n"effort.frequency" = ["2 Hz", "4 Hz"]\n[keep]')
    bench.write(grid, name="grid.toml")
    assert main(["study", "grid.toml", "--out", "grid", "--workers", "1"]) == 0
    page = (bench.folder / "grid" / "report.html").read_text()
    assert "effort.frequency 2" in page
    bench.write(STUDY.replace("runs = 12", "runs = 32").replace("seed = 7", "seed = 7\nsobol_indices = true"), "i.toml")
    assert main(["study", "i.toml", "--out", "indices", "--workers", "1", "--json"]) == 0
    capsys.readouterr()
    summary = json.loads((bench.folder / "indices" / "summary.json").read_text())
    assert [entry["cause"] for entry in summary["sobol_indices"]][:2] == ["friction.F_C", "plant.M"]
    assert "Sobol indices" in (bench.folder / "indices" / "report.html").read_text()


@pytest.mark.slow
def test_figures_of_a_study_replace_those_of_an_earlier_report(bench, capsys):
    assert main(["study", "study.toml", "--out", "out", "--workers", "1", "--format", "svg", "--format", "csv"]) == 0
    figures = bench.folder / "out" / "figures"
    names = {file.name for file in figures.iterdir()}
    assert {"spread.svg", "captions.txt"} <= names
    assert any(name.startswith("spread") and name.endswith(".csv") for name in names)
    page = (bench.folder / "out" / "report.html").read_text()
    assert page.count("<figure id=") == len(list(figures.glob("*.svg")))
    (figures / "mine.svg").write_text("of a person")
    assert main(["study", "study.toml", "--out", "out", "--format", "pdf"]) == 0
    drawn = {file.name for file in figures.iterdir()}
    assert {"mine.svg", "spread.pdf", "captions.txt"} <= drawn
    assert [name for name in drawn if name.endswith((".svg", ".csv"))] == ["mine.svg"]
    captions = (figures / "captions.txt").read_text()
    (figures / "captions.txt").write_text("of a person")
    capsys.readouterr()
    assert main(["study", "study.toml", "--out", "out", "--format", "svg"]) == 2
    assert "were changed: figures/captions.txt" in capsys.readouterr().err
    assert (figures / "captions.txt").read_text() == "of a person"
    assert (figures / "spread.pdf").is_file()
    (figures / "captions.txt").write_text(captions)
    assert main(["study", "study.toml", "--out", "out", "--format", "svg"]) == 0
    assert {file.suffix for file in figures.iterdir()} == {".svg", ".txt"}
    assert (figures / "spread.svg").is_file()


def test_a_study_with_only_refused_runs_exits_with_1(bench, capsys, undrawn):
    never = '"run.settle" = { uniform = ["2 s", "3 s"] }'
    bench.write(STUDY.replace('"friction.F_C" = { normal = ["1 N", "0.1 N"] }', never))
    assert main(["study", "study.toml", "--out", "out", "--workers", "1"]) == 1
    assert "12 of 12 runs failed: 12 refused." in capsys.readouterr().out
