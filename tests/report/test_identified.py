"""The result of an identification: its data, predictions, files and pickle."""

import inspect
import json
import pickle
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.identification.known_logs import sliding_log

import bristle as br
from bristle import identification
from bristle.core.diagnostic import Diagnostic
from bristle.core.errors import InputError, MissingExtraError
from bristle.demo import axis_simulated
from bristle.files import arrays
from bristle.files.axis import axis_text
from bristle.files.model import read_model
from bristle.prediction import kept, predict

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
    assert dict(single.treatment) == dict(other.treatment)
    assert list(single.draws) == list(other.draws)
    for name, draws in single.draws.items():
        np.testing.assert_array_equal(draws, other.draws[name])
    assert vars(single.best.resampling.bands) | {"draws": 0} == vars(other.best.resampling.bands) | {"draws": 0}
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
    assert {name: item.value for name, item in again.parameters.items()} == {name: item.value for name, item in result.parameters.items()}
    table = result.to_dataframe()
    assert table.loc["M", "value"] == result.parameters["M"].value
    assert (table.loc["M", "low"], table.loc["M", "high"]) == result.parameters["M"].interval


def test_columns_of_a_rotary_axis_need_only_its_kind(columns):
    turned = br.identify(columns, "coulomb_viscous", axis=br.Axis(kind="rotational"), cutoff=60.0, decimation=7, draws=0, blocks=0)
    assert (turned.parameters["M"].unit, turned.model.kind) == ("kg*m^2", "rotational")


def test_identify_has_the_arguments_of_the_identification():
    ours, low = (inspect.signature(each).parameters for each in (br.identify, identification.identify))
    assert {name: item.default for name, item in ours.items()} == {name: item.default for name, item in low.items()}


def test_prediction_uses_axis_and_treatment_of_the_result(columns, result, folder):
    predicted = result.predict(columns)
    treatment = read_model(folder / "model.toml").info["treatment"]
    assert (treatment["cutoff"], treatment["decimation"]) == (60.0, 7)
    bands = result.best.resampling.bands
    low = predict(result.plant, result.model, br.Log.from_columns(columns), bands=bands, **treatment)
    np.testing.assert_array_equal(predicted.effort_predicted, low.effort_predicted)
    np.testing.assert_array_equal(predicted.half_width, low.half_width)
    assert 85.0 < predicted.inside_percent <= 100.0
    quick = {**columns, "time": columns["time"] / 3.0}
    doubts = [each.code for each in result.predict(quick).diagnostics if each.severity == "warning"]
    assert doubts, "three times as fast as what was fitted, and nothing is said of it"


def test_drive_table_equals_the_table_by_call(result, monkeypatch):
    requested = []
    monkeypatch.setattr("bristle.report.identified.drive_table", lambda best, entries: requested.append(entries) or [])
    monkeypatch.setattr("bristle.prediction.drive_table", lambda best, entries: requested.append(entries) or [])
    monkeypatch.setattr("bristle.certificates.check", lambda model: {})
    assert result.outcome_with(loop=(None, None, None)).table == result.drive_table() == []
    assert requested[0] == requested[1]


def test_covariance_is_of_the_identified_parameters(columns, result):
    names, covariance = result.covariance_names, result.covariance
    assert set(names) == {name for name, item in result.parameters.items() if item.status == "identified"}
    assert np.sqrt(np.diag(covariance)) == pytest.approx([result.parameters[name].std for name in names])
    np.testing.assert_allclose(covariance, covariance.T)
    assert np.linalg.eigvalsh(covariance / np.sqrt(np.outer(np.diag(covariance), np.diag(covariance)))).min() > 0.0
    fixed = br.identify(columns, "coulomb_viscous", mass=12.0, cutoff=60.0, decimation=7, draws=0, blocks=0)
    assert "M" not in fixed.covariance_names
    assert fixed.covariance.shape == (len(fixed.covariance_names),) * 2


def test_card_of_an_identification_is_short(result, loaded):
    for each in (result, loaded):
        lines = repr(each).splitlines()
        assert len(lines) <= 30
        assert [line.split()[0] for line in lines[2:6]] == list(result.parameters)
        assert "viscous" in lines[6]


