"""Options: which way a command takes by them, what it hands on to the work, and the words and codes with which it ends."""

from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest
import typer
from tests.cli.conftest import USER_MODEL

import bristle as br
from bristle.apps.design import command as design
from bristle.apps.study import command as study
from bristle.apps.study.store import OK
from bristle.cli import compare, export, identify, models, options, run
from bristle.cli.log import MOST_COLUMNS, _parts, _table
from bristle.cli.options import (
    SIZE_SETTING,
    Output,
    command_text,
    folder_named,
    holds_own,
    loaded_code,
    print_json,
    refuse,
    size_limit,
)
from bristle.core import SIZE_LIMIT, Variable
from bristle.report.table import Table


def test_a_folder_has_a_name():
    assert folder_named("out") == folder_named(Path("out")) == Path("out")
    for text in ("", "  "):
        with pytest.raises(typer.BadParameter, match="the name of the folder is empty"):
            folder_named(text)


def test_a_log_may_be_as_large_as_the_environment_says(monkeypatch):
    monkeypatch.delenv(SIZE_SETTING, raising=False)
    assert size_limit() == SIZE_LIMIT == 512 * 2**20
    monkeypatch.setenv(SIZE_SETTING, "2 GB")
    assert size_limit() == 2 * 10**9
    monkeypatch.setenv(SIZE_SETTING, "many")
    with pytest.raises(br.core.InputError, match=SIZE_SETTING):
        size_limit()


def test_the_first_option_that_was_given_is_refused():
    refuse({"--a": None, "--b": False, "--c": ""}, "no")
    with pytest.raises(br.core.InputError, match=r"--b: says nothing here\. Leave --b out"):
        refuse({"--a": None, "--b": 3, "--c": 4}, "says nothing here")
    with pytest.raises(br.core.InputError, match=r"--a: says nothing here\. Do that"):
        refuse({"--a": True}, "says nothing here", "Do that")


@pytest.mark.parametrize(
    ("name", "own"),
    [
        ("lugre", False),
        ("lugre+asymmetry", False),
        ("my.py", True),
        ("lugre+my.py", True),
        ("py", False),
    ],
)
def test_a_name_holds_a_file_of_code(name, own):
    assert holds_own(name) is own


def test_code_is_allowed_once_all_of_it_is_loaded(tmp_path, monkeypatch):
    allowed = []
    monkeypatch.setattr("bristle.files.allow", allowed.append)
    for name in ("a.py", "b.py"):
        (tmp_path / name).write_text("x = 1\n")
    files = [tmp_path / "a.py", tmp_path / "b.py"]
    loaded, contents = loaded_code(files, lambda content: content.source.name)
    assert loaded == ["a.py", "b.py"]
    assert allowed == contents
    allowed.clear()

    def fails(content):
        if content.source.name == "b.py":
            raise br.core.InputError("is no model")

    with pytest.raises(br.core.InputError):
        loaded_code(files, fails)
    assert allowed == []


def reported(capsys, **options):
    Output(SimpleNamespace(obj="bristle x"), **options).tell(
        {"a": 1}, "paragraph", None, warnings=["careful"]
    )
    return capsys.readouterr()


def test_a_command_prints_json_or_text(capsys):
    words, numbers = reported(capsys), reported(capsys, as_json=True)
    assert (words.out, words.err) == ("paragraph\n", "bristle: careful\n")
    assert (numbers.out, numbers.err) == ('{\n  "a": 1\n}\n', "")
    print_json({"b": float("nan")})
    assert capsys.readouterr().out == '{\n  "b": null\n}\n'


def test_a_command_names_the_folder_of_results(capsys):
    assert reported(capsys, out=Path("there")).err.endswith(
        "bristle: wrote there; open there/report.html in a browser\n"
    )
    Output(SimpleNamespace(obj="x"), out=Path("there")).tell({}, files="a.c")
    assert capsys.readouterr().err == "bristle: wrote there: a.c\n"


def test_a_command_line_is_stored_without_folders():
    assert command_text(
        ["identify", "a/b.csv", "--axis", "c/d.toml,e/f.toml", "--out=g/h/"], "/"
    ) == ("bristle identify b.csv --axis d.toml,f.toml --out=h")
    assert command_text(["x\x07y", "a=b/c"], "/") == "bristle 'x?y' c"


