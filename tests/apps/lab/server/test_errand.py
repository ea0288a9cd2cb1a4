"""What a job is to do, and what it leaves: curves of few points, archives that are alike."""

import json
import shutil
import tomllib
import zipfile
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import bristle
from bristle.apps.lab.server import loop, tasks
from bristle.apps.lab.server.errand import BUCKETS, Errand, LabelledLog, as_table, thinned, zipped
from bristle.core import Content, InputError
from bristle.files import NOTE, edited, form_of, plain, read_axis
from bristle.report.table import Table


def errand_of(tmp_path, **changed):
    """An errand as the server asks for it."""
    request = {
        "folder": str(tmp_path),
        "logs": [
            (str(tmp_path / "file-1"), "log.csv", "fit"),
            (str(tmp_path / "file-2"), "later.csv", "held_out"),
        ],
        "axis_text": "schema = 1\n",
        "axis_label": "stage.toml",
        "options": {},
        "size_limit": 1000,
        "results": None,
    }
    return Errand.of(request | changed, lambda share, text: None, nullcontext)


def test_an_errand_is_the_request_of_the_server(tmp_path):
    errand = errand_of(tmp_path, results=str(tmp_path / "results"))
    assert (errand.folder, errand.model) == (tmp_path, tmp_path / "results")
    logs = [(log.label, log.role, log.place.name) for log in (*errand.logs, *errand.fitted)]
    assert logs == [
        ("log.csv", "fit", "file-1"),
        ("later.csv", "held_out", "file-2"),
        ("log.csv", "fit", "file-1"),
    ]
    assert (errand.axis_file.source, errand.size_limit) == (Path("stage.toml"), 1000)


def test_a_log_is_its_bytes_under_its_label(tmp_path):
    (tmp_path / "file-1").write_bytes(b"time,x\n")
    content = errand_of(tmp_path).fitted[0].content
    assert (content.source, bytes(content.data)) == (Path("log.csv"), b"time,x\n")


def test_missing_files_are_reported(tmp_path):
    for name, words in (("fitted", "Drop a log to fit"), ("model", "Identify a model first")):
        with pytest.raises(InputError, match=words):
            getattr(errand_of(tmp_path, logs=[("file-2", "later.csv", "held_out")]), name)


def test_options_are_text_and_whole_numbers(tmp_path):
    errand = errand_of(
        tmp_path, options={"name": "  x axis ", "points": 12, "draws": -1, "models": 3}
    )
    assert (errand.text("name"), errand.text("target", "table"), errand.text("travel")) == (
        "x axis",
        "table",
        "",
    )
    assert (errand.count("points", 20), errand.count("others", 20)) == (12, 20)
    for ask in (lambda: errand.count("draws", 1), lambda: errand.text("models")):
        with pytest.raises(InputError):
            ask()


def test_a_short_curve_keeps_all_of_its_points():
    time, signal = np.arange(2.0 * BUCKETS), np.sin(np.arange(2.0 * BUCKETS))
    rows = thinned(time, signal, 2.0 * signal)
    assert rows == [
        time.tolist(),
        pytest.approx(signal, rel=1e-7),
        pytest.approx(2.0 * signal, rel=1e-7),
    ]
    assert [
        len(thinned(np.arange(float(count)), np.arange(float(count)))[0]) for count in (3000, 3001)
    ] == [3000, 3000]


def test_a_long_curve_keeps_its_ends_and_every_extreme():
    count = 40 * BUCKETS
    signal = np.random.default_rng(1).normal(size=count)
    signal[12_345], signal[54_321] = 50.0, -60.0
    time, first, second = thinned(np.arange(float(count)), signal, np.arange(float(count)))
    assert len(time) == len(first) <= 2 * BUCKETS + 2
    assert (time[0], time[-1], second) == (0.0, count - 1.0, sorted(set(time)))
    assert (first[time.index(12_345.0)], first[time.index(54_321.0)]) == (50.0, -60.0)
    # Nearly each stretch of forty samples keeps its largest and its smallest one: edges are rounded.
    whole, kept = signal.reshape(BUCKETS, 40), set(np.round(first, 5))
    for extremes in (whole.max(axis=1), whole.min(axis=1)):
        assert len(set(np.round(extremes, 5)) & kept) > 0.95 * BUCKETS


