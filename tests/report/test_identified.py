"""The result of an identification: its data, predictions, files and pickle."""

import inspect
import json
import pickle
import shutil
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace as Some

import numpy as np
import pytest
from tests.identification.known_logs import sliding_log
from tests.logs.test_check import elements, pulled

import bristle as br
from bristle import identification
from bristle.cli.demonstration import axis_simulated
from bristle.core import Diagnostic, InputError, InputWarning, MissingExtraError
from bristle.exports import Request, Source, writing
from bristle.files import TREATMENT, arrays, read_model
from bristle.files.axis import axis_from, axis_text
from bristle.identification import settings, structure
from bristle.prediction import kept
from bristle.prediction.drive_table import drive_table, level_values
from bristle.report import identified, model_in_hand, model_tables

pytestmark = pytest.mark.usefixtures("undrawn")

MODELS = "coulomb_viscous,viscous"
ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def columns():
    log = sliding_log()
    return {name: getattr(log, name).values[:4000] for name in ("time", "position", "effort")}


@pytest.fixture(scope="module")
def result(columns):
    return br.identify(columns, MODELS, cutoff=60.0, decimation=7, draws=20)


@pytest.fixture(scope="module")
def folder(result, tmp_path_factory):
    return result.save(tmp_path_factory.mktemp("saved") / "results")


@pytest.fixture(scope="module")
def loaded(folder):
    return br.load(folder)


@pytest.mark.parametrize(
    "claim", [{"least_distance": 1e-3, "slowest_move": None, "longest_rest": 0.3}]
)
def test_saved_gain_and_claims_are_read_even_without_a_factor(loaded, claim):
    known = replace(
        loaded, summary=loaded.summary | {"feedforward": {"first_gain": 0.7, "claims": [claim]}}
    )
    assert known.compensation[::2] == (
        loaded.compensation.rule._replace(gain=0.7),
        ((1e-3, None, 0.3, None),),
    )


def same(single, other):
    """Whether two models have the same numbers, to the bit."""
    for name, estimate in single.parameters.items():
        again = other.parameters[name]
        for field in ("value", "unit", "std", "robust_std", "interval", "status", "description"):
            assert getattr(again, field) == getattr(estimate, field), (name, field)
    assert (single.model, single.plant) == (other.model, other.plant)
    assert list(single.parameters) == list(other.parameters)
    assert single.covariance_names == other.covariance_names
    np.testing.assert_array_equal(single.covariance, other.covariance)
    assert (dict(single.treatment), single.compensation[1:], list(single.draws)) == (
        *(dict(other.treatment), other.compensation[1:], list(other.draws)),
    )
    for name, draws in single.draws.items():
        np.testing.assert_array_equal(draws, other.draws[name])
    assert vars(single.best.resampling.bands) | {"draws": 0} == vars(
        other.best.resampling.bands
    ) | {"draws": 0}
    assert [vars(each) for each in single.diagnostics] == [vars(each) for each in other.diagnostics]
    assert single.drive_table(12) == other.drive_table(12)
    assert single.to_dict() == other.to_dict()
    return True


@pytest.mark.slow
def test_columns_and_log_give_the_same_result(columns, result):
    log = br.Log.from_columns(columns)
    low = identification.identify(log, MODELS, cutoff=60.0, decimation=7, draws=20)
    assert result.parameters == low.best.parameters
    assert (result.model, result.plant) == (low.best.friction, low.best.plant)
    assert [fit.name for fit in result.fits] == [fit.name for fit in low.fits]


def test_data_frame_gives_the_same_result(columns, result):
    frame = pytest.importorskip("pandas").DataFrame(columns)
    again = br.identify(frame, "coulomb_viscous", cutoff=60.0, decimation=7, draws=0, blocks=0)
    assert {name: item.value for name, item in again.parameters.items()} == {
        name: item.value for name, item in result.parameters.items()
    }


