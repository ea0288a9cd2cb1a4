"""Step 6 without a browser: a controller from fields, the gain of a loop that is simulated, and why a gain is missing."""

import json
import zipfile
from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from markupsafe import Markup
from tests.cli.conftest import EXPERIMENT

from bristle.apps.lab.server import cases, loop, tasks
from bristle.apps.lab.server.errand import Errand, LabelledLog
from bristle.core import Diagnostic, InputError
from bristle.files import read_axis, read_experiment
from bristle.report import page
from bristle.simulation import simulate

AXIS = (
    'schema = 1\nkind = "translational"\n[columns]\ntime = { column = "time", unit = "s" }\n'
    'position = { column = "x", unit = "mm" }\nreference = { column = "r", unit = "mm" }\neffort = { column = "u", unit = "A" }\n'
    '[effort]\nconstant = "10 N/A"\n'
)


@pytest.fixture(scope="module", autouse=True)
def undrawn_reports():
    """Reports have no figures: nothing is said of them here."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            page,
            "picture",
            lambda name, draw, alternative, caption, **_: page.Picture(
                name, Markup("<svg></svg>"), caption
            ),
        )
        yield


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """The log of a simulated axis with its reference, and the controller of its loop as fields of an axis file."""
    folder = tmp_path_factory.mktemp("recorded")
    (folder / "experiment.toml").write_text(EXPERIMENT)
    experiment = read_experiment(folder / "experiment.toml")
    run, variant = (
        simulate(experiment).variants["none"],
        next(variant for variant in experiment.variants if variant.name == "none"),
    )
    columns = np.column_stack((run.time, 1e3 * run.measured, 1e3 * run.reference, 0.1 * run.effort))
    np.savetxt(
        folder / "log.csv", columns, delimiter=",", header="time,x,r,u", comments="", fmt="%.9g"
    )
    law = {
        f"controller.{name}": value
        for name, value in variant.controller.values.items()
        if np.isfinite(value)
    }
    return folder / "log.csv", {"controller.model": variant.controller.name} | law


@pytest.fixture(scope="module")
def identified(recorded, tmp_path_factory):
    """The errand after an identification without a controller, and what the page shows of it."""
    folder = tmp_path_factory.mktemp("identified")
    log = LabelledLog(recorded[0], "log.csv", "fit")
    options = {"models": "coulomb_viscous", "draws": 0}
    errand = Errand(
        folder, (log,), AXIS, "axis.toml", options, 2**24, None, lambda *_: None, nullcontext
    )
    _, data = tasks.identify(errand)
    return replace(errand, results=folder / "results", options={}), data


def test_without_a_controller_the_page_says_what_is_missing(identified):
    errand, data = identified
    assert data["loop"]["gain"] is None
    assert "controller is missing" in data["loop"]["reason"]
    assert "Friction forward, F+" in [row[0] for row in data["loop"]["values"]["rows"]]
    assert data["loop"]["values"]["heads"][1] == "In the drive's units"
    with pytest.raises(
        InputError, match=r"cannot be simulated: the controller is missing\. Select it"
    ):
        loop.compensate(errand)


@pytest.fixture(scope="module")
def compensated(identified, recorded):
    """Facts and data of the page after the simulation of the loop with the controller from fields."""
    return loop.compensate(replace(identified[0], options={"edits": recorded[1]}))


def test_a_controller_from_fields_shows_the_gain_and_keeps_the_model(
    identified, recorded, compensated
):
    (errand, before), (facts, found) = identified, compensated
    data = found["loop"]
    assert read_axis(facts["axis_text"].encode()).controller.name == recorded[1]["controller.model"]
    assert facts["axis_text"].startswith(AXIS)
    gain = data["gain"]
    assert (gain["helps"], data["reason"], data["log"]) == (True, "", "log.csv")
    times = gain["headline"].rpartition("×")[2]
    assert float(times) > 2.0
    assert data["values"] == before["loop"]["values"]
    assert data["tables"]["controller"]["model"] == recorded[1]["controller.model"]
    archive = archived(errand.folder)
    assert json.loads(archive["summary.json"])["compensation"]
    assert times in archive["report.html"].decode()


@pytest.mark.slow
def test_an_export_simulates_the_loop_of_the_controller(identified, compensated):
    exported = tasks.export(replace(identified[0], axis_text=compensated[0]["axis_text"]))[1]
    assert not [note for note in exported["notes"] if "did not simulate" in note]


def archived(folder):
    with zipfile.ZipFile(folder / "results.zip") as archive:
        return {name: archive.read(name) for name in archive.namelist()}


@pytest.mark.slow
def test_the_archive_is_that_of_an_identification_with_this_controller(
    compensated, identified, tmp_path
):
    facts, data = compensated
    errand, archive = identified[0], archived(identified[0].folder)
    again = replace(
        errand,
        folder=tmp_path,
        axis_text=facts["axis_text"],
        options={"models": "coulomb_viscous", "draws": 0},
        results=None,
    )
    assert tasks.identify(again)[1] == data
    assert archived(tmp_path) == archive


def test_a_gain_that_is_missing_is_named(identified):
    errand, _ = identified
    edits = {"controller.model": "cascade", "controller.k_p": "60 1/s"}
    with pytest.raises(InputError, match="controller: cascade needs k_v"):
        loop.compensate(replace(errand, options={"edits": edits}))
    with pytest.raises(InputError, match=r"controller\.k_v: has the wrong unit"):
        loop.compensate(replace(errand, options={"edits": edits | {"controller.k_v": "3 A"}}))


def test_a_field_that_changes_the_log_needs_another_identification(identified, recorded):
    errand, _ = identified
    with pytest.raises(InputError, match=r"changes the meaning of the log.*identify again"):
        loop.compensate(
            replace(errand, options={"edits": recorded[1] | {"effort.constant": "20 N/A"}})
        )


@pytest.mark.slow
def test_a_field_of_the_loop_needs_no_other_identification(identified, recorded):
    errand, _ = identified
    loop.compensate(
        replace(
            errand,
            options={"edits": recorded[1] | {"effort.limit": "500 A", "effort.lag": "0.1 ms"}},
        )
    )


@pytest.mark.parametrize(
    ("following", "words"),
    [
        (
            SimpleNamespace(contradiction=Diagnostic("switching_law", "", "note")),
            "the control law chatters",
        ),
        (SimpleNamespace(contradiction=None), "the simulated loop is unstable"),
        (None, "the simulated loop is unstable"),
    ],
)
def test_an_unknown_gain_has_a_reason(monkeypatch, following, words):
    monkeypatch.setattr(
        "bristle.report.compensation.gain_of", lambda simulation: SimpleNamespace(steps=())
    )
    gain, reason = loop._gain(None, following)
    assert (gain, reason[: len(words)]) == (None, words)


@pytest.mark.slow
def test_a_wrong_gain_is_no_basis_for_a_prediction(identified, recorded):
    errand, _ = identified
    gains = {name: 5.0 * value for name, value in recorded[1].items() if name == "controller.k_p"}
    data = loop.compensate(replace(errand, options={"edits": recorded[1] | gains}))[1]["loop"]
    assert data["gain"] is None
    assert "log" in data["reason"]


def test_a_log_without_a_reference_has_no_loop():
    fit = SimpleNamespace(position_rmse=None)
    assert "Record the desired position" in loop.reason_without_loop(
        fit, SimpleNamespace(controller=1), SimpleNamespace(reference=None)
    )
    assert "fitted to the position" in loop.reason_without_loop(
        SimpleNamespace(position_rmse=1.0), None, None
    )


def test_another_controller_leaves_the_model_valid(tmp_path):
    case = cases.Case("one", tmp_path)
    for name in ("identified", "compensated"):
        case.keep(name, cases.Part(1, tmp_path, {}, case.inputs_of(name)))
    case.changed("loop")
    assert (case.is_old("identified"), case.is_old("compensated")) == (False, True)


def test_every_controller_has_fields():
    laws = {law["name"]: [key for key, _, _ in law["fields"]] for law in loop.controller_fields()}
    assert laws["cascade"][:3] == ["controller.k_p", "controller.k_v", "controller.k_i"]
    assert "controller.lambda" in laws["sliding_mode"]
    assert all(laws.values())


@pytest.mark.parametrize("constant", ["61.2", "61.2 "])
def test_a_constant_without_a_unit_asks_for_it(constant):
    with pytest.raises(
        InputError, match=r"effort\.constant: lacks its unit.*Add the unit: N/A or N\*m/A"
    ):
        read_axis(AXIS.replace("10 N/A", constant).encode())
