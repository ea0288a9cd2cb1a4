"""An experiment that identifies its compensator: fitted once, kept, and fitted again for a changed rig."""

import re
import shutil
from dataclasses import replace

import numpy as np
import pytest

import bristle as br
from bristle.cli.main import main
from bristle.core import InputError

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("undrawn")]

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
def prepared(tmp_path_factory):
    path = tmp_path_factory.mktemp("prepared") / "rig.toml"
    path.write_text(RIG)
    return path, br.prepare(path)


@pytest.fixture
def copied(prepared, tmp_path):
    """A rig with an identified compensator."""
    shutil.copytree(prepared[0].parent, tmp_path / "copied")
    return tmp_path / "copied" / "rig.toml"


def compensator(path):
    return next(v for v in br.read_experiment(path).variants if v.name == "identified").feedforward.friction


def test_rig_is_excited_and_its_friction_is_used_as_feedforward(prepared):
    path, (model,) = prepared
    assert model.best.friction == compensator(path)
    assert pytest.approx(20.0, rel=0.02) == compensator(path).F_C
    assert [variant.name for variant in br.read_experiment(path).variants] == ["base", "identified"]
    assert "identified from a run of" in (model.folder / "model.toml").read_text()
    assert (model.folder / "report.html").exists()


@pytest.mark.parametrize(
    ("seen", "instead"),
    [
        ('F_C = "20 N"', 'F_C = "26 N"'),
        ('k_p = "60 1/s"', 'k_p = "50 1/s"'),
        ('"8 mm", "2 mm"', '"7 mm", "2 mm"'),
        ('model = "coulomb_viscous"\n\n[compare', 'model = "coulomb_viscous"\ncutoff = "90 Hz"\n\n[compare'),
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


def test_edited_digest_is_ignored(copied):
    folder = copied.parent / "rig_identified" / "axis_x"
    note = folder / "depends_on.json"
    note.write_text(note.read_text() + " ")
    with pytest.raises(InputError, match="other inputs than those that this file now states"):
        br.read_experiment(copied)


def test_interrupted_fit_is_not_saved(rig, monkeypatch):
    import bristle.report.identified as identified

    whole = identified.identify
    monkeypatch.setattr(identified, "identify", lambda *logs, **options: replace(whole(*logs, **options), unfinished="interrupted"))
    with pytest.raises(KeyboardInterrupt):
        br.prepare(rig)
    assert list((rig.parent / "rig_identified").iterdir()) == []


def test_changed_evaluation_needs_no_new_fit(copied):
    copied.write_text(
        RIG.replace(
            "[compare.identified.controller.feedforward]",
            '[compare.identified.run]\nduration = "2 s"\n\n[compare.identified.controller.feedforward]',
        )
    )
    assert br.prepare(copied)[0].best is None


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


def test_changed_log_is_fitted_again(rig, tmp_path):
    rng = np.random.default_rng(1)

    def record(level):
        t = np.arange(6000) * 1e-3
        v = 0.02 * np.cos(2 * np.pi * 0.7 * t) + 0.03 * np.cos(2 * np.pi * 1.3 * t)
        effort = 28.0 * np.gradient(v, t) + level * np.sign(v) + 200.0 * v + 0.01 * rng.standard_normal(t.size)
        columns = np.column_stack([t, np.cumsum(v) * 1e-3, effort])
        np.savetxt(tmp_path / "log.csv", columns, delimiter=",", header="time [s],position [m],effort [N]", comments="")

    rig.write_text(
        RIG.replace('excite = "learning"', 'log = "log.csv"').replace(
            re.search(r"\[compare\.learning\.reference\].*?(?=\[compare\.identified)", RIG, re.DOTALL)[0], ""
        )
    )
    for level in (15.0, 18.0):
        record(level)
        assert br.prepare(rig)[0].best is not None
        assert pytest.approx(level, rel=0.02) == compensator(rig).F_C
    assert br.prepare(rig)[0].best is None


@pytest.mark.parametrize(
    ("seen", "instead", "said"),
    [
        ('excite = "learning"', 'excite = "lerning"', 'identify.axis_x.excite.*is not a variant.*"?learning'),
        ('excite = "learning"', "", "identify.axis_x: needs a log or a simulated loop for the fit"),
        ('excite = "learning"', 'excite = "identified"', "must not be used in this loop"),
        ('excite = "learning"', 'excit = "learning"', "unknown key"),
        ('identified = "axis_x"', 'identified = "axis_y"', r"friction\.identified.*is not a model under.*axis_x"),
        ('excite = "learning"', 'log = "none.csv"', "identify.axis_x.log"),
        ('identified = "axis_x"', 'identified = "axis_x"', "identify.axis_x: is not identified.*bristle run"),
    ],
)
def test_unsuitable_entry_is_refused_by_its_key(rig, seen, instead, said):
    rig.write_text(RIG.replace(seen, instead))
    with pytest.raises(InputError, match=said):
        br.read_experiment(rig)
    assert not (rig.parent / "rig_identified").exists()


def test_commands_prepare_their_models(rig, tmp_path, capsys):
    assert main(["run", str(rig), "--out", str(tmp_path / "results")]) == 0
    assert "axis_x: identified (coulomb_viscous" in capsys.readouterr().err
    assert main(["run", str(rig)]) == 0
    assert "axis_x: identified earlier" in capsys.readouterr().err


def test_study_uses_identified_models(copied, tmp_path):
    from bristle.study import read_study_file

    study = tmp_path / "study.toml"
    study.write_text(
        f'schema = 1\nexperiment = "{copied}"\nruns = 3\nseed = 1\n[vary]\n"friction.F_C" = {{ uniform = ["18 N", "22 N"] }}\n'
    )
    assert {v.name for v in read_study_file(study).experiment.variants} == {"base", "identified"}
    copied.write_text(RIG.replace('F_C = "20 N"', 'F_C = "26 N"'))
    with pytest.raises(InputError, match="other inputs"):
        read_study_file(study)