def test_a_missing_number_is_a_gap_on_the_page():
    rows = thinned(np.arange(4.0), np.array([1.0, np.nan, np.inf, 1.0 / 3.0]))
    assert rows == [[0.0, 1.0, 2.0, 3.0], [1.0, None, None, 0.33333333]]  # of eight digits
    gap = np.where(np.arange(4.0 * BUCKETS) < 10, np.nan, 1.0)
    assert thinned(np.arange(gap.size), gap)[1][0] is None


def test_the_same_files_make_the_same_archive_without_the_note(tmp_path):
    archives = []
    for name in ("one", "other"):
        folder = tmp_path / name
        (folder / "figures").mkdir(parents=True)
        for file, text in (
            ("b.csv", "1,2\n" * 500),
            ("a.txt", "first"),
            ("figures/a.svg", "<svg/>"),
            (NOTE, name),
        ):
            (folder / file).write_text(text)
        zipped(folder)
        archives.append((tmp_path / f"{name}.zip").read_bytes())
    assert archives[0] == archives[1]
    with zipfile.ZipFile(tmp_path / "one.zip") as archive:
        assert (archive.namelist(), archive.read("a.txt")) == (
            ["a.txt", "b.csv", "figures/a.svg"],
            b"first",
        )
        assert archive.getinfo("b.csv").compress_size < 200


# --- What an axis file says of the columns is shown on the data, or refused in the words of the command line


LOG = "time,x,force\n" + "".join(
    f"{0.001 * row:.3f},{0.1 * (row % 40)},{row % 7}\n" for row in range(400)
)


@pytest.fixture
def looked(tmp_path):
    (tmp_path / "file-1").write_text(LOG)
    log = LabelledLog(tmp_path / "file-1", "log.csv", "fit")

    def looked(text, **edits):
        errand = Errand(
            tmp_path,
            (log,),
            text,
            "axis.toml",
            {"edits": edits},
            2**20,
            None,
            lambda *_: None,
            nullcontext,
        )
        facts, data = tasks.look(errand)
        return facts, json.loads(json.dumps(plain(data), allow_nan=False))

    return looked


def test_a_column_may_be_named_in_short(looked):
    text = 'schema = 1\nkind = "translational"\n[columns]\ntime = "time"\nposition = "x"\neffort = "force"\n'
    facts, data = looked(text)
    assert (facts["axis_text"], facts["ready"]) == (text, True)
    assert [(plot["word"], plot["unit"], plot["column"]) for plot in data["plots"]] == [
        ("position", "m", "x"),
        ("effort", "N", "force"),
    ]
    facts, data = looked(text, **{"columns.position.unit": "mm"})
    assert read_axis(facts["axis_text"].encode()).columns["position"].unit == "mm"


@pytest.mark.parametrize(
    "columns",
    [
        "columns = 3",
        'columns = ["x"]',
        '[[columns]]\nposition = "x"',
        "[columns]\nposition = true",
        '[columns]\nposition = ["x"]',
        '[columns]\nposition = { column = ["x"] }',
        "[columns]\nposition = 2020-01-01",
        "[columns]\nposition = -2",
        '[columns]\ntime = 1.5\nposition = "x"',
        '[columns]\nposition = { column = "x", unit = ["m"] }',
        '[effort]\nlag = 10:00:00\n[columns]\nposition = "x"',
    ],
)
def test_an_unknown_column_is_refused_as_in_the_terminal(looked, columns):
    text = f"schema = 1\n{columns}\n"
    with pytest.raises(InputError) as refused:
        read_axis(Content(Path("axis.toml"), text.encode()))
    facts, data = looked(text)
    assert (facts["ready"], data["refusal"]) == (False, str(refused.value))


def test_invalid_toml_is_reported_for_the_dropped_file(looked):
    with pytest.raises(InputError, match=r"^axis\.toml: .*line 2"):
        looked("schema = 1\n=\n")