def test_columns_of_a_rotary_axis_need_only_its_kind(columns):
    turned = br.identify(
        columns,
        "coulomb_viscous",
        axis=br.Axis(kind="rotational"),
        cutoff=60.0,
        decimation=7,
        draws=0,
        blocks=0,
    )
    assert (turned.parameters["M"].unit, turned.model.kind) == ("kg*m^2", "rotational")


def test_identify_has_the_arguments_of_the_identification():
    ours, low = (
        inspect.signature(each).parameters for each in (br.identify, identification.identify)
    )
    assert {name: item.default for name, item in ours.items()} == {
        name: item.default for name, item in low.items()
    }


def test_most_of_the_effort_is_in_the_band_of_its_prediction(columns, result):
    predicted = result.predict(columns)
    assert 85.0 < predicted.inside_percent <= 100.0
    quick = {**columns, "time": columns["time"] / 3.0}  # three times as fast as what was fitted
    assert [each.code for each in result.predict(quick).diagnostics if each.severity == "warning"]


def test_covariance_is_of_the_identified_parameters(columns, result):
    names, covariance = result.covariance_names, result.covariance
    assert set(names) == {
        name for name, item in result.parameters.items() if item.status == "identified"
    }
    assert np.sqrt(np.diag(covariance)) == pytest.approx(
        [result.parameters[name].std for name in names]
    )
    np.testing.assert_allclose(covariance, covariance.T)
    assert (
        np.linalg.eigvalsh(
            covariance / np.sqrt(np.outer(np.diag(covariance), np.diag(covariance)))
        ).min()
        > 0.0
    )
    fixed = br.identify(
        columns, "coulomb_viscous", mass=12.0, cutoff=60.0, decimation=7, draws=0, blocks=0
    )
    assert "M" not in fixed.covariance_names
    assert fixed.covariance.shape == (len(fixed.covariance_names),) * 2


def test_card_of_an_identification_is_short(result, loaded):
    for each in (result, loaded):
        lines = repr(each).splitlines()
        assert len(lines) <= 30
        assert [line.split()[0] for line in lines[2:6]] == list(result.parameters)
        assert "viscous" in lines[6]


def test_identification_survives_pickle(result):
    assert same(result, pickle.loads(pickle.dumps(result)))


def test_saved_identification_loads_with_the_same_numbers(columns, result, loaded):
    assert same(result, loaded)
    assert same(loaded, pickle.loads(pickle.dumps(loaded)))
    item, other = result.predict(columns), loaded.predict(columns)
    np.testing.assert_array_equal(item.effort_predicted, other.effort_predicted)
    np.testing.assert_array_equal(item.half_width, other.half_width)


def test_without_pyarrow_draws_are_npz(result, tmp_path, monkeypatch):
    def absent(name, wanted_by):
        raise MissingExtraError("is not installed", path=wanted_by)

    with monkeypatch.context() as patch:
        patch.setattr(arrays, "library", absent)
        place = result.save(tmp_path / "results")
        assert {item.name for item in place.glob("*.npz")} == {"draws.npz", "traces.npz"}
        assert same(result, br.load(place))


def test_folder_has_the_files_for_further_use(result, folder):
    table = br.read_axis(folder / "axis.toml")
    assert {name: item.name for name, item in table.columns.items()} == {
        name: name for name in ("time", "position", "effort")
    }
    curve = np.loadtxt(folder / "friction_curve.csv", delimiter=",", skiprows=1)
    assert np.all(np.diff(curve[:, 0]) >= 0.0)
    velocity, force = curve[-1, :2]
    assert force == pytest.approx(
        result.model.F_C + result.model.F_v * velocity + result.parameters["offset"].value, rel=1e-4
    )
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["parameters"]["M"]["value"] == result.parameters["M"].value
    assert (
        "passive" in summary["certificates"],
        "identify" in summary["provenance"]["command"],
    ) == (True, True)


