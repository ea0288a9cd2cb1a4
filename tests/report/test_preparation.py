"""Models of an experiment file before its simulation, without the fits: kept, read, excited and written."""

import re
import shutil
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from tests.simulation.test_run import loop

import bristle as br
from bristle import controllers, sensors
from bristle.cli.main import main
from bristle.core import Axis, InputError, Run
from bristle.engine import interpreted
from bristle.report import identified, prepared


@dataclass(frozen=True)
class Plan:
    """The entry of a model to identify in an experiment file."""

    name: str
    folder: Path
    is_current: bool = False
    logs: tuple = ()
    axis: object = None
    excited: object = None
    options: dict = field(default_factory=dict)
    note: tuple = ("depends_on.json", "digest")

    @property
    def path(self):
        return f"identify.{self.name}"


def written(tmp_path, monkeypatch, *plans):
    """An experiment file with these models to identify."""
    (tmp_path / "experiment.toml").write_text("schema = 1\n", encoding="utf-8")
    monkeypatch.setattr(
        prepared, "planned_in", lambda data, source, sources: {plan.name: plan for plan in plans}
    )
    return tmp_path / "experiment.toml"


def test_present_models_are_not_fitted_again_and_keep_the_order(tmp_path, monkeypatch):
    plans = [
        Plan("first", tmp_path / "1"),
        Plan("second", tmp_path / "2", is_current=True),
        Plan("third", tmp_path / "3"),
    ]
    file, fitted, reports = written(tmp_path, monkeypatch, *plans), [], []

    def identify(plan, source, size_limit, progress):
        fitted.append((plan.name, source, size_limit))
        progress(0.0, "begins")
        progress(0.5, "goes on")
        return f"fit of {plan.name}"

    monkeypatch.setattr(prepared, "_identified", identify)
    result = prepared.prepare(
        file, size_limit="2 kB", progress=lambda share, text: reports.append(share)
    )
    assert result == (
        prepared.Prepared("first", tmp_path / "1", "fit of first"),
        prepared.Prepared("second", tmp_path / "2", None),
        prepared.Prepared("third", tmp_path / "3", "fit of third"),
    )
    assert fitted == [("first", file, 2000), ("third", file, 2000)]
    assert reports == pytest.approx([0.0, 1.0 / 6.0, 2.0 / 3.0, 5.0 / 6.0])
    # Whoever asks for no progress gets none.
    assert prepared.prepare(file)[0].best == "fit of first"


def identified_of(tmp_path, monkeypatch, plan):
    """The results of a plan without the fit: the requests and the files."""
    asked, files = {}, {}
    outcome = SimpleNamespace(provenance={"log": "sum"})

    @dataclass(frozen=True)
    class Outcome:
        provenance: dict

        def write(self, folder):
            files["outcome"] = self

    def outcome_with(command):
        asked["command"] = command
        return Outcome(outcome.provenance)

    def identify(logs, axis, progress, **options):
        asked.update(logs=logs, axis=axis, options=options)
        return SimpleNamespace(finished=SimpleNamespace(best="best", outcome_with=outcome_with))

    folder = SimpleNamespace(write=lambda name, text: files.update({name: text}))
    monkeypatch.setattr(
        prepared,
        "results_folder",
        lambda place, force: asked.update(force=force) or nullcontext(folder),
    )
    monkeypatch.setattr(
        "bristle.files.logs_and_axes",
        lambda logs, axis, size_limit: [((log, axis, size_limit), axis) for log in logs],
    )
    monkeypatch.setattr("bristle.files.read_axis", lambda file: f"axis of {file}")
    monkeypatch.setattr(identified, "identify", identify)
    best = prepared._identified(plan, Path("experiment.toml"), 1000, lambda share, text: None)
    return best, asked, files


def test_logs_are_read_with_their_axis_and_results_are_saved(tmp_path, monkeypatch):
    plan = Plan(
        "axis_x",
        tmp_path / "identified" / "axis_x",
        logs=("a.csv", "b.csv"),
        axis="axis.toml",
        options={"model": "lugre"},
    )
    best, asked, files = identified_of(tmp_path, monkeypatch, plan)
    expected = {
        "options": {"draws": 0, "model": "lugre"},
        "command": "[identify.axis_x] of experiment.toml",
        "force": True,
    }
    expected |= {
        "logs": [("a.csv", "axis of axis.toml", 1000), ("b.csv", "axis of axis.toml", 1000)]
    }
    assert {name: asked[name] for name in expected} == expected
    assert (best, files["outcome"].provenance, files["depends_on.json"]) == (
        "best",
        {"log": "sum"},
        "digest",
    )
    assert plan.folder.parent.is_dir()
    _, asked, _ = identified_of(
        tmp_path, monkeypatch, replace(plan, axis=None, options={"draws": 50})
    )
    assert (asked["axis"], asked["options"]) == (None, {"draws": 50})