# --- The axis file as a form: what a person changes is changed, all else of it stays


TEXT = """# Proposed by bristle.
schema = 1
name = "x"

[columns]
time = { column = "t", unit = "s" }  # its name
position = { column = "x", unit = "mm" }
effort = { column = "i", unit = "A", sign = -1 }  # moves like the acceleration

[effort]
constant = "?"  # force or torque for one A

# columns that are not used: z
"""


def test_an_edit_changes_one_field_and_keeps_the_rest():
    text = edited(
        TEXT, {"effort.constant": "61 N/A", "columns.position.unit": "um", "kind": "translational"}
    )
    assert tomllib.loads(text) == tomllib.loads(TEXT) | {
        "kind": "translational",
        "effort": {"constant": "61 N/A"},
        "columns": tomllib.loads(TEXT)["columns"] | {"position": {"column": "x", "unit": "um"}},
    }
    assert all(
        kept in text
        for kept in (
            "# Proposed by bristle.",
            "# its name",
            "# columns that are not used: z",
            "# moves like the accel",
        )
    )
    assert read_axis(text.encode()).columns["effort"].scale == -61.0


def test_a_column_is_added_changed_and_removed():
    text = edited(
        TEXT,
        {
            "columns.velocity.column": "v",
            "columns.velocity.unit": "mm/s",
            "columns.effort.column": "j",
        },
    )
    columns = tomllib.loads(text)["columns"]
    assert (columns["velocity"], columns["effort"]["column"]) == (
        {"column": "v", "unit": "mm/s"},
        "j",
    )
    assert "moves like" not in text  # that was said of another column
    gone = edited(
        text, {"columns.velocity.column": None, "columns.velocity.unit": None, "limits.jerk": None}
    )
    assert "velocity" not in tomllib.loads(gone)["columns"]
    assert tomllib.loads(edited("schema = 1\n", {"limits.velocity": "1 m/s"}))["limits"] == {
        "velocity": "1 m/s"
    }


SHORT = """schema = 1
[columns]
time = 1
position = "x"  # its name
effort = { column = "i", unit = "N" }
"""


@pytest.mark.parametrize(
    ("edits", "position"),
    [
        ({"columns.position.unit": "mm"}, {"column": "x", "unit": "mm"}),
        ({"columns.position.sign": -1}, {"column": "x", "sign": -1}),
        (
            {"columns.position.column": "y", "columns.position.unit": "m"},
            {"column": "y", "unit": "m"},
        ),
        ({"columns.position.column": None}, None),
    ],
)
def test_the_short_form_of_a_column_is_shown_and_changed_as_the_long_one(edits, position):
    shown = form_of(Content("axis.toml", SHORT.encode()))["tables"]["columns"]
    assert shown == {
        "time": {"column": "column_1"},
        "position": {"column": "x"},
        "effort": {"column": "i", "unit": "N"},
    }
    columns = tomllib.loads(edited(SHORT, edits))["columns"]
    assert columns.pop("position", None) == position
    assert columns == {"time": 1, "effort": {"column": "i", "unit": "N"}}  # nobody changed those


@pytest.mark.parametrize(
    ("edits", "words"),
    [
        ({"a.b.c.d": 1}, "is not a key"),
        ({"columns..x": 1}, "is not a key"),
        ({"columns": []}, "text or a number"),
        ({"schema.x": 1}, "is not a table"),
    ],
)
def test_an_unknown_key_of_an_axis_file_is_refused(edits, words):
    with pytest.raises(InputError, match=words):
        edited(TEXT, edits)
    with pytest.raises(InputError, match="not valid TOML"):
        edited("=", {})


def test_a_form_shows_gaps_and_remarks():
    form = form_of(Content("axis.toml", TEXT.encode()))
    remarks = {
        "columns.effort": "moves like the acceleration",
        "effort.constant": "force or torque for one A",
    }
    assert (form["missing"], form["remarks"].items() >= remarks.items()) == (
        ["effort.constant"],
        True,
    )


