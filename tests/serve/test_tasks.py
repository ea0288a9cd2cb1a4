"""What jobs answer, each by small logs or by what stands in for the work."""

import shutil
from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.server import loop, tasks
from bristle.server.errand import Errand, LabelledLog, as_table

AXIS = 'schema = 1\nkind = "translational"\n[columns]\ntime = "time"\nposition = "x"\neffort = "force"\n'


def log(rows=400):
    t = 0.001 * np.arange(rows)
    return "time,x,force\n" + "".join(
        f"{a:.4f},{b:.8f},{c:.4f}\n" for a, b, c in zip(t, 0.01 * np.sin(20.0 * t), 3.0 * np.sign(np.cos(20.0 * t)), strict=True)
    )


@pytest.fixture
def errand(tmp_path):
    """A function that returns an errand with logs by label and role."""
    reported = []

    def errand(logs, text=AXIS, **options):
        labelled = []
        for number, (label, role, content) in enumerate(logs):
            place = tmp_path / f"file-{number}"
            place.write_text(content)
            labelled.append(LabelledLog(place, label, role))
        return Errand(tmp_path, tuple(labelled), text, "axis.toml", options, 2**20, None, lambda *call: reported.append(call), nullcontext)

    errand.told = reported
    return errand


def test_every_log_is_checked_and_problems_are_counted(errand):
    facts, data = tasks.check(errand([("a.csv", "fit", log()), ("b.csv", "held_out", "nothing\n"), ("c.csv", "held_out", log())]))
    assert [(entry["label"], entry["role"]) for entry in data["logs"]] == [("a.csv", "fit"), ("b.csv", "held_out"), ("c.csv", "held_out")]
    assert facts["problems"] == len(data["logs"][1]["problems"]) >= 1
    assert not facts["ready"]
    assert data["logs"][0]["rate"] == pytest.approx(1000.0)
    assert errand.told == [(0.0, "reading a.csv"), (1.0 / 3.0, "reading b.csv"), (2.0 / 3.0, "reading c.csv")]


def test_warnings_are_counted_and_notes_are_not(errand, monkeypatch):
    def inspected(content, axis, size_limit):
        summary = dict.fromkeys(("rate", "duration", "kind", "channels", "notes"))
        diagnostics = [{"severity": severity} for severity in ("warning", "note", "error")]
        return SimpleNamespace(summary=summary | {"passages": [], "diagnostics": diagnostics, "problems": []})

    monkeypatch.setattr(tasks, "inspect_log", inspected)
    facts, data = tasks.check(errand([("a.csv", "fit", ""), ("b.csv", "fit", "")]))
    assert facts == {"problems": 0, "warnings": 4, "ready": True}
    assert data["logs"][0]["passages"] is None


def test_a_command_contains_options_with_a_value():
    command = tasks._command("identify", ["a b.csv", "c.csv"], {"--axis": "x.toml", "--draws": "", "--cutoff": None, "--out": "results"})
    assert command == "bristle identify 'a b.csv' c.csv --axis x.toml --out results"


def test_columns_are_shown_as_recorded_until_their_units_are_known():
    table = SimpleNamespace(columns={"t": np.arange(3.0), "x": np.array([1.0, 2.0, 3.0]), "u": np.array([4.0, 5.0]), "none": np.empty(0)})
    inspected = SimpleNamespace(table=table)
    columns = {
        "time": {"column": "t", "unit": "ms"},
        "position": {"column": "x", "unit": "mm"},
        "velocity": {"column": "none", "unit": "mm/s"},
        "reference": {"column": "gone"},
        "effort": {"column": "u", "unit": "?"},
    }
    position, effort = tasks._of_columns(inspected, columns)
    assert (position["word"], position["unit"], position["column"], position["time_unit"]) == ("position", "mm", "x", "ms")
    assert position["curve"] == [[0.0, 1.0, 2.0], [1.0, 2.0, 3.0]]
    assert (effort["word"], effort["unit"], effort["time_unit"]) == ("effort", "as recorded", "sample")
    assert effort["curve"] == [[0.0, 1.0], [4.0, 5.0]]
    (bare,) = tasks._of_columns(inspected, {"position": {"column": "x", "unit": ""}})
    assert (bare["unit"], bare["time_unit"], bare["curve"][0]) == ("as recorded", "sample", [0.0, 1.0, 2.0])


