"""Which way a command takes by its options, and what it hands on to the work."""

from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest

from bristle.cli import compare, design, export, identify, run
from bristle.core.errors import InputError
from bristle.friction import DEFAULT_MODELS


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
        yield self.out, reported

    def tell(self, summary, *parts, warnings=(), files=""):
        self.told = [summary, *(part for part in parts if part is not None)]
        self.warnings = list(warnings)


def reported(share, text):
    assert 0.0 <= share <= 1.0, text


def named(**parts):
    return SimpleNamespace(**parts)


@pytest.fixture
def asked(monkeypatch):
    """What was asked for, instead of being done."""
    calls = []

    def put(place, answer=None):
        monkeypatch.setattr(place, lambda *passed, **how: calls.append((place.rpartition(".")[2], passed, how)) or answer)
        return calls

    put.calls = calls
    return put


# --- identify --------------------------------------------------------------------------------------------------------


@pytest.fixture
def ways(asked):
    for name, code in (("_identify_each", 7), ("_identify_friction", 5)):
        asked(f"bristle.cli.identify.{name}", code)
    asked("bristle.cli.operators.identify_operators", 3)
    return asked.calls


def test_logs_are_identified_together_or_as_a_fleet(ways):
    output, logs = Told(), [Path("a.csv"), Path("b.csv")]
    assert identify.identify(log=logs, output=output) == 5
    assert identify.identify(log=logs, output=output, separate=True, workers=3, reader=None) == 7
    (together, passed, _), (each, separate, how) = ways
    assert (together, each, how) == ("_identify_friction", "_identify_each", {"readers": (), "workers": 3, "robot": None})
    assert passed[:2] == separate[:2] == (logs, [])
    assert passed[2]["model"] == DEFAULT_MODELS.split(",")
    assert separate[2]["model"] == ["coulomb_viscous"]
    rest = {"cutoff": None, "free": "", "draws": 100, "method": None}
    assert {key: passed[2][key] for key in rest} == {key: separate[2][key] for key in rest} == rest


def test_options_of_an_identification_are_passed_in_si(ways):
    chosen = {"model": "dahl , lugre+asymmetry", "cutoff": "0.1 kHz", "draws": 20, "free": "exponent", "method": "output_error"}
    identify.identify(log=[Path("a.csv")], output=Told(), **chosen)
    models = ["dahl", "lugre+asymmetry"]
    assert ways[0][1][2] == chosen | {"model": models, "cutoff": 100.0}
    with pytest.raises(InputError, match="--cutoff"):
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
    with pytest.raises(InputError, match="--figure: needs a folder to write into"):
        command(**files, output=Told(), figure=[tmp_path / "f.py"])
    with pytest.raises(InputError, match=r"f\.py"):
        command(**files, output=Told(tmp_path / "out"), figure=[tmp_path / "f.py"])


def test_an_export_passes_its_options_and_states_its_notes(asked, monkeypatch, tmp_path):
    output, context = Told(Path("out")), named(obj="bristle export")
    exported = named(write=lambda folder: None, summary={"notes": ["short"]}, product=named(files={"a.c": "", "a.h": ""}))
    monkeypatch.setattr(export, "Output", lambda *_, **__: output)
    asked("bristle.report.exported.export_model_file", exported)
    asked("bristle.cli.export._law", exported)
    export.export(context, model=tmp_path, to="c", out=Path("out"), float32=True, log=Path("a.csv"), tunable=True)
    export.export(context, law=Path("e.toml"), to="st", out=Path("out"), variant="fed", float32=True, accept_harm=True)
    (_, model, how), (_, law, of_law) = asked.calls
    assert (model, law) == ((tmp_path / "model.toml", "c"), (Path("e.toml"), "fed", "st"))
    expected = {"points": 20, "float32": True, "tunable": True, "accept_harm": False, "name": "axis_x", "log": Path("a.csv"), "step": None}
    assert {key: how[key] for key in expected} == expected
    assert {key: of_law[key] for key in ("single", "accept_harm", "tunable")} == {"single": True, "accept_harm": True, "tunable": False}
    assert output.opens == [
        ("exporting", [tmp_path / "model.toml", Path("a.csv")], {"draws": False}),
        ("exporting", [Path("e.toml")], {"draws": False}),
    ]
    assert output.told == [{"notes": ["short"]}, "Note: short"]