# --- What jobs answer, each by small logs or by what stands in for the work


AXIS = 'schema = 1\nkind = "translational"\n[columns]\ntime = "time"\nposition = "x"\neffort = "force"\n'


def log(rows=400):
    t = 0.001 * np.arange(rows)
    return "time,x,force\n" + "".join(
        f"{a:.4f},{b:.8f},{c:.4f}\n"
        for a, b, c in zip(t, 0.01 * np.sin(20.0 * t), 3.0 * np.sign(np.cos(20.0 * t)), strict=True)
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
        return Errand(
            tmp_path,
            tuple(labelled),
            text,
            "axis.toml",
            options,
            2**20,
            None,
            lambda *call: reported.append(call),
            nullcontext,
        )

    errand.told = reported
    return errand


def test_every_log_is_checked_and_problems_are_counted(errand):
    facts, data = tasks.check(
        errand(
            [
                ("a.csv", "fit", log()),
                ("b.csv", "held_out", "nothing\n"),
                ("c.csv", "held_out", log()),
            ]
        )
    )
    assert [(entry["label"], entry["role"]) for entry in data["logs"]] == [
        ("a.csv", "fit"),
        ("b.csv", "held_out"),
        ("c.csv", "held_out"),
    ]
    assert facts["problems"] == len(data["logs"][1]["problems"]) >= 1
    assert (facts["ready"], data["logs"][0]["rate"]) == (False, pytest.approx(1000.0))
    assert errand.told == [
        (0.0, "reading a.csv"),
        (1.0 / 3.0, "reading b.csv"),
        (2.0 / 3.0, "reading c.csv"),
    ]


def test_of_several_logs_a_short_one_is_left_out(errand):
    facts, data = tasks.check(
        errand([("a.csv", "fit", log()), ("b.csv", "fit", log(50)), ("c.csv", "held_out", log(50))])
    )
    assert facts == {"problems": 0, "warnings": facts["warnings"], "ready": True}
    whole, *short = data["logs"]
    assert "left_out" not in whole
    for name, entry in zip(("b.csv", "c.csv"), short, strict=True):
        assert entry["left_out"].startswith(
            f"bristle leaves this log out: {name}: column 'time': is too short"
        )
        assert entry["problems"] == []
    facts, data = tasks.check(errand([("a.csv", "fit", log(50)), ("b.csv", "held_out", log())]))
    assert (facts["problems"], facts["ready"]) == (1, False)


def test_warnings_are_counted_and_notes_are_not(errand, monkeypatch):
    def inspected(content, axis, size_limit):
        summary = dict.fromkeys(("rate", "duration", "kind", "channels", "notes"))
        diagnostics = [{"severity": severity} for severity in ("warning", "note", "error")]
        return SimpleNamespace(
            summary=summary | {"passages": [], "diagnostics": diagnostics, "problems": []}
        )

    monkeypatch.setattr(tasks, "inspect_log", inspected)
    facts, data = tasks.check(errand([("a.csv", "fit", ""), ("b.csv", "fit", "")]))
    assert facts == {"problems": 0, "warnings": 4, "ready": True}
    assert data["logs"][0]["passages"] is None


def test_a_command_contains_options_with_a_value():
    command = tasks._command(
        "identify",
        ["a b.csv", "c.csv"],
        {"--axis": "x.toml", "--draws": "", "--cutoff": None, "--out": "results"},
    )
    assert command == "bristle identify 'a b.csv' c.csv --axis x.toml --out results"


def test_columns_are_shown_as_recorded_until_their_units_are_known():
    table = SimpleNamespace(
        columns={
            "t": np.arange(3.0),
            "x": np.array([1.0, 2.0, 3.0]),
            "u": np.array([4.0, 5.0]),
            "none": np.empty(0),
        }
    )
    inspected = SimpleNamespace(table=table)
    columns = {
        "time": {"column": "t", "unit": "ms"},
        "position": {"column": "x", "unit": "mm"},
        "velocity": {"column": "none", "unit": "mm/s"},
        "reference": {"column": "gone"},
        "effort": {"column": "u", "unit": "?"},
    }
    position, effort = tasks._of_columns(inspected, columns)
    known = {
        "word": "position",
        "unit": "mm",
        "column": "x",
        "time_unit": "ms",
        "curve": [[0.0, 1.0, 2.0], [1.0, 2.0, 3.0]],
    }
    unknown = {
        "word": "effort",
        "unit": "as recorded",
        "column": "u",
        "time_unit": "sample",
        "curve": [[0.0, 1.0], [4.0, 5.0]],
    }
    assert (position, effort) == (known, unknown)
    (bare,) = tasks._of_columns(inspected, {"position": {"column": "x", "unit": ""}})
    assert (bare["unit"], bare["time_unit"], bare["curve"][0]) == (
        "as recorded",
        "sample",
        [0.0, 1.0, 2.0],
    )


def test_a_log_without_an_axis_file_is_read_with_a_proposal(errand):
    facts, data = tasks.look(errand([("a.csv", "fit", log())], text=""))
    assert "[columns]" in facts["axis_text"]
    assert "columns.position.unit" in facts["missing"] or facts["ready"]
    assert (data["log"], errand.told) == ("a.csv", [(0.1, "reading the log")])
    with pytest.raises(InputError, match="Drop a log to fit"):
        tasks.look(errand([("a.csv", "held_out", log())]))


def test_a_complete_axis_file_shows_channels_in_si(errand):
    facts, data = tasks.look(errand([("a.csv", "fit", log())]))
    assert (facts["ready"], facts["missing"], data["refusal"]) == (True, [], "")
    assert [(plot["word"], plot["unit"], plot["time_unit"]) for plot in data["plots"]] == [
        ("position", "m", "s"),
        ("effort", "N", "s"),
    ]
    facts, data = tasks.look(
        errand([("a.csv", "fit", log())], text=AXIS.replace("translational", "else"))
    )
    assert (facts["ready"], data["problems"], data["diagnostics"]) == (False, [], [])
    assert "kind" in data["refusal"]
    # Without an axis the problems of a log are not yet those of the axis.
    _, data = tasks.look(errand([("a.csv", "fit", "a,b\n1,2\n2,3\n3,4\n")], text=""))
    assert (data["problems"], data["diagnostics"]) == ([], [])


def test_each_held_out_log_is_predicted(errand, monkeypatch):
    class Prediction:
        effort = effort_predicted = time = np.arange(3.0)
        metrics, inside_percent = {"force_error_percent": 4.5}, 93.0

    requested = []
    model = SimpleNamespace(predict=lambda log, mode, axis: requested.append(mode) or Prediction)
    monkeypatch.setattr(bristle, "load", lambda folder: model)
    monkeypatch.setattr(
        "bristle.report.prediction.prediction_ruling",
        lambda prediction: SimpleNamespace(as_data=lambda: {"level": "usable"}),
    )
    made = errand(
        [
            ("a.csv", "fit", log()),
            *(
                (f"{name}.csv", "held_out", log(rows))
                for name, rows in (("b", 400), ("c", 50), ("d", 400))
            ),
        ]
    )
    vars(made)["results"] = made.folder
    facts, data = tasks.predict(made)
    assert (facts, requested, data["mode"], data["kind"]) == (
        {"logs": 3},
        ["inverse"] * 2,
        "inverse",
        "translational",
    )
    first, short, last = data["logs"]
    assert [
        (entry["label"], entry["error_percent"], entry["inside_percent"]) for entry in (first, last)
    ] == [("b.csv", 4.5, 93.0), ("d.csv", 4.5, 93.0)]
    assert short["left_out"].startswith("bristle leaves this log out: c.csv: ")
    assert errand.told == [
        (0.0, "predicting b.csv"),
        (1.0 / 3.0, "predicting c.csv"),
        (2.0 / 3.0, "predicting d.csv"),
    ]


def test_a_table_marks_columns_of_numbers():
    data = as_table(Table("T", ("Name", "Value", "Empty"), [("a", "1.5", ""), ("b", "2", "")]))
    assert (list(data["heads"]), data["numbers"]) == (["Name", "Value"], [False, True])


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
        made.product, made.summary = (
            SimpleNamespace(files=files),
            {"notes": ["a note"], "files": list(files)},
        )
        return made

    monkeypatch.setattr("bristle.report.exported.export_model_file", exported)
    return requested


@pytest.mark.parametrize(
    ("files", "shown"),
    [
        ({"a.c": "x" * 6000, "b.h": "short", "c.h": "also"}, "b.h"),
        ({"a.c": b"bytes", "b.h": "x" * 5999}, "b.h"),
        ({"a.c": b"bytes"}, None),
    ],
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
    assert (
        how["command"]
        == "bristle export results --to c --out stage_c --name stage --axis axis.toml --points 7"
    )
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
        motion.excitation = SimpleNamespace(
            notes=["slow"], motion=SimpleNamespace(time=np.array([0.0, 30.0, 60.0]))
        )
        motion.next_command = lambda file: f"bristle log {file}"
        return motion

    monkeypatch.setattr("bristle.report.excitation.designed_motion", designed)
    assert tasks.excite(errand([], duration="90 s", purposes="friction", travel="20 mm")) == (
        {"duration": 60.0},
        {"notes": ["slow"]},
    )
    (how,) = requested
    assert (how["duration"], how["travel"], how["purposes"]) == ("90 s", "20 mm", "friction")
    assert (
        how["command"]
        == "bristle excite axis.toml --out motion --duration '90 s' --for friction --travel '20 mm'"
    )
    shutil.rmtree(errand([]).folder / "motion")
    tasks.excite(errand([]))
    assert (requested[1]["duration"], requested[1]["travel"], requested[1]["purposes"]) == (
        "60 s",
        None,
        None,
    )


@pytest.mark.parametrize("level", ["usable", "with_care", "measure_again"])
def test_findings_are_those_of_the_best_fit(errand, monkeypatch, level):
    parameters = Table("Parameters", ("A",), [("1",)])
    monkeypatch.setattr("bristle.report.model_tables.parameter_table", lambda fit, axis: parameters)
    judgement = SimpleNamespace(level=level, as_data=lambda: {"level": level})
    monkeypatch.setattr("bristle.report.judgement.ruling_of", lambda *passed: judgement)
    monkeypatch.setattr("bristle.report.judgement.misfit", lambda fit: ["model error 1 %"])
    monkeypatch.setattr(
        "bristle.report.judgement.feedforward_of", lambda identified: f"try {identified.best.name}"
    )
    monkeypatch.setattr(
        loop,
        "_loop_view",
        lambda *passed, usable: {"usable": usable, "simulated": passed[-1].simulation},
    )
    best = SimpleNamespace(name="lugre")
    identified = SimpleNamespace(best=best, settings=None, axis=None, unfinished="")
    outcome = SimpleNamespace(following="error", simulation="loop", command="bristle identify")
    data = loop._findings(errand([]), identified, outcome)
    expected = {
        "misfit": ["model error 1 %", "feedforward: try lugre"],
        "verdict": {"level": level},
        "command": "bristle identify",
    }
    expected |= {
        "model": "lugre",
        "loop": {"usable": level != "measure_again", "simulated": "loop"},
    }
    assert {name: data[name] for name in expected} == expected
    assert data["parameters"]["rows"] == [["1"]]


def test_progress_of_an_identification_never_decreases_or_passes_the_end(errand, monkeypatch):
    def stage(progress):
        for share in (0.0, 0.5, 1.0):
            progress(share, "work")

    def outcome_with(*, progress, **_):
        stage(progress)
        raise InterruptedError

    monkeypatch.setattr(
        bristle,
        "identify",
        lambda *_, progress, **__: stage(progress) or SimpleNamespace(outcome_with=outcome_with),
    )
    asked = errand([("a.csv", "fit", log())])
    with pytest.raises(InterruptedError):
        tasks.identify(asked)
    shares = [share for share, _ in errand.told]
    assert shares == sorted(shares)
    assert (len(shares), shares[0], shares[-1]) == (6, 0.0, 1.0)