def test_a_log_without_an_axis_file_is_read_with_a_proposal(errand):
    facts, data = tasks.look(errand([("a.csv", "fit", log())], text=""))
    assert "[columns]" in facts["axis_text"]
    assert "columns.position.unit" in facts["missing"] or facts["ready"]
    assert data["log"] == "a.csv"
    assert errand.told == [(0.1, "reading the log")]
    with pytest.raises(InputError, match="Drop a log to fit"):
        tasks.look(errand([("a.csv", "held_out", log())]))


def test_a_complete_axis_file_shows_channels_in_si(errand):
    facts, data = tasks.look(errand([("a.csv", "fit", log())]))
    assert (facts["ready"], facts["missing"], data["refusal"]) == (True, [], "")
    assert [(plot["word"], plot["unit"], plot["time_unit"]) for plot in data["plots"]] == [("position", "m", "s"), ("effort", "N", "s")]
    facts, data = tasks.look(errand([("a.csv", "fit", log())], text=AXIS.replace("translational", "else")))
    assert not facts["ready"]
    assert "kind" in data["refusal"]
    assert (data["problems"], data["diagnostics"]) == ([], [])


def test_each_held_out_log_is_predicted(errand, monkeypatch):
    import bristle

    class Prediction:
        effort = effort_predicted = time = np.arange(3.0)
        metrics, inside_percent = {"force_error_percent": 4.5}, 93.0

    requested = []
    model = SimpleNamespace(predict=lambda log, mode, axis: requested.append(mode) or Prediction)
    monkeypatch.setattr(bristle, "load", lambda folder: model)
    monkeypatch.setattr(
        "bristle.report.prediction.prediction_ruling", lambda prediction: SimpleNamespace(as_data=lambda: {"level": "usable"})
    )
    made = errand([("a.csv", "fit", log()), ("b.csv", "held_out", log()), ("c.csv", "held_out", log())])
    vars(made)["results"] = made.folder
    facts, data = tasks.predict(made)
    assert facts == {"logs": 2}
    assert requested == ["inverse", "inverse"]
    assert [entry["label"] for entry in data["logs"]] == ["b.csv", "c.csv"]
    assert (data["logs"][0]["error_percent"], data["logs"][0]["inside_percent"]) == (4.5, 93.0)
    assert (data["mode"], data["kind"]) == ("inverse", "translational")
    assert errand.told == [(0.0, "predicting b.csv"), (0.5, "predicting c.csv")]


def test_a_table_marks_columns_of_numbers():
    from bristle.report.table import Table

    data = as_table(Table("T", ("Name", "Value", "Empty"), [("a", "1.5", ""), ("b", "2", "")]))
    assert list(data["heads"]) == ["Name", "Value"]
    assert data["numbers"] == [False, True]


def test_the_page_asks_for_tasks_by_name():
    assert list(tasks.TASKS) == ["look", "check", "identify", "predict", "compensate", "export", "excite", "plan", "tune", "undo"]
    assert all(task.__name__ == name for name, task in tasks.TASKS.items())


class Written:
    """Something that writes a file into a folder of results."""

    def write(self, folder, *more):
        folder.write("a.txt", "x")


def stand_in_for_exports(monkeypatch, files):
    """Write these files at each export, and return what exports are asked for."""
    requested = []

    def exported(model, target, **how):
        requested.append((model.name, target, how))
        made = Written()
        made.product, made.summary = SimpleNamespace(files=files), {"notes": ["a note"], "files": list(files)}
        return made

    monkeypatch.setattr("bristle.report.exported.export_model_file", exported)
    return requested


@pytest.mark.parametrize(
    ("files", "shown"),
    [({"a.c": "x" * 6000, "b.h": "short", "c.h": "also"}, "b.h"), ({"a.c": b"bytes", "b.h": "x" * 5999}, "b.h"), ({"a.c": b"bytes"}, None)],
)
def test_the_first_short_text_of_an_export_is_shown(errand, monkeypatch, files, shown):
    requested = stand_in_for_exports(monkeypatch, files)
    made = errand([("a.csv", "fit", log())], target="c", name=" stage ", points=7)
    vars(made)["results"] = made.folder
    facts, data = tasks.export(made)
    assert facts == {"target": "c", "file": "stage_c.zip"}
    assert (data["notes"], data["files"]) == (["a note"], list(files))
    assert (data["shown"] and data["shown"]["file"]) == shown
    ((name, target, how),) = requested
    assert (name, target, how["name"], how["points"]) == ("model.toml", "c", "stage", 7)
    assert how["command"] == "bristle export results --to c --out stage_c --name stage --axis axis.toml --points 7"
    assert errand.told == [(0.2, "writing for c")]
    assert (made.folder / "export.zip").is_file()