def test_report_is_a_self_contained_file(result, loaded, tmp_path):
    page = result.report(tmp_path / "report.html").read_text(encoding="utf-8")
    assert [item.name for item in tmp_path.iterdir()] == ["report.html"]
    assert [part in page for part in ("Certificates of", 'src="http', 'href="http', "<link")] == [
        True,
        False,
        False,
        False,
    ]
    assert loaded.report(tmp_path / "again.html").read_text(encoding="utf-8") == page


def test_figure_has_the_effort_whole_and_close_up(result):
    whole, close = (
        [(line.get_label(), np.ptp(line.get_xdata())) for line in axes.lines[:2]]
        for axes in result.plot().axes
    )
    assert [name for name, _ in (*whole, *close)] == ["measured", "predicted"] * 2
    assert 0.0 < close[0][1] < whole[0][1]


@pytest.mark.parametrize(
    ("files", "words"),
    [
        ({}, "summary.json"),
        ({"traces.parquet": b"no table"}, "cannot be read"),
        ({"summary.json": b"{"}, "is not JSON"),
    ],
)
def test_folder_without_identification_is_refused(tmp_path, folder, files, words):
    if files:
        for name in ("summary.json", "model.toml"):
            (tmp_path / name).write_bytes((folder / name).read_bytes())
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=words):
        br.load(tmp_path)


def test_axis_file_is_written_as_read_or_as_changed():
    axis = axis_simulated.axis()
    assert axis_text(axis) == Path(axis_simulated.AXIS_FILE).read_bytes()
    changed = replace(axis, mass=28.0, cutoff=77.0, seeks_delay=True, span=(0.5, 3.0), at_rest=True)
    assert br.read_axis(axis_text(changed)) == changed != axis


def test_axis_without_a_file_form_is_not_written():
    axis = axis_simulated.axis()
    counted = replace(axis.columns["position"], base="count", scale=1e-6)
    assert axis_text(replace(axis, columns={**axis.columns, "position": counted})) is None


@pytest.mark.slow
def test_notebook_runs_and_its_job_has_ten_lines(tmp_path, monkeypatch):
    pytest.importorskip("pandas")
    monkeypatch.chdir(tmp_path)
    notebook = json.loads((ROOT / "examples" / "notebook.ipynb").read_text(encoding="utf-8"))
    cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    first, last = (
        next(i for i, cell in enumerate(cells) if word in cell)
        for word in ("br.identify", ".save(")
    )
    assert sum(len(cell.splitlines()) for cell in cells[first : last + 1]) <= 10
    names = {}
    for cell in cells:
        exec(cell, names)
    mass = names["found"].parameters["M"]
    assert names["again"].parameters["M"].value == mass.value
    assert mass.interval[0] < 12.0 < mass.interval[1]
    assert {"model.toml", "report.html", "draws.parquet"} <= {
        item.name for item in Path("results").iterdir()
    }
    assert Path("report.html").is_file()


def test_without_draws_the_bands_come_from_the_model_file(folder, result, tmp_path):
    bare = shutil.copytree(folder, tmp_path / "bare")
    (file,) = bare.glob("draws.*")
    file.unlink()
    bands = br.load(bare).best.resampling.bands
    few, all_draws = (
        next(iter(each.draws.values())) for each in (bands, result.best.resampling.bands)
    )
    assert 0 < few.size <= all_draws.size
    assert vars(bands) | {"draws": 0} == vars(result.best.resampling.bands) | {"draws": 0}


def test_reason_of_a_parameter_is_its_first_diagnostic():
    first, second = (
        Diagnostic(code, "F_C", "warning", {}, "translational") for code in ("wide", "follows")
    )
    entry = {
        "value": 1.0,
        "unit": "N",
        "description": "Coulomb friction",
        "std": 9.0,
        "status": "not identified",
        "interval": None,
    }
    (estimate,) = kept._estimates({"F_C": entry}, (first, second))
    assert estimate.reason is first


# --- An identified model: covariance, prediction with its treatment, and loading from a folder