def test_provenance_names_the_excited_rig_and_its_friction(tmp_path, monkeypatch):
    excited = loop(name="learning")
    monkeypatch.setattr(
        prepared, "_excited", lambda variant, axis: (["log of the run"], "axis of the run")
    )
    plan = Plan("axis_x", tmp_path / "identified" / "axis_x", excited=excited)
    _, asked, files = identified_of(tmp_path, monkeypatch, plan)
    assert (asked["logs"], asked["axis"]) == (["log of the run"], "axis of the run")
    provenance = files["outcome"].provenance
    assert (
        provenance.items()
        >= {"identified from a run of": "experiment.toml: learning", "log": "sum"}.items()
    )
    assert len(provenance) == 3


def test_run_of_a_loop_is_the_log_of_its_drive():
    with interpreted():
        (log,), axis = prepared._excited(loop(120, sensor=sensors.encoder(resolution=1e-4)), None)
    assert (axis.kind, axis.resolution, log.sample_time) == (
        "translational",
        1e-4,
        pytest.approx(1e-2),
    )
    assert log.position.values / 1e-4 == pytest.approx(
        np.round(log.position.values / 1e-4), abs=1e-6
    )
    assert log.reference.values[:30] == pytest.approx(1e-3 * np.arange(30))
    assert np.max(np.abs(log.effort.values)) > 3.0  # more than Coulomb friction
    known = Axis(resolution=2e-4)
    with interpreted():
        assert prepared._excited(loop(120), known)[1] is known


def test_diverged_loop_identifies_no_model():
    fast = controllers.cascade(k_p=10.0, k_v=1e8)
    wild = loop(200, controller=fast, run=Run(duration=2.0, sample_time=1e-2, substeps=1))
    refused = pytest.raises(
        InputError, match=r"compare\.loop: the simulation stopped early.*Correct this loop"
    )
    with interpreted(), np.errstate(all="ignore"), refused:
        prepared._excited(wild, None)


# --- An experiment that identifies its compensator: fitted once, kept, and fitted again for a changed rig


RIG = """
schema = 1

[plant]
M = "28 kg"

[friction]
model = "coulomb_viscous"
F_C = "20 N"
F_v = "200 N*s/m"

[controller]
model = "cascade"
k_p = "60 1/s"
k_v = "6.7 N*s/mm"

[sensor]
resolution = "0.1 um"

[reference]
model = "sine"
amplitude = "5 mm"
frequency = "1 Hz"

[run]
duration = "1 s"
sample_time = "1 ms"

[identify.axis_x]
excite = "learning"
model = "coulomb_viscous"

[compare.learning.reference]
model = "varied_sine"
amplitudes = ["0 mm", "8 mm", "2 mm", "6 mm"]
frequency = "0.7 Hz"
duration = "6 s"

[compare.learning.run]
duration = "6 s"

[compare.identified.controller.feedforward]
friction = { identified = "axis_x" }
"""


@pytest.fixture
def rig(tmp_path):
    path = tmp_path / "rig.toml"
    path.write_text(RIG)
    return path


@pytest.fixture(scope="module")
def fitted_rig(tmp_path_factory):
    path = tmp_path_factory.mktemp("prepared") / "rig.toml"
    path.write_text(RIG)
    return path, br.prepare(path)


@pytest.fixture
def copied(fitted_rig, tmp_path):
    """A rig with an identified compensator."""
    shutil.copytree(fitted_rig[0].parent, tmp_path / "copied")
    return tmp_path / "copied" / "rig.toml"