# --- studies ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("is_whole", "statuses", "code"),
    [(True, {OK: 3}, 0), (False, {OK: 3}, 1), (True, {"diverged": 3}, 1)],
)
def test_a_study_succeeds_with_all_runs_and_some_good_ones(is_whole, statuses, code):
    assert (
        study.exit_code(SimpleNamespace(lost=[], is_whole=is_whole), {"statuses": statuses}) == code
    )


def test_runs_that_crash_every_process_are_reported(capsys):
    lost = [SimpleNamespace(first=10, last=20)]
    study.exit_code(SimpleNamespace(lost=lost, is_whole=False), {"statuses": {}})
    assert (
        "runs 10 to 19 are missing: every process that simulated them crashed"
        in capsys.readouterr().err
    )


def test_an_interruption_reports_the_kept_runs(capsys):
    with pytest.raises(KeyboardInterrupt), study.interruptible(Path("out"), "runs"):
        raise KeyboardInterrupt
    assert (
        capsys.readouterr().err
        == "bristle: out keeps the finished runs. Give the same command again to continue\n"
    )


def test_values_of_a_run_are_written_as_text():
    values = {"plant.M": 20.0, "run.delay": 2, "friction.k_i": [1.0, 2.0, 3.0], "x": 0.5}
    text = study._in_words(values, {"plant.M": "kg", "x": ""})
    assert (
        text.replace("\u00a0", " ")
        == "plant.M = 20 kg, run.delay = 2, friction.k_i = 3 numbers, x = 0.5"
    )
    assert study._in_words({}, {}) == "only the seed varies"


# --- logs and models -------------------------------------------------------------------------------------------------


def column(name, **facts):
    return {
        "name": name,
        "column": None,
        "unit": "mm",
        "samples": 3,
        "min": 0.123456789,
        "max": None,
        "mean": 1.0,
        "std": 2.0,
        "step": 0.5,
    } | facts


def test_columns_of_a_log_have_six_digits():
    table = _table(
        "T", [column("x"), column("y", unit="furlong", column="c"), column("z", unit="qwe")]
    )
    assert table.heads == ("Name", "Column", "Unit", "Samples", "Min", "Max", "Mean", "Std", "Step")
    assert list(table.rows[0]) == ["x", "", "mm", "3", "0.123457", "–", "1", "2", "0.5"]
    assert [list(row[1:3]) for row in table.rows[1:]] == [["c", "furlong"], ["", "qwe (unknown)"]]


def summary(count, **changed):
    facts = {
        "channels": [],
        "passages": [],
        "kind": "translational",
        "rate": None,
        "duration": None,
        "notes": [],
        "diagnostics": [],
        "proposal": {},
    }
    return {"columns": [column(f"c{number}") for number in range(count)]} | facts | changed


def test_of_many_columns_the_first_hundred_are_shown():
    assert len(_parts(summary(MOST_COLUMNS))) == 1
    table, rest = _parts(summary(MOST_COLUMNS + 2))
    assert (len(table.rows), rest) == (100, "... and 2 more columns. --json lists all columns.")


def test_a_rate_is_printed_with_its_duration():
    assert _parts(summary(1, rate=1000.0))[1] == "1000 samples a second."
    assert _parts(summary(1, rate=1000.0, duration=2.5))[1] == "1000 samples a second, 2.5 s."


def test_notes_and_diagnostics_come_last():
    diagnostics = [{"severity": "warning", "message": "It turns seldom.", "code": "few_turns"}]
    channels = [column("position")]
    parts = _parts(summary(1, notes=["a remark"], diagnostics=diagnostics, channels=channels))
    assert isinstance(parts[1], Table)
    assert parts[2:] == ["Note: a remark", "Warning: It turns seldom. (few_turns)"]


@pytest.mark.parametrize(
    ("variable", "words"),
    [
        (Variable("1", "share", min=0.0, max=1.0), "0 to 1"),
        (Variable("length", "way", min=0.0, max=2.0), "0 to 2"),
        (Variable("force", "force", min=0.0), ">= 0"),
    ],
)
def test_a_range_is_written_without_its_unit(variable, words):
    assert models._range(variable) == words