def estimate(name, std=0.5, status="identified"):
    known = {
        "value": 3.0,
        "unit": "N",
        "robust_std": 0.6,
        "interval": (2.0, 4.0),
        "description": name,
        "interval_percent": 10.0,
    }
    return Some(name=name, std=std, status=status, **known)


def in_hand(**changes):
    names = ("a", "gone", "b")
    correlation = [[1.0, 0.3, -0.5], [0.3, 1.0, 0.2], [-0.5, 0.2, 1.0]]
    items = (
        estimate("M", 2.0),
        estimate("a", 0.5),
        estimate("gone", 1.0, "held"),
        estimate("b", 4.0),
        estimate("c", None),
        estimate("d", np.inf),
    )
    known = {
        "estimates": items,
        "correlation_names": names,
        "correlation": correlation,
        "resampling": None,
        "friction": "f",
        "plant": "p",
    }
    known |= {
        "parameters": {item.name: item for item in items},
        "diagnostics": (Diagnostic("switching_law", "", "warning"),),
    }
    model = model_in_hand.ModelInHand()
    model.best, model.axis, model.treatment = (
        Some(**known | changes),
        "axis",
        {"cutoff": 60.0, "decimation": 7.0, "rows": 3},
    )
    return model


def test_inertia_from_before_the_fit_is_independent_in_the_covariance():
    model = in_hand()
    assert model.covariance_names == ("a", "b", "M")
    expected = [[0.25, -1.0, 0.0], [-1.0, 16.0, 0.0], [0.0, 0.0, 4.0]]
    np.testing.assert_allclose(model.covariance, expected)
    assert (model.model, model.plant) == ("f", "p")


def test_draws_equal_those_of_the_bands():
    assert in_hand().draws == {}
    assert in_hand(resampling=Some(bands=Some(draws={"a": [1.0, 2.0]}))).draws["a"].tolist() == [
        1.0,
        2.0,
    ]


def test_a_prediction_takes_each_number_of_a_treatment():
    assert set(TREATMENT) <= set(inspect.signature(br.predict).parameters)


def test_prediction_uses_the_treatment_of_the_fit(monkeypatch):
    called = []
    monkeypatch.setattr("bristle.prediction.predict", lambda *a, **k: called.append((a, k)))
    in_hand().predict("log")
    in_hand(resampling=Some(bands="bands")).predict("log", "open-loop", axis="other")
    treatment = {"cutoff": 60.0, "decimation": 7}
    assert called == [
        (("p", "f", "log", "axis", "inverse"), {"bands": None} | treatment),
        (("p", "f", "log", "other", "open-loop"), {"bands": "bands"} | treatment),
    ]
    assert isinstance(called[0][1]["decimation"], int)


def test_drive_table_has_twenty_rows_by_default(monkeypatch):
    monkeypatch.setattr("bristle.prediction.drive_table", lambda best, entries: entries)
    assert (in_hand().drive_table(), in_hand().drive_table(7)) == (20, 7)


def test_a_data_frame_has_a_row_for_each_parameter():
    pytest.importorskip("pandas")
    frame = in_hand().to_dataframe()
    assert list(frame.index) == ["M", "a", "gone", "b", "c", "d"]
    assert frame.loc["a", ["value", "std", "robust_std", "low", "high"]].tolist() == [
        3.0,
        0.5,
        0.6,
        2.0,
        4.0,
    ]
    model = in_hand()
    model.best.parameters["a"].interval = None
    assert model.to_dataframe().loc["a", "low"] is None or np.isnan(
        model.to_dataframe().loc["a", "low"]
    )


def test_text_of_a_diagnostic_is_its_sentence():
    (diagnostic,) = in_hand().diagnostics
    assert diagnostic.message.startswith("the control law chatters")
    assert str(diagnostic) == diagnostic.message