def test_diagnostics_have_sentence_and_code(result):
    assert all(each.code and each.message.strip() for each in result.diagnostics)
    assert [each.message for each in result.diagnostics] == [each["message"] for each in result.to_dict()["diagnostics"]]


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
    assert {name: item.name for name, item in table.columns.items()} == {name: name for name in ("time", "position", "effort")}
    curve = np.loadtxt(folder / "friction_curve.csv", delimiter=",", skiprows=1)
    F_C, F_v = result.model.F_C, result.model.F_v
    assert np.all(np.diff(curve[:, 0]) >= 0.0)
    fastest = curve[-1]
    assert fastest[1] == pytest.approx(F_C + F_v * fastest[0] + result.parameters["offset"].value, rel=1e-4)
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["parameters"]["M"]["value"] == result.parameters["M"].value
    assert "passive" in summary["certificates"]
    assert "identify" in summary["provenance"]["command"]


def test_report_is_a_self_contained_file(result, loaded, tmp_path):
    page = result.report(tmp_path / "report.html").read_text(encoding="utf-8")
    assert [item.name for item in tmp_path.iterdir()] == ["report.html"]
    assert "Certificates of" in page
    assert not any(outside in page for outside in ('src="http', 'href="http', "<link"))
    assert loaded.report(tmp_path / "again.html").read_text(encoding="utf-8") == page


def test_figure_has_the_effort_whole_and_close_up(result):
    whole, close = result.plot().axes
    for axes in (whole, close):
        assert [line.get_label() for line in axes.lines[:2]] == ["measured", "predicted"]
    spans = [np.ptp(axes.lines[0].get_xdata()) for axes in (whole, close)]
    assert 0.0 < spans[1] < spans[0]


def test_existing_results_are_not_replaced_without_force(result, folder):
    with pytest.raises(InputError, match="exists already"):
        result.save(folder)


def test_folder_without_identification_is_refused(tmp_path, folder):
    with pytest.raises(InputError):
        br.load(tmp_path)
    for name in ("summary.json", "model.toml"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    with pytest.raises(InputError, match="contains no identification"):
        br.load(tmp_path)
    (tmp_path / "traces.parquet").write_bytes(b"no table")
    with pytest.raises(InputError, match="cannot be read"):
        br.load(tmp_path)
    (tmp_path / "summary.json").write_text("{")
    with pytest.raises(InputError, match="is not JSON"):
        br.load(tmp_path)


def test_axis_file_is_written_as_read_or_as_changed():
    axis = axis_simulated.axis()
    assert axis_text(axis) == Path(axis_simulated.AXIS_FILE).read_bytes()
    changed = replace(axis, mass=28.0, cutoff=77.0, seeks_delay=True, span=(0.5, 3.0), at_rest=True)
    again = br.read_axis(axis_text(changed))
    assert again == changed
    assert again != axis


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
    first, last = (next(i for i, cell in enumerate(cells) if word in cell) for word in ("br.identify", ".save("))
    assert sum(len(cell.splitlines()) for cell in cells[first : last + 1]) <= 10
    names = {}
    for cell in cells:
        exec(cell, names)
    assert names["again"].parameters["M"].value == names["found"].parameters["M"].value
    assert names["found"].parameters["M"].interval[0] < 12.0 < names["found"].parameters["M"].interval[1]
    assert {"model.toml", "report.html", "draws.parquet"} <= {item.name for item in Path("results").iterdir()}
    assert Path("report.html").is_file()


def test_without_draws_the_bands_come_from_the_model_file(folder, result, tmp_path):
    bare = shutil.copytree(folder, tmp_path / "bare")
    (file,) = bare.glob("draws.*")
    file.unlink()
    bands = br.load(bare).best.resampling.bands
    few, all_draws = (next(iter(each.draws.values())) for each in (bands, result.best.resampling.bands))
    assert 0 < few.size <= all_draws.size
    assert vars(bands) | {"draws": 0} == vars(result.best.resampling.bands) | {"draws": 0}


def test_reason_of_a_parameter_is_its_first_diagnostic():
    first, second = (Diagnostic(code, "F_C", "warning", {}, "translational") for code in ("wide", "follows"))
    entry = {"value": 1.0, "unit": "N", "description": "Coulomb friction", "std": 9.0, "status": "not identified", "interval": None}
    (estimate,) = kept._estimates({"F_C": entry}, (first, second))
    assert estimate.reason is first