def test_an_export_is_a_table_of_twenty_points_by_default(errand, monkeypatch):
    requested = stand_in_for_exports(monkeypatch, {})
    made = errand([], text="")
    vars(made)["results"] = made.folder
    tasks.export(made)
    ((_, target, how),) = requested
    assert (target, how["points"], how["axis"]) == ("table", 20, None)
    assert not {"--points", "--axis"} & set(how["command"].split())


def test_a_motion_is_designed_for_its_duration(errand, monkeypatch):
    requested = []

    def designed(axis_file, **how):
        requested.append(how)
        motion = Written()
        motion.excitation = SimpleNamespace(notes=["slow"], motion=SimpleNamespace(time=np.array([0.0, 30.0, 60.0])))
        motion.next_command = lambda file: f"bristle log {file}"
        return motion

    monkeypatch.setattr("bristle.report.excitation.designed_motion", designed)
    facts, data = tasks.excite(errand([], duration="90 s", purposes="friction", travel="20 mm"))
    assert facts == {"duration": 60.0}
    assert data == {"notes": ["slow"]}
    (how,) = requested
    assert (how["duration"], how["travel"], how["purposes"]) == ("90 s", "20 mm", "friction")
    assert how["command"] == "bristle excite axis.toml --out motion --duration '90 s' --for friction --travel '20 mm'"
    shutil.rmtree(errand([]).folder / "motion")
    tasks.excite(errand([]))
    assert (requested[1]["duration"], requested[1]["travel"], requested[1]["purposes"]) == ("60 s", None, None)


@pytest.mark.parametrize("level", ["usable", "with_care", "measure_again"])
def test_findings_are_those_of_the_best_fit(errand, monkeypatch, level):
    from bristle.report.table import Table

    parameters = Table("Parameters", ("A",), [("1",)])
    monkeypatch.setattr("bristle.report.model_tables.parameter_table", lambda fit, axis: parameters)
    judgement = SimpleNamespace(level=level, as_data=lambda: {"level": level})
    monkeypatch.setattr("bristle.report.judgement.ruling_of", lambda *passed: judgement)
    monkeypatch.setattr("bristle.report.judgement.misfit", lambda fit: ["model error 1 %"])
    monkeypatch.setattr("bristle.report.judgement.feedforward_text", lambda fit: f"try {fit.name}")
    monkeypatch.setattr(loop, "_loop_view", lambda *passed, usable: {"usable": usable, "simulated": passed[-1].simulation})
    best = SimpleNamespace(name="lugre")
    identified = SimpleNamespace(best=best, settings=None, axis=None, unfinished="")
    outcome = SimpleNamespace(following="error", simulation="loop", command="bristle identify")
    data = loop._findings(errand([]), identified, outcome)
    assert data["misfit"] == ["model error 1 %", "feedforward: try lugre"]
    assert (data["verdict"], data["command"]) == ({"level": level}, "bristle identify")
    assert data["parameters"]["rows"] == [["1"]]
    assert (data["model"], data["loop"]) == ("lugre", {"usable": level != "measure_again", "simulated": "loop"})


def test_progress_of_an_identification_never_decreases_or_passes_the_end(errand, monkeypatch):
    import bristle

    def stage(progress):
        for share in (0.0, 0.5, 1.0):
            progress(share, "work")

    def outcome_with(*, progress, **_):
        stage(progress)
        raise InterruptedError

    monkeypatch.setattr(bristle, "identify", lambda *_, progress, **__: stage(progress) or SimpleNamespace(outcome_with=outcome_with))
    asked = errand([("a.csv", "fit", log())])
    with pytest.raises(InterruptedError):
        tasks.identify(asked)
    shares = [share for share, _ in errand.told]
    assert len(shares) == 6
    assert shares == sorted(shares)
    assert (shares[0], shares[-1]) == (0.0, 1.0)