def compensator(path):
    return next(
        v for v in br.read_experiment(path).variants if v.name == "identified"
    ).feedforward.friction


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_rig_is_excited_and_its_friction_is_used_as_feedforward(fitted_rig):
    path, (model,) = fitted_rig
    assert model.best.friction == compensator(path)
    assert pytest.approx(20.0, rel=0.02) == compensator(path).F_C
    assert [variant.name for variant in br.read_experiment(path).variants] == ["base", "identified"]
    assert "identified from a run of" in (model.folder / "model.toml").read_text()
    assert (model.folder / "report.html").exists()


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    ("seen", "instead"),
    [
        ('F_C = "20 N"', 'F_C = "26 N"'),
        ('k_p = "60 1/s"', 'k_p = "50 1/s"'),
        ('"8 mm", "2 mm"', '"7 mm", "2 mm"'),
        (
            'model = "coulomb_viscous"\n\n[compare',
            'model = "coulomb_viscous"\ncutoff = "90 Hz"\n\n[compare',
        ),
    ],
)
def test_changed_rig_is_fitted_again(copied, seen, instead):
    assert seen in RIG
    copied.write_text(RIG.replace(seen, instead))
    with pytest.raises(InputError, match="other inputs than those that this file now states"):
        br.read_experiment(copied)
    assert br.prepare(copied)[0].best is not None
    now = br.read_experiment(copied).variants[0].friction.F_C
    assert pytest.approx(now, rel=0.02) == compensator(copied).F_C


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_edited_digest_is_ignored(copied):
    folder = copied.parent / "rig_identified" / "axis_x"
    note = folder / "depends_on.json"
    note.write_text(note.read_text() + " ")
    with pytest.raises(InputError, match="other inputs than those that this file now states"):
        br.read_experiment(copied)


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_interrupted_fit_is_not_saved(rig, monkeypatch):
    whole = identified.identify
    monkeypatch.setattr(
        identified,
        "identify",
        lambda *logs, **options: replace(whole(*logs, **options), unfinished="interrupted"),
    )
    with pytest.raises(KeyboardInterrupt):
        br.prepare(rig)
    assert list((rig.parent / "rig_identified").iterdir()) == []


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_changed_evaluation_needs_no_new_fit(copied):
    copied.write_text(
        RIG.replace(
            "[compare.identified.controller.feedforward]",
            '[compare.identified.run]\nduration = "2 s"\n\n[compare.identified.controller.feedforward]',
        )
    )
    assert br.prepare(copied)[0].best is None


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_edited_model_is_neither_used_nor_replaced(copied):
    model = copied.parent / "rig_identified" / "axis_x" / "model.toml"
    custom = model.read_text().replace("F_C =", "F_C = 1.0 #")
    model.write_text(custom)
    for use in (br.read_experiment, br.prepare):
        with pytest.raises(InputError, match="was changed after its identification"):
            use(copied)
    copied.write_text(RIG.replace('F_C = "20 N"', 'F_C = "26 N"'))
    with pytest.raises(InputError, match="was changed after"):
        br.prepare(copied)
    assert model.read_text() == custom


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_changed_log_is_fitted_again(rig, tmp_path):
    rng = np.random.default_rng(1)

    def record(level):
        t = np.arange(6000) * 1e-3
        v = 0.02 * np.cos(2 * np.pi * 0.7 * t) + 0.03 * np.cos(2 * np.pi * 1.3 * t)
        effort = (
            28.0 * np.gradient(v, t)
            + level * np.sign(v)
            + 200.0 * v
            + 0.01 * rng.standard_normal(t.size)
        )
        columns = np.column_stack([t, np.cumsum(v) * 1e-3, effort])
        np.savetxt(
            tmp_path / "log.csv",
            columns,
            delimiter=",",
            header="time [s],position [m],effort [N]",
            comments="",
        )

    rig.write_text(
        RIG.replace('excite = "learning"', 'log = "log.csv"').replace(
            re.search(
                r"\[compare\.learning\.reference\].*?(?=\[compare\.identified)", RIG, re.DOTALL
            )[0],
            "",
        )
    )
    for level in (15.0, 18.0):
        record(level)
        assert br.prepare(rig)[0].best is not None
        assert pytest.approx(level, rel=0.02) == compensator(rig).F_C
    assert br.prepare(rig)[0].best is None


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    ("seen", "instead", "said"),
    [
        (
            'excite = "learning"',
            'excite = "lerning"',
            'identify.axis_x.excite.*is not a variant.*"?learning',
        ),
        ('excite = "learning"', "", "identify.axis_x: needs a log or a simulated loop for the fit"),
        ('excite = "learning"', 'excite = "identified"', "must not be used in this loop"),
        ('excite = "learning"', 'excit = "learning"', "unknown key"),
        (
            'identified = "axis_x"',
            'identified = "axis_y"',
            r"friction\.identified.*is not a model under.*axis_x",
        ),
        ('excite = "learning"', 'log = "none.csv"', "identify.axis_x.log"),
        (
            'identified = "axis_x"',
            'identified = "axis_x"',
            "identify.axis_x: is not identified.*bristle run",
        ),
    ],
)
def test_unsuitable_entry_is_refused_by_its_key(rig, seen, instead, said):
    rig.write_text(RIG.replace(seen, instead))
    with pytest.raises(InputError, match=said):
        br.read_experiment(rig)
    assert not (rig.parent / "rig_identified").exists()


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_commands_prepare_their_models(rig, tmp_path, capsys):
    assert main(["run", str(rig), "--out", str(tmp_path / "results")]) == 0
    assert "axis_x: identified (coulomb_viscous" in capsys.readouterr().err
    assert main(["run", str(rig)]) == 0
    assert "axis_x: identified earlier" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_study_uses_identified_models(copied, tmp_path):
    from bristle.apps.study import read_study_file

    study = tmp_path / "study.toml"
    study.write_text(
        f'schema = 1\nexperiment = "{copied}"\nruns = 3\nseed = 1\n[vary]\n"friction.F_C" = {{ uniform = ["18 N", "22 N"] }}\n'
    )
    assert {v.name for v in read_study_file(study).experiment.variants} == {"base", "identified"}
    copied.write_text(RIG.replace('F_C = "20 N"', 'F_C = "26 N"'))
    with pytest.raises(InputError, match="other inputs"):
        read_study_file(study)