@pytest.mark.parametrize(
    ("name", "words"),
    [
        (
            "lugra",
            r"NAME: is not a known model; found 'lugra'.*'lugre'.*For a list type: bristle models",
        ),
        (
            "cascade+asymmetry",
            "NAME: a controller has no slots; found 'cascade.asymmetry'. Write cascade",
        ),
    ],
)
def test_an_unknown_model_is_refused(name, words):
    with pytest.raises(br.core.InputError, match=words):
        models._selected(name)


def test_a_model_is_found_in_its_family():
    assert list(models._selected("lugre")) == ["friction"]
    assert [member.name for member in models._selected("lugre+asymmetry")["friction"]] == [
        "lugre+asymmetry"
    ]
    assert list(models._selected("inertia+gravity")) == ["plant"]
    assert list(models._families()) == [
        "friction",
        "hysteresis",
        "plant",
        "controller",
        "sensor",
        "reference",
        "slot",
    ]


def test_a_user_model_is_tested_and_then_allowed(tmp_path, monkeypatch):
    (tmp_path / "own.py").write_text(USER_MODEL)
    order = []
    monkeypatch.setattr("bristle.contract.admit", lambda model: order.append(model.name))
    monkeypatch.setattr("bristle.files.allow", lambda content: order.append(content.source.name))
    chosen = options.own_model(f"{tmp_path}/own.py+asymmetry", "NAME")
    assert (chosen.name, order) == ("own+asymmetry", ["own+asymmetry", "own.py"])


def test_an_identified_model_is_reported_with_its_error_or_as_earlier(
    tmp_path, monkeypatch, capsys
):
    fit, asked = SimpleNamespace(name="lugre", error_percent=2.3456), []
    prepared = [SimpleNamespace(name="axis", best=best, folder=Path("fit")) for best in (None, fit)]
    monkeypatch.setattr(
        "bristle.report.prepared.prepare", lambda content, **how: asked.append(how) or prepared
    )
    monkeypatch.setattr(
        "bristle.files.read_experiment",
        lambda content, **how: asked.append(how) or content.source.name,
    )
    (tmp_path / "a.toml").write_text("schema = 1")
    assert options.experiment_in(tmp_path / "a.toml", allow_code=True, progress=print) == "a.toml"
    assert capsys.readouterr().err.splitlines() == [
        "bristle: axis: identified earlier; see fit",
        "bristle: axis: identified (lugre, error 2.35 %); see fit/report.html",
    ]
    allowed = {"allow_code": True, "size_limit": size_limit()}
    assert asked == [allowed | {"progress": print}, allowed]


# --- ways ------------------------------------------------------------------------------------------------------------


class Told:
    """The options of a command's output; what is told is kept."""

    command, formats, force, as_json = "bristle command", None, False, False

    def __init__(self, out=None, **options):
        self.out, self.told, self.opens, self.warnings = out, [], [], []
        self.context = SimpleNamespace(with_resource=lambda resource: resource, obj=self.command)
        self.__dict__ |= options

    @contextmanager
    def opened(self, words, reads=(), **how):
        self.opens.append((words, [file for file in reads if file is not None], how))
        yield self.out, in_range

    def tell(self, summary, *parts, warnings=(), files=""):
        self.told = [summary, *(part for part in parts if part is not None)]
        self.warnings = list(warnings)


def in_range(share, text):
    assert 0.0 <= share <= 1.0, text


def named(**parts):
    return SimpleNamespace(**parts)


@pytest.fixture
def asked(monkeypatch):
    """What was asked for, instead of being done."""
    calls = []

    def put(place, answer=None):
        monkeypatch.setattr(
            place,
            lambda *passed, **how: calls.append((place.rpartition(".")[2], passed, how)) or answer,
        )
        return calls

    put.calls = calls
    return put


# --- identify --------------------------------------------------------------------------------------------------------