def test_saved_model_lists_the_next_models():
    summary = {
        "models": [{"name": "a"}, {"name": "b"}, {"name": "c"}],
        "provenance": {"log": "a.csv"},
    }
    loaded = model_in_hand.Loaded(None, {}, None, summary, "page")
    assert loaded._words() == ("a.csv", ["next in rank: b, c"])
    assert model_in_hand.Loaded(None, {}, None, {"models": [{"name": "a"}]}, "")._words() == (
        "",
        [],
    )
    assert (loaded.to_dict(), loaded.to_dict() is summary) == (summary, False)


@pytest.mark.parametrize(
    ("summary", "plant", "traces", "words"),
    [
        ("{}", "p", {"time": 1}, "contains no identification"),
        ('{"parameters": {}}', None, {"time": 1}, "contains no identification"),
        ('{"parameters": {}}', "p", {}, "contains no identification"),
        ('{"parameters": {}}', "p", {"time": 1}, "has missing or invalid entries"),
    ],
)
def test_folder_without_plant_traces_or_numbers_is_refused(
    tmp_path, monkeypatch, summary, plant, traces, words
):
    (tmp_path / "summary.json").write_text(summary)
    monkeypatch.setattr(model_in_hand, "read_model", lambda *a, **k: (plant, "f", {"bands": None}))
    monkeypatch.setattr(model_in_hand, "read_arrays", lambda *a: traces)
    with pytest.raises(InputError, match=words):
        model_in_hand.load(tmp_path)


def test_folder_is_loaded_with_its_axis_and_page(tmp_path, monkeypatch):
    (tmp_path / "summary.json").write_text('{"parameters": {}, "treatment": {"cutoff": 60.0}}')
    seen = []
    monkeypatch.setattr(
        model_in_hand,
        "read_model",
        lambda *a, allow_code: seen.append(allow_code) or ("p", "f", {"bands": None}),
    )
    monkeypatch.setattr(model_in_hand, "read_arrays", lambda place, name: {"time": name})
    monkeypatch.setattr(model_in_hand, "fit_of", lambda *arguments: arguments)
    monkeypatch.setattr(model_in_hand, "read_axis", lambda file: file.name)
    bare = model_in_hand.load(tmp_path)
    assert (bare.axis, bare.page, bare.treatment) == (None, "", {"cutoff": 60.0})
    assert bare.best[3:] == ({"time": "traces"}, {"time": "draws"}, None)
    (tmp_path / "axis.toml").write_text("")
    (tmp_path / "report.html").write_text("page")
    whole = model_in_hand.load(tmp_path, allow_code=True)
    assert (whole.axis, whole.page) == ("axis.toml", "page")
    assert seen == [False, True]


# --- A log without sliding gives no level of friction to a drive


RATED = {
    "schema": 1,
    "kind": "translational",
    "columns": {
        name: {"column": name, "unit": unit}
        for name, unit in (("time", "s"), ("position", "m"), ("effort", "N"))
    },
    "effort": {"rated": "100 N"},
}


@pytest.fixture(scope="module")
def log():
    """A log of springs that slip in turn, deflected to half of the last slip."""
    return pulled(lambda x: elements(x, 5e-6), 0)


@pytest.fixture(scope="module")
def never_slid(log):
    return br.identify(log, "preisach_contact", draws=0, blocks=0)


def test_level_above_the_effort_of_the_log_is_not_identified(log, never_slid):
    level = never_slid.best.parameters["f_p"]
    assert level.value > 1.2 * np.max(np.abs(log.effort.values))
    assert (level.status, level.reason.code) == ("unidentifiable", "beyond_effort")
    (message,) = [
        diagnostic
        for diagnostic in never_slid.best.diagnostics
        if diagnostic.code == "never_slides"
    ]
    assert "f_p" in message.numbers["names"]


@pytest.mark.slow
def test_log_without_sliding_gives_no_level_and_no_table(never_slid, tmp_path):
    best = never_slid.best
    assert (
        level_values(best),
        drive_table(best),
        model_tables.values_to_enter(best, None).rows,
    ) == (None, [], [])
    never_slid.save(tmp_path / "out")
    assert not (tmp_path / "out" / "drive_table.csv").exists()