@pytest.fixture
def ways(asked):
    asked("bristle.apps.study.fleet.command.identify_each", 7)
    asked("bristle.cli.identify._identify_friction", 5)
    asked("bristle.cli.operators.identify_operators", 3)
    return asked.calls


def test_logs_are_identified_together_or_as_a_fleet(ways):
    output, logs = Told(), [Path("a.csv"), Path("b.csv")]
    assert identify.identify(log=logs, output=output) == 5
    assert identify.identify(log=logs, output=output, separate=True, workers=3, reader=None) == 7
    (together, passed, _), (each, separate, how) = ways
    assert (together, each, how) == (
        "_identify_friction",
        "identify_each",
        {"readers": (), "workers": 3, "robot": None},
    )
    assert passed[:2] == separate[:2] == (logs, [])
    assert passed[2]["model"] == br.friction.DEFAULT_MODELS.split(",")
    assert separate[2]["model"] == ["coulomb_viscous"]
    rest = {"cutoff": None, "free": "", "draws": 100, "method": None}
    assert {key: passed[2][key] for key in rest} == {key: separate[2][key] for key in rest} == rest


def test_options_of_an_identification_are_passed_in_si(ways):
    chosen = {
        "model": "dahl , lugre+asymmetry",
        "cutoff": "0.1 kHz",
        "draws": 20,
        "free": "exponent",
        "method": "output_error",
    }
    identify.identify(log=[Path("a.csv")], output=Told(), **chosen)
    models = ["dahl", "lugre+asymmetry"]
    assert ways[0][1][2] == chosen | {"model": models, "cutoff": 100.0}
    with pytest.raises(br.core.InputError, match="--cutoff"):
        identify.identify(log=[Path("a.csv")], output=Told(), cutoff="0 Hz")


@pytest.mark.parametrize(
    ("command", "files"),
    [
        (identify.identify, {"log": [Path("a.csv")]}),
        (compare.compare, {"before": Path("a.csv"), "after": Path("b.csv")}),
        (design.design, {"experiment": Path("e.toml")}),
        (run.run, {"experiment": Path("e.toml")}),
    ],
)
def test_a_figure_needs_a_folder(command, files, tmp_path):
    with pytest.raises(
        br.core.InputError, match=r"--figure: needs a folder to write into\. Add --out DIR"
    ):
        command(**files, output=Told(), figure=[tmp_path / "f.py"])
    with pytest.raises(br.core.InputError, match=r"f\.py"):
        command(**files, output=Told(tmp_path / "out"), figure=[tmp_path / "f.py"])


def test_an_export_passes_its_options_and_states_its_notes(asked, monkeypatch, tmp_path):
    output, context = Told(Path("out")), named(obj="bristle export")
    exported = named(
        write=lambda folder: None,
        summary={"notes": ["short"]},
        product=named(files={"a.c": "", "a.h": ""}),
    )
    monkeypatch.setattr(export, "Output", lambda *_, **__: output)
    asked("bristle.report.exported.export_model_file", exported)
    asked("bristle.cli.export._law", exported)
    export.export(
        context,
        model=tmp_path,
        to="c",
        out=Path("out"),
        float32=True,
        log=Path("a.csv"),
        tunable=True,
    )
    export.export(
        context,
        law=Path("e.toml"),
        to="st",
        out=Path("out"),
        variant="fed",
        float32=True,
        accept_harm=True,
    )
    (_, model, how), (_, law, of_law) = asked.calls
    assert (model, law) == ((tmp_path / "model.toml", "c"), (Path("e.toml"), "fed", "st"))
    expected = {
        "points": 20,
        "float32": True,
        "tunable": True,
        "accept_harm": False,
        "name": "axis_x",
        "log": Path("a.csv"),
        "step": None,
    }
    assert {key: how[key] for key in expected} == expected
    assert {key: of_law[key] for key in ("single", "accept_harm", "tunable")} == {
        "single": True,
        "accept_harm": True,
        "tunable": False,
    }
    assert output.opens == [
        ("exporting", [tmp_path / "model.toml", Path("a.csv")], {"draws": False}),
        ("exporting", [Path("e.toml")], {"draws": False}),
    ]
    assert output.told == [{"notes": ["short"]}, "Note: short"]