@pytest.mark.slow
@pytest.mark.parametrize(("target", "points"), [("table", 20), ("table", 3), ("tf5200", 20)])
def test_drive_files_have_the_warning(never_slid, tmp_path, target, points, monkeypatch):
    # It runs the model uncompiled.
    monkeypatch.setattr("bristle.exports.writing.effect_of_files", lambda *_, **__: None)
    never_slid.save(tmp_path / "out")
    plant, friction, info = read_model(tmp_path / "out" / "model.toml")
    source = Source(info["provenance"], info["uncertainty"])
    requested = Request(
        friction,
        "axis_x",
        1e-3,
        source,
        speed=0.1,
        points=points,
        plant=plant,
        axis=axis_from(RATED),
    )
    product = writing.files_for(target, requested)
    assert "do not use" in product.notes[0]
    assert "f_p" in product.notes[0]
    if target == "tf5200":
        assert "do not use" in product.files["axis_x.txt"]


@pytest.mark.slow
def test_level_within_the_effort_has_the_warning(never_slid):
    entry = {"std": 0.1, "status": "identified", "note": "the log contains only pre-sliding"}
    friction = never_slid.best.friction
    message = writing.files_for(
        "table", Request(friction, "x", 1e-3, Source({}, {"f_p": entry}), speed=0.1)
    ).notes
    plain = writing.files_for(
        "table", Request(friction, "x", 1e-3, Source({}, {"f_p": {"status": "held"}}), speed=0.1)
    ).notes
    assert len(message) == len(plain) + 1


@pytest.mark.slow
def test_pre_sliding_is_named_before_position_dependence(log):
    fit = br.identify(log, "coulomb_viscous", draws=0, blocks=0).best
    named = [diagnostic for diagnostic in fit.diagnostics if diagnostic.code.startswith("missing_")]
    assert [diagnostic.code for diagnostic in named] == ["missing_presliding"]
    assert named[0].numbers["model"] == "preisach_contact"


@pytest.mark.slow
def test_compared_models_are_not_suggested(log):
    fits = br.identify(log, "coulomb_viscous,preisach_contact", draws=0, blocks=0).fits
    static = next(fit for fit in fits if fit.name == "coulomb_viscous")
    named = (
        structure.with_structure(static, None, settings.DEFAULT, compared=["preisach_contact"])
        .diagnostics[0]
        .numbers
    )
    assert (named["model"], named["compared"]) == ("", "preisach_contact")


def test_of_several_logs_those_that_are_too_short_are_named_and_the_others_go_on(columns):
    whole, *short = (
        {name: values[:count] for name, values in columns.items()} for count in (4000, 60, 150)
    )
    with pytest.warns(InputWarning, match="leaves out a log: "):
        result = br.identify([short[0], whole, short[1]], "viscous", draws=0, blocks=0)
    named = [note for note in result.log.notes if note.startswith("bristle leaves out a log: ")]
    assert (len(result.axes), len(result.log)) == (1, 4000)
    assert ["(60 instead of" in named[0], "(150 samples without a gap instead of" in named[1]] == [
        True,
        True,
    ]
    with pytest.raises(
        InputError, match=r"all 2 logs are too short: .*\(60 instead of .*, .*\(60 instead of"
    ):
        br.identify(short[:1] * 2, "viscous")


def test_lines_of_a_second_pass_stand_in_the_axis_of_the_log_that_was_used(result):
    def fitted(log, model, axis):
        return replace(result, log=log[1], second_pass=Some(taken=True, lines=()))

    logs = [replace(result.log, source=Path(name)) for name in ("short.csv", "long.csv")]
    logs[0] = replace(logs[0], time=replace(logs[0].time))
    assert [axis.name for axis in identified._in_hand(fitted)(logs, "viscous", None).axes] == [
        "long"
    ]
